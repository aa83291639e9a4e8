#include "build/predicted_rounds.hpp"

#include <algorithm>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

namespace ptet::build {
namespace {

/// So many stars are examined at once: enough to share out, and few enough to stay in a cache until they are collapsed.
constexpr std::size_t kClaims = 128;

} // namespace

PredictedRounds::PredictedRounds(Collapser& collapser, BuildReport& report)
    : collapser_(collapser), complex_(collapser.complex()), candidates_(collapser.candidates()), report_(report),
      touched_(complex_.vertex_count()), claimed_(complex_.vertex_count() + 1) {}

void PredictedRounds::take(const std::vector<Vertex>& picked, std::uint32_t round) {
  round_ = round;
  std::vector<Vertex> waiting;
  for (std::size_t next = 0; !collapser_.at_target() && (next < picked.size() || !waiting.empty());) {
    next = claim_stars(picked, next, waiting);
    collapser_.begin_changes();
    oneapi::tbb::parallel_for(oneapi::tbb::blocked_range<std::size_t>(0, claim_count_, 16), [&](const auto& range) {
      Trial& trial = candidates_.trial();
      for (std::size_t i = range.begin(); i != range.end(); ++i)
        examine_claim(claims_[i], trial);
    });
    for (std::size_t i = 0; i < claim_count_ && !collapser_.at_target(); ++i)
      if (!take_claim(claims_[i])) waiting.push_back(claims_[i].vs);
    collapser_.make_accepted();
  }
}

/// Sorts vertices that may still go in this round, first those that are `waiting` and then those of `picked` from
/// place `next` on, into claims, which depend on nobody before them, and others, which wait on. Returns the place of
/// the first that was not looked at.
std::size_t PredictedRounds::claim_stars(const std::vector<Vertex>& picked, std::size_t next,
                                         std::vector<Vertex>& waiting) {
  ++claim_stamp_;
  claim_count_ = 0;
  std::size_t kept = 0;
  const auto claim = [&](Vertex vs) {
    if (claim_count_ == claims_.size()) claims_.emplace_back();
    claims_[claim_count_++].vs = vs;
  };
  const auto look_at = [&](Vertex vs) {
    if (!may_go(vs)) return true;
    const bool free = claimed_[vs] != claim_stamp_ && claimed_[candidates_.best(vs).target] != claim_stamp_;
    if (free) claim(vs);
    // Who waits comes before what it would touch, too.
    for (const SlotId s : complex_.star(vs))
      for (const Vertex x : complex_.slot(s).v)
        claimed_[x] = claim_stamp_;
    return free;
  };
  for (const Vertex vs : waiting)
    if (!look_at(vs)) waiting[kept++] = vs;
  waiting.resize(kept);
  for (; next < picked.size() && claim_count_ < kClaims && waiting.size() < kClaims; ++next) {
    if (next + WorkingComplex::kPrefetch < picked.size())
      complex_.prefetch_star(picked[next + WorkingComplex::kPrefetch]);
    if (!look_at(picked[next])) waiting.push_back(picked[next]);
  }
  ++claim_stamp_; // from now on for what has changed
  return next;
}

/// Whether the star of `vs` is as it was when the round began, and its best half-edge within the round's cost.
bool PredictedRounds::may_go(Vertex vs) const {
  return touched_[vs] != round_ && candidates_.best(vs).target != kNone &&
         candidates_.best(vs).cost <= candidates_.round_cost();
}

/// Goes down the half-edges of the claim's vertex to the first that is not refused by the stars of its ends, nor by the
/// boundary as it is now: of that `plan` tells, if there is one.
void PredictedRounds::examine_claim(Claim& claim, Trial& trial) {
  claim.plan.vs = kNone;
  while (may_go(claim.vs)) {
    const CollapseStatus status = examine(claim.vs, claim.move, trial);
    if (status == CollapseStatus::kAccepted) {
      trial.swap(claim.plan);
      if (collapser_.measures_nothing()) collapser_.predicted_errors(claim.plan, claim.field_errors);
      return;
    }
    candidates_.count_refusal(status);
    candidates_.drop_best(claim.vs, round_);
  }
}

/// The best half-edge of `vs`.
CollapseStatus PredictedRounds::examine(Vertex vs, BoundaryMove& move, Trial& trial) const {
  const BoundaryCheck& boundary = collapser_.boundary();
  CollapseStatus status = trial.examine(vs, candidates_.best(vs).target);
  if (!trial.check().moves_boundary()) return status;
  move.error.reset();
  if (status == CollapseStatus::kAccepted) status = boundary.examine(trial.check().plan(), move);
  if (status == CollapseStatus::kAccepted && boundary.measures_quickly())
    status = boundary.measure(vs, trial.check().plan().vd, move);
  return status;
}

/// False when its best half-edge within the round's cost, if there is one, is yet to be examined.
bool PredictedRounds::take_claim(Claim& claim) {
  if (claim.plan.vs == kNone) return true;
  const Vertex vs = claim.vs;
  Trial& trial = candidates_.trial();
  CollapseStatus status = CollapseStatus::kAccepted;
  const std::vector<double>* known = collapser_.measures_nothing() ? &claim.field_errors : nullptr;
  if (claimed_[claim.plan.vd] == claim_stamp_) { // another collapse changes its star
    collapser_.make_accepted();
    status = examine(vs, claim.move, trial);
    known = nullptr;
  } else {
    trial.swap(claim.plan);
  }
  if (status == CollapseStatus::kAccepted) status = collapser_.accept(round_, known, claim.move);
  ++report_.collapses[static_cast<std::size_t>(status)];
  if (status != CollapseStatus::kAccepted) {
    candidates_.drop_best(vs, round_);
    return false;
  }
  touched_[vs] = round_;
  for (const LinkVertex& x : collapser_.last_accepted().link) {
    touched_[x.vertex] = round_;
    claimed_[x.vertex] = claim_stamp_;
  }
  return true;
}

} // namespace ptet::build
