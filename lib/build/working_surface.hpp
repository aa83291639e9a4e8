// The boundary while it is being collapsed: an OpenMesh half-edge surface, and an index that tells whether a moving
// boundary would meet itself. Where domain errors are measured its faces each hold samples of the original boundary
// (removed vertices, and the centroid of every original face), or pieces of it, which give bounds
// (boundary_pieces.hpp).
//
// Where the boundary is no manifold the surface is cut open: every fan of faces there gets a surface vertex of its own.
//
// Source: Cignoni et al. 2000, section 4.2 (domain error); one sample for each face besides the vertices, because
// vertices alone miss surfaces that span gaps.
#pragma once

#include "build/boundary_pieces.hpp"
#include "build/self_crossings.hpp"
#include "build/swept_space.hpp"
#include "build/working_complex.hpp"
#include "error/triangle_distance.hpp"
#include "mesh/box_tree.hpp"

#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace ptet::build {

enum class DomainError : std::uint8_t {
  kPredicted, ///< elsewhere: the faces hold nothing
  kSampled,   ///< by simulate()
  kBound,     ///< by bound()
};

class WorkingSurface {
public:
  /// `frozen`: vertices that cannot be represented are frozen too. `crossing_curves`: as PreparedMesh has them.
  WorkingSurface(const WorkingComplex& complex, const std::vector<Point>& positions, double diagonal,
                 std::vector<char>& frozen, DomainError domain_error = DomainError::kSampled,
                 std::span<const std::uint32_t> crossing_curves = {});
  ~WorkingSurface();
  WorkingSurface(const WorkingSurface&) = delete;
  WorkingSurface& operator=(const WorkingSurface&) = delete;

  [[nodiscard]] bool contains(Vertex v) const;
  /// Whether vs -> vd keeps the surface a manifold. Both must be on it, vs not frozen; false too when vs vd is no
  /// edge of it. Thread rule: const.
  [[nodiscard]] bool collapse_ok(Vertex vs, Vertex vd) const;
  /// A sample of the original boundary, and the face that is to hold it, by its place among those that are left.
  struct Held {
    std::uint32_t sample, face;
  };
  /// What a collapse makes of what the faces around it hold of the original boundary: of its samples, or of its pieces
  /// where there are bounds.
  struct Handover {
    std::vector<std::uint32_t> fine, coarse; ///< faces before (where there are bounds), and those that are left
    BoundaryPieces::Handover pieces;
    std::vector<Held> held;
  };
  /// What one thread needs to simulate, for bounds and for intersections.
  class Workspace {
  public:
    explicit Workspace(const WorkingSurface& surface);

  private:
    friend class WorkingSurface;
    struct Around {
      std::uint32_t first_sample; ///< that the face holds
      std::uint32_t left;         ///< what becomes of it; kNone when it goes
    };

    std::vector<TriangleDistance> left_;
    std::vector<Around> around_;
    std::vector<Held> held_;
    std::optional<BoundaryPieces::Division> division_;
    std::vector<std::uint32_t> fine_, coarse_;
    std::vector<PatchTriangle> fine_triangles_, coarse_triangles_;
    SweptSpace swept_;
    std::vector<Vertex> corners_; ///< of faces that may be passed over
    std::vector<SlotId> hits_;
    std::vector<SelfCrossings::Set> curves_;
  };

  /// Assigns the samples that the faces around vs hold to the faces that vs -> vd would leave; collapse_ok must have
  /// been true. Returns the largest distance of a sample to its face, mesh units.
  /// Thread rule: const; one workspace a thread. It is about the faces around vs: collapses elsewhere change nothing.
  [[nodiscard]] double simulate(Vertex vs, Vertex vd, Workspace& workspace) const;
  /// An upper bound on the distance between each face that vs -> vd would leave around vs and the part of the original
  /// boundary that it would stand for, and on the distance of its points to the original boundary; mesh units, 0 when
  /// that is rounding. Values above `limit` are found early: they are not above the bound. vs -> vd must be an edge of
  /// the surface with faces all around vs, and the surface must have been made with kBound. Thread rule: const; one
  /// workspace a thread. It is about the faces around vs: collapses elsewhere change nothing.
  [[nodiscard]] double bound(Vertex vs, Vertex vd, double limit, Workspace& workspace) const;
  /// A lower bound on bound(), for a fraction of the work; it may end at any value above `enough`. Thread rule: as
  /// bound().
  [[nodiscard]] double at_least(Vertex vs, Vertex vd, double enough, Workspace& workspace) const;
  /// Of the last simulation, or bound where there are bounds; it is taken out of the workspace.
  static void take_handover(Workspace& workspace, Handover& handover);
  /// What a collapse makes of the faces around vs, by their ghosts.
  struct FaceChanges {
    struct Moved {
      SlotId face;
      std::array<Vertex, 3> corners; ///< that it gets, outward oriented
      BoundingBox box;               ///< of those
    };
    std::vector<SlotId> gone;
    std::vector<Moved> moved;
  };
  /// Of vs -> vd, before the complex has changed. Thread rule: const.
  void find_changes(const WorkingComplex& complex, Vertex vs, Vertex vd, std::span<const SlotId> modified,
                    std::span<const SlotId> deleted, FaceChanges& changes) const;
  /// Whether a face that vs -> vd would make meets another present face anywhere but where they join, unless both stand
  /// for faces of one curve along which the original crosses itself (self_crossings.hpp). `changes`: of the collapse.
  /// Thread rule: const; one workspace a thread.
  [[nodiscard]] bool would_intersect(const WorkingComplex& complex, Vertex vs, Vertex vd,
                                     std::span<const SlotId> modified, const FaceChanges& changes,
                                     Workspace& workspace) const;
  /// Whether a face that one collapse would make meets one that another would make, anywhere but where they join.
  /// Thread rule: const.
  [[nodiscard]] bool would_meet(const FaceChanges& one, const FaceChanges& other) const;
  /// Whether vs -> vd would carry the surface past something: what lies wholly in the space that the faces around vs
  /// sweep meets none of the new ones, but would be on the other side of them. That is another shell, or one that
  /// touches this one, or the far side of a small void. Shells that cross one another in the original count as one.
  /// Thread rule: const; one workspace a thread.
  [[nodiscard]] bool would_pass_over(const WorkingComplex& complex, Vertex vs, Vertex vd,
                                     std::span<const SlotId> modified, Workspace& workspace) const;
  /// All that an answer of collapse_ok(), would_intersect() or would_pass_over() that is in favour of the collapse
  /// depends on: it stands until a face moves in this box. Thread rule: const.
  [[nodiscard]] BoundingBox reach(const WorkingComplex& complex, Vertex vd, std::span<const SlotId> modified) const;
  /// From now on has_moved() tells of collapses.
  void begin_changes();
  /// Whether a face of a collapse since then comes into this box. Thread rule: const.
  [[nodiscard]] bool has_moved(const BoundingBox& box) const;
  /// vs is gone, and what its faces held has been handed over. Does not look at the complex. Every collapse
  /// is told to this and to move_faces(), in the same order. Thread rule: the two may be called at the same time, each
  /// by one thread, and contains() for vertices that stay.
  void collapse(Vertex vs, Vertex vd, const Handover& handover);
  /// The faces of a collapse are where it has moved them.
  void move_faces(const FaceChanges& changes);

private:
  void find_faces(Vertex vs, Vertex vd, Workspace& workspace) const;
  [[nodiscard]] double hold(std::uint32_t sample, std::uint32_t likely, Workspace& workspace) const;

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

} // namespace ptet::build
