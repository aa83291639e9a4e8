#include "build/boundary_check.hpp"

namespace ptet::build {

CollapseStatus BoundaryCheck::examine(const CollapsePlan& plan) const {
  if (!surface_.collapse_ok(plan.vs, plan.vd)) return CollapseStatus::kSurfaceTopology;
  return surface_.would_intersect(complex_, plan.vs, plan.vd, plan.modified, workspaces_.local())
             ? CollapseStatus::kSelfIntersection
             : CollapseStatus::kAccepted;
}

double BoundaryCheck::bound(Vertex vs, Vertex vd, BoundarySurface::Handover& handover) const {
  BoundarySurface::Workspace& workspace = workspaces_.local();
  const double error = surface_.bound(vs, vd, domain_limit_, workspace);
  if (!(error > domain_limit_)) handover = BoundarySurface::handover(workspace);
  return error;
}

} // namespace ptet::build
