#include "formats/surface/write.hpp"

#include "formats/file_names.hpp"
#include "formats/surface/formats.hpp"
#include "formats/whole_file.hpp"
#include "mesh/disjoint_sets.hpp"
#include "mesh/topology.hpp"
#include "mesh/vec3.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <limits>
#include <tuple>
#include <vector>

#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Core/System/omstream.hh>

namespace ptet {
namespace {

using namespace ptet::vec;

/// With 32-bit positions, which only STL takes: OpenMesh's writers read nothing wider, whatever the mesh holds.
using Surface = OpenMesh::TriMesh_ArrayKernelT<>;
using Faces = std::span<const std::array<VertexId, 3>>;

/// Corner 3 f + k is vertex k of face f.
using Corner = std::size_t;

/// Sets of corners that are one vertex of the surface.
using CornerSets = DisjointSets<Corner>;

void check(const std::string& path, const TetMesh& mesh, Faces faces, bool in_floats) {
  const auto fail = [&](std::size_t face, const char* what) {
    throw Error(ErrorCode::kBadInput, "cannot write " + path + ": face " + std::to_string(face) + what);
  };
  if (faces.size() > kMostSurfaceFaces)
    throw Error(ErrorCode::kLimit,
                "cannot write " + path + ": the surface has more than " + std::to_string(kMostSurfaceFaces) + " faces");
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto& [a, b, c] = faces[f];
    if (std::max({a, b, c}).index() >= mesh.vertex_count()) fail(f, " names a vertex that is not there");
    if (a == b || b == c || c == a) fail(f, " names a vertex twice");
    for (const VertexId v : faces[f]) {
      const Point p = mesh.position(v);
      if (!is_finite(p)) fail(f, " has a vertex whose position is not finite");
      const auto is_beyond = [](double x) { return std::abs(x) > std::numeric_limits<float>::max(); };
      if (in_floats && std::any_of(p.begin(), p.end(), is_beyond))
        fail(f, " has a vertex beyond the range of 32-bit floats, which .stl holds; .obj, .off and .ply hold more");
    }
  }
}

/// Faces are joined across edges of exactly two faces that run through it in opposite directions.
CornerSets join_fans(Faces faces) {
  struct Side {
    VertexId low, high;
    std::size_t face;
    int corner; ///< where the edge starts in the face
    bool forward;
  };
  std::vector<Side> sides;
  sides.reserve(3 * faces.size());
  for (std::size_t f = 0; f < faces.size(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const VertexId from = faces[f][static_cast<std::size_t>(k)];
      const VertexId to = faces[f][static_cast<std::size_t>((k + 1) % 3)];
      sides.push_back({std::min(from, to), std::max(from, to), f, k, from < to});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.low, a.high, a.face, a.corner) < std::tie(b.low, b.high, b.face, b.corner);
  });

  CornerSets sets(3 * faces.size());
  const auto start = [](const Side& side) { return 3 * side.face + static_cast<std::size_t>(side.corner); };
  const auto end = [](const Side& side) { return 3 * side.face + static_cast<std::size_t>((side.corner + 1) % 3); };
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t next = i + 1;
    while (next < sides.size() && sides[next].low == sides[i].low && sides[next].high == sides[i].high)
      ++next;
    if (next == i + 2 && sides[i].forward != sides[i + 1].forward) {
      sets.join(start(sides[i]), end(sides[i + 1]));
      sets.join(end(sides[i]), start(sides[i + 1]));
    }
    i = next;
  }
  return sets;
}

/// OpenMesh's streams, which write to the console, switched off while this lives.
class Silence {
public:
  Silence() {
    for (std::size_t i = 0; i < streams_.size(); ++i) {
      was_enabled_[i] = streams_[i]->is_enabled();
      streams_[i]->disable();
    }
  }
  ~Silence() {
    for (std::size_t i = 0; i < streams_.size(); ++i) {
      if (was_enabled_[i]) streams_[i]->enable();
    }
  }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

private:
  std::array<OpenMesh::mostream*, 3> streams_{&omlog(), &omout(), &omerr()};
  std::array<bool, 3> was_enabled_{};
};

/// OpenMesh prints when it refuses a face, so it is not asked in vain.
bool takes_face(const Surface& surface, const std::array<Surface::VertexHandle, 3>& corners) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (!surface.is_boundary(corners[k])) return false;
    const auto halfedge = surface.find_halfedge(corners[k], corners[(k + 1) % 3]);
    if (halfedge.is_valid() && !surface.is_boundary(halfedge)) return false;
  }
  return true;
}

/// A surface as OpenMesh connects it, without positions, and in rows in the same order.
struct Connected {
  Surface surface;
  SurfaceRows rows;
};

Connected connect(const TetMesh& mesh, Faces faces) {
  CornerSets sets = join_fans(faces);
  const auto vertex_of = [&](Corner corner) { return faces[corner / 3][corner % 3]; };
  std::vector<Corner> roots;
  for (Corner corner = 0; corner < 3 * faces.size(); ++corner) {
    if (sets.root(corner) == corner) roots.push_back(corner);
  }
  std::stable_sort(roots.begin(), roots.end(), [&](Corner a, Corner b) { return vertex_of(a) < vertex_of(b); });

  Connected result;
  auto& [surface, rows] = result;
  rows.positions = &mesh.positions;
  rows.faces.reserve(faces.size());
  surface.reserve(roots.size(), 3 * faces.size() / 2, faces.size());
  const auto add_vertex = [&, &surface = surface, &rows = rows](Corner corner) {
    rows.vertices.push_back(vertex_of(corner));
    return surface.add_vertex({0, 0, 0});
  };
  std::vector<Surface::VertexHandle> handle_of_root(3 * faces.size());
  for (const Corner root : roots)
    handle_of_root[root] = add_vertex(root);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    std::array<Surface::VertexHandle, 3> corners;
    for (std::size_t k = 0; k < 3; ++k)
      corners[k] = handle_of_root[sets.root(3 * f + k)];
    // Fans at the two ends of a non-manifold edge may each be one although the edge is complex; a face that OpenMesh
    // cannot hang in there stands alone.
    if (!takes_face(surface, corners)) {
      for (std::size_t k = 0; k < 3; ++k)
        corners[k] = add_vertex(3 * f + k);
    }
    surface.add_face(corners[0], corners[1], corners[2]);
    const auto row = [&](std::size_t k) { return static_cast<std::uint32_t>(corners[k].idx()); };
    rows.faces.push_back({row(0), row(1), row(2)});
  }
  return result;
}

/// Of vectors whose squares are beyond the doubles, too.
double length(const Vec3& a) {
  return std::hypot(a[0], a[1], a[2]);
}

Point in_floats(const Point& p) {
  return {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
}

bool has_area(const Point& a, const Point& b, const Point& c) {
  const Vec3 normal = cross(b - a, c - a);
  return normal[0] != 0 || normal[1] != 0 || normal[2] != 0;
}

double diagonal_of(const TetMesh& mesh, const SurfaceRows& rows) {
  if (rows.vertices.empty()) return 0;
  Point least = mesh.position(rows.vertices.front());
  Point most = least;
  for (const VertexId v : rows.vertices) {
    const Point p = mesh.position(v);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      least[axis] = std::min(least[axis], p[axis]);
      most[axis] = std::max(most[axis], p[axis]);
    }
  }
  return length(most - least);
}

SurfaceLoss loss_in_floats(const TetMesh& mesh, const SurfaceRows& rows) {
  SurfaceLoss loss;
  loss.diagonal = diagonal_of(mesh, rows);
  for (const VertexId v : rows.vertices) {
    const Point p = mesh.position(v);
    loss.largest_move = std::max(loss.largest_move, length(in_floats(p) - p));
  }
  for (const auto& face : rows.faces) {
    const auto corner = [&](std::size_t k) { return mesh.position(rows.vertices[face[k]]); };
    const std::array<Point, 3> given = {corner(0), corner(1), corner(2)};
    if (has_area(given[0], given[1], given[2]) &&
        !has_area(in_floats(given[0]), in_floats(given[1]), in_floats(given[2])))
      ++loss.degenerate_faces;
  }
  return loss;
}

void write_stl(const WholeFile& file, const TetMesh& mesh, Connected& connected) {
  auto& [surface, rows] = connected;
  for (std::size_t row = 0; row < rows.vertices.size(); ++row) {
    const Point p = mesh.position(rows.vertices[row]);
    surface.set_point(Surface::VertexHandle(static_cast<int>(row)),
                      {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
  }
  errno = 0;
  std::ofstream stream(file.temporary_path(), std::ios::binary);
  if (!stream) file.fail(errno != 0 ? errno : EIO);
  const Silence silence;
  errno = 0;
  const bool written = OpenMesh::IO::write_mesh(surface, stream, ".stl", OpenMesh::IO::Options::Binary);
  stream.flush();
  const bool flushed = stream.good();
  const int error_number = errno;
  stream.close();
  if (!flushed || stream.fail()) file.fail(error_number != 0 ? error_number : EIO);
  if (!written) file.fail("OpenMesh refused");
}

} // namespace

bool is_surface_name(const std::string& path) {
  static constexpr std::array kEndings = {".obj", ".ply", ".stl", ".off"};
  return std::find(kEndings.begin(), kEndings.end(), ending_of(path)) != kEndings.end();
}

SurfaceLoss write_surface(const std::string& path, const TetMesh& mesh, Faces faces) {
  if (!is_surface_name(path))
    throw Error(ErrorCode::kBadArgument, "cannot write " + path + ": a surface is written as .obj, .ply, .stl or .off");
  const std::string ending = ending_of(path);
  const bool is_stl = ending == ".stl";
  check(path, mesh, faces, is_stl);
  Connected connected = connect(mesh, faces);

  WholeFile file(path);
  if (is_stl)
    write_stl(file, mesh, connected);
  else if (ending == ".obj")
    write_obj(file, connected.rows);
  else if (ending == ".off")
    write_off(file, connected.rows);
  else
    write_ply(file, connected.rows);
  file.commit();
  return is_stl ? loss_in_floats(mesh, connected.rows) : SurfaceLoss{};
}

} // namespace ptet
