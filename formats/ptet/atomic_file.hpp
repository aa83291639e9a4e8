// Writing a file whole or not at all: to a temporary name in the same folder, synced, renamed over the asked name.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace ptet::file {

class AtomicFile {
public:
  /// Makes the temporary file. Throws Error(kIo) naming `path` and the system's reason.
  explicit AtomicFile(std::string path);
  /// Removes the temporary file unless commit() was called.
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Throws Error(kIo).
  void write(std::span<const std::byte> bytes);
  /// Syncs the file, gives it its name, syncs the folder. Throws Error(kIo); then the asked name is as it was.
  void commit();

private:
  [[noreturn]] void fail(int reason) const;

  std::string path_;
  std::string temporary_;
  int handle_ = -1;
};

} // namespace ptet::file
