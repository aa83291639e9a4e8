#include "build/checkpoint.hpp"

#include "builder_id.hpp"
#include "formats/ptet/layout.hpp"
#include "formats/ptet/running_hash.hpp"
#include "formats/whole_file.hpp"
#include "ptet/error.hpp"
#include "ptet/version.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <span>
#include <string_view>

namespace ptet::build {
namespace {

constexpr std::string_view kCheckpointMagic{"PTETCKP\n", 8};
constexpr std::size_t kFrameBytes = 24;

/// Of things, not of bytes.
class Identity {
public:
  void add(std::span<const std::byte> bytes) { hash_.add(bytes); }
  void add(std::string_view text) {
    add(std::uint64_t{text.size()});
    add(std::as_bytes(std::span(text)));
  }
  void add(std::uint64_t number) { add(std::as_bytes(std::span(&number, 1))); }
  void add(const PointArray& array) {
    add(array.name);
    add(static_cast<std::uint64_t>(array.type));
    add(std::uint64_t{array.components});
    add(std::span<const std::byte>(array.bytes));
  }
  [[nodiscard]] std::uint64_t value() const { return hash_.value(); }

private:
  file::RunningHash hash_;
};

std::string hex(std::uint64_t number) {
  std::array<char, 17> text{};
  std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(number));
  return text.data();
}

std::vector<std::byte> read_file(const std::string& path) {
  std::error_code status;
  if (std::filesystem::is_directory(path, status))
    throw Error(ErrorCode::kIo, "cannot read the checkpoint '" + path + "': it is a folder");
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  const auto fail = [&] {
    throw Error(ErrorCode::kIo,
                "cannot read the checkpoint '" + path + "': " + std::strerror(errno != 0 ? errno : EIO));
  };
  if (!in) fail();
  const auto size = std::filesystem::file_size(path, status);
  if (status) fail();
  std::vector<std::byte> bytes(size);
  if (!in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size))) fail();
  return bytes;
}

/// What is said of an option that one of two builds has.
std::string value_of(const std::vector<std::pair<std::string, std::string>>& options, const std::string& name) {
  std::string values;
  for (const auto& [option, value] : options)
    if (option == name) values += (values.empty() ? "" : ", ") + value;
  return values.empty() ? "none" : values;
}

/// In words, how the checkpoint's build differs; empty when it does not.
std::string difference(const BuildIdentity& stored, const BuildIdentity& wanted) {
  if (stored.program != wanted.program)
    return "it was written by another program, " + stored.program + "; this is " + wanted.program;
  if (stored.mesh != wanted.mesh) return "it is of another mesh, or of one whose points were welded otherwise";
  for (const auto* options : {&stored.options, &wanted.options})
    for (const auto& [name, value] : *options) {
      const std::string before = value_of(stored.options, name);
      const std::string now = value_of(wanted.options, name);
      if (before != now) return "it is of a build with " + name + " " + before + "; here it is " + now;
    }
  return stored.options == wanted.options ? "" : "it is of a build with other options";
}

/// The payload, by size and hash what was written.
std::span<const std::byte> payload_of(const std::string& path, const std::vector<std::byte>& bytes) {
  const auto refuse = [&](const char* what) {
    throw Error(ErrorCode::kCorruptFile, "the checkpoint '" + path + "' cannot be used: " + what);
  };
  if (bytes.size() < kFrameBytes) refuse("it is too short for a checkpoint");
  file::ByteReader in(std::span<const std::byte>(bytes).first(kFrameBytes), "checkpoint", 0);
  if (in.get_text(kCheckpointMagic.size(), "magic") != kCheckpointMagic) refuse("it is no checkpoint");
  if (in.get<std::uint64_t>("size") != bytes.size() - kFrameBytes) refuse("it is cut short, or too long");
  const auto payload = std::span<const std::byte>(bytes).subspan(kFrameBytes);
  if (in.get<std::uint64_t>("hash") != file::hash_of(payload)) refuse("it is damaged, its hash does not match");
  return payload;
}

} // namespace

BuildIdentity identity_of(const TetMesh& mesh, std::vector<std::pair<std::string, std::string>> options) {
  Identity hash;
  hash.add(mesh.positions);
  hash.add(std::uint64_t{mesh.point_arrays.size()});
  for (const PointArray& array : mesh.point_arrays)
    hash.add(array);
  hash.add(std::as_bytes(std::span(mesh.tets)));
  return {std::string(kVersion) + " (" + kBuilderId + ")", hex(hash.value()), std::move(options)};
}

StoredState::StoredState(const std::string& path, const BuildIdentity& identity)
    : path_(path), bytes_(read_file(path)), in_(payload_of(path, bytes_), "checkpoint", kFrameBytes), archive_(in_) {
  BuildIdentity stored;
  archive_& stored;
  if (const std::string what = difference(stored, identity); !what.empty())
    throw Error(ErrorCode::kBadArgument, "the build cannot go on from the checkpoint '" + path + "': " + what);
}

void StoredState::refuse(const std::string& what) const {
  throw Error(ErrorCode::kCorruptFile, "the checkpoint '" + path_ + "' cannot be used: " + what);
}

CheckpointWriter::CheckpointWriter(const CheckpointOptions& options) : options_(options) {
  std::error_code status;
  if (enabled() && !options.resume && std::filesystem::exists(options.path, status))
    throw Error(ErrorCode::kBadArgument,
                "the checkpoint '" + options.path + "' is there already: go on from it, or remove it to begin anew");
  if (enabled()) (void)WholeFile(options.path); // to know now, not when the first one is due
}

bool CheckpointWriter::due() const {
  return enabled() && std::chrono::duration<double>(Clock::now() - last_).count() >= options_.every_seconds;
}

void CheckpointWriter::write(const BuildIdentity& identity, const std::function<void(file::OutputArchive&)>& save_state,
                             BuildReport& report) {
  const auto start = Clock::now();
  file::ByteWriter payload;
  file::OutputArchive archive(payload);
  archive& identity;
  save_state(archive);
  file::ByteWriter frame;
  frame.put_text(kCheckpointMagic);
  frame.put(std::uint64_t{payload.size()});
  frame.put(file::hash_of(payload.bytes()));
  WholeFile file(options_.path);
  file.write(frame.bytes());
  file.write(payload.bytes());
  file.commit();
  last_ = Clock::now();
  ++report.checkpoints;
  report.checkpoint_bytes = kFrameBytes + payload.size();
  report.checkpoint_seconds += std::chrono::duration<double>(last_ - start).count();
}

} // namespace ptet::build
