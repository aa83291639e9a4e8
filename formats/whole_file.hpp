// A file that appears under its name only when it is whole: written beside it under a temporary name, synced, renamed.
// Whatever ends the writing early, nothing is left behind and an older file of that name stays as it was. One that is
// replaced hands on its owner and who may read and write it; one that is write-protected is not replaced.
#pragma once

#include "ptet/error.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <span>
#include <string>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace ptet {

class WholeFile {
public:
  /// Creates the empty temporary file. Throws Error: kIo with the system's reason; kBadArgument for a name that the
  /// system would cut short.
  explicit WholeFile(const std::string& path) : WholeFile() { // constructed by then: if the rest throws, it is undone
    path_ = behind_links(path);
    struct stat status {};
    const bool replaces = ::stat(path_.c_str(), &status) == 0;
    if (!replaces && errno != ENOENT) fail(errno);
    if (replaces && !S_ISREG(status.st_mode))
      fail(S_ISDIR(status.st_mode) ? "it is a folder" : "it is not a regular file");
    if (replaces && ::access(path_.c_str(), W_OK) != 0) fail(errno);
    for (int attempt = 0; descriptor_ < 0; ++attempt) {
      temporary_ = beside(".part" + std::to_string(::getpid()) + "x" + std::to_string(attempt));
      descriptor_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, replaces ? 0600 : 0666);
      if (descriptor_ < 0 && errno != EEXIST) fail(errno);
    }
    if (replaces) hand_on(status);
  }
  ~WholeFile() {
    if (descriptor_ >= 0) {
      ::close(descriptor_);
      ::unlink(temporary_.c_str());
    }
  }
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;

  /// The file that a name stands for where it is a link, also one to a file that is not there yet: a link stays a link.
  /// Throws as the constructor does.
  [[nodiscard]] static std::string behind_links(const std::string& given) {
    if (const auto zero = given.find('\0'); zero != std::string::npos)
      throw Error(ErrorCode::kBadArgument,
                  "cannot write " + given.substr(0, zero) + "...: the name has a zero byte in it");
    std::string path = given;
    for (int links = 0; links <= kMostLinks; ++links) {
      std::array<char, 4096> target{};
      const ssize_t length = ::readlink(path.c_str(), target.data(), target.size());
      if (length < 0) return path; // no link; what else may be wrong with it is found by who opens it
      const std::string next(target.data(), static_cast<std::size_t>(length));
      path = next.starts_with('/') ? next : path.substr(0, path.rfind('/') + 1) + next;
    }
    throw Error(ErrorCode::kIo, "cannot write " + given + ": " + std::strerror(ELOOP));
  }

  [[nodiscard]] const std::string& temporary_path() const { return temporary_; }

  /// Appends. Throws Error(kIo).
  void write(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
      const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) fail(errno);
      bytes = bytes.subspan(static_cast<std::size_t>(written));
    }
  }

  /// Makes what was written (under temporary_path() through any descriptor) the file of the asked name, and durable.
  /// Throws Error(kIo); then the asked name is as it was, unless the message says that the file is written.
  void commit() {
    if (::fsync(descriptor_) != 0) fail(errno);
    if (::rename(temporary_.c_str(), path_.c_str()) != 0) fail(errno);
    ::close(descriptor_);
    descriptor_ = -1;
    sync_folder();
  }

  [[noreturn]] void fail(int error_number) const { fail(std::string(std::strerror(error_number))); }
  [[noreturn]] void fail(const std::string& reason) const {
    throw Error(ErrorCode::kIo, "cannot write " + path_ + ": " + reason);
  }

private:
  WholeFile() = default;

  static constexpr int kMostLinks = 40; ///< that the system follows
  static constexpr std::size_t kLongestName = 255;

  /// A path in the same folder, whose name ends so and begins as that of the file as far as it may be long.
  [[nodiscard]] std::string beside(const std::string& ending) const {
    const std::size_t name = path_.rfind('/') + 1; // 0 where there is no folder
    return path_.substr(0, std::min(path_.size(), name + kLongestName - ending.size())) + ending;
  }

  /// Gives the temporary file the owner and the permissions of the one that it will replace. Where the system refuses
  /// the group, its members may do no more than everybody.
  void hand_on(const struct stat& old) const {
    mode_t mode = old.st_mode & 0777;
    struct stat own {};
    if (::fstat(descriptor_, &own) != 0) fail(errno);
    if (own.st_uid != old.st_uid) (void)!::fchown(descriptor_, old.st_uid, static_cast<gid_t>(-1));
    if (own.st_gid != old.st_gid && ::fchown(descriptor_, static_cast<uid_t>(-1), old.st_gid) != 0)
      mode = (mode & ~static_cast<mode_t>(0070)) | ((mode & 0007) << 3);
    (void)!::fchmod(descriptor_, mode); // some file systems know no permissions
  }

  /// The new name is there; that it lasts is asked of the folder, which some file systems cannot sync.
  void sync_folder() const {
    const auto slash = path_.rfind('/');
    const std::string folder = slash == std::string::npos ? "." : slash == 0 ? "/" : path_.substr(0, slash);
    const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0) return;
    const int result = ::fsync(descriptor);
    const int reason = errno;
    ::close(descriptor);
    if (result != 0 && reason != EINVAL && reason != ENOTSUP)
      throw Error(ErrorCode::kIo, path_ + " is written, but may not be there after a loss of power: its folder says " +
                                      std::strerror(reason));
  }

  std::string path_;
  std::string temporary_;
  int descriptor_ = -1;
};

} // namespace ptet
