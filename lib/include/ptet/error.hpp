// The one exception of the library: a stable code, a message a user can act on, and where it helps a place.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

namespace ptet {

enum class ErrorCode {
  kBadArgument, ///< a request that cannot be met by any data (exit code 2)
  kBadInput,    ///< a mesh or field that cannot be handled (exit code 3)
  kCorruptFile, ///< a .ptet file that breaks its specification (exit code 4)
  kLimit,       ///< a size or memory limit would be passed (exit code 5)
  kIo,          ///< the operating system refused to read or write (exit code 6)
  kCancelled,   ///< the progress callback asked to stop (exit code 130)
};

class Error : public std::runtime_error {
public:
  Error(ErrorCode code, const std::string& message)
      : std::runtime_error(message), code_(code), reason_length_(message.size()) {}
  Error(ErrorCode code, const std::string& message, std::uint64_t byte_offset)
      : std::runtime_error(message + " (at byte " + std::to_string(byte_offset) + ")"), code_(code),
        reason_length_(message.size()), byte_offset_(byte_offset) {}

  [[nodiscard]] ErrorCode code() const { return code_; }
  /// what() without the place in a file.
  [[nodiscard]] std::string_view reason() const { return {what(), reason_length_}; }
  /// Where in the file the reader stood, when the error is about a place in a file.
  [[nodiscard]] std::optional<std::uint64_t> byte_offset() const { return byte_offset_; }

private:
  ErrorCode code_;
  std::size_t reason_length_;
  std::optional<std::uint64_t> byte_offset_;
};

} // namespace ptet
