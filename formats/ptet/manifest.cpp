#include "formats/ptet/manifest.hpp"

#include <charconv>

namespace ptet::file {

std::optional<Bound> Manifest::welded_within() const {
  if (!has_option("weld", "yes")) return std::nullopt;
  Bound within;
  for (const auto& [name, value] : options) {
    if (name != "weld-within") continue;
    const auto [end, status] = std::from_chars(value.data(), value.data() + value.size(), within.value);
    within.relative = end != value.data() + value.size();
  }
  return within;
}

} // namespace ptet::file
