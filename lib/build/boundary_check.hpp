// Is a half-edge collapse that moves the boundary allowed? What the boundary says, by any number of threads at once,
// before anything is changed.
#pragma once

#include "build/boundary_surface.hpp"
#include "build/collapse_check.hpp"
#include "build/working_complex.hpp"
#include "ptet/build.hpp"

#include <oneapi/tbb/enumerable_thread_specific.h>

namespace ptet::build {

class BoundaryCheck {
public:
  /// `domain_limit`: mesh units. The others must outlive the object.
  BoundaryCheck(const WorkingComplex& complex, const BoundarySurface& surface, double domain_limit)
      : complex_(complex), surface_(surface), domain_limit_(domain_limit),
        workspaces_([&surface] { return BoundarySurface::Workspace(surface); }) {}

  /// kAccepted, or what stands against a collapse that moves the boundary, but for how far it moves.
  /// Thread rule: const.
  [[nodiscard]] CollapseStatus examine(const CollapsePlan& plan) const;

  /// What bounds the domain error of such a collapse, mesh units, and what the collapse needs of it, unless that is
  /// beyond the limit. The surface must have been made with kBound. Thread rule: const.
  [[nodiscard]] double bound(Vertex vs, Vertex vd, BoundarySurface::Handover& handover) const;

private:
  const WorkingComplex& complex_;
  const BoundarySurface& surface_;
  double domain_limit_;
  mutable oneapi::tbb::enumerable_thread_specific<BoundarySurface::Workspace> workspaces_;
};

} // namespace ptet::build
