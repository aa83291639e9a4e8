#include "build/measured_rounds.hpp"

#include "build/certify.hpp"
#include "build/collapse_geometry.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

namespace ptet::build {
namespace {

/// An evaluation is given up once its error is so many times the round's cost: it would be put back anyway, and the
/// factor keeps it from coming up again at once. Later, at 2, costs a tenth more time and 2% of the mean square.
constexpr double kGiveUpAt = 1.2;
/// What was given up for its fields comes up again at so many times what had been seen of it: the rest costs too.
constexpr double kUnseen = 1.2;
/// From this part of the round's cost on that a domain error costs at least, it is measured before the fields are: it
/// is likely to be what is too much. On a thin mesh full of holes (22,000 tets, most of its vertices on the boundary)
/// 14,000 candidates then have their fields measured; 28,000 if it never is, 71,000 without the lower bound.
constexpr float kRatherDomain = 0.5F;
/// What is known of versions may take up so many bytes for each vertex that is still to be removed: the records that
/// will come of them take up more.
constexpr std::size_t kKnownBytes = 300;
/// So many candidates are measured before who waits is asked whether to go on: some tenths of a second of work.
constexpr std::size_t kMeasuredBetweenLooks = 2048;

} // namespace

/// What became of the exact evaluation of a candidate.
struct MeasuredRounds::Verdict {
  CollapseStatus status = CollapseStatus::kAccepted;
  float cost = 0;
  std::vector<double> errors;    ///< one a field, fractions of the ranges: the exact maxima; empty: not looked at
  BoundaryMove move;             ///< where it moves the boundary
  std::vector<double> outside;   ///< one a field, fractions of the ranges: at removed vertices that no tet covers
  std::vector<double> integrals; ///< as Trial::measure() has them: modified slot x (field, volume)
};

MeasuredRounds::MeasuredRounds(Collapser& collapser, BuildReport& report)
    : collapser_(collapser), complex_(collapser.complex()), candidates_(collapser.candidates()), report_(report),
      field_count_(collapser.fields().field_count()), sum_count_(field_count_ + 1),
      squared_scale_(squared_scales(collapser.fields(), collapser.scales().volume)),
      vertex_volume_(collapser.scales().vertex_volume()), slot_sums_(complex_.slot_count() * sum_count_),
      known_(complex_.vertex_count()), claimed_(complex_.vertex_count() + 1) {}

void MeasuredRounds::take(const std::vector<Vertex>& picked, std::uint32_t round, const std::function<void()>& look) {
  const std::vector<Vertex> measured = apart(picked, round);
  std::vector<Verdict> verdicts(measured.size());
  collapser_.begin_changes();
  // Where errors have limits, many measurements end at these, and nothing is known of them.
  if (!collapser_.limits().bounds_fields())
    known_.set_room(kKnownBytes * (collapser_.alive_count() - collapser_.target_count()));
  for (std::size_t begin = 0; begin < measured.size(); begin += kMeasuredBetweenLooks) {
    if (begin > 0) look();
    const std::size_t end = std::min(begin + kMeasuredBetweenLooks, measured.size());
    oneapi::tbb::parallel_for(oneapi::tbb::blocked_range<std::size_t>(begin, end, 8), [&](const auto& range) {
      Trial& trial = candidates_.trial();
      for (std::size_t i = range.begin(); i != range.end(); ++i)
        verdicts[i] = measure(measured[i], trial);
    });
  }
  report_.exact_evaluations += static_cast<std::uint64_t>(
      std::count_if(verdicts.begin(), verdicts.end(), [](const Verdict& verdict) { return !verdict.errors.empty(); }));
  for (std::size_t i = 0; i < measured.size() && !collapser_.at_target(); ++i) {
    const Vertex vs = measured[i];
    CollapseStatus status = verdicts[i].status;
    if (status == CollapseStatus::kAccepted && verdicts[i].cost > candidates_.round_cost()) {
      candidates_.raise_best(vs, verdicts[i].cost);
      continue;
    }
    if (status == CollapseStatus::kAccepted) status = collapse(vs, round, verdicts[i]);
    ++report_.collapses[static_cast<std::size_t>(status)];
    if (status != CollapseStatus::kAccepted) candidates_.drop_best(vs, round);
  }
}

/// Those of `picked` whose stars have no tet in common with those of others before them.
std::vector<Vertex> MeasuredRounds::apart(const std::vector<Vertex>& picked, std::uint32_t round) {
  std::vector<Vertex> free;
  for (const Vertex vs : picked) {
    if (claimed_[vs] == round) continue;
    for (const SlotId s : complex_.star(vs))
      for (const Vertex x : complex_.slot(s).v)
        claimed_[x] = round;
    free.push_back(vs);
  }
  return free;
}

/// The exact errors of a candidate and what it costs by them; more than the round's cost when it was given up.
MeasuredRounds::Verdict MeasuredRounds::measure(Vertex vs, Trial& trial) {
  const HalfEdge half_edge = candidates_.best(vs);
  const float round_cost = candidates_.round_cost();
  const double enough = kGiveUpAt * static_cast<double>(round_cost);
  Verdict verdict;
  const auto may_go = [&] { return verdict.status == CollapseStatus::kAccepted && verdict.cost <= round_cost; };
  verdict.status = trial.examine(vs, half_edge.target);
  verdict.cost = half_edge.cost;
  const bool moves_boundary = trial.check().moves_boundary();
  if (verdict.status == CollapseStatus::kAccepted && moves_boundary)
    look_at_boundary(trial.check().plan(), enough, verdict);
  if (!may_go()) return verdict;
  measure_fields(trial, enough, known_.of(vs), verdict);
  if (moves_boundary && !verdict.move.error && may_go()) measure_domain(vs, enough, verdict);
  if (verdict.status == CollapseStatus::kAccepted && !may_go()) {
    known_.settle(vs);
    verdict.integrals = {}; // many are put back, and all wait for the last
  } else {
    known_.forget(vs); // it does not come up again
  }
  return verdict;
}

/// The exact errors of its fields, and what it costs by these; given up when that is more than `enough`.
void MeasuredRounds::measure_fields(Trial& trial, double enough, KnownVersions* known, Verdict& verdict) const {
  const RemovedVertices::Simulation& seen = trial.simulate();
  verdict.errors.assign(seen.errors_inside().begin(), seen.errors_inside().end());
  verdict.outside.assign(seen.errors_outside().begin(), seen.errors_outside().end());
  // The integral grows from what stands in the star now to what the collapse makes of it. What has not been measured
  // counts as if it stayed as it is, which it seldom does better than.
  const std::vector<double> before = squared_in_star(trial.check());
  verdict.integrals.reserve(trial.check().modified().size() * sum_count_);
  for (const SlotId s : trial.check().modified()) {
    const double* const now = slot_sums_.data() + s * sum_count_;
    verdict.integrals.insert(verdict.integrals.end(), now, now + sum_count_);
  }
  const CollapseCost& of = collapser_.cost();
  std::vector<double> growth(field_count_);
  const auto cost = [&] {
    std::fill(growth.begin(), growth.end(), 0.0);
    for (std::size_t i = 0; i < verdict.integrals.size(); i += sum_count_)
      for (std::size_t f = 0; f < field_count_; ++f)
        growth[f] += verdict.integrals[i + f];
    for (std::size_t f = 0; f < field_count_; ++f)
      growth[f] = (growth[f] - before[f]) / vertex_volume_;
    return of.of_field(std::max(of.of_maximum(verdict.errors), of.of_maximum(verdict.outside)), of.of_mean(growth));
  };
  const ErrorLimits& limits = collapser_.limits();
  std::vector<double> limit = limits.field();
  for (std::size_t f = 0; f < field_count_; ++f)
    limit[f] = std::min(limit[f], of.error_at(enough, f));
  const bool whole = trial.measure(
      verdict.errors, &verdict.integrals, limit, [&] { return cost() > enough; }, known);
  if (limits.passed_by(verdict.errors) || limits.passed_by(verdict.outside))
    verdict.status = CollapseStatus::kFieldError;
  verdict.cost = std::max(verdict.cost, static_cast<float>((whole ? 1 : kUnseen) * cost()));
  if (!whole) verdict.cost = std::max({verdict.cost, static_cast<float>(enough), not_now()});
  if (std::isinf(verdict.cost)) verdict.status = CollapseStatus::kFieldError;
}

/// What stands against a candidate that moves the boundary, as far as it is found in less time than its fields are
/// measured in.
void MeasuredRounds::look_at_boundary(const CollapsePlan& plan, double enough, Verdict& verdict) const {
  const BoundaryCheck& boundary = collapser_.boundary();
  verdict.status = boundary.examine(plan, verdict.move);
  if (verdict.status != CollapseStatus::kAccepted) return;
  const CollapseCost& cost = collapser_.cost();
  const double most = std::min(boundary.domain_limit(), cost.domain_error_at(enough));
  const double least = boundary.at_least(plan.vs, plan.vd, most);
  const auto at_least = static_cast<float>(cost.of_domain(least));
  verdict.cost = std::max(verdict.cost, at_least);
  if (least > boundary.domain_limit())
    verdict.status = CollapseStatus::kDomainError;
  else if (verdict.cost <= candidates_.round_cost() && at_least > kRatherDomain * candidates_.round_cost())
    measure_domain(plan.vs, enough, verdict);
}

/// How far a candidate moves the boundary, and what it costs by that; given up when that is more than `enough`.
void MeasuredRounds::measure_domain(Vertex vs, double enough, Verdict& verdict) const {
  const CollapseCost& cost = collapser_.cost();
  const double most = cost.domain_error_at(enough);
  verdict.status = collapser_.boundary().measure(vs, candidates_.best(vs).target, verdict.move, most);
  const double error = *verdict.move.error;
  verdict.cost = std::max(verdict.cost, static_cast<float>(cost.of_domain(error)));
  if (error > most) verdict.cost = std::max(verdict.cost, not_now());
}

/// What is not to be taken in this round costs this at least, whatever is left of its cost in a float.
float MeasuredRounds::not_now() const {
  return std::nextafter(candidates_.round_cost(), INFINITY);
}

/// By field: the integral of the squared error over the tets that the collapse would consume.
std::vector<double> MeasuredRounds::squared_in_star(const CollapseCheck& check) const {
  std::vector<double> sum(field_count_);
  for (const std::span<const SlotId> part : {check.deleted(), check.modified()})
    for (const SlotId s : part)
      for (std::size_t f = 0; f < field_count_; ++f)
        sum[f] += slot_sums_[s * sum_count_ + f];
  return sum;
}

CollapseStatus MeasuredRounds::collapse(Vertex vs, std::uint32_t round, Verdict& verdict) {
  Trial& trial = candidates_.trial();
  const Vertex vd = candidates_.best(vs).target;
  CollapseStatus status = trial.examine(vs, vd);
  if (status != CollapseStatus::kAccepted) return status;
  const double added = trial.check().moves_boundary() ? volume_added(complex_, collapser_.positions(), vs, vd) : 0;
  status = collapser_.collapse(round, verdict.errors, verdict.move);
  if (status == CollapseStatus::kAccepted) record_squared_errors(trial.check(), verdict.integrals, added);
  return status;
}

/// Puts what was measured in the place of the sums `i` of the star's slots; returns the change of their total.
double MeasuredRounds::exchange_sums(const CollapseCheck& check, std::size_t i, const std::vector<double>& integrals) {
  double change = 0;
  for (const SlotId s : check.deleted())
    change -= std::exchange(slot_sums_[s * sum_count_ + i], 0.0);
  for (std::size_t m = 0; m < check.modified().size(); ++m) {
    double& sum = slot_sums_[check.modified()[m] * sum_count_ + i];
    change += integrals[m * sum_count_ + i] - sum;
    sum = integrals[m * sum_count_ + i];
  }
  return change;
}

/// The changes by a collapse that has been made. What the mesh covers is its volume less what is outside of the domain;
/// inside the mesh neither changes.
void MeasuredRounds::record_squared_errors(const CollapseCheck& check, const std::vector<double>& integrals,
                                           double volume_added) {
  for (std::size_t f = 0; f < field_count_; ++f)
    collapser_.records().squared_error.push_back(exchange_sums(check, f, integrals) * squared_scale_[f]);
  const double uncovered = exchange_sums(check, field_count_, integrals) - volume_added;
  collapser_.records().uncovered_volume.push_back(check.moves_boundary() ? uncovered : 0);
}

void MeasuredRounds::measure_made() {
  std::vector<SlotId> made;
  for (Vertex v = 0; v < complex_.vertex_count(); ++v)
    for (const SlotId s : complex_.star(v)) {
      const Slot& slot = complex_.slot(s);
      if (slot.version != s && !complex_.is_ghost(slot) && v == *std::min_element(slot.v.begin(), slot.v.end()))
        made.push_back(s);
    }
  const ExactFieldError& exact = *collapser_.exact();
  oneapi::tbb::enumerable_thread_specific<ExactFieldError::Workspace> workspaces(
      [&] { return ExactFieldError::Workspace(exact); });
  oneapi::tbb::parallel_for(oneapi::tbb::blocked_range<std::size_t>(0, made.size(), 64), [&](const auto& range) {
    std::vector<double> errors(field_count_);
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      const std::span<double> sums(slot_sums_.data() + made[i] * sum_count_, sum_count_);
      std::fill(errors.begin(), errors.end(), 0.0);
      exact.measure(complex_.tet_of(complex_.slot(made[i])), workspaces.local(), errors, sums);
    }
  });
}

} // namespace ptet::build
