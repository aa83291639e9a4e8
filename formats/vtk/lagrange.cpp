#include "formats/vtk/lagrange.hpp"

#include <vtkCellType.h>
#include <vtkHigherOrderHexahedron.h>
#include <vtkHigherOrderTetra.h>
#include <vtkHigherOrderWedge.h>

namespace ptet::vtkio {
namespace {

constexpr int kLeastOrder = 3, kMostOrder = 64;

/// 0: none.
int order_of(int type, std::uint64_t points) {
  if (lagrange_points(type, kLeastOrder) == 0) return 0;
  for (int order = kLeastOrder; order <= kMostOrder; ++order)
    if (lagrange_points(type, static_cast<std::uint64_t>(order)) == points) return order;
  return 0;
}

LagrangeParts parts_of_tet(int order) {
  LagrangeParts parts;
  // By steps from the first corner along its three edges.
  const auto at = [order](int i, int j, int k) {
    const std::array<vtkIdType, 4> steps = {i, j, k, order - i - j - k};
    return static_cast<std::uint32_t>(vtkHigherOrderTetra::Index(steps.data(), order));
  };
  for (int k = 0; k < order; ++k)
    for (int j = 0; j < order - k; ++j)
      for (int i = 0; i < order - k - j; ++i) {
        const int left = order - i - j - k;
        parts.tets.push_back({at(i, j, k), at(i + 1, j, k), at(i, j + 1, k), at(i, j, k + 1)});
        if (left >= 2)
          parts.octahedra.push_back({at(i + 1, j, k), at(i, j + 1, k + 1), at(i + 1, j + 1, k), at(i, j, k + 1),
                                     at(i, j + 1, k), at(i + 1, j, k + 1)});
        if (left >= 3)
          parts.tets.push_back(
              {at(i + 1, j + 1, k), at(i, j + 1, k + 1), at(i + 1, j, k + 1), at(i + 1, j + 1, k + 1)});
      }
  return parts;
}

LagrangeParts parts_of_hexahedron(int order) {
  LagrangeParts parts;
  const std::array orders = {order, order, order};
  const auto at = [&](int i, int j, int k) {
    return static_cast<std::uint32_t>(vtkHigherOrderHexahedron::PointIndexFromIJK(i, j, k, orders.data()));
  };
  for (int k = 0; k < order; ++k)
    for (int j = 0; j < order; ++j)
      for (int i = 0; i < order; ++i)
        parts.hexahedra.push_back({at(i, j, k), at(i + 1, j, k), at(i + 1, j + 1, k), at(i, j + 1, k), at(i, j, k + 1),
                                   at(i + 1, j, k + 1), at(i + 1, j + 1, k + 1), at(i, j + 1, k + 1)});
  return parts;
}

LagrangeParts parts_of_wedge(int order) {
  LagrangeParts parts;
  const auto points = static_cast<int>(lagrange_points(VTK_LAGRANGE_WEDGE, static_cast<std::uint64_t>(order)));
  const std::array orders = {order, order, order, points}; // VTK reads all four
  const auto at = [&](int i, int j, int k) {
    return static_cast<std::uint32_t>(vtkHigherOrderWedge::PointIndexFromIJK(i, j, k, orders.data()));
  };
  // VTK's linear wedges have their triangles the other way round.
  const auto add = [&](std::array<int, 2> a, std::array<int, 2> b, std::array<int, 2> c, int k) {
    parts.wedges.push_back({at(a[0], a[1], k), at(c[0], c[1], k), at(b[0], b[1], k), at(a[0], a[1], k + 1),
                            at(c[0], c[1], k + 1), at(b[0], b[1], k + 1)});
  };
  for (int k = 0; k < order; ++k)
    for (int j = 0; j < order; ++j)
      for (int i = 0; i < order - j; ++i) {
        add({i, j}, {i + 1, j}, {i, j + 1}, k);
        if (i + j + 2 <= order) add({i + 1, j}, {i + 1, j + 1}, {i, j + 1}, k);
      }
  return parts;
}

} // namespace

std::uint64_t lagrange_points(int vtk_cell_type, std::uint64_t order) {
  const std::uint64_t n = order + 1;
  switch (vtk_cell_type) {
  case VTK_LAGRANGE_TETRAHEDRON: return n * (n + 1) * (n + 2) / 6;
  case VTK_LAGRANGE_HEXAHEDRON: return n * n * n;
  case VTK_LAGRANGE_WEDGE: return n * (n + 1) / 2 * n;
  default: return 0;
  }
}

const LagrangeParts* LagrangeCells::parts_of(int vtk_cell_type, std::uint64_t points) {
  const auto known = known_.find({vtk_cell_type, points});
  if (known != known_.end()) return &known->second;
  const int order = order_of(vtk_cell_type, points);
  if (order == 0) return nullptr;
  LagrangeParts& parts = known_[{vtk_cell_type, points}];
  parts = vtk_cell_type == VTK_LAGRANGE_TETRAHEDRON  ? parts_of_tet(order)
          : vtk_cell_type == VTK_LAGRANGE_HEXAHEDRON ? parts_of_hexahedron(order)
                                                     : parts_of_wedge(order);
  return &parts;
}

} // namespace ptet::vtkio
