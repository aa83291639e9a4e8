#include "build/swept_space.hpp"

#include "mesh/predicates.hpp"

#include <algorithm>

namespace ptet::build {

void SweptSpace::begin(Vertex vs, Vertex vd) {
  vs_ = vs;
  vd_ = vd;
  tets_.clear();
}

void SweptSpace::add(const Face& face, const std::vector<Point>& positions) {
  tets_.push_back(
      {face, box_of(std::array{positions[face[0]], positions[face[1]], positions[face[2]], positions[vd_]})});
}

std::ptrdiff_t SweptSpace::faces_at(Vertex x) const {
  return std::count_if(tets_.begin(), tets_.end(), [&](const Swept& tet) {
    return std::find(tet.face.begin(), tet.face.end(), x) != tet.face.end();
  });
}

bool SweptSpace::is_in(const Face& face, const Point& p, const std::vector<Point>& positions) const {
  const std::array<Point, 4> tet{positions[face[0]], positions[face[1]], positions[face[2]], positions[vd_]};
  const int sign = orientation(tet[0], tet[1], tet[2], tet[3]);
  for (std::size_t i = 0; i < 4; ++i) {
    std::array<Point, 4> seen = tet;
    seen[i] = p;
    const int side = sign * orientation(seen[0], seen[1], seen[2], seen[3]);
    if (side < 0) return false;
    if (side > 0) continue;
    if (i == 3 || face[i] == vs_) return false;
    // On the side of vs, vd and the third corner: what lies between two of the tets is swept, what lies on a face that
    // is there before or after is not.
    const auto third = std::find_if(face.begin(), face.end(), [&](Vertex x) { return x != vs_ && x != face[i]; });
    if (faces_at(*third) != 2) return false;
  }
  return true;
}

bool SweptSpace::contains(const Point& p, const std::vector<Point>& positions) const {
  return std::any_of(tets_.begin(), tets_.end(),
                     [&](const Swept& tet) { return tet.box.contains(p) && is_in(tet.face, p, positions); });
}

} // namespace ptet::build
