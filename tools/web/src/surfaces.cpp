#include "surfaces.hpp"

#include "ptet/session.hpp"

#include <algorithm>
#include <utility>

namespace ptet::web {
namespace {

struct Corner {
  Point point;
  double colour = 0;
};

class Writer {
public:
  explicit Writer(const Point& origin) : origin_(origin) {}

  /// `edges`: bit i, whether the edge opposite corner i is one of the mesh.
  void add(const std::array<Corner, 3>& corners, unsigned edges = 7) {
    for (unsigned c = 0; c < 3; ++c) {
      for (unsigned axis = 0; axis < 3; ++axis)
        out_.positions.push_back(static_cast<float>(corners[c].point[axis] - origin_[axis]));
      out_.colours.push_back(static_cast<float>(corners[c].colour));
      for (unsigned i = 0; i < 4; ++i)
        out_.barycentric.push_back(i == c || (i < 3 && (edges >> i & 1U) == 0) ? 255 : 0);
    }
  }
  [[nodiscard]] Triangles take() { return std::move(out_); }

private:
  Point origin_;
  Triangles out_;
};

Corner at(const Scene& scene, std::uint32_t slot) {
  return {scene.points[slot], scene.colours[slot]};
}

using Face = std::array<std::uint32_t, 3>;

Face sorted(Face face) {
  std::sort(face.begin(), face.end());
  return face;
}

// Faces that the cut lays open lie wholly before the plane, and what was behind them does, too. A tet has one such face
// at most, if it has exactly one vertex that is not before the plane.
std::vector<Face> laid_open(const Scene& scene, std::span<const double> height) {
  struct Keyed {
    Face key, face;
  };
  std::vector<Keyed> faces;
  for (const auto& tet : scene.tets) {
    if (tet[0] == Session::kUnused) continue;
    unsigned behind = 0, last = 0;
    for (unsigned k = 0; k < 4; ++k)
      if (height[tet[k]] <= 0) ++behind, last = k;
    if (behind != 1) continue;
    // Seen from outside counter-clockwise: corners behind an odd place turn the other way.
    Face face{tet[(last + 1) % 4], tet[(last + 2) % 4], tet[(last + 3) % 4]};
    if (last % 2 == 1) std::swap(face[1], face[2]);
    faces.push_back({sorted(face), face});
  }
  std::sort(faces.begin(), faces.end(), [](const Keyed& a, const Keyed& b) { return a.key < b.key; });
  std::vector<Face> open;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    if (i + 1 < faces.size() && faces[i].key == faces[i + 1].key) {
      ++i; // between two tets that stay
      continue;
    }
    open.push_back(faces[i].face);
  }
  return open;
}

} // namespace

std::vector<double> heights(std::span<const Point> points, const Plane& plane) {
  std::vector<double> result;
  result.reserve(points.size());
  for (const Point& p : points)
    result.push_back(plane.normal[0] * p[0] + plane.normal[1] * p[1] + plane.normal[2] * p[2] - plane.offset);
  return result;
}

Triangles surface(const Scene& scene, const std::optional<Plane>& cut, const Point& origin) {
  Writer writer(origin);
  const auto add = [&](const Face& face) { writer.add({at(scene, face[0]), at(scene, face[1]), at(scene, face[2])}); };
  std::vector<double> height;
  if (cut) height = heights(scene.points, *cut);
  for (const Face& face : scene.boundary_faces) {
    if (face[0] == Session::kUnused) continue;
    // Those wholly before the plane are laid open, or go with their tet.
    if (cut && height[face[0]] > 0 && height[face[1]] > 0 && height[face[2]] > 0) continue;
    add(face);
  }
  if (cut)
    for (const Face& face : laid_open(scene, height))
      add(face);
  return writer.take();
}

Triangles contour(const Scene& scene, std::span<const double> values, double level, const Point& origin) {
  Writer writer(origin);
  // The same point for every tet at the edge: always from the smaller slot.
  const auto crossing = [&](std::uint32_t a, std::uint32_t b) {
    if (b < a) std::swap(a, b);
    const double t = (level - values[a]) / (values[b] - values[a]);
    Corner corner;
    for (unsigned axis = 0; axis < 3; ++axis)
      corner.point[axis] = scene.points[a][axis] + t * (scene.points[b][axis] - scene.points[a][axis]);
    corner.colour = scene.colours[a] + t * (scene.colours[b] - scene.colours[a]);
    return corner;
  };
  for (const auto& tet : scene.tets) {
    if (tet[0] == Session::kUnused) continue;
    std::array<std::uint32_t, 4> order{};
    unsigned above = 0, below = 4;
    for (const std::uint32_t v : tet) // what has no value (NaN) is below
      order[values[v] >= level ? above++ : --below] = v;
    const auto& [a, b, c, d] = order;
    if (above == 1) writer.add({crossing(a, b), crossing(a, c), crossing(a, d)});
    if (above == 3) writer.add({crossing(a, d), crossing(b, d), crossing(c, d)});
    if (above == 2) {
      const std::array quad{crossing(a, c), crossing(a, d), crossing(b, d), crossing(b, c)};
      writer.add({quad[0], quad[1], quad[2]}, 0b101);
      writer.add({quad[0], quad[2], quad[3]}, 0b011);
    }
  }
  return writer.take();
}

} // namespace ptet::web
