// The rounds of a build: the mesh is collapsed until the target is reached or a whole sweep accepts nothing.
//
//   repeat   predict    the cheapest outgoing half-edge of every vertex whose star has changed   (parallel)
//            pick       the best part of them, lower dependency height first
//            take       what may go of them, by what was predicted or by exact measurement; no star twice
//   until    the target is reached or a whole sweep accepts nothing
//
// Source: Cignoni et al. 2000, sections 3 and 4; rounds instead of one greedy sequence keep the records' dependencies
// short.
#pragma once

#include "build/collapser.hpp"
#include "build/measured_rounds.hpp"
#include "build/predicted_rounds.hpp"
#include "ptet/build.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace ptet::build {

/// How far the rounds have come.
struct RoundState {
  std::uint32_t round = 0;
  bool swept = true;           ///< nothing was accepted since every vertex was looked at afresh
  StatusCounts before_sweep{}; ///< refusals when the last sweep began

  template <class Archive>
  void serialize(Archive& archive, unsigned /*version*/) {
    archive& round& swept& before_sweep;
  }
};

class Rounds {
public:
  /// All must outlive the object; the mesh must be as it was given.
  Rounds(Collapser& collapser, const BuildOptions& options, RoundState& state, BuildReport& report);

  /// All rounds that are left. `within` is called now and then within a round, `after` at the end of each, both from
  /// this thread, and may throw. The report gets counts, walk and why it ended.
  void run(const std::function<void()>& within, const std::function<void()>& after);
  /// Before the first round, when collapses were made, and their errors recorded, by others.
  void go_on_from_collapses();

  /// All that lasts from one round to the next, besides the state and what the same collapses, made by others, bring
  /// back.
  template <class Archive>
  void serialize(Archive& archive, unsigned /*version*/) {
    if (measured_) archive&* measured_;
    archive& collapser_.candidates();
  }

private:
  void take(std::vector<Vertex> picked, const std::function<void()>& within);
  [[nodiscard]] StatusCounts tries() const;
  [[nodiscard]] StatusCounts refusals_of_last_sweep() const;
  [[nodiscard]] std::string why_stuck() const;

  Collapser& collapser_;
  RoundState& state_;
  BuildReport& report_;
  // One of these.
  std::optional<PredictedRounds> predicted_;
  std::optional<MeasuredRounds> measured_;
};

} // namespace ptet::build
