// The boundary while it is being collapsed: an OpenMesh half-edge surface whose faces each hold samples of the original
// boundary (removed vertices, and the centroid of every original face), the domain error seen at them, and an index
// that tells whether a moving boundary would meet itself.
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

class BoundarySurface {
public:
  /// `frozen`: vertices that cannot be represented are frozen too.
  BoundarySurface(const WorkingComplex& complex, const std::vector<Point>& positions, double diagonal,
                  std::vector<char>& frozen);
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
  /// Whether a face that vs -> vd would make meets another present face anywhere but where they join.
  [[nodiscard]] bool would_intersect(const WorkingComplex& complex, Vertex vs, Vertex vd,
                                     std::span<const SlotId> modified, std::span<const SlotId> deleted);
  /// The last simulation becomes true, vs is gone. To be called after the complex has changed.
  void collapse(const WorkingComplex& complex, Vertex vs, Vertex vd, std::span<const SlotId> modified,
                std::span<const SlotId> deleted);

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

} // namespace ptet::build
