#include "formats/ptet/manifest.hpp"

#include <charconv>
#include <limits>
#include <string_view>
#include <system_error>

namespace ptet::file {

std::optional<Bound> Manifest::welded_within() const {
  if (!has_option("weld", "yes")) return std::nullopt;
  Bound within;
  for (const auto& [name, value] : options) {
    if (name != "weld-within") continue;
    const char* const last = value.data() + value.size();
    const auto [end, status] = std::from_chars(value.data(), last, within.value);
    const std::string_view unit(end, static_cast<std::size_t>(last - end));
    within.relative = unit == " of the diagonal";
    if (status != std::errc{} || !(within.relative || unit.empty()))
      within.value = std::numeric_limits<double>::quiet_NaN();
  }
  return within;
}

} // namespace ptet::file
