// What somebody may have meant who typed a name that is not there.
#pragma once

#include <string>
#include <vector>

namespace ptet::cli {

/// That of `names` which the fewest letters make of `given`, put in, left out, changed, or two exchanged: the first of
/// several, "" where each takes more than one for three of its letters.
[[nodiscard]] std::string closest_name(const std::string& given, const std::vector<std::string>& names);

} // namespace ptet::cli
