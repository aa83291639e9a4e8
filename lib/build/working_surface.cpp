#include "build/working_surface.hpp"

#include "build/collapse_geometry.hpp"
#include "build/face_index.hpp"
#include "mesh/disjoint_sets.hpp"
#include "mesh/face_plane.hpp"
#include "mesh/predicates.hpp"
#include "mesh/topology.hpp"
#include "mesh/vec3.hpp"
#include "ptet/error.hpp"

// OpenMesh's headers are not clean under our warnings.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wnon-virtual-dtor"
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#pragma GCC diagnostic pop

#include <algorithm>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <tuple>

namespace ptet::build {
using namespace vec;
namespace {

/// Distances below this fraction of the diagonal are rounding.
constexpr double kSurfaceRounding = 1e-13;

struct SurfaceTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  VertexAttributes(OpenMesh::Attributes::Status);
  EdgeAttributes(OpenMesh::Attributes::Status);
  FaceAttributes(OpenMesh::Attributes::Status);
  VertexTraits { std::uint32_t mesh_vertex = kNone; };
  FaceTraits { std::uint32_t first_sample = kNone; };
};
using Surface = OpenMesh::TriMesh_ArrayKernelT<SurfaceTraits>;
using VertexHandle = Surface::VertexHandle;
using FaceHandle = Surface::FaceHandle;
using HalfedgeHandle = Surface::HalfedgeHandle;

using Triangle = std::array<Vertex, 3>;

/// The face of a ghost, outward oriented.
Triangle face_of(const Slot& ghost, Vertex dummy) {
  // (a, b, c, dummy) is positive; moving the dummy from corner i to the last one must keep the parity.
  static constexpr std::array<std::array<std::size_t, 3>, 4> kFace{{{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}}};
  for (std::size_t i = 0; i < 4; ++i)
    if (ghost.v[i] == dummy) return {ghost.v[kFace[i][0]], ghost.v[kFace[i][1]], ghost.v[kFace[i][2]]};
  return {kNone, kNone, kNone};
}

Face ids(const Triangle& t) {
  return {VertexId{t[0]}, VertexId{t[1]}, VertexId{t[2]}};
}

/// Classes of face corners that are joined by manifold edges: one surface vertex for each.
class CornerClasses {
public:
  explicit CornerClasses(const std::vector<Triangle>& faces) : sets_(3 * faces.size()) {
    struct Side {
      Vertex low, high;
      std::uint32_t face, corner; ///< corner of `low`'s side: the edge runs from `corner` to the next one
    };
    std::vector<Side> sides;
    sides.reserve(3 * faces.size());
    for (std::uint32_t f = 0; f < faces.size(); ++f)
      for (std::uint32_t i = 0; i < 3; ++i) {
        const auto [low, high] = std::minmax(faces[f][i], faces[f][(i + 1) % 3]);
        sides.push_back({low, high, f, i});
      }
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
      return std::tie(a.low, a.high, a.face, a.corner) < std::tie(b.low, b.high, b.face, b.corner);
    });
    for (std::size_t i = 0; i < sides.size();) {
      std::size_t end = i + 1;
      while (end < sides.size() && sides[end].low == sides[i].low && sides[end].high == sides[i].high)
        ++end;
      if (end - i == 2) {
        const Side& a = sides[i];
        const Side& b = sides[i + 1];
        const auto start = [](const Side& s) { return 3 * s.face + s.corner; };
        const auto stop = [](const Side& s) { return 3 * s.face + (s.corner + 1) % 3; };
        // Neighbours run along their common edge in opposite directions.
        if (faces[a.face][a.corner] != faces[b.face][b.corner]) {
          sets_.join(start(a), stop(b));
          sets_.join(stop(a), start(b));
        }
      }
      i = end;
    }
  }
  [[nodiscard]] std::uint32_t of(std::uint32_t face, std::uint32_t corner) { return sets_.root(3 * face + corner); }

private:
  DisjointSets<> sets_;
};

} // namespace

struct WorkingSurface::Impl {
  Impl(const std::vector<Point>& p, std::span<const std::uint32_t> crossing_curves)
      : positions(p), relative(p), crossings(crossing_curves) {
    for (Point& x : relative)
      x = x - p.front();
  }

  const std::vector<Point>& positions;
  std::vector<Point> relative; ///< to the first: points between them are rounded by the size of the mesh
  double rounding = 0;
  Surface surface;
  std::vector<VertexHandle> handle;       ///< by mesh vertex; only one is kept where there are several (frozen)
  std::vector<Point> centroids;           ///< relative; samples behind the vertices: sample vertex_count + i
  std::vector<std::uint32_t> next_sample; ///< by sample: the next one that the same face holds
  FaceIndex index;
  SelfCrossings crossings;
  SlotId first_ghost = 0;
  std::vector<SelfCrossings::Set> curves; ///< by ghost; none where the original does not cross itself
  std::vector<std::uint32_t> shell;       ///< by ghost: the number of its shell; none where there is but one, 0
  std::vector<std::uint32_t> shell_size;  ///< by shell: the faces that are left of it

  std::optional<BoundaryPieces> pieces; ///< where domain errors are to be bounds: what the faces hold

  /// `classes`: of the corners of the faces, which are those of the ghosts.
  void find_shells(CornerClasses& classes, std::size_t face_count, std::span<const std::uint32_t> crossing_curves) {
    DisjointSets<> shells(face_count);
    std::vector<std::uint32_t> of_class(3 * face_count, kNone);
    std::map<std::uint32_t, std::uint32_t> of_curve; // those of a piece are numbers of the whole mesh
    const auto join = [&](std::uint32_t face, std::uint32_t& first) {
      if (first == kNone) first = face;
      shells.join(face, first);
    };
    for (std::uint32_t f = 0; f < face_count; ++f) {
      for (std::uint32_t i = 0; i < 3; ++i)
        join(f, of_class[classes.of(f, i)]);
      if (!crossing_curves.empty() && crossing_curves[f] != 0)
        join(f, of_curve.try_emplace(crossing_curves[f], kNone).first->second);
    }
    shell_size.assign(face_count, 0);
    for (std::uint32_t f = 0; f < face_count; ++f) {
      if (shells.count() > 1) shell.push_back(shells.root(f));
      ++shell_size[shell_of(first_ghost + f)];
    }
  }
  /// 0 of every face where there is but one shell.
  [[nodiscard]] std::uint32_t shell_of(SlotId ghost) const { return shell.empty() ? 0 : shell[ghost - first_ghost]; }
  [[nodiscard]] SelfCrossings::Set curves_of(SlotId ghost) const { return curves[ghost - first_ghost]; }
  /// What a collapse makes is of all curves of what it consumed.
  void join_curves(const FaceChanges& changes) {
    SelfCrossings::Set all = SelfCrossings::kNone;
    for (const FaceChanges::Moved& moved : changes.moved)
      all = crossings.join(all, curves_of(moved.face));
    for (const SlotId s : changes.gone)
      all = crossings.join(all, curves_of(s));
    for (const FaceChanges::Moved& moved : changes.moved)
      curves[moved.face - first_ghost] = all;
  }
  [[nodiscard]] const Point& sample_position(std::uint32_t sample) const {
    return sample < relative.size() ? relative[sample] : centroids[sample - relative.size()];
  }
  [[nodiscard]] HalfedgeHandle halfedge(Vertex vs, Vertex vd) const {
    if (!handle[vs].is_valid()) return HalfedgeHandle();
    for (auto it = surface.cvoh_iter(handle[vs]); it.is_valid(); ++it)
      if (surface.data(surface.to_vertex_handle(*it)).mesh_vertex == vd) return *it;
    return HalfedgeHandle();
  }
};

WorkingSurface::WorkingSurface(const WorkingComplex& complex, const std::vector<Point>& positions, double diagonal,
                               std::vector<char>& frozen, DomainError domain_error,
                               std::span<const std::uint32_t> crossing_curves)
    : impl_(std::make_unique<Impl>(positions, crossing_curves)) {
  Impl& m = *impl_;
  m.rounding = kSurfaceRounding * diagonal;
  m.handle.resize(complex.vertex_count());
  std::vector<Triangle> faces;
  std::vector<SlotId> slots;
  for (SlotId s = 0; s < complex.slot_count(); ++s)
    if (complex.is_ghost(complex.slot(s))) {
      faces.push_back(face_of(complex.slot(s), complex.dummy()));
      slots.push_back(s);
    }
  if (faces.size() > kMostSurfaceFaces)
    throw Error(ErrorCode::kLimit, "the boundary has more than " + std::to_string(kMostSurfaceFaces) + " faces");
  if (domain_error == DomainError::kBound) m.pieces.emplace(m.relative, faces, diagonal);
  CornerClasses classes(faces);
  std::vector<VertexHandle> handle_of_class(3 * faces.size());
  m.surface.reserve(faces.size() / 2 + 3, faces.size() * 3 / 2 + 3, faces.size());
  const bool holds_samples = domain_error == DomainError::kSampled;
  if (holds_samples) m.next_sample.assign(positions.size() + faces.size(), kNone);
  for (std::uint32_t f = 0; f < faces.size(); ++f) {
    std::array<VertexHandle, 3> corners;
    for (std::uint32_t i = 0; i < 3; ++i) {
      VertexHandle& h = handle_of_class[classes.of(f, i)];
      if (!h.is_valid()) {
        const Vertex v = faces[f][i];
        h = m.surface.add_vertex({positions[v][0], positions[v][1], positions[v][2]});
        m.surface.data(h).mesh_vertex = v;
        if (m.handle[v].is_valid()) frozen[v] = 1;
        m.handle[v] = h;
      }
      corners[i] = h;
    }
    const FaceHandle face = m.surface.add_face(corners[0], corners[1], corners[2]);
    if (holds_samples) {
      const auto& x0 = m.relative[faces[f][0]];
      const auto& x1 = m.relative[faces[f][1]];
      const auto& x2 = m.relative[faces[f][2]];
      m.centroids.push_back((1.0 / 3.0) * (x0 + x1 + x2));
    }
    if (face.is_valid()) {
      if (holds_samples) m.surface.data(face).first_sample = static_cast<std::uint32_t>(positions.size() + f);
      if (m.pieces) m.pieces->add(static_cast<std::uint32_t>(face.idx()), faces[f]);
    } else
      for (const Vertex v : faces[f])
        frozen[v] = 1;
  }
  m.index.build(complex, positions, slots);
  if (slots.empty()) return;
  m.first_ghost = slots.front(); // the others follow without gaps
  m.find_shells(classes, faces.size(), crossing_curves);
  if (m.crossings.empty()) return;
  for (std::size_t f = 0; f < faces.size(); ++f)
    m.curves.push_back(m.crossings.of_original(f));
}

WorkingSurface::~WorkingSurface() = default;

bool WorkingSurface::contains(Vertex v) const {
  return impl_->handle[v].is_valid();
}

bool WorkingSurface::collapse_ok(Vertex vs, Vertex vd) const {
  const Impl& m = *impl_;
  const HalfedgeHandle h = m.halfedge(vs, vd);
  if (!h.is_valid() || m.surface.is_boundary(m.handle[vs])) return false;
  // OpenMesh's own test marks vertices; with faces all around vs only this is left of it.
  const VertexHandle left = m.surface.to_vertex_handle(m.surface.next_halfedge_handle(h));
  const VertexHandle right =
      m.surface.to_vertex_handle(m.surface.next_halfedge_handle(m.surface.opposite_halfedge_handle(h)));
  if (left == right) return false;
  const VertexHandle hd = m.surface.to_vertex_handle(h);
  for (auto it = m.surface.cvv_iter(m.handle[vs]); it.is_valid(); ++it) {
    if (*it == left || *it == right) continue;
    for (auto other = m.surface.cvv_iter(*it); other.is_valid(); ++other)
      if (*other == hd) return false;
  }
  return true;
}

/// Finds the face nearest to a sample, or one that it lies on; `likely` is tried first. Returns the squared distance.
double WorkingSurface::hold(std::uint32_t sample, std::uint32_t likely, Workspace& w) const {
  const Impl& m = *impl_;
  const Point& p = m.sample_position(sample);
  double nearest = std::numeric_limits<double>::infinity();
  std::uint32_t best = 0;
  const auto look_at = [&](std::uint32_t i) {
    const double d = w.left_[i].squared(p, nearest);
    if (d < nearest) {
      nearest = d;
      best = i;
    }
  };
  if (likely < w.left_.size()) look_at(likely);
  for (std::uint32_t i = 0; i < w.left_.size() && nearest > m.rounding * m.rounding; ++i)
    if (i != likely) look_at(i);
  w.held_.push_back({sample, best});
  return nearest;
}

double WorkingSurface::simulate(Vertex vs, Vertex vd, Workspace& w) const {
  const Impl& m = *impl_;
  w.left_.clear();
  w.coarse_.clear();
  w.held_.clear();
  w.around_.clear();
  const Point& target = m.relative[vd];
  for (auto it = m.surface.cvf_iter(m.handle[vs]); it.is_valid(); ++it) {
    std::array<Point, 3> corners{};
    bool deleted = false;
    std::size_t i = 0;
    for (auto v = m.surface.cfv_iter(*it); v.is_valid(); ++v, ++i) {
      const Vertex x = m.surface.data(*v).mesh_vertex;
      deleted |= x == vd;
      corners[i] = x == vs ? target : m.relative[x];
    }
    w.around_.push_back(
        {m.surface.data(*it).first_sample, deleted ? kNone : static_cast<std::uint32_t>(w.left_.size())});
    if (deleted) continue;
    w.left_.emplace_back(corners);
    w.coarse_.push_back(static_cast<std::uint32_t>(it->idx()));
  }
  double worst_sq = hold(vs, kNone, w);
  for (const auto& [first_sample, face] : w.around_)
    for (std::uint32_t sample = first_sample; sample != kNone; sample = m.next_sample[sample])
      worst_sq = std::max(worst_sq, hold(sample, face, w));
  const double worst = std::sqrt(worst_sq);
  return worst < m.rounding ? 0 : worst;
}

WorkingSurface::Workspace::Workspace(const WorkingSurface& surface) {
  if (surface.impl_->pieces) division_.emplace(*surface.impl_->pieces);
}

/// The faces around vs, and those that vs -> vd would leave of them.
void WorkingSurface::find_faces(Vertex vs, Vertex vd, Workspace& w) const {
  const Impl& m = *impl_;
  w.fine_.clear();
  w.coarse_.clear();
  w.fine_triangles_.clear();
  w.coarse_triangles_.clear();
  const auto triangle = [&](Vertex a, Vertex b, Vertex c) {
    return PatchTriangle{{a, b, c}, {m.relative[a], m.relative[b], m.relative[c]}};
  };
  const HalfedgeHandle first = m.halfedge(vs, vd);
  HalfedgeHandle h = first;
  do {
    const Vertex b = m.surface.data(m.surface.to_vertex_handle(h)).mesh_vertex;
    const auto face = static_cast<std::uint32_t>(m.surface.face_handle(h).idx());
    h = m.surface.ccw_rotated_halfedge_handle(h);
    const Vertex c = m.surface.data(m.surface.to_vertex_handle(h)).mesh_vertex;
    w.fine_.push_back(face);
    w.fine_triangles_.push_back(triangle(vs, b, c));
    if (b == vd || c == vd) continue;
    w.coarse_.push_back(face);
    w.coarse_triangles_.push_back(triangle(vd, b, c));
  } while (h != first);
}

double WorkingSurface::bound(Vertex vs, Vertex vd, double limit, Workspace& w) const {
  find_faces(vs, vd, w);
  return w.division_->hand_over(w.fine_, w.fine_triangles_, w.coarse_triangles_, limit);
}

double WorkingSurface::at_least(Vertex vs, Vertex vd, double enough, Workspace& w) const {
  find_faces(vs, vd, w);
  return w.division_->at_least(w.fine_, w.coarse_triangles_, enough);
}

void WorkingSurface::take_handover(Workspace& w, Handover& handover) {
  handover.fine.swap(w.fine_);
  handover.coarse.swap(w.coarse_);
  handover.held.swap(w.held_);
  if (w.division_) handover.pieces = w.division_->handover();
}

void WorkingSurface::find_changes(const WorkingComplex& complex, Vertex vs, Vertex vd, std::span<const SlotId> modified,
                                  std::span<const SlotId> deleted, FaceChanges& changes) const {
  const std::vector<Point>& positions = impl_->positions;
  changes.gone.clear();
  changes.moved.clear();
  std::copy_if(deleted.begin(), deleted.end(), std::back_inserter(changes.gone),
               [&](SlotId s) { return complex.is_ghost(complex.slot(s)); });
  for (const SlotId s : modified) {
    if (!complex.is_ghost(complex.slot(s))) continue;
    Triangle face = face_of(complex.slot(s), complex.dummy());
    std::replace(face.begin(), face.end(), vs, vd);
    changes.moved.push_back({s, face, box_of(std::array{positions[face[0]], positions[face[1]], positions[face[2]]})});
  }
}

bool WorkingSurface::would_intersect(const WorkingComplex& complex, Vertex vs, Vertex vd,
                                     std::span<const SlotId> modified, const FaceChanges& changes, Workspace& w) const {
  const Impl& m = *impl_;
  const std::span<const FaceChanges::Moved> made = changes.moved;
  BoundingBox all;
  bool moves = false;
  for (const FaceChanges::Moved& face : made) {
    all.join(face.box);
    moves |= orientation(m.positions[face.corners[0]], m.positions[face.corners[1]], m.positions[face.corners[2]],
                         m.positions[vs]) != 0;
  }
  // In its own plane the surface stays the same set of points where the tets behind it stay positive. In front of flat
  // tets, faces may turn over in it.
  const auto is_flat = [&](SlotId s) {
    const Slot& slot = complex.slot(s);
    const auto at = [&](std::size_t i) -> const Point& { return m.positions[slot.v[i] == vs ? vd : slot.v[i]]; };
    return !complex.is_ghost(slot) && orientation(at(0), at(1), at(2), at(3)) == 0;
  };
  if (!moves && std::none_of(modified.begin(), modified.end(), is_flat)) return false;
  w.curves_.clear();
  if (!m.crossings.empty())
    for (const SlotId s : complex.star(vs))
      if (complex.is_ghost(complex.slot(s)) && m.curves_of(s) != SelfCrossings::kNone)
        w.curves_.push_back(m.curves_of(s));
  const auto may_cross = [&](SlotId other) {
    return std::any_of(w.curves_.begin(), w.curves_.end(),
                       [&](SelfCrossings::Set mine) { return m.crossings.share(mine, m.curves_of(other)); });
  };
  w.hits_.clear();
  m.index.query(all, w.hits_);
  std::erase_if(w.hits_, [&](SlotId s) { return has_corner(complex.slot(s).v, vs); }); // they go
  for (std::size_t i = 0; i < made.size(); ++i) {
    const Face face = ids(made[i].corners);
    for (std::size_t j = i + 1; j < made.size(); ++j)
      if (faces_meet_improperly(face, ids(made[j].corners), m.positions)) return true;
    const FacePlane plane(face, m.positions);
    for (const SlotId s : w.hits_) {
      if (!m.index.box(s).meets(made[i].box)) continue;
      const Face other = ids(face_of(complex.slot(s), complex.dummy()));
      if (!plane.surely_misses(other, m.positions) && faces_meet_improperly(face, other, m.positions) &&
          (share_vertex(face, other) || !may_cross(s)))
        return true;
    }
  }
  return false;
}

bool WorkingSurface::would_meet(const FaceChanges& one, const FaceChanges& other) const {
  return std::any_of(one.moved.begin(), one.moved.end(), [&](const FaceChanges::Moved& a) {
    return std::any_of(other.moved.begin(), other.moved.end(), [&](const FaceChanges::Moved& b) {
      return a.box.meets(b.box) && faces_meet_improperly(ids(a.corners), ids(b.corners), impl_->positions);
    });
  });
}

bool WorkingSurface::would_pass_over(const WorkingComplex& complex, Vertex vs, Vertex vd,
                                     std::span<const SlotId> modified, Workspace& w) const {
  const Impl& m = *impl_;
  const BoundingBox all = reach(complex, vd, modified);
  if (m.shell.empty() && !all.contains(m.index.bounds())) return false;
  SweptSpace& swept = w.swept_;
  swept.begin(vs, vd);
  std::uint32_t shell = 0;
  for (const SlotId s : modified) {
    if (!complex.is_ghost(complex.slot(s))) continue;
    swept.add(face_of(complex.slot(s), complex.dummy()), m.positions);
    shell = m.shell_of(s);
  }
  w.hits_.clear();
  m.index.query(all, w.hits_);
  // A shell is closed: what of the own one goes on beyond what is swept would cross the new faces.
  std::uint32_t own = 0;
  for (const SlotId s : w.hits_)
    if (m.shell_of(s) == shell && all.contains(m.index.box(s)) &&
        (m.crossings.empty() || m.curves_of(s) == SelfCrossings::kNone))
      ++own;
  const bool goes_on = own < m.shell_size[shell];
  w.corners_.clear();
  for (const SlotId s : w.hits_) {
    if (goes_on && m.shell_of(s) == shell) continue;
    const Triangle face = face_of(complex.slot(s), complex.dummy());
    if (std::find(face.begin(), face.end(), vs) != face.end()) continue; // it moves
    if (std::all_of(face.begin(), face.end(), [&](Vertex x) { return swept.has_corner(x); })) {
      const Point sum = m.positions[face[0]] + m.positions[face[1]] + m.positions[face[2]];
      if (swept.contains((1.0 / 3.0) * sum, m.positions)) return true;
    } else {
      w.corners_.insert(w.corners_.end(), face.begin(), face.end());
    }
  }
  std::sort(w.corners_.begin(), w.corners_.end());
  const auto end = std::unique(w.corners_.begin(), w.corners_.end());
  return std::any_of(w.corners_.begin(), end, [&](Vertex x) { return swept.contains(m.positions[x], m.positions); });
}

BoundingBox WorkingSurface::reach(const WorkingComplex& complex, Vertex vd, std::span<const SlotId> modified) const {
  BoundingBox box;
  box.add(impl_->positions[vd]);
  for (const SlotId s : modified)
    if (complex.is_ghost(complex.slot(s)))
      for (const Vertex x : complex.slot(s).v)
        if (x != complex.dummy()) box.add(impl_->positions[x]);
  return box;
}

void WorkingSurface::begin_changes() {
  impl_->index.begin_changes();
}

bool WorkingSurface::has_moved(const BoundingBox& box) const {
  return impl_->index.has_moved(box);
}

void WorkingSurface::collapse(Vertex vs, Vertex vd, const Handover& handover) {
  Impl& m = *impl_;
  m.surface.collapse(m.halfedge(vs, vd));
  m.handle[vs] = VertexHandle();
  if (m.pieces) {
    m.pieces->commit(handover.fine, handover.coarse, handover.pieces);
  } else {
    const auto first_sample = [&](std::uint32_t face) -> std::uint32_t& {
      return m.surface.data(FaceHandle(static_cast<int>(face))).first_sample;
    };
    for (const std::uint32_t face : handover.coarse)
      first_sample(face) = kNone;
    for (const Held& held : handover.held) {
      std::uint32_t& first = first_sample(handover.coarse[held.face]);
      m.next_sample[held.sample] = first;
      first = held.sample;
    }
  }
}

void WorkingSurface::move_faces(const FaceChanges& changes) {
  Impl& m = *impl_;
  if (!m.crossings.empty()) m.join_curves(changes);
  for (const SlotId s : changes.gone) {
    m.index.erase(s);
    --m.shell_size[m.shell_of(s)];
  }
  for (const FaceChanges::Moved& moved : changes.moved)
    m.index.replace(moved.face, moved.box);
}

} // namespace ptet::build
