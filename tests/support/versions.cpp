#include "support/versions.hpp"

#include <algorithm>

namespace ptet::test {

Versions::Versions(const RecordStream& stream) : star_begin(stream.star_begin) {
  tets = stream.slots;
  for (std::size_t i = stream.size(); i-- > 0;)
    for (std::size_t m = 0; m < stream.modified_count[i]; ++m) {
      Tet& tet = tets[stream.stars[stream.star_begin[i] + m]];
      std::replace(tet.begin(), tet.end(), stream.target[i], stream.removed[i]);
    }
  std::vector<std::uint32_t> held(tets.size()); // by slot: the version
  for (std::uint32_t slot = 0; slot < held.size(); ++slot)
    held[slot] = slot;
  for (std::size_t i = 0; i < stream.size(); ++i) {
    coarse_begin.emplace_back(static_cast<std::uint32_t>(tets.size()));
    for (std::size_t k = stream.star_begin[i]; k < stream.star_begin[i + 1]; ++k)
      fine.emplace_back(held[stream.stars[k]]);
    for (std::size_t m = 0; m < stream.modified_count[i]; ++m) {
      std::uint32_t& version = held[stream.stars[stream.star_begin[i] + m]];
      Tet tet = tets[version];
      std::replace(tet.begin(), tet.end(), stream.removed[i], stream.target[i]);
      version = static_cast<std::uint32_t>(tets.size());
      tets.push_back(tet);
    }
  }
}

} // namespace ptet::test
