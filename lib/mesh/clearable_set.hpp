// A set of numbers below a bound, which is emptied in no time however many are in it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace ptet {

/// Not safe for concurrent use. Not checked: numbers are below the bound.
class ClearableSet {
public:
  explicit ClearableSet(std::size_t bound) : added_at_(bound) {}

  void clear() {
    if (++now_ != 0) return;
    std::fill(added_at_.begin(), added_at_.end(), 0U); // 2^32 times: the count has gone round
    now_ = 1;
  }
  [[nodiscard]] bool has(std::size_t i) const { return added_at_[i] == now_; }
  /// Returns false if it was there before.
  bool add(std::size_t i) {
    if (has(i)) return false;
    added_at_[i] = now_;
    return true;
  }
  /// Returns false if it was not there.
  bool remove(std::size_t i) {
    if (!has(i)) return false;
    added_at_[i] = now_ - 1;
    return true;
  }

private:
  std::vector<std::uint32_t> added_at_; ///< how often the set had been emptied then
  std::uint32_t now_ = 1;
};

} // namespace ptet
