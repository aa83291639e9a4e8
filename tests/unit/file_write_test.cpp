// Files are written whole or not at all, and what the system refuses is said.
#include "formats/ptet/reader.hpp"
#include "formats/ptet/writer.hpp"
#include "ptet/error.hpp"
#include "support/meshes.hpp"
#include "support/naive_simplifier.hpp"

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <catch2/catch.hpp>
#include <sys/resource.h>
#include <unistd.h>

using namespace ptet;
using namespace ptet::test;
namespace fs = std::filesystem;

namespace {

/// A folder of its own, gone afterwards.
struct Folder {
  fs::path path = fs::temp_directory_path() / ("ptet-write-test-" + std::to_string(::getpid()));
  Folder() { fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }
  [[nodiscard]] std::size_t files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(path), fs::directory_iterator()));
  }
};

ErrorCode code_of(const std::function<void()>& call, std::string& message) {
  try {
    call();
  } catch (const Error& error) {
    message = error.what();
    return error.code();
  }
  FAIL("nothing was thrown");
  return ErrorCode::kIo;
}

} // namespace

TEST_CASE("a file is written under its name and nothing is left beside it") {
  const Folder folder;
  const TetMesh mesh = grid({});
  const auto records = simplify_naively(mesh);
  const std::string path = folder.path / "mesh.ptet";
  std::ofstream(path) << "what was there before";
  const std::uint64_t bytes = file::write(path, mesh, records, {});
  CHECK(folder.files() == 1);
  CHECK(fs::file_size(path) == bytes);
  file::Reader reader(file::open_file(path));
  CHECK(reader.file_bytes() == bytes);
  CHECK(reader.bytes_read() < bytes);
}

TEST_CASE("arrays that could not be told apart, or not named, are refused") {
  TetMesh mesh = grid({});
  const auto [name, says] = GENERATE(table<std::string, std::string>(
      {{"", "has no name"}, {std::string("a\0b", 3), "behind a zero byte"}, {"f", "are called 'f'"}}));
  const PointArray more{name, ScalarType::kUInt8, 1, std::vector<std::byte>(mesh.vertex_count())};
  mesh.point_arrays = {{"f", ScalarType::kUInt8, 1, std::vector<std::byte>(mesh.vertex_count())}, more};
  std::string message;
  CHECK(code_of([&] { file::check_storable(mesh); }, message) == ErrorCode::kBadInput);
  CHECK_THAT(message, Catch::Contains(says));
}

TEST_CASE("cancelling at any time leaves the old file and nothing else") {
  const Folder folder;
  const TetMesh mesh = grid({});
  const auto records = simplify_naively(mesh);
  const std::string path = folder.path / "mesh.ptet";
  std::ofstream(path) << "old";
  int calls = 0;
  file::write(folder.path / "count.ptet", mesh, records, {}, [&](const Progress&) { return ++calls > 0; });
  fs::remove(folder.path / "count.ptet");
  REQUIRE(calls >= 3);
  for (int stop = 1; stop <= calls; ++stop) {
    int left = stop;
    std::string message;
    CHECK(code_of([&] { file::write(path, mesh, records, {}, [&](const Progress&) { return --left > 0; }); },
                  message) == ErrorCode::kCancelled);
    CHECK(folder.files() == 1);
    CHECK(fs::file_size(path) == 3);
  }
}

TEST_CASE("what the system refuses to take is said, and nothing is left") {
  const Folder folder;
  const TetMesh mesh = grid({});
  const auto records = simplify_naively(mesh);
  const std::string path = folder.path / "mesh.ptet";
  // Stands for a full disk: no file of this process may grow beyond a few bytes.
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit tight{100, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &tight);
  std::string message;
  const ErrorCode code = code_of([&] { file::write(path, mesh, records, {}); }, message);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  CHECK(code == ErrorCode::kIo);
  CHECK(message == "cannot write " + path + ": File too large");
  CHECK(folder.files() == 0);
}

TEST_CASE("a folder that is not there is named") {
  const TetMesh mesh = single_tet();
  const auto records = simplify_naively(mesh);
  std::string message;
  CHECK(code_of([&] { file::write("/nowhere/at/all.ptet", mesh, records, {}); }, message) == ErrorCode::kIo);
  CHECK(message == "cannot write /nowhere/at/all.ptet: No such file or directory");
  CHECK(code_of([&] { static_cast<void>(file::open_file("/nowhere/at/all.ptet")); }, message) == ErrorCode::kIo);
  CHECK(message == "cannot open /nowhere/at/all.ptet: No such file or directory");
  CHECK(code_of([&] { static_cast<void>(file::open_file("/")); }, message) == ErrorCode::kIo);
}

TEST_CASE("a file of another kind is not called damaged but named as what it is not") {
  std::vector<std::byte> bytes(500, std::byte{'x'});
  std::string message;
  CHECK(code_of([&] { file::Reader reader(file::over_memory(bytes)); }, message) == ErrorCode::kCorruptFile);
  CHECK(message.find("not a .ptet file") != std::string::npos);
}

TEST_CASE("whatever a source throws is an error of reading, with its place") {
  class Source final : public ByteSource {
  public:
    std::uint64_t size() override { return 100; }
    void read(std::uint64_t offset, std::span<std::byte> into) override {
      if (offset == 10) throw std::runtime_error("no line");
      if (offset == 20) throw Error(ErrorCode::kLimit, "too much");
      if (offset == 30) throw Error(ErrorCode::kIo, "no disk", 33);
      if (offset == 40) throw std::bad_alloc();
      std::fill(into.begin(), into.end(), std::byte{7});
    }
  };
  file::RangeReader reader(std::make_shared<Source>(), 0);
  const auto error_of = [&](std::uint64_t offset, std::uint64_t count) {
    try {
      static_cast<void>(reader.read({offset, count}));
    } catch (const Error& error) {
      return error;
    }
    FAIL("no error");
    return Error(ErrorCode::kIo, "");
  };
  CHECK(reader.read({50, 50}) == std::vector<std::byte>(50, std::byte{7}));
  CHECK(error_of(10, 1).code() == ErrorCode::kIo);
  CHECK(std::string(error_of(10, 1).what()).find("no line") != std::string::npos);
  CHECK(error_of(10, 1).byte_offset() == 10);
  CHECK(error_of(20, 1).code() == ErrorCode::kIo);
  CHECK(error_of(30, 1).byte_offset() == 33);
  CHECK_THROWS_AS(reader.read({40, 1}), std::bad_alloc);
  CHECK(error_of(90, 11).code() == ErrorCode::kCorruptFile);
  CHECK(error_of(101, 0).code() == ErrorCode::kCorruptFile);

  // Together, what can be read is read.
  const std::vector<file::ByteRange> ranges = {{8, 1}, {10, 1}, {11, 1}, {60, 5}};
  const auto read = reader.read_all(ranges);
  CHECK(read[0].bytes.size() == 1);
  CHECK(read[1].failure != nullptr);
  CHECK(read[2].bytes.size() == 1);
  CHECK(read[3].bytes.size() == 5);

  // What is wanted no more once another has failed is not asked for.
  const std::uint64_t requests = reader.requests();
  std::vector<std::size_t> done;
  bool has_failed = false;
  reader.read_each(
      ranges, [&](std::size_t i) { return i == 0 || !has_failed; },
      [&](std::size_t i, const file::RangeBytes& part) {
        has_failed |= part.failure != nullptr;
        done.push_back(i);
      });
  reader.read_each(
      ranges, [](std::size_t) { return true; }, [&](std::size_t i, const file::RangeBytes&) { done.push_back(i); },
      [] { return true; });
  CHECK(done == std::vector<std::size_t>{0, 1});
  CHECK(reader.requests() - requests == 3); // 0; 1 and 2, as they lie together; 1

  const auto bytes = file::over_memory(std::vector<std::byte>(8));
  std::vector<std::byte> into(4);
  CHECK_NOTHROW(bytes->read(4, into));
  CHECK_THROWS_AS(bytes->read(5, into), Error);
  CHECK_THROWS_AS(bytes->read(9, {}), Error);
}
