#include "formats/vtk/split_cell.hpp"

#include <algorithm>

#include <vtkCellType.h>

namespace ptet::vtkio {
namespace {

/// A face of a linear cell, outward oriented; a triangle when the last corner is kNoCorner.
constexpr std::uint8_t kNoCorner = 255;
using Face = std::array<std::uint8_t, 4>;

constexpr std::array<Face, 6> kHexahedron = {
    {{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4}, {3, 7, 6, 2}, {0, 3, 2, 1}, {4, 5, 6, 7}}};
constexpr std::array<Face, 6> kVoxel = {
    {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
constexpr std::array<Face, 5> kWedge = {
    {{0, 1, 2, kNoCorner}, {3, 5, 4, kNoCorner}, {0, 3, 4, 1}, {1, 4, 5, 2}, {2, 5, 3, 0}}};
constexpr std::array<Face, 5> kPyramid = {
    {{0, 3, 2, 1}, {0, 1, 4, kNoCorner}, {1, 2, 4, kNoCorner}, {2, 3, 4, kNoCorner}, {3, 0, 4, kNoCorner}}};

void append_if_proper(const Tet& tet, std::vector<Tet>& tets) {
  for (int i = 0; i < 4; ++i) {
    for (int j = i + 1; j < 4; ++j) {
      if (tet[i] == tet[j]) return;
    }
  }
  tets.push_back(tet);
}

void cone(std::span<const Face> faces, std::span<const VertexId> points, const Ranks& ranks, std::vector<Tet>& tets) {
  const auto earlier = [&](std::uint8_t a, std::uint8_t b) { return ranks[a] < ranks[b]; };
  const auto ranked_end = ranks.begin() + static_cast<std::ptrdiff_t>(points.size());
  const auto apex = static_cast<std::uint8_t>(std::min_element(ranks.begin(), ranked_end) - ranks.begin());
  for (const Face& face : faces) {
    Face corner = face;
    const bool is_triangle = face[3] == kNoCorner;
    const auto end = corner.end() - (is_triangle ? 1 : 0);
    // By rank, not by corner: a degenerate cell may name its first point twice.
    if (std::any_of(corner.begin(), end, [&](std::uint8_t c) { return ranks[c] == ranks[apex]; })) continue;
    std::rotate(corner.begin(), std::min_element(corner.begin(), end, earlier), end);
    append_if_proper({points[apex], points[corner[0]], points[corner[1]], points[corner[2]]}, tets);
    if (!is_triangle) append_if_proper({points[apex], points[corner[0]], points[corner[2]], points[corner[3]]}, tets);
  }
}

double squared_distance(const Point& a, const Point& b) {
  return (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]);
}

void split_quadratic(std::span<const VertexId> p, const TetMesh& mesh, std::vector<Tet>& tets) {
  static constexpr std::uint8_t kCorners[4][4] = {{0, 4, 6, 7}, {4, 1, 5, 8}, {6, 5, 2, 9}, {7, 8, 9, 3}};
  for (const auto& c : kCorners)
    append_if_proper({p[c[0]], p[c[1]], p[c[2]], p[c[3]]}, tets);

  // Each diagonal with the four points around it, so ordered that (from, to, ring[i], ring[i + 1]) is positive.
  struct Diagonal {
    std::uint8_t from, to, ring[4];
  };
  static constexpr Diagonal kDiagonals[3] = {{4, 9, {5, 6, 7, 8}}, {5, 7, {6, 4, 8, 9}}, {6, 8, {4, 5, 9, 7}}};
  const Diagonal* best = nullptr;
  double best_length = 0;
  for (const Diagonal& diagonal : kDiagonals) {
    const double length = squared_distance(mesh.position(p[diagonal.from]), mesh.position(p[diagonal.to]));
    if (best && !(length < best_length)) continue;
    best = &diagonal;
    best_length = length;
  }
  for (int i = 0; i < 4; ++i) {
    append_if_proper({p[best->from], p[best->to], p[best->ring[i]], p[best->ring[(i + 1) % 4]]}, tets);
  }
}

} // namespace

std::size_t splittable_size(int vtk_cell_type) {
  switch (vtk_cell_type) {
  case VTK_TETRA: return 4;
  case VTK_PYRAMID: return 5;
  case VTK_WEDGE: return 6;
  case VTK_VOXEL:
  case VTK_HEXAHEDRON: return 8;
  case VTK_QUADRATIC_TETRA: return 10;
  default: return 0;
  }
}

void split_cell(int vtk_cell_type, std::span<const VertexId> points, const Ranks& ranks, const TetMesh& positions,
                std::vector<Tet>& tets) {
  switch (vtk_cell_type) {
  case VTK_PYRAMID: cone(kPyramid, points, ranks, tets); break;
  case VTK_WEDGE: cone(kWedge, points, ranks, tets); break;
  case VTK_VOXEL: cone(kVoxel, points, ranks, tets); break;
  case VTK_HEXAHEDRON: cone(kHexahedron, points, ranks, tets); break;
  case VTK_QUADRATIC_TETRA: split_quadratic(points, positions, tets); break;
  default: break;
  }
}

} // namespace ptet::vtkio
