// Takes the collapses of a round by what was predicted of them: batch after batch, those that do not depend on one
// another are examined in parallel, accepted one by one, and made together.
//
//   picked     a  b  c  d  e  f  g ...     in the order in which they are to be taken
//   claims     a     c        f            free of the stars of the claims before them: examined at the same time
//   waiting       b     d  e               looked at again when all of the picked have been, those first that were not
//                                          free, batch by batch
//
// Most of those that wait find then that their star has changed, and are left for another round. What comes of a round
// depends on its picks alone, not on the number of threads.
#pragma once

#include "build/collapser.hpp"
#include "ptet/build.hpp"

#include <cstdint>
#include <functional>
#include <vector>

namespace ptet::build {

class PredictedRounds {
public:
  /// Both must outlive the object. `report` counts what becomes of half-edges.
  PredictedRounds(Collapser& collapser, BuildReport& report);

  /// Collapses what may go of `picked`, by Candidates::pick(), until the target is reached. `within`: see Rounds::run.
  void take(std::vector<Vertex> picked, std::uint32_t round, const std::function<void()>& within);

private:
  struct Claim {
    Vertex vs = kNone;
    std::uint32_t number = 0;         ///< one more than that of the claim before it
    bool waits = false;               ///< for a claim before it
    CollapsePlan plan;                ///< of the half-edge that is to be taken; of none: its vs is kNone
    BoundaryMove move;                ///< of that
    std::vector<double> field_errors; ///< of that, where nothing is measured
  };

  [[nodiscard]] std::size_t claim_stars(const std::vector<Vertex>& picked, std::size_t next,
                                        std::vector<Vertex>& waiting);
  [[nodiscard]] bool may_go(Vertex vs) const;
  [[nodiscard]] bool is_claimed(Vertex x) const { return claimed_[x] >= first_number_; }
  void examine_claim(Claim& claim, std::uint32_t round, Trial& trial);
  [[nodiscard]] CollapseStatus examine(Vertex vs, BoundaryMove& move, Trial& trial) const;
  [[nodiscard]] bool take_claim(Claim& claim, std::uint32_t round);

  Collapser& collapser_;
  const WorkingComplex& complex_;
  Candidates& candidates_;
  BuildReport& report_;
  std::vector<Claim> claims_;          ///< room for those that are examined at the same time
  std::size_t claim_count_ = 0;        ///< so many of these are in use
  std::uint32_t first_number_ = 1;     ///< of these
  std::vector<std::uint32_t> claimed_; ///< by vertex, the dummy last: the first of the last claims with it in its star
};

} // namespace ptet::build
