// The manifest of a file as JSON text, for DatasetInfo::provenance_json.
#pragma once

#include "formats/ptet/manifest.hpp"

#include <string>
#include <string_view>

namespace ptet {

/// An object with tool_version, source_name, source_hash, options (an object; an option that was given more than once
/// has a list) and notes (a list). Options keep their order.
[[nodiscard]] std::string to_json(const file::Manifest& manifest);

/// A JSON string in quotes. What the file calls text need not be any: bytes that are no UTF-8 become U+FFFD.
[[nodiscard]] std::string json_string(std::string_view text);

} // namespace ptet
