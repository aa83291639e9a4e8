#include "build/predicted_rounds.hpp"

#include <algorithm>
#include <cassert>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

namespace ptet::build {
namespace {

/// So many stars are examined at once: enough to share out, and few enough to stay in a cache until they are collapsed.
constexpr std::size_t kClaims = 128;

} // namespace

PredictedRounds::PredictedRounds(Collapser& collapser, BuildReport& report)
    : collapser_(collapser), complex_(collapser.complex()), candidates_(collapser.candidates()), report_(report),
      claimed_(complex_.vertex_count() + 1) {}

void PredictedRounds::take(std::vector<Vertex> picked, std::uint32_t round, const std::function<void()>& within) {
  std::vector<Vertex> waiting;
  for (; !picked.empty(); picked.swap(waiting), waiting.clear()) {
    for (std::size_t next = 0; next < picked.size();) {
      if (collapser_.at_target()) return;
      next = claim_stars(picked, next, waiting);
      collapser_.begin_changes();
      oneapi::tbb::parallel_for(oneapi::tbb::blocked_range<std::size_t>(0, claim_count_, 8), [&](const auto& range) {
        Trial& trial = candidates_.trial();
        for (std::size_t i = range.begin(); i != range.end(); ++i)
          examine_claim(claims_[i], round, trial);
      });
      for (std::size_t i = 0; i < claim_count_ && !collapser_.at_target(); ++i)
        if (!take_claim(claims_[i], round)) waiting.push_back(claims_[i].vs);
      collapser_.make_accepted();
      within();
    }
  }
}

/// Makes claims of the vertices of `picked`, from place `next` on, that may still go and whose half-edge does not touch
/// the stars of those before them; the others wait. Returns the place of the first that was not looked at.
std::size_t PredictedRounds::claim_stars(const std::vector<Vertex>& picked, std::size_t next,
                                         std::vector<Vertex>& waiting) {
  first_number_ += static_cast<std::uint32_t>(claim_count_);
  if (first_number_ > kNone - kClaims) { // the numbers have gone round
    std::fill(claimed_.begin(), claimed_.end(), 0);
    first_number_ = 1;
  }
  claim_count_ = 0;
  for (; next < picked.size() && claim_count_ < kClaims; ++next) {
    if (next + WorkingComplex::kPrefetch < picked.size())
      complex_.prefetch_star(picked[next + WorkingComplex::kPrefetch]);
    const Vertex vs = picked[next];
    if (!may_go(vs)) continue;
    if (is_claimed(vs) || is_claimed(candidates_.best(vs).target)) {
      waiting.push_back(vs);
      continue;
    }
    if (claim_count_ == claims_.size()) claims_.emplace_back();
    Claim& claim = claims_[claim_count_];
    claim.vs = vs;
    claim.number = first_number_ + static_cast<std::uint32_t>(claim_count_++);
    for (const SlotId s : complex_.star(vs))
      for (const Vertex x : complex_.slot(s).v)
        if (!is_claimed(x)) claimed_[x] = claim.number;
  }
  return next;
}

/// Whether the star of `vs` is as it was when the round began, and its best half-edge within the round's cost.
bool PredictedRounds::may_go(Vertex vs) const {
  return !candidates_.has_changed(vs) && candidates_.best(vs).target != kNone &&
         candidates_.best(vs).cost <= candidates_.round_cost();
}

/// Goes down the half-edges of the claim's vertex to the first that is not refused by the stars of its ends, nor by the
/// boundary as it is now: of that `plan` tells, if there is one. Where it touches the star of a claim before this one,
/// the claim waits.
void PredictedRounds::examine_claim(Claim& claim, std::uint32_t round, Trial& trial) {
  claim.plan.vs = kNone;
  claim.waits = false;
  while (may_go(claim.vs)) {
    const Vertex target = candidates_.best(claim.vs).target;
    assert(is_claimed(target)); // by this claim at the latest
    claim.waits = claimed_[target] < claim.number;
    if (claim.waits) return;
    const CollapseStatus status = examine(claim.vs, claim.move, trial);
    if (status == CollapseStatus::kAccepted) {
      trial.swap(claim.plan);
      if (collapser_.measures_nothing()) collapser_.predicted_errors(claim.plan, claim.field_errors);
      return;
    }
    candidates_.count_refusal(status);
    candidates_.drop_best(claim.vs, round);
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

/// False when its best half-edge within the round's cost, if there is one, is to be examined, or examined again.
bool PredictedRounds::take_claim(Claim& claim, std::uint32_t round) {
  if (claim.plan.vs == kNone) return !claim.waits;
  if (claim.plan.moves_boundary && collapser_.may_meet_accepted(claim.move)) return false;
  candidates_.trial().swap(claim.plan);
  const CollapseStatus status =
      collapser_.accept(round, collapser_.measures_nothing() ? &claim.field_errors : nullptr, claim.move);
  ++report_.collapses[static_cast<std::size_t>(status)];
  if (status == CollapseStatus::kAccepted) return true;
  candidates_.drop_best(claim.vs, round);
  return false;
}

} // namespace ptet::build
