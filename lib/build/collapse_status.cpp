#include "ptet/build.hpp"

namespace ptet {

std::string_view name_of(CollapseStatus status) {
  static constexpr std::array<std::string_view, kCollapseStatusCount> kNames = {
      "accepted", "frozen vertex", "boundary vertex",  "link condition",    "star too large", "removed star too large",
      "inverted", "quality",       "surface topology", "self-intersection", "domain error",   "field error",
  };
  return kNames.at(static_cast<std::size_t>(status));
}

} // namespace ptet
