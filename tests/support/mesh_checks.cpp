#include "support/mesh_checks.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

namespace ptet::test {
namespace {

double determinant(const Point& a, const Point& b, const Point& c) {
  return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

Point minus(const Point& a, const Point& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

/// The four faces of a positively oriented tet, seen from outside.
std::array<Face, 4> outward_faces(const Tet& t) {
  return {{{t[1], t[2], t[3]}, {t[0], t[3], t[2]}, {t[0], t[1], t[3]}, {t[0], t[2], t[1]}}};
}

} // namespace

int orientation(const Point& a, const Point& b, const Point& c, const Point& d) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  const auto point = [](const Point& p) { return Kernel::Point_3(p[0], p[1], p[2]); };
  return static_cast<int>(CGAL::orientation(point(a), point(b), point(c), point(d)));
}

Face turned(const Face& face) {
  Face result = face;
  std::rotate(result.begin(), std::min_element(result.begin(), result.end()), result.end());
  return result;
}

Tet sorted_keeping_orientation(const Tet& tet) {
  Tet result = tet;
  bool is_odd = false;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j)
      is_odd ^= tet[j] < tet[i];
  std::sort(result.begin(), result.end());
  if (is_odd) std::swap(result[2], result[3]);
  return result;
}

double enclosed_volume(const TetMesh& mesh, const std::vector<Face>& faces) {
  double six_volumes = 0;
  for (const Face& f : faces)
    six_volumes += determinant(mesh.position(f[0]), mesh.position(f[1]), mesh.position(f[2]));
  return six_volumes / 6;
}

MeshFacts examine(const TetMesh& mesh) {
  MeshFacts facts;
  std::map<Face, std::vector<std::pair<std::size_t, Face>>> faces; // by sorted vertices
  std::set<Tet> names;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const Tet& tet = mesh.tets[t];
    const Point a = mesh.position(tet[0]), b = mesh.position(tet[1]), c = mesh.position(tet[2]),
                d = mesh.position(tet[3]);
    facts.inverted_tets += orientation(a, b, c, d) > 0 ? 0 : 1;
    facts.volume += determinant(minus(b, a), minus(c, a), minus(d, a)) / 6;
    Tet name = tet;
    std::sort(name.begin(), name.end());
    facts.repeated_tets += names.insert(name).second ? 0 : 1;
    for (const Face& face : outward_faces(tet)) {
      Face key = face;
      std::sort(key.begin(), key.end());
      faces[key].emplace_back(t, turned(face));
    }
  }

  std::vector<std::size_t> root(mesh.tets.size());
  std::iota(root.begin(), root.end(), std::size_t{0});
  const auto find_root = [&](std::size_t t) {
    while (root[t] != t)
      t = root[t] = root[root[t]];
    return t;
  };
  facts.components = mesh.tets.size();
  std::set<VertexId> boundary_vertices;
  std::set<std::pair<VertexId, VertexId>> boundary_edges;
  for (const auto& [key, sides] : faces) {
    facts.crowded_faces += sides.size() > 2 ? 1 : 0;
    for (std::size_t i = 1; i < sides.size(); ++i) {
      const std::size_t x = find_root(sides[0].first), y = find_root(sides[i].first);
      facts.components -= x != y ? 1 : 0;
      root[x] = y;
      facts.folded_faces += sides[i].second == sides[0].second ? 1 : 0;
    }
    if (sides.size() != 1) continue;
    facts.boundary.push_back(sides[0].second);
    boundary_vertices.insert(key.begin(), key.end());
    boundary_edges.insert({{key[0], key[1]}, {key[0], key[2]}, {key[1], key[2]}});
  }
  facts.boundary_euler_characteristic = static_cast<std::int64_t>(boundary_vertices.size()) -
                                        static_cast<std::int64_t>(boundary_edges.size()) +
                                        static_cast<std::int64_t>(facts.boundary.size());
  std::sort(facts.boundary.begin(), facts.boundary.end());
  return facts;
}

} // namespace ptet::test
