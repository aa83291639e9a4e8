#include "formats/vtk/split_cell.hpp"

#include <algorithm>
#include <utility>

#include <vtkCellType.h>

namespace ptet::vtkio {
namespace {

/// A face of a convex part, outward oriented; a triangle when the last corner is kNoCorner.
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

// Cells with a point in the middle of each edge: what these cut off at corners of three edges, and the faces of what is
// left, first those within the cell's own.
using Corner = std::array<std::uint8_t, 4>;
constexpr std::array<Corner, 8> kHexahedronCorners = {{{0, 16, 8, 11},
                                                       {1, 9, 8, 17},
                                                       {2, 10, 9, 18},
                                                       {3, 11, 10, 19},
                                                       {4, 15, 12, 16},
                                                       {5, 17, 12, 13},
                                                       {6, 18, 13, 14},
                                                       {7, 19, 14, 15}}};
constexpr std::array<Face, 14> kHexahedronCore = {{{16, 15, 19, 11},
                                                   {9, 18, 13, 17},
                                                   {8, 17, 12, 16},
                                                   {19, 14, 18, 10},
                                                   {11, 10, 9, 8},
                                                   {12, 13, 14, 15},
                                                   {8, 16, 11, kNoCorner},
                                                   {8, 9, 17, kNoCorner},
                                                   {9, 10, 18, kNoCorner},
                                                   {10, 11, 19, kNoCorner},
                                                   {12, 15, 16, kNoCorner},
                                                   {12, 17, 13, kNoCorner},
                                                   {13, 18, 14, kNoCorner},
                                                   {14, 19, 15, kNoCorner}}};
constexpr std::array<Corner, 6> kWedgeCorners = {
    {{0, 12, 6, 8}, {1, 7, 6, 13}, {2, 8, 7, 14}, {3, 11, 9, 12}, {4, 13, 9, 10}, {5, 14, 10, 11}}};
constexpr std::array<Face, 11> kWedgeCore = {{{8, 7, 6, kNoCorner},
                                              {9, 10, 11, kNoCorner},
                                              {6, 13, 9, 12},
                                              {7, 14, 10, 13},
                                              {8, 12, 11, 14},
                                              {6, 12, 8, kNoCorner},
                                              {6, 7, 13, kNoCorner},
                                              {7, 8, 14, kNoCorner},
                                              {9, 11, 12, kNoCorner},
                                              {9, 13, 10, kNoCorner},
                                              {10, 14, 11, kNoCorner}}};
constexpr std::array<Corner, 4> kPyramidCorners = {{{0, 9, 5, 8}, {1, 6, 5, 10}, {2, 7, 6, 11}, {3, 8, 7, 12}}};
/// Below the pyramid that is cut off at the tip.
constexpr std::array<Face, 10> kPyramidCore = {{{8, 7, 6, 5},
                                                {5, 10, 9, kNoCorner},
                                                {6, 11, 10, kNoCorner},
                                                {7, 12, 11, kNoCorner},
                                                {8, 9, 12, kNoCorner},
                                                {5, 9, 8, kNoCorner},
                                                {5, 6, 10, kNoCorner},
                                                {6, 7, 11, kNoCorner},
                                                {7, 8, 12, kNoCorner},
                                                {9, 10, 11, 12}}};
constexpr std::array<Face, 5> kPyramidTip = {
    {{9, 12, 11, 10}, {9, 10, 4, kNoCorner}, {10, 11, 4, kNoCorner}, {11, 12, 4, kNoCorner}, {12, 9, 4, kNoCorner}}};

// Cells with points in the middles of their quadrilaterals, too: the linear ones that they consist of.
constexpr std::array<std::array<std::uint8_t, 8>, 8> kHexahedra = {{{0, 8, 24, 11, 16, 22, 26, 20},
                                                                    {8, 1, 9, 24, 22, 17, 21, 26},
                                                                    {11, 24, 10, 3, 20, 26, 23, 19},
                                                                    {24, 9, 2, 10, 26, 21, 18, 23},
                                                                    {16, 22, 26, 20, 4, 12, 25, 15},
                                                                    {22, 17, 21, 26, 12, 5, 13, 25},
                                                                    {20, 26, 23, 19, 15, 25, 14, 7},
                                                                    {26, 21, 18, 23, 25, 13, 6, 14}}};
/// VTK has the triangles of this kind the other way round than those of linear wedges.
constexpr std::array<std::array<std::uint8_t, 6>, 8> kWedges = {{{0, 8, 6, 12, 17, 15},
                                                                 {6, 7, 1, 15, 16, 13},
                                                                 {8, 2, 7, 17, 14, 16},
                                                                 {6, 8, 7, 15, 17, 16},
                                                                 {12, 17, 15, 3, 11, 9},
                                                                 {15, 16, 13, 9, 10, 4},
                                                                 {17, 14, 16, 11, 5, 10},
                                                                 {15, 17, 16, 9, 11, 10}}};

void cone(std::span<const Face> faces, std::span<const VertexId> points, const Ranks& ranks, std::vector<Tet>& tets) {
  const auto earlier = [&](std::uint8_t a, std::uint8_t b) { return ranks[a] < ranks[b]; };
  std::uint8_t apex = faces[0][0];
  for (const Face& face : faces)
    for (const std::uint8_t c : face)
      if (c != kNoCorner && earlier(c, apex)) apex = c;
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

void cut_off(std::span<const Corner> corners, std::span<const VertexId> points, std::vector<Tet>& tets) {
  for (const Corner& c : corners)
    append_if_proper({points[c[0]], points[c[1]], points[c[2]], points[c[3]]}, tets);
}

template <std::size_t N>
void cone_parts(std::span<const std::array<std::uint8_t, N>> parts, std::span<const Face> faces,
                std::span<const VertexId> points, const Ranks& ranks, std::vector<Tet>& tets) {
  std::array<VertexId, N> part_points;
  Ranks part_ranks{};
  for (const auto& part : parts) {
    for (std::size_t i = 0; i < N; ++i) {
      part_points[i] = points[part[i]];
      part_ranks[i] = ranks[part[i]];
    }
    cone(faces, part_points, part_ranks, tets);
  }
}

double squared_distance(const Point& a, const Point& b) {
  return (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]);
}

void split_quadratic_tet(std::span<const VertexId> p, const TetMesh& mesh, std::vector<Tet>& tets) {
  static constexpr std::array<Corner, 4> kCorners = {{{0, 4, 6, 7}, {4, 1, 5, 8}, {6, 5, 2, 9}, {7, 8, 9, 3}}};
  cut_off(kCorners, p, tets);

  split_octahedron({p[4], p[9], p[5], p[7], p[6], p[8]}, mesh, tets);
}

} // namespace

void append_if_proper(const Tet& tet, std::vector<Tet>& tets) {
  for (int i = 0; i < 4; ++i) {
    for (int j = i + 1; j < 4; ++j) {
      if (tet[i] == tet[j]) return;
    }
  }
  tets.push_back(tet);
}

void split_octahedron(const std::array<VertexId, 6>& corners, const TetMesh& positions, std::vector<Tet>& tets) {
  // Each diagonal with the four corners around it, so ordered that (from, to, ring[i], ring[i + 1]) is positive.
  struct Diagonal {
    std::uint8_t from, to, ring[4];
  };
  static constexpr Diagonal kDiagonals[3] = {{0, 1, {2, 4, 3, 5}}, {2, 3, {4, 0, 5, 1}}, {4, 5, {0, 2, 1, 3}}};
  const Diagonal* best = nullptr;
  double best_length = 0;
  for (const Diagonal& diagonal : kDiagonals) {
    const double length =
        squared_distance(positions.position(corners[diagonal.from]), positions.position(corners[diagonal.to]));
    if (best && !(length < best_length)) continue;
    best = &diagonal;
    best_length = length;
  }
  for (int i = 0; i < 4; ++i)
    append_if_proper({corners[best->from], corners[best->to], corners[best->ring[i]], corners[best->ring[(i + 1) % 4]]},
                     tets);
}

CellSize cell_size(int vtk_cell_type) {
  switch (vtk_cell_type) {
  case VTK_TETRA: return {4, 1};
  case VTK_PYRAMID: return {5, 2};
  case VTK_WEDGE: return {6, 3};
  case VTK_VOXEL:
  case VTK_HEXAHEDRON: return {8, 6};
  case VTK_QUADRATIC_TETRA: return {10, 8};
  case VTK_QUADRATIC_PYRAMID: return {13, 13};
  case VTK_QUADRATIC_WEDGE: return {15, 15};
  case VTK_BIQUADRATIC_QUADRATIC_WEDGE: return {18, 24};
  case VTK_QUADRATIC_HEXAHEDRON: return {20, 22};
  case VTK_TRIQUADRATIC_HEXAHEDRON: return {27, 48};
  default: return {0, 0};
  }
}

int plain_type(int vtk_cell_type, std::uint64_t points) {
  switch (vtk_cell_type) {
  case VTK_LAGRANGE_TETRAHEDRON: return points == 4 ? VTK_TETRA : points == 10 ? VTK_QUADRATIC_TETRA : vtk_cell_type;
  case VTK_LAGRANGE_WEDGE:
    return points == 6 ? VTK_WEDGE : points == 18 ? VTK_BIQUADRATIC_QUADRATIC_WEDGE : vtk_cell_type;
  case VTK_LAGRANGE_HEXAHEDRON:
    return points == 8 ? VTK_HEXAHEDRON : points == 27 ? VTK_TRIQUADRATIC_HEXAHEDRON : vtk_cell_type;
  default: return vtk_cell_type;
  }
}

void to_plain_order(int vtk_cell_type, std::span<VertexId> points) {
  if (vtk_cell_type != VTK_LAGRANGE_WEDGE || points.size() != 6) return;
  std::swap(points[1], points[2]);
  std::swap(points[4], points[5]);
}

bool has_diagonals(int vtk_cell_type) {
  return vtk_cell_type != VTK_TETRA && vtk_cell_type != VTK_QUADRATIC_TETRA;
}

void split_cell(int vtk_cell_type, std::span<const VertexId> points, const Ranks& ranks, const TetMesh& positions,
                std::vector<Tet>& tets) {
  switch (vtk_cell_type) {
  case VTK_PYRAMID: cone(kPyramid, points, ranks, tets); break;
  case VTK_WEDGE: cone(kWedge, points, ranks, tets); break;
  case VTK_VOXEL: cone(kVoxel, points, ranks, tets); break;
  case VTK_HEXAHEDRON: cone(kHexahedron, points, ranks, tets); break;
  case VTK_QUADRATIC_TETRA: split_quadratic_tet(points, positions, tets); break;
  case VTK_QUADRATIC_PYRAMID:
    cut_off(kPyramidCorners, points, tets);
    cone(kPyramidCore, points, ranks, tets);
    cone(kPyramidTip, points, ranks, tets);
    break;
  case VTK_QUADRATIC_WEDGE:
    cut_off(kWedgeCorners, points, tets);
    cone(kWedgeCore, points, ranks, tets);
    break;
  case VTK_QUADRATIC_HEXAHEDRON:
    cut_off(kHexahedronCorners, points, tets);
    cone(kHexahedronCore, points, ranks, tets);
    break;
  case VTK_BIQUADRATIC_QUADRATIC_WEDGE: cone_parts<6>(kWedges, kWedge, points, ranks, tets); break;
  case VTK_TRIQUADRATIC_HEXAHEDRON: cone_parts<8>(kHexahedra, kHexahedron, points, ranks, tets); break;
  default: break;
  }
}

} // namespace ptet::vtkio
