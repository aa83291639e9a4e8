// Where the original boundary crosses itself, and which faces of a coarser one may therefore cross, too.
//
//     ____\__________     The faces that cross one another along a curve are of that curve: these, and those that they
//      A   \     B        cross elsewhere on it. What a collapse makes stands for all that it consumed, and is of all
//      _____\____         its curves. Two faces of one curve may cross; others must not.
//            \  C
//
// Without that, nothing could move where bodies of the input reach into one another: whatever comes out of a collapse
// there crosses what the faces before it crossed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

namespace ptet::build {

/// Sets of curves, each there once.
class SelfCrossings {
public:
  using Set = std::uint32_t;
  static constexpr Set kNone = 0; ///< of no curve

  /// `curves`: by original boundary face, as PreparedMesh::crossing_curves.
  explicit SelfCrossings(std::span<const std::uint32_t> curves);

  /// Whether there are any.
  [[nodiscard]] bool empty() const { return of_original_.empty(); }
  /// Of an original boundary face, by its place among them.
  [[nodiscard]] Set of_original(std::size_t face) const { return empty() ? kNone : of_original_[face]; }
  /// What is of one or the other.
  [[nodiscard]] Set join(Set a, Set b);
  /// Whether faces of these curves may cross. Thread rule: const.
  [[nodiscard]] bool share(Set a, Set b) const;

private:
  Set intern(std::vector<std::uint32_t> curves);

  std::vector<Set> of_original_;
  std::vector<std::vector<std::uint32_t>> sets_; ///< ascending
  std::map<std::vector<std::uint32_t>, Set> place_of_;
};

} // namespace ptet::build
