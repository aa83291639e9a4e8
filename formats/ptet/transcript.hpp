// What one coder of a block was told, to be told to another (range_coder.hpp).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <initializer_list>
#include <vector>

namespace ptet::file {

/// Two bytes a bit in a context; of its 32,752 first ones, that is. Packed, a bit takes less than one.
class Transcript {
public:
  void bit(std::uint32_t context, bool bit) {
    const std::uint32_t unit = context << 1 | (bit ? 1U : 0U);
    if (unit >= kRaw) put({kFar, unit >> 16});
    put({unit & 0xFFFF});
  }
  void raw(unsigned count, std::uint64_t value) {
    for (unsigned left = count; left > 0;) {
      const unsigned step = std::min(left, 16U); // a coder goes by eights
      left -= step;
      put({kRaw + step, static_cast<std::uint32_t>(value >> left & ((1U << step) - 1))});
    }
  }
  template <class Coder>
  void tell(Coder& coder) const {
    if (packed_.empty())
      tell(coder, units_);
    else
      tell(coder, unpacked());
  }
  /// Bytes of memory.
  [[nodiscard]] std::size_t bytes() const { return units_.size() * sizeof(Unit) + packed_.size(); }
  /// Makes it smaller; nothing may be added any more. Throws Error(kLimit) where memory runs out.
  void pack();

private:
  using Unit = std::uint16_t;                   ///< a bit: 2 * context + bit
  static constexpr std::uint32_t kRaw = 0xFFE0; ///< and the number of bits: these follow
  static constexpr std::uint32_t kFar = 0xFFFF; ///< two halves of a greater number follow

  void put(std::initializer_list<std::uint32_t> units) {
    for (const std::uint32_t unit : units)
      units_.push_back(static_cast<Unit>(unit));
  }
  [[nodiscard]] std::vector<Unit> unpacked() const;
  template <class Coder, class Units>
  static void tell(Coder& coder, const Units& units) {
    for (auto at = units.begin(); at != units.end(); ++at) {
      std::uint32_t unit = *at;
      if (unit > kRaw && unit != kFar) {
        coder.raw(unit - kRaw, *++at);
        continue;
      }
      if (unit == kFar) {
        unit = std::uint32_t{*++at} << 16;
        unit |= *++at;
      }
      coder.bit(unit >> 1, (unit & 1) != 0);
    }
  }

  std::deque<Unit> units_; ///< which does not move what it has as it grows
  std::vector<std::byte> packed_;
  std::size_t packed_units_ = 0;
};

} // namespace ptet::file
