// Union-find with path halving. The least member of a set is its root, so nothing depends on the order of the calls.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace ptet {

/// Sets of the numbers 0 .. size - 1, each by itself at first.
template <class Id = std::uint32_t>
class DisjointSets {
public:
  explicit DisjointSets(std::size_t size) : parent_(size), count_(size) {
    std::iota(parent_.begin(), parent_.end(), Id{0});
  }

  [[nodiscard]] Id root(Id a) {
    while (parent_[a] != a)
      a = parent_[a] = parent_[parent_[a]];
    return a;
  }
  void join(Id a, Id b) {
    a = root(a);
    b = root(b);
    if (a == b) return;
    parent_[std::max(a, b)] = std::min(a, b);
    --count_;
  }
  /// How many sets there are.
  [[nodiscard]] std::uint64_t count() const { return count_; }

private:
  std::vector<Id> parent_;
  std::uint64_t count_;
};

} // namespace ptet
