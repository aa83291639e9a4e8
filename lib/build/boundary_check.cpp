#include "build/boundary_check.hpp"

#include <algorithm>

namespace ptet::build {

void BoundaryCheck::outline(const CollapsePlan& plan, BoundaryMove& move) const {
  move.reach = surface_.reach(complex_, plan.vd, plan.modified);
  surface_.find_changes(complex_, plan.vs, plan.vd, plan.modified, plan.deleted, move.changes);
}

CollapseStatus BoundaryCheck::examine(const CollapsePlan& plan, BoundaryMove& move) const {
  outline(plan, move);
  if (!surface_.collapse_ok(plan.vs, plan.vd)) return CollapseStatus::kSurfaceTopology;
  WorkingSurface::Workspace& workspace = workspaces_.local();
  return surface_.would_intersect(complex_, plan.vs, plan.vd, plan.modified, move.changes, workspace) ||
                 surface_.would_pass_over(complex_, plan.vs, plan.vd, plan.modified, workspace)
             ? CollapseStatus::kSelfIntersection
             : CollapseStatus::kAccepted;
}

CollapseStatus BoundaryCheck::measure(Vertex vs, Vertex vd, BoundaryMove& move, double enough) const {
  WorkingSurface::Workspace& workspace = workspaces_.local();
  move.error = error_of(vs, vd, enough, workspace);
  if (*move.error > domain_limit_) return CollapseStatus::kDomainError;
  if (*move.error <= enough) WorkingSurface::take_handover(workspace, move.handover);
  return CollapseStatus::kAccepted;
}

double BoundaryCheck::error_of(Vertex vs, Vertex vd, double enough, WorkingSurface::Workspace& workspace) const {
  switch (domain_error_) {
  case DomainError::kPredicted: return diagonal_ * predictor_.domain_error(vs, vd);
  case DomainError::kSampled: return surface_.simulate(vs, vd, workspace);
  case DomainError::kBound: break;
  }
  return surface_.bound(vs, vd, std::min(enough, domain_limit_), workspace);
}

} // namespace ptet::build
