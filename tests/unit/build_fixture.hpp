// A mesh as the builder holds it, from a handful of points and tets; ids as given.
#pragma once

#include "build/collapse_check.hpp"
#include "build/working_complex.hpp"
#include "mesh/shape.hpp"
#include "mesh/topology.hpp"

#include <array>
#include <set>
#include <vector>

namespace ptet::build::test {

enum class Ghosts { kAll, kNone };

struct Fixture {
  std::vector<Point> points;
  WorkingComplex complex;

  /// `tets` that are negatively oriented are turned round.
  Fixture(std::vector<Point> at, const std::vector<std::array<Vertex, 4>>& tets, Ghosts ghosts = Ghosts::kAll)
      : points(std::move(at)), complex(make_complex(points, tets, ghosts)) {
    for (SlotId s = 0; s < complex.slot_count(); ++s) {
      Slot& slot = complex.slot(s);
      if (!complex.is_ghost(slot))
        slot.quality = std::max(0.0F, static_cast<float>(shape_quality(points[slot.v[0]], points[slot.v[1]],
                                                                       points[slot.v[2]], points[slot.v[3]])));
    }
  }

  [[nodiscard]] CollapseStatus examine(Vertex vs, Vertex vd, double min_quality = 0,
                                       std::uint32_t max_star = 64) const {
    return CollapseCheck(complex, points, min_quality, max_star).examine(vs, vd);
  }
  /// What is there, by its vertices; the dummy is the last id.
  [[nodiscard]] std::set<std::set<Vertex>> cells() const {
    std::set<std::set<Vertex>> found;
    for (Vertex v = 0; v < complex.vertex_count(); ++v)
      for (const SlotId s : complex.star(v))
        found.emplace(complex.slot(s).v.begin(), complex.slot(s).v.end());
    return found;
  }

private:
  static WorkingComplex make_complex(const std::vector<Point>& points, const std::vector<std::array<Vertex, 4>>& rows,
                                     Ghosts ghosts) {
    std::vector<Tet> tets;
    for (const auto& row : rows) {
      Tet tet = {VertexId{row[0]}, VertexId{row[1]}, VertexId{row[2]}, VertexId{row[3]}};
      if (orientation(points[row[0]], points[row[1]], points[row[2]], points[row[3]]) < 0) std::swap(tet[2], tet[3]);
      tets.push_back(tet);
    }
    std::vector<Face> faces;
    if (ghosts == Ghosts::kAll)
      faces = build_boundary(tets, build_face_table(tets, points.size()), points.size()).faces;
    return WorkingComplex(static_cast<std::uint32_t>(points.size()), tets, faces);
  }
};

/// Four tets around the edge from the tip (0) to the foot (1), on a square ring (2 3 4 5) at z = 0:
///
///        0 (0, 0, tip)
///     3 ------- 2       2 (1, 1, 0)   3 (-1, 1, 0)   4 (-1, -1, 0)   5 (1, -1, 0)
///    /    .    /
///   4 ------- 5
///        1 (0, 0, foot)
inline Fixture tent(double tip, double foot = -2) {
  return {{{0, 0, tip}, {0, 0, foot}, {1, 1, 0}, {-1, 1, 0}, {-1, -1, 0}, {1, -1, 0}},
          {{0, 1, 2, 3}, {0, 1, 3, 4}, {0, 1, 4, 5}, {0, 1, 5, 2}}};
}

} // namespace ptet::build::test
