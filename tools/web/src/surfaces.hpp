// Triangles to draw out of a session's mesh: its boundary, what a plane leaves of its cells, and contours, that is
// slices and isosurfaces.
//
//   cells cut open           contour
//    ____                     ____
//   |\  /| kept: every       |\ _/|   one polygon in each tet
//   |_\/ | tet that is not   |-/\-|   that has values on both sides
//   |_/\_| before the plane  |/__\|
//    ----- plane
#pragma once

#include "ptet/mesh.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace ptet::web {

/// The points x with dot(normal, x) = offset. Before it: dot(normal, x) > offset.
struct Plane {
  Point normal{};
  double offset = 0;
};

/// A session's mesh (slots, unused ones included) with what is drawn of it, by vertex slot.
struct Scene {
  std::span<const std::array<std::uint32_t, 4>> tets;
  std::span<const std::array<std::uint32_t, 3>> boundary_faces;
  std::span<const Point> points;
  std::span<const double> colours; ///< the field that is shown
};

/// Triangles that share nothing, in 32-bit floats as a graphics card takes them.
struct Triangles {
  std::vector<float> positions; ///< 9 each, relative to the origin that was given
  std::vector<float> colours;   ///< 3 each
  /// 12 each: for each corner its barycentric coordinates, 0 or 255, and a byte of no meaning. Where an edge is not one
  /// of the mesh, the coordinate that would be 0 along it is 255 at all three corners.
  std::vector<std::uint8_t> barycentric;

  [[nodiscard]] std::size_t size() const { return positions.size() / 9; }
};

/// The boundary; with a plane that of the tets that are not wholly before it.
[[nodiscard]] Triangles surface(const Scene& scene, const std::optional<Plane>& cut, const Point& origin);

/// Where the function that is linear in every tet and has these values at the vertex slots is `level`.
[[nodiscard]] Triangles contour(const Scene& scene, std::span<const double> values, double level, const Point& origin);

/// Signed distances of the points to the plane, times the length of its normal.
[[nodiscard]] std::vector<double> heights(std::span<const Point> points, const Plane& plane);

} // namespace ptet::web
