// The manifest: where a .ptet file comes from. Described once by Boost.Serialization serialize() functions and stored
// through our own bounded little-endian archive (archive.hpp), values only.
#pragma once

#include "ptet/bounds.hpp"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace ptet::file {

struct Manifest {
  std::string tool_version; ///< of the builder, "0.1.0"
  std::string source_name;  ///< file name of the input, without its folder
  std::string source_hash;  ///< "xxh64:..." of the input's bytes, and its pieces'; empty when it was no file
  std::vector<std::pair<std::string, std::string>> options; ///< name and value, as used
  std::vector<std::string> notes;                           ///< what was found in the input and done about it

  template <class Archive>
  void serialize(Archive& archive, unsigned /*version*/) {
    archive& tool_version& source_name& source_hash& options& notes;
  }

  [[nodiscard]] bool has_option(const std::string& name, const std::string& value) const {
    return std::find(options.begin(), options.end(), std::pair(name, value)) != options.end();
  }
  /// Whether the build has measured the errors everywhere, so that they are bounds; else they are what it has seen.
  [[nodiscard]] bool states_bounds() const { return has_option("evaluate", "exact"); }
  /// Within what the points of the input were welded to make the original; none: they were not.
  [[nodiscard]] std::optional<Bound> welded_within() const;

  friend bool operator==(const Manifest&, const Manifest&) = default;
};

} // namespace ptet::file
