#include "closest_name.hpp"

#include <algorithm>
#include <cstddef>

namespace ptet::cli {
namespace {

/// The optimal string alignment distance.
std::size_t letters_apart(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> apart(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i)
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        apart[i][j] = i + j;
        continue;
      }
      apart[i][j] =
          std::min({apart[i - 1][j] + 1, apart[i][j - 1] + 1, apart[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0U : 1U)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        apart[i][j] = std::min(apart[i][j], apart[i - 2][j - 2] + 1);
    }
  return apart[a.size()][b.size()];
}

} // namespace

std::string closest_name(const std::string& given, const std::vector<std::string>& names) {
  std::string closest;
  std::size_t least = 0;
  for (const std::string& name : names) {
    const std::size_t apart = letters_apart(given, name);
    if (3 * apart > name.size() || (!closest.empty() && apart >= least)) continue;
    closest = name;
    least = apart;
  }
  return closest;
}

} // namespace ptet::cli
