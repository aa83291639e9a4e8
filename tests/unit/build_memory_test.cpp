// From a mesh in memory to a cut, with and without a file between.
#include "build/memory_need.hpp"
#include "ptet/build.hpp"
#include "ptet/dataset.hpp"
#include "ptet/error.hpp"
#include "support/meshes.hpp"
#include "support/temp_folder.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <set>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

BuildOptions quick() {
  BuildOptions options;
  options.prediction = Prediction::kQuadric;
  options.evaluation = Evaluation::kVertices;
  options.target_vertices = 0.2;
  return options;
}

std::string text_of(const std::vector<std::byte>& bytes) {
  std::string text(bytes.size(), '\0');
  std::memcpy(text.data(), bytes.data(), bytes.size());
  return text;
}

} // namespace

TEST_CASE("built in memory: the bytes are those of the file") {
  const TetMesh mesh = test::grid({});
  const test::TempFolder folder;
  const BuildReport of_file = build_file(mesh, folder / "mesh.ptet", quick(), "mesh", "hash");
  BuildReport of_memory;
  of_memory.notes = {"of an earlier build"};
  const std::vector<std::byte> bytes = build_memory(mesh, quick(), &of_memory, "mesh", "hash");
  CHECK(text_of(bytes) == test::read_bytes(folder / "mesh.ptet"));
  CHECK(of_memory.file_bytes == bytes.size());
  CHECK(of_memory.file_bytes == of_file.file_bytes);
  CHECK(of_memory.records == of_file.records);
  CHECK(of_memory.base_vertices < of_memory.input_vertices);
  CHECK(of_memory.notes == of_file.notes);
  CHECK(text_of(build_memory(mesh, quick(), nullptr, "other")) != text_of(bytes));
}

TEST_CASE("what no file can hold is refused before the build") {
  TetMesh mesh = test::grid({});
  test::add_array(mesh, "modes", ScalarType::kUInt8, 1025, [](const Point&) { return std::vector<double>(1025); });
  int reports = 0;
  const auto count = [&](const Progress&) {
    ++reports;
    return true;
  };
  const auto code_of_build = [&] {
    try {
      (void)build_memory(mesh, quick(), nullptr, {}, {}, count);
    } catch (const Error& error) {
      return error.code();
    }
    return ErrorCode::kIo;
  };
  CHECK(code_of_build() == ErrorCode::kLimit);
  CHECK(reports == 0);
  mesh.point_arrays.assign(1025, mesh.point_arrays.front());
  CHECK(code_of_build() == ErrorCode::kLimit);
  CHECK(reports == 0);
}

TEST_CASE("a checkpoint under another name of the file to be built is refused before the build") {
  const test::TempFolder folder;
  BuildOptions options = quick();
  options.checkpoint.path = folder / "./mesh.ptet";
  CHECK_THROWS_WITH(build_file(test::grid({}), folder / "mesh.ptet", options),
                    Catch::Contains("is the file that is to be built"));
  CHECK(folder.names().empty());
}

TEST_CASE("built in memory: cut without a file") {
  const TetMesh mesh = test::grid({});
  const auto data = Dataset::open_memory(build_memory(mesh, quick()));
  CHECK(data->extract({}).mesh.tets.size() == mesh.tets.size());
  Request request;
  request.max_tets = mesh.tets.size() / 2;
  const Extraction cut = data->extract(request);
  CHECK(cut.mesh.tets.size() <= mesh.tets.size() / 2);
  CHECK(cut.mesh.tets.size() > data->info().base_tets);
}

TEST_CASE("built in memory: RMS errors of fields whose squares a double does not hold") {
  BuildOptions options = quick();
  options.evaluation = Evaluation::kExact;
  const auto fractions = [&](double unit) {
    TetMesh mesh = test::grid({});
    mesh.point_arrays.clear();
    test::add_array(mesh, "wave", ScalarType::kFloat64, 1, [=](const Point& p) {
      return std::vector<double>{unit * (std::sin(p[0] / 9) + std::cos(p[1] / 7))};
    });
    const auto data = Dataset::open_memory(build_memory(mesh, options));
    return std::pair{data->info().base_rms_error.at(0) / unit, data->info().max_field_error.at(0) / unit};
  };
  const auto [rms, most] = fractions(1);
  CHECK(rms > 0);
  for (const double unit : {1e200, 1e-200, 1e-300}) {
    INFO("unit " << unit);
    const auto [same_rms, same_most] = fractions(unit);
    CHECK(same_most == Approx(most).epsilon(1e-9));
    CHECK(same_rms == Approx(rms).epsilon(1e-9));
  }
}

TEST_CASE("built in memory: cancelled at any stage, and refused") {
  const TetMesh mesh = test::grid({});
  int calls = 0;
  (void)build_memory(mesh, quick(), nullptr, {}, {}, [&](const Progress&) { return ++calls > 0; });
  REQUIRE(calls > 2);
  for (const int last : {1, calls / 2, calls}) {
    int left = last;
    const auto cancel = [&](const Progress&) { return --left > 0; };
    try {
      (void)build_memory(mesh, quick(), nullptr, {}, {}, cancel);
      FAIL("was not cancelled");
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::kCancelled);
    }
  }
  CHECK_THROWS_AS(build_memory({}), Error);
}

TEST_CASE("built in memory: progress is told within rounds by predicted costs") {
  std::set<std::uint64_t> collapses;
  BuildReport report;
  (void)build_memory(test::grid({{16, 16, 16}, {}, 2, 2}), quick(), &report, {}, {}, [&](const Progress& progress) {
    if (progress.stage == "collapsing") collapses.insert(progress.done);
    return true;
  });
  CHECK(collapses.size() > 2 * report.rounds);
}

TEST_CASE("a vertex with too large a star is refused once, not for each of its edges") {
  constexpr std::uint32_t kRim = 1500;
  std::vector<Point> points{{0, 0, 0}, {0, 0, 1}, {0, 0, -1}};
  std::vector<std::array<std::uint32_t, 4>> tets;
  for (std::uint32_t i = 0; i < kRim; ++i) {
    const double angle = 6.283185307179586 * i / kRim;
    const double rough = 1 + 0.01 * ((i * i) % 7); // so that it costs most to take one of these
    points.push_back({rough * std::cos(angle), rough * std::sin(angle), 0});
    const std::uint32_t here = 3 + i, next = 3 + (i + 1) % kRim;
    tets.push_back({0, here, next, 1});
    tets.push_back({0, next, here, 2});
  }
  TetMesh mesh = test::make_mesh(points, tets, ScalarType::kFloat64);
  // With a constant field it costs nothing to take the one in the middle.
  test::add_array(mesh, "constant", ScalarType::kFloat64, 1, [](const Point&) { return std::vector<double>(1, 1.0); });
  BuildReport report;
  (void)build_memory(mesh, quick(), &report);
  CHECK(report.collapses[static_cast<std::size_t>(CollapseStatus::kRemovedStarTooLarge)] < 100);
}

TEST_CASE("memory limit: what is foreseen to pass it is refused, and nothing is left behind") {
  const TetMesh mesh = test::grid({});
  const test::TempFolder folder;
  BuildOptions options = quick();
  options.memory_limit = 1000;
  try {
    build_file(mesh, folder / "mesh.ptet", options);
    FAIL("was not refused");
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::kLimit);
    CHECK(std::string(error.what()).find("the limit is 1000 bytes") != std::string::npos);
  }
  CHECK(std::filesystem::is_empty(folder / ""));
  BuildOptions wrong = options;
  for (const double target : {-50.0, -1e30}) {
    wrong.target_vertices = target;
    try {
      (void)build_memory(mesh, wrong);
      FAIL("was not refused");
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::kBadArgument);
    }
  }
  options.memory_limit = std::uint64_t{1} << 40;
  BuildReport report;
  CHECK(text_of(build_memory(mesh, options, &report)) == text_of(build_memory(mesh, quick())));
  CHECK(report.foreseen_memory_bytes > 0);
  CHECK(report.peak_memory_bytes > 0);
}

TEST_CASE("memory limit: a process that comes near it ends the build between two rounds, with a checkpoint") {
  const TetMesh mesh = test::grid({});
  const test::TempFolder folder;
  BuildReport report;
  const std::string whole = text_of(build_memory(mesh, quick(), &report));
  BuildOptions options = quick();
  options.memory_limit = report.foreseen_memory_bytes + 100'000'000;
  options.checkpoint.path = folder / "ckpt";
  std::vector<char> ballast; // of somebody else in the process
  const auto grow = [&](const Progress& progress) {
    if (progress.stage == "collapsing" && progress.done > 0 && ballast.empty()) ballast.assign(400'000'000, 1);
    return true;
  };
  try {
    build_file(mesh, folder / "mesh.ptet", options, {}, {}, grow);
    FAIL("was not ended");
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::kLimit);
    CHECK(std::string(error.what()).find("come near the memory limit") != std::string::npos);
    CHECK(std::string(error.what()).find("in the checkpoint") != std::string::npos);
  }
  CHECK(ballast.size() == 400'000'000);
  CHECK(!std::filesystem::exists(folder / "mesh.ptet"));
  ballast = std::vector<char>();
  options.checkpoint.resume = true;
  const BuildReport resumed = build_file(mesh, folder / "mesh.ptet", options);
  CHECK(resumed.resumed_records > 0);
  CHECK(test::read_bytes(folder / "mesh.ptet") == whole);
}

TEST_CASE("memory limit: what the end of a build says of its checkpoint is about the last one") {
  const TetMesh mesh = test::grid({});
  BuildOptions options; // a few dozen rounds, and of each the end is told
  options.target_vertices = 0.2;
  BuildReport report;
  (void)build_memory(mesh, options, &report);
  const bool last_fails = GENERATE(false, true);
  CAPTURE(last_fails);
  const test::TempFolder folder;
  const std::string of_checkpoint = folder / "kept";
  options.memory_limit = report.foreseen_memory_bytes + 100'000'000;
  options.checkpoint.path = of_checkpoint + "/ckpt";
  options.checkpoint.every_seconds = 0;
  std::filesystem::create_directory(of_checkpoint);
  std::vector<char> ballast; // of somebody else in the process
  std::uint64_t last_done = 0;
  int rounds = 0;
  const auto grow = [&](const Progress& progress) {
    if (progress.stage != "collapsing" || progress.done <= last_done) return true;
    last_done = progress.done;
    ++rounds;
    // The folder goes after the first round or the third. Then the limit is near.
    if (rounds == (last_fails ? 3 : 1)) std::filesystem::remove_all(of_checkpoint);
    if (rounds == 3 && !last_fails) std::filesystem::create_directory(of_checkpoint);
    if (rounds == 3) ballast.assign(400'000'000, 1);
    return true;
  };
  try {
    build_file(mesh, folder / "mesh.ptet", options, {}, {}, grow);
    FAIL("was not ended");
  } catch (const Error& error) {
    const std::string message = error.what();
    CAPTURE(message);
    CHECK((message.find("a checkpoint could not be written") != std::string::npos) == last_fails);
    CHECK((message.find("what was done is in the checkpoint") != std::string::npos) == !last_fails);
  }
}

TEST_CASE("memory limit: says what would help") {
  build::BuildCounts counts{200'000, 1'000'000, 40'000, 32, 3, 5};
  BuildOptions options;
  options.threads = 4;
  options.memory_limit = 100'000'000;
  const auto refusal = [&] {
    try {
      (void)build::MemoryWatch({}, options).check(counts);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  for (const char* part :
       {"1000000 tets", "the limit is 100 MB", "with method QN", "with one governing field", "with one thread"})
    CHECK(refusal().find(part) != std::string::npos);
  CHECK(refusal().find("piece") == std::string::npos);
  options.pieces = kMostPieces;
  CHECK(refusal().find("in one piece") != std::string::npos);
  // It grows with everything that is counted.
  const std::uint64_t need = build::memory_need(counts, options).most();
  for (std::uint64_t build::BuildCounts::*const part :
       {&build::BuildCounts::vertices, &build::BuildCounts::tets, &build::BuildCounts::boundary_faces,
        &build::BuildCounts::row_bytes, &build::BuildCounts::channels}) {
    build::BuildCounts more = counts;
    more.*part *= 2;
    CHECK(build::memory_need(more, options).most() > need);
  }
  BuildOptions less = options;
  less.target_vertices = 0.5;
  CHECK(build::memory_need(counts, less).most() < need);
  less = options;
  less.pieces = 1;
  CHECK(build::memory_need(counts, less).most() + 100'000'000 < need);
}
