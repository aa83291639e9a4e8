// Takes the collapses of a round by what was predicted of them: again and again the first of those left that do not
// depend on one another are examined in parallel, accepted one by one, and made together.
//
//   picked     a  b  c  d  e  f  g ...     in the order in which they are to be taken
//   claims     a     c        f            free of whatever stands before them: examined at the same time
//   waiting       b     d  e               looked at again when those are done
//
// So what comes of a round is what taking one after the other in the order of the picks would make of it, but for
// boundaries that get out of one another's way in between.
#pragma once

#include "build/collapser.hpp"
#include "ptet/build.hpp"

#include <cstdint>
#include <vector>

namespace ptet::build {

class PredictedRounds {
public:
  /// Both must outlive the object. `report` counts what becomes of half-edges.
  PredictedRounds(Collapser& collapser, BuildReport& report);

  /// Collapses what may go of `picked`, by Candidates::pick(), until the target is reached. To be called once a round.
  void take(const std::vector<Vertex>& picked, std::uint32_t round);

private:
  struct Claim {
    Vertex vs = kNone;
    CollapsePlan plan;                ///< of the half-edge that is to be taken; of none: its vs is kNone
    BoundaryMove move;                ///< of that
    std::vector<double> field_errors; ///< of that, where nothing is measured
  };

  [[nodiscard]] std::size_t claim_stars(const std::vector<Vertex>& picked, std::size_t next,
                                        std::vector<Vertex>& waiting);
  [[nodiscard]] bool may_go(Vertex vs) const;
  void examine_claim(Claim& claim, Trial& trial);
  [[nodiscard]] CollapseStatus examine(Vertex vs, BoundaryMove& move, Trial& trial) const;
  [[nodiscard]] bool take_claim(Claim& claim);

  Collapser& collapser_;
  const WorkingComplex& complex_;
  Candidates& candidates_;
  BuildReport& report_;
  std::uint32_t round_ = 0;
  std::vector<std::uint32_t> touched_; ///< by vertex: the last round in which its star changed
  std::vector<Claim> claims_;          ///< room for those that are examined at the same time
  std::size_t claim_count_ = 0;        ///< so many of these are in use
  std::vector<std::uint32_t>
      claimed_; ///< by vertex: odd stamps for stars that are claimed, even for those that changed
  std::uint32_t claim_stamp_ = 0;
};

} // namespace ptet::build
