// One thread's trial of half-edge collapses: is it allowed, what would it do to the removed vertices, what are its
// exact errors. Nothing changes until somebody commits what was tried.
#pragma once

#include "build/collapse_check.hpp"
#include "build/known_versions.hpp"
#include "build/removed_vertices.hpp"
#include "error/exact_field_error.hpp"

#include <optional>
#include <vector>

namespace ptet::build {

class Trial {
public:
  /// `exact` may be null when measure() is not called. All must outlive the object.
  Trial(const WorkingComplex& complex, const std::vector<Point>& positions, const RemovedVertices& removed,
        const ExactFieldError* exact, double min_quality, std::uint32_t max_star);

  /// As CollapseCheck::examine. What follows is about the half-edge last examined, and it must have been accepted.
  [[nodiscard]] CollapseStatus examine(Vertex vs, Vertex vd) { return check_.examine(vs, vd); }
  [[nodiscard]] const CollapseCheck& check() const { return check_; }
  /// Exchanges what the last examination found for what another one has, by whichever trial; both stars must still be
  /// as they were then.
  void swap(CollapsePlan& plan) { check_.swap(plan); }

  /// Errors at the removed vertices.
  const RemovedVertices::Simulation& simulate();
  [[nodiscard]] const RemovedVertices::Simulation& last_simulation() const { return simulation_; }

  /// Raises `errors` (one a field, fractions of the ranges) to the exact maxima over the coarse versions, with what
  /// rounding can hide of them, and puts the integrals of the squared error over them in `integrals`, unless that is
  /// null, and behind those of the fields the volume outside of the domain: modified slot x (field, volume); what is
  /// missing is 0, and those of ghosts stay as they are. Gives up, returning
  /// false, when an error passes its `limit` (one a field), or when `enough()`, which is asked after every version, is
  /// true. The order is that of the errors that were seen in the last simulation; the integrals of what has not been
  /// measured by then stay as they are: where it ends, and with what, does not depend on what is known. `known`: what
  /// was measured before, or null; what is measured now joins it, where it takes more, and what has gone leaves it.
  template <class Enough>
  [[nodiscard]] bool measure(std::vector<double>& errors, std::vector<double>* integrals,
                             const std::vector<double>& limit, Enough&& enough, KnownVersions* known = nullptr) {
    const std::size_t width = errors.size() + 1;
    if (integrals != nullptr) integrals->resize(check_.modified().size() * width, 0.0);
    known_ = integrals != nullptr && !errors.empty() ? known : nullptr;
    if (known_ != nullptr) forget_gone();
    order_slots();
    for (const Next& next : order_) {
      double* const squared = integrals != nullptr ? integrals->data() + next.index * width : nullptr;
      if (!measure_slot(check_.modified()[next.index], errors, squared, limit) || enough()) return false;
    }
    return true;
  }

private:
  struct Next {
    double worst; ///< error of any field, so far as was seen
    std::size_t index;
  };

  void order_slots();
  void forget_gone();
  [[nodiscard]] std::size_t find_known(std::uint32_t fine) const;
  /// `squared`: one a field and one more; null: not wanted.
  bool measure_slot(SlotId slot, std::vector<double>& errors, double* squared, const std::vector<double>& limit);

  const WorkingComplex& complex_;
  const RemovedVertices& removed_;
  const ExactFieldError* exact_;
  CollapseCheck check_;
  RemovedVertices::Simulation simulation_;
  std::optional<ExactFieldError::Workspace> workspace_;
  std::vector<double> measured_, integrals_;
  std::vector<Next> order_;
  KnownVersions* known_ = nullptr;
};

} // namespace ptet::build
