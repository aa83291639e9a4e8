#include "files.hpp"

#include "formats/ptet/layout.hpp"
#include "formats/whole_file.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace ptet::cli {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void cannot(const char* verb, const std::string& path, const std::string& why) {
  throw Error(ErrorCode::kIo, std::string("cannot ") + verb + " '" + path + "': " + why);
}

/// What would keep the new file from taking the place of the one that is there, said before hours of work.
void check_replaceable(const std::string& path, const fs::path& target, const fs::path& folder) {
  if (access(target.c_str(), W_OK) != 0) cannot("write", path, std::strerror(errno));
  struct statx file {
  }, around{};
  if (statx(AT_FDCWD, target.c_str(), 0, STATX_UID, &file) != 0 ||
      statx(AT_FDCWD, folder.c_str(), 0, STATX_UID | STATX_MODE, &around) != 0)
    return;
  if ((file.stx_attributes & STATX_ATTR_MOUNT_ROOT) != 0)
    cannot("write", path, "it is mounted there by itself and cannot be replaced; give the output another name");
  const uid_t user = geteuid();
  if ((around.stx_mode & S_ISVTX) != 0 && user != 0 && user != file.stx_uid && user != around.stx_uid)
    cannot("write", path, "it belongs to another user, and so does its folder, which is sticky");
}

} // namespace

bool is_ptet_file(const std::string& path) {
  std::error_code status;
  const fs::file_status found = fs::status(path, status);
  if (fs::is_directory(found)) cannot("read", path, "it is a folder");
  // Opening a pipe waits for who writes to it, for ever and deaf to Ctrl-C; and no reader here could read one.
  if (fs::exists(found) && !fs::is_regular_file(found)) cannot("read", path, "it is not a regular file");
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) cannot("read", path, std::strerror(errno));
  std::array<char, file::kMagic.size()> begin{};
  file.read(begin.data(), begin.size());
  return file.gcount() == static_cast<std::streamsize>(begin.size()) &&
         std::memcmp(begin.data(), file::kMagic.data(), begin.size()) == 0;
}

std::uint64_t size_of_file(const std::string& path) {
  std::error_code status;
  const auto size = fs::file_size(path, status);
  return status ? 0 : size;
}

void note_values_of_cells(const TetMesh& mesh, ReadReport& read) {
  if (mesh.point_arrays.empty() && !read.cell_arrays.empty())
    read.notes.push_back(std::string("only cells have values: ") + kCellsToPoints);
}

std::uint64_t bytes_of(const std::string& path, const ReadReport& read) {
  std::uint64_t bytes = size_of_file(path);
  for (const std::string& piece : read.more_files)
    bytes += size_of_file(piece);
  return bytes;
}

std::string checked_output(const std::string& option, const std::string& path, const std::string& input) {
  if (path.empty()) throw Error(ErrorCode::kBadArgument, option + ": the name is empty");
  std::error_code status;
  // Of the path, not the target: a link to a pipe (/dev/stdout) names none that could be looked up.
  const fs::file_status found = fs::status(path, status);
  if (fs::is_directory(found)) cannot("write", path, "it is a folder");
  if (fs::exists(found) && !fs::is_regular_file(found)) cannot("write", path, "it is not a regular file");
  if (found.type() == fs::file_type::none) cannot("write", path, status.message()); // a name too long, links in a ring
  const fs::path target = WholeFile::behind_links(path);
  if (fs::equivalent(target, input, status)) {
    throw Error(ErrorCode::kBadArgument, option + " '" + path + "': this is the input file; give another name");
  }
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, status)) cannot("write", path, "there is no folder '" + folder.string() + "'");
  if (access(folder.c_str(), W_OK | X_OK) != 0) cannot("write", path, std::strerror(errno));
  if (fs::exists(found)) check_replaceable(path, target, folder);
  return target.string();
}

Limits machine_limits() {
  Limits limits;
  const long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
  if (pages > 0 && page > 0)
    limits.max_bytes = std::max(limits.max_bytes, static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page));
  return limits;
}

std::shared_ptr<const Dataset> open_dataset(const std::string& path, std::optional<std::uint64_t> memory_limit) {
  if (!is_ptet_file(path)) throw Error(ErrorCode::kCorruptFile, "this is not a .ptet file");
  OpenOptions options;
  options.limits = machine_limits();
  if (memory_limit) options.limits.max_bytes = *memory_limit;
  return Dataset::open(path, options);
}

} // namespace ptet::cli
