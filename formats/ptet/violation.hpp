// What breaks the specification but leaves the rest readable: a reader that is to find everything goes on after it.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

namespace ptet::file {

struct Violation {
  std::string what;                     ///< a sentence
  std::optional<std::uint64_t> offset;  ///< in the file: of the field, or of the section or block that holds it
  std::optional<std::uint32_t> block;   ///< number in the table
  std::optional<std::uint32_t> record;  ///< number in the file
  std::optional<std::uint32_t> version; ///< as VersionTable numbers them
};

/// Told of every violation. Where there is none, a violation is thrown as an Error(kCorruptFile).
using Violations = std::function<void(const Violation&)>;

} // namespace ptet::file
