// Where a .ptet file's bytes come from: a file, memory, or a user's own source.
#pragma once

#include "ptet/source.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace ptet::file {

class Source {
public:
  virtual ~Source() = default;
  [[nodiscard]] virtual std::uint64_t size() const = 0;
  /// Fills `into` from `offset`. Throws Error(kIo) when the bytes cannot be had.
  virtual void read(std::uint64_t offset, std::span<std::byte> into) = 0;
};

/// Throws Error(kIo) when the file cannot be opened; the message names it.
[[nodiscard]] std::unique_ptr<Source> open_file(const std::string& path);
[[nodiscard]] std::unique_ptr<Source> over_memory(std::vector<std::byte> bytes);
/// Throws Error(kBadArgument) when there is none.
[[nodiscard]] std::unique_ptr<Source> over(std::shared_ptr<ByteSource> source);

} // namespace ptet::file
