#include "support/mesh_checks.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>

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

/// A face as one of its tets has it.
struct Side {
  Face key; ///< ascending
  std::size_t tet;
  Face outward; ///< turned
  friend bool operator<(const Side& a, const Side& b) { return std::tie(a.key, a.tet) < std::tie(b.key, b.tet); }
};

template <class T>
std::size_t distinct(std::vector<T> values) {
  std::sort(values.begin(), values.end());
  return static_cast<std::size_t>(std::unique(values.begin(), values.end()) - values.begin());
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
  for (const auto& [i, j] : {std::pair(0, 1), std::pair(2, 3), std::pair(0, 2), std::pair(1, 3), std::pair(1, 2)})
    if (result[j] < result[i]) {
      std::swap(result[i], result[j]);
      is_odd = !is_odd;
    }
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
  std::vector<Side> sides;
  std::vector<Tet> names;
  sides.reserve(4 * mesh.tets.size());
  names.reserve(mesh.tets.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const Tet& tet = mesh.tets[t];
    const Point a = mesh.position(tet[0]), b = mesh.position(tet[1]), c = mesh.position(tet[2]),
                d = mesh.position(tet[3]);
    facts.inverted_tets += orientation(a, b, c, d) > 0 ? 0 : 1;
    facts.volume += determinant(minus(b, a), minus(c, a), minus(d, a)) / 6;
    names.push_back(tet);
    std::sort(names.back().begin(), names.back().end());
    for (const Face& face : outward_faces(tet)) {
      sides.push_back({face, t, turned(face)});
      std::sort(sides.back().key.begin(), sides.back().key.end());
    }
  }
  facts.repeated_tets = names.size() - distinct(names);
  std::sort(sides.begin(), sides.end());

  std::vector<std::size_t> root(mesh.tets.size());
  std::iota(root.begin(), root.end(), std::size_t{0});
  const auto find_root = [&](std::size_t t) {
    while (root[t] != t)
      t = root[t] = root[root[t]];
    return t;
  };
  facts.components = mesh.tets.size();
  std::vector<VertexId> boundary_vertices;
  std::vector<std::pair<VertexId, VertexId>> boundary_edges;
  for (std::size_t first = 0, last = 0; first < sides.size(); first = last) {
    const auto& key = sides[first].key;
    for (last = first + 1; last < sides.size() && sides[last].key == key; ++last) {
      const std::size_t x = find_root(sides[first].tet), y = find_root(sides[last].tet);
      facts.components -= x != y ? 1 : 0;
      root[x] = y;
      facts.folded_faces += sides[last].outward == sides[first].outward ? 1 : 0;
    }
    facts.crowded_faces += last - first > 2 ? 1 : 0;
    if (last - first != 1) continue;
    facts.boundary.push_back(sides[first].outward);
    boundary_vertices.insert(boundary_vertices.end(), key.begin(), key.end());
    boundary_edges.insert(boundary_edges.end(), {{key[0], key[1]}, {key[0], key[2]}, {key[1], key[2]}});
  }
  facts.boundary_euler_characteristic = static_cast<std::int64_t>(distinct(boundary_vertices)) -
                                        static_cast<std::int64_t>(distinct(boundary_edges)) +
                                        static_cast<std::int64_t>(facts.boundary.size());
  std::sort(facts.boundary.begin(), facts.boundary.end());
  return facts;
}

} // namespace ptet::test
