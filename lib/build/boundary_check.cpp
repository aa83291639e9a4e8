#include "build/boundary_check.hpp"

#include <algorithm>

namespace ptet::build {

CollapseStatus BoundaryCheck::examine(const CollapsePlan& plan, BoundaryMove& move) const {
  move.reach = surface_.reach(complex_, plan.vd, plan.modified);
  if (!surface_.collapse_ok(plan.vs, plan.vd)) return CollapseStatus::kSurfaceTopology;
  BoundarySurface::Workspace& workspace = workspaces_.local();
  return surface_.would_intersect(complex_, plan.vs, plan.vd, plan.modified, workspace) ||
                 surface_.would_pass_over(complex_, plan.vs, plan.vd, plan.modified, workspace)
             ? CollapseStatus::kSelfIntersection
             : CollapseStatus::kAccepted;
}

CollapseStatus BoundaryCheck::measure(Vertex vs, Vertex vd, BoundaryMove& move, double enough) const {
  BoundarySurface::Workspace& workspace = workspaces_.local();
  move.error = measures_samples() ? surface_.simulate(vs, vd, workspace)
                                  : surface_.bound(vs, vd, std::min(enough, domain_limit_), workspace);
  if (*move.error > domain_limit_) return CollapseStatus::kDomainError;
  if (*move.error <= enough) BoundarySurface::take_handover(workspace, move.handover);
  return CollapseStatus::kAccepted;
}

} // namespace ptet::build
