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

#include "build/working_complex.hpp"

#include <memory>
#include <span>
#include <vector>

namespace ptet::build {

enum class DomainError : std::uint8_t {
  kSampled, ///< simulate() only
  kBound,   ///< bound() too; to be called before every collapse
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
  /// edge of it.
  [[nodiscard]] bool collapse_ok(Vertex vs, Vertex vd);
  /// Assigns what the faces around vs hold to the faces that vs -> vd would leave; collapse_ok must have been true.
  /// Returns the largest distance of a sample to its face, mesh units.
  [[nodiscard]] double simulate(Vertex vs, Vertex vd);
  /// An upper bound on the distance between each face that vs -> vd would leave around vs and the part of the original
  /// boundary that it would stand for, and on the distance of its points to the original boundary; mesh units, 0 when
  /// that is rounding. Values above `limit` are found early, and are no bounds. collapse_ok must have been true, and
  /// the surface must have been made with kBound.
  [[nodiscard]] double bound(Vertex vs, Vertex vd, double limit);
  /// Whether a face that vs -> vd would make meets another present face anywhere but where they join.
  [[nodiscard]] bool would_intersect(const WorkingComplex& complex, Vertex vs, Vertex vd,
                                     std::span<const SlotId> modified, std::span<const SlotId> deleted);
  /// The last simulation and the last bound become true, vs is gone. To be called after the complex has changed.
  void collapse(const WorkingComplex& complex, Vertex vs, Vertex vd, std::span<const SlotId> modified,
                std::span<const SlotId> deleted);

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

} // namespace ptet::build
