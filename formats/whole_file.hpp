// A file that appears under its name only when it is whole: written beside it under a temporary name, synced, renamed.
// Whatever ends the writing early, nothing is left behind and an older file of that name stays as it was.
#pragma once

#include "ptet/error.hpp"

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
  /// Creates the empty temporary file. Throws Error(kIo) with the system's reason.
  explicit WholeFile(const std::string& path) : path_(path) {
    struct stat status {};
    if (::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode))
      throw Error(ErrorCode::kIo, "cannot write " + path + ": " +
                                      (S_ISDIR(status.st_mode) ? "it is a folder" : "it is not a regular file"));
    for (int attempt = 0; descriptor_ < 0; ++attempt) {
      temporary_ = path + ".part" + std::to_string(::getpid()) + "x" + std::to_string(attempt);
      descriptor_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
      if (descriptor_ < 0 && errno != EEXIST) fail(errno);
    }
  }
  ~WholeFile() {
    if (descriptor_ >= 0) {
      ::close(descriptor_);
      ::unlink(temporary_.c_str());
    }
  }
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;

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
  /// Throws Error(kIo); then the asked name is as it was.
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
  /// The new name is there; that it lasts is asked of the folder, which some file systems cannot sync.
  void sync_folder() const {
    const auto slash = path_.rfind('/');
    const std::string folder = slash == std::string::npos ? "." : slash == 0 ? "/" : path_.substr(0, slash);
    const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0) return;
    const int result = ::fsync(descriptor);
    const int reason = errno;
    ::close(descriptor);
    if (result != 0 && reason != EINVAL && reason != ENOTSUP) fail(reason);
  }

  std::string path_;
  std::string temporary_;
  int descriptor_ = -1;
};

} // namespace ptet
