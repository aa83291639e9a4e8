// Is a half-edge collapse that moves the boundary allowed, and how far does it move? By any number of threads at once,
// before anything is changed.
#pragma once

#include "build/collapse_check.hpp"
#include "build/predictor.hpp"
#include "build/working_complex.hpp"
#include "build/working_surface.hpp"
#include "ptet/build.hpp"

#include <limits>
#include <optional>

#include <oneapi/tbb/enumerable_thread_specific.h>

namespace ptet::build {

/// What has been found of a collapse that moves the boundary.
struct BoundaryMove {
  BoundingBox reach;                   ///< it is allowed until a face moves in here
  WorkingSurface::FaceChanges changes; ///< that it makes
  std::optional<double> error;         ///< the domain error, mesh units, once it has been asked for
  WorkingSurface::Handover handover;
};

class BoundaryCheck {
public:
  /// `domain_error`: as the surface was made. `diagonal`, `domain_limit`: mesh units. The others must outlive the
  /// object.
  BoundaryCheck(const WorkingComplex& complex, const WorkingSurface& surface, const Predictor& predictor,
                DomainError domain_error, double diagonal, double domain_limit)
      : complex_(complex), surface_(surface), predictor_(predictor), domain_error_(domain_error), diagonal_(diagonal),
        domain_limit_(domain_limit), workspaces_([&surface] { return WorkingSurface::Workspace(surface); }) {}

  /// Puts down the reach and the changes of such a collapse. Thread rule: const.
  void outline(const CollapsePlan& plan, BoundaryMove& move) const;
  /// The outline, and kAccepted, or what stands against a collapse that moves the boundary, but for how far it moves.
  /// Thread rule: const.
  [[nodiscard]] CollapseStatus examine(const CollapsePlan& plan, BoundaryMove& move) const;
  /// Whether what was accepted, since the surface last began with its changes, still is. Thread rule: const.
  [[nodiscard]] bool stands(const BoundaryMove& move) const { return !surface_.has_moved(move.reach); }
  /// Whether a move may no longer be allowed once an earlier one has been made, where both were examined at the same
  /// time and neither of its ends is in the star of the vertex that the earlier one removes: their faces may meet.
  /// Nothing else can come between them, as the surface around its ends stays, and vertices that it must not pass over
  /// only become fewer. True too where both stand for one curve along which the original crosses itself.
  /// Thread rule: const.
  [[nodiscard]] bool may_meet(const BoundaryMove& move, const BoundaryMove& earlier) const {
    return move.reach.meets(earlier.reach) && surface_.would_meet(move.changes, earlier.changes);
  }

  /// kAccepted, or kDomainError where the domain error of such a collapse is beyond the limit. It depends on the faces
  /// around vs alone. Beyond `enough` (mesh units) it may be any value between that and the error, and there is no
  /// handover. Thread rule: const.
  [[nodiscard]] CollapseStatus measure(Vertex vs, Vertex vd, BoundaryMove& move,
                                       double enough = std::numeric_limits<double>::infinity()) const;
  /// Whether measure() is little work: nothing is bounded.
  [[nodiscard]] bool measures_quickly() const { return domain_error_ != DomainError::kBound; }
  /// A lower bound on what measure() would find, mesh units, where that bounds; it may end at any value above `enough`.
  /// Thread rule: const.
  [[nodiscard]] double at_least(Vertex vs, Vertex vd, double enough) const {
    return domain_error_ == DomainError::kBound ? surface_.at_least(vs, vd, enough, workspaces_.local()) : 0;
  }
  [[nodiscard]] double domain_limit() const { return domain_limit_; }

private:
  [[nodiscard]] double error_of(Vertex vs, Vertex vd, double enough, WorkingSurface::Workspace& workspace) const;

  const WorkingComplex& complex_;
  const WorkingSurface& surface_;
  const Predictor& predictor_;
  DomainError domain_error_;
  double diagonal_;
  double domain_limit_;
  mutable oneapi::tbb::enumerable_thread_specific<WorkingSurface::Workspace> workspaces_;
};

} // namespace ptet::build
