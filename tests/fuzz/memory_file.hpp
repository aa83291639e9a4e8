// Bytes under a path, for functions that read files: in memory, gone with the object.
#pragma once

#include "fuzz/mutate_file.hpp"

#include <stdexcept>
#include <string>

#include <sys/mman.h>
#include <unistd.h>

namespace ptet::fuzz {

class MemoryFile {
public:
  explicit MemoryFile(Input bytes) : descriptor_(::memfd_create("input", MFD_CLOEXEC)) {
    if (descriptor_ < 0 || ::write(descriptor_, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size()))
      throw std::runtime_error("cannot make a file in memory");
  }
  ~MemoryFile() { ::close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  [[nodiscard]] std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

private:
  int descriptor_;
};

} // namespace ptet::fuzz
