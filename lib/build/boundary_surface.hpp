// The boundary while it is being collapsed: an OpenMesh half-edge surface whose faces each hold samples of the original
// boundary (removed vertices, and the centroid of every original face), the domain error seen at them, bounds on it by
// the pieces of the original boundary that they stand for (boundary_pieces.hpp), and an index that tells whether a
// moving boundary would meet itself.
//
// Where the boundary is no manifold the surface is cut open: every fan of faces there gets a surface vertex of its own.
//
// Source: Cignoni et al. 2000, section 4.2 (domain error); one sample for each face besides the vertices, because
// vertices alone miss surfaces that span gaps.
#pragma once

#include "build/boundary_pieces.hpp"
#include "build/working_complex.hpp"

#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace ptet::build {

enum class DomainError : std::uint8_t {
  kSampled, ///< simulate(), to be called before every collapse
  kBound,   ///< bound(), whose handover every collapse needs
};

class BoundarySurface {
public:
  /// `frozen`: vertices that cannot be represented are frozen too.
  BoundarySurface(const WorkingComplex& complex, const std::vector<Point>& positions, double diagonal,
                  std::vector<char>& frozen, DomainError domain_error = DomainError::kSampled);
  ~BoundarySurface();
  BoundarySurface(const BoundarySurface&) = delete;
  BoundarySurface& operator=(const BoundarySurface&) = delete;

  [[nodiscard]] bool contains(Vertex v) const;
  /// Whether vs -> vd keeps the surface a manifold. Both must be on it, vs not frozen; false too when vs vd is no
  /// edge of it. Thread rule: const.
  [[nodiscard]] bool collapse_ok(Vertex vs, Vertex vd) const;
  /// Assigns the samples that the faces around vs hold to the faces that vs -> vd would leave; collapse_ok must have
  /// been true. Returns the largest distance of a sample to its face, mesh units.
  [[nodiscard]] double simulate(Vertex vs, Vertex vd);
  /// What a collapse makes of the pieces of the original boundary around it.
  struct Handover {
    std::vector<std::uint32_t> fine, coarse; ///< faces
    BoundaryPieces::Handover pieces;
  };
  /// What one thread needs for bounds and for intersections.
  class Workspace {
  public:
    explicit Workspace(const BoundarySurface& surface);

  private:
    friend class BoundarySurface;
    std::optional<BoundaryPieces::Division> division_;
    std::vector<std::uint32_t> fine_, coarse_;
    std::vector<PatchTriangle> fine_triangles_, coarse_triangles_;
    std::vector<std::array<Vertex, 3>> made_;
    std::vector<SlotId> hits_;
  };

  /// An upper bound on the distance between each face that vs -> vd would leave around vs and the part of the original
  /// boundary that it would stand for, and on the distance of its points to the original boundary; mesh units, 0 when
  /// that is rounding. Values above `limit` are found early, and are no bounds. vs -> vd must be an edge of the surface
  /// with faces all around vs, and the surface must have been made with kBound.
  /// Thread rule: const; one workspace a thread. It is about the faces around vs: collapses elsewhere change nothing.
  [[nodiscard]] double bound(Vertex vs, Vertex vd, double limit, Workspace& workspace) const;
  /// Of the last bound.
  [[nodiscard]] static Handover handover(const Workspace& workspace);
  /// Whether a face that vs -> vd would make meets another present face anywhere but where they join.
  /// Thread rule: const; one workspace a thread.
  [[nodiscard]] bool would_intersect(const WorkingComplex& complex, Vertex vs, Vertex vd,
                                     std::span<const SlotId> modified, Workspace& workspace) const;
  /// The last simulation becomes true, or `handover` where there are bounds; vs is gone. To be called after the complex
  /// has changed.
  void collapse(const WorkingComplex& complex, Vertex vs, Vertex vd, std::span<const SlotId> modified,
                std::span<const SlotId> deleted, const Handover& handover);

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

} // namespace ptet::build
