#include "build/rounds.hpp"

#include <string_view>
#include <utility>

namespace ptet::build {

Rounds::Rounds(Collapser& collapser, const BuildOptions& options, RoundState& state, BuildReport& report)
    : collapser_(collapser), state_(state), report_(report) {
  if (options.prediction == Prediction::kExact)
    measured_.emplace(collapser, report);
  else
    predicted_.emplace(collapser, report);
}

void Rounds::run(const std::function<void()>& within, const std::function<void()>& after) {
  Candidates& candidates = collapser_.candidates();
  while (!collapser_.at_target()) {
    ++state_.round;
    candidates.predict(state_.round, within);
    auto picked = candidates.pick();
    if (picked.empty()) {
      if (state_.swept) break;
      // Refusals may have lost their reason by collapses near by: look at everything once more.
      candidates.forget_all();
      state_.swept = true;
      state_.before_sweep = tries();
      continue;
    }
    const std::size_t before = collapser_.records().size();
    take(std::move(picked), within);
    if (collapser_.records().size() != before) {
      state_.swept = false;
      ++report_.rounds;
      report_.depth = collapser_.depth();
      report_.walk.push_back({collapser_.vertices_left(), candidates.round_cost()});
    }
    after();
  }
  report_.last_refusals = {};
  if (!collapser_.at_target()) report_.last_refusals = refusals_of_last_sweep();
  report_.stopped_by = collapser_.at_target() ? "target" : why_stuck();
  report_.collapses = tries();
  report_.simulations += candidates.simulations();
}

void Rounds::take(std::vector<Vertex> picked, const std::function<void()>& within) {
  if (measured_)
    measured_->take(picked, state_.round, within);
  else
    predicted_->take(std::move(picked), state_.round, within);
}

void Rounds::go_on_from_collapses() {
  if (measured_) measured_->measure_made();
}

/// By CollapseStatus: what has become of all half-edges looked at so far.
StatusCounts Rounds::tries() const {
  StatusCounts sum = collapser_.candidates().refusals();
  for (std::size_t i = 0; i < sum.size(); ++i)
    sum[i] += report_.collapses[i];
  return sum;
}

/// The last sweep was over all half-edges that are left.
StatusCounts Rounds::refusals_of_last_sweep() const {
  StatusCounts counts = tries();
  for (std::size_t i = 0; i < counts.size(); ++i)
    counts[i] -= state_.before_sweep[i];
  counts[static_cast<std::size_t>(CollapseStatus::kAccepted)] = 0;
  return counts;
}

std::string Rounds::why_stuck() const {
  std::string reasons;
  const auto add = [&](std::string_view what, std::uint64_t count) {
    if (count != 0) reasons += (reasons.empty() ? "" : ", ") + std::string(what) + " " + std::to_string(count);
  };
  for (std::size_t i = 0; i < kCollapseStatusCount; ++i)
    if (const auto status = static_cast<CollapseStatus>(i); status != CollapseStatus::kFrozenVertex)
      add(name_of(status), report_.last_refusals[i]);
  add("frozen vertices", collapser_.alive_count() - collapser_.candidates().movable_count());
  return "no candidate left (" + (reasons.empty() ? "no edge may be collapsed" : "refused: " + reasons) + ")";
}

} // namespace ptet::build
