// The adaptive binary range coder of the record blocks, seen from four sides that share one shape, so that one text
// says what is coded and every side runs it:
//
//   bool          bit(context, bit)    the decoder ignores its argument, all return the bit coded
//   std::uint64_t raw(count, value)    `count` bits (<= 64) as they are, high ones first
//
//   RangeEncoder  writes              RangeDecoder  reads
//   BitCounter    trains              BitMeter      says what coding would cost, and changes nothing
//
// After Martin 1979 and the coder of LZMA; PTET.md gives it in full.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace ptet::file {

/// A context's state: how likely bit 1 is, in 1/65536; moves towards what it sees.
struct Probability {
  static constexpr unsigned kRate = 5;
  static constexpr unsigned kBits = 12; ///< of it that the coder uses

  std::uint16_t one = 0x8000;

  [[nodiscard]] static Probability from_byte(std::uint8_t byte) {
    return {static_cast<std::uint16_t>(byte * 256U + 128U)};
  }
  [[nodiscard]] std::uint32_t scaled() const { return one >> (16 - kBits); }
  void update(bool bit) { update(bit ? ~0U : 0U); }
  /// `if_one`: 0 or all bits set. Rises by (65535 - one) >> kRate or falls by one >> kRate: rounding down what is
  /// added, both are a part of the way to a number.
  void update(std::uint32_t if_one) {
    constexpr std::uint32_t kLeast = (1U << kRate) - 1;
    const auto towards = static_cast<std::int32_t>(kLeast + (if_one & (65535U - kLeast)));
    one = static_cast<std::uint16_t>(one + ((towards - one) >> kRate));
  }
};

/// The probabilities of all contexts as one block starts with them.
using InitialProbabilities = std::vector<std::uint8_t>;

[[nodiscard]] inline std::vector<Probability> start_probabilities(const InitialProbabilities& initial) {
  std::vector<Probability> result(initial.size());
  std::transform(initial.begin(), initial.end(), result.begin(), Probability::from_byte);
  return result;
}

class RangeEncoder {
public:
  explicit RangeEncoder(const InitialProbabilities& initial) : contexts_(start_probabilities(initial)) {}

  bool bit(std::uint32_t context, bool bit) {
    Probability& p = contexts_[context];
    const std::uint32_t bound = (range_ >> Probability::kBits) * p.scaled();
    if (bit) {
      range_ = bound;
    } else {
      low_ += bound;
      range_ -= bound;
    }
    p.update(bit);
    normalise();
    return bit;
  }
  std::uint64_t raw(unsigned count, std::uint64_t value) {
    for (unsigned left = count; left > 0;) {
      const unsigned step = std::min(left, 8U);
      left -= step;
      range_ >>= step;
      low_ += (value >> left & ((1U << step) - 1)) * static_cast<std::uint64_t>(range_);
      normalise();
    }
    return value;
  }
  /// Ends the code with as few bytes as decode right, given that zeros are read behind the end.
  [[nodiscard]] std::vector<std::byte> finish() {
    for (unsigned zeros = 32; zeros-- > 0;) {
      const std::uint64_t mask = (std::uint64_t{1} << zeros) - 1;
      const std::uint64_t value = (low_ + mask) & ~mask;
      if (value < low_ + range_) {
        low_ = value;
        break;
      }
    }
    for (int i = 0; i < 4; ++i)
      shift_out();
    while (!bytes_.empty() && bytes_.back() == std::byte{0})
      bytes_.pop_back();
    return std::move(bytes_);
  }

private:
  void normalise() {
    while (range_ < (1U << 24)) {
      range_ <<= 8;
      shift_out();
    }
  }
  void shift_out() {
    if (low_ >> 32 != 0) {
      for (std::size_t i = bytes_.size(); i-- > 0;) {
        bytes_[i] = static_cast<std::byte>(static_cast<unsigned>(bytes_[i]) + 1);
        if (bytes_[i] != std::byte{0}) break;
      }
    }
    bytes_.push_back(static_cast<std::byte>(low_ >> 24 & 0xFF));
    low_ = (low_ & 0x00FFFFFF) << 8;
  }

  std::vector<Probability> contexts_;
  std::vector<std::byte> bytes_;
  std::uint64_t low_ = 0;
  std::uint32_t range_ = 0xFFFFFFFF;
};

class RangeDecoder {
public:
  RangeDecoder(const InitialProbabilities& initial, std::vector<std::byte> bytes, std::size_t start)
      : contexts_(start_probabilities(initial)), bytes_(std::move(bytes)), next_(start) {
    for (int i = 0; i < 4; ++i)
      state_.code = state_.code << 8 | next_byte();
  }

  bool bit(std::uint32_t context, bool = false) {
    Probability& p = contexts_[context];
    return take(p, p.scaled(), state_) != 0;
  }
  /// `levels` bits, at least one, each in the context `first` plus the bits before it with a 1 in front; returns them
  /// with that 1. The contexts of both outcomes are at hand before a bit is known: the next bit waits for no memory.
  std::uint32_t tree(std::uint32_t first, unsigned levels) {
    Probability* const root = contexts_.data() + first;
    State state = state_;
    std::uint32_t node = 1;
    std::uint32_t scaled = root[1].scaled();
    for (unsigned level = 1; level < levels; ++level) {
      const std::uint32_t of_zero = root[2 * node].scaled(), of_one = root[2 * node + 1].scaled();
      const std::uint32_t if_one = take(root[node], scaled, state);
      scaled = of_zero ^ ((of_zero ^ of_one) & if_one);
      node = 2 * node - if_one;
    }
    node = 2 * node - take(root[node], scaled, state);
    state_ = state;
    return node;
  }
  std::uint64_t raw(unsigned count, std::uint64_t = 0) {
    std::uint64_t value = 0;
    State state = state_;
    for (unsigned left = count; left > 0;) {
      const unsigned step = std::min(left, 8U);
      left -= step;
      state.range >>= step;
      const std::uint32_t digit = std::min(state.code / state.range, (1U << step) - 1);
      state.code -= digit * state.range;
      value = value << step | digit;
      normalise(state);
    }
    state_ = state;
    return value;
  }

private:
  struct State {
    std::uint32_t range = 0xFFFFFFFF, code = 0;
  };

  // Bits are what cannot be predicted, so there is no branch on one here. Returns 0 or, for a 1, all bits set.
  [[gnu::always_inline]] std::uint32_t take(Probability& p, std::uint32_t scaled, State& state) {
    const std::uint32_t bound = (state.range >> Probability::kBits) * scaled;
    const auto if_one = static_cast<std::uint32_t>((std::uint64_t{state.code} - bound) >> 32);
    const std::uint32_t rest = state.range - bound;
    state.code -= bound & ~if_one;
    state.range = rest ^ ((rest ^ bound) & if_one);
    p.update(if_one);
    normalise(state);
    return if_one;
  }
  [[nodiscard]] std::uint32_t next_byte() {
    return next_ < bytes_.size() ? static_cast<std::uint32_t>(bytes_[next_++]) : 0U;
  }
  void normalise(State& state) {
    while (state.range < (1U << 24))
      [[unlikely]] {
        state.range <<= 8;
        state.code = state.code << 8 | next_byte();
      }
  }

  std::vector<Probability> contexts_;
  std::vector<std::byte> bytes_;
  std::size_t next_;
  State state_;
};

/// Cost of a bit in 1/256 bits, by the 12-bit probability of what happened.
[[nodiscard]] inline std::uint32_t bit_cost(std::uint32_t scaled) {
  static const auto kTable = [] {
    std::array<std::uint32_t, (1U << Probability::kBits) + 1> table{};
    for (std::size_t i = 0; i < table.size(); ++i) {
      const double p = std::max<double>(static_cast<double>(i), 0.5) / (1U << Probability::kBits);
      table[i] = static_cast<std::uint32_t>(std::lround(-std::log2(p) * 256));
    }
    return table;
  }();
  return kTable[scaled];
}

class BitCounter {
public:
  explicit BitCounter(std::size_t contexts) : counts_(contexts) {}

  bool bit(std::uint32_t context, bool bit) {
    ++counts_[context][bit ? 1 : 0];
    return bit;
  }
  std::uint64_t raw(unsigned /*count*/, std::uint64_t value) { return value; }

  BitCounter& operator+=(const BitCounter& other) {
    for (std::size_t i = 0; i < counts_.size(); ++i)
      for (const std::size_t bit : {0U, 1U})
        counts_[i][bit] += other.counts_[i][bit];
    return *this;
  }
  [[nodiscard]] InitialProbabilities trained() const {
    InitialProbabilities result(counts_.size());
    std::transform(counts_.begin(), counts_.end(), result.begin(), [](const auto& count) {
      const std::uint64_t byte = (count[1] * 256 + 128) / (count[0] + count[1] + 1);
      return static_cast<std::uint8_t>(std::min<std::uint64_t>(byte, 255));
    });
    return result;
  }

private:
  std::vector<std::array<std::uint64_t, 2>> counts_;
};

class BitMeter {
public:
  explicit BitMeter(const std::vector<Probability>& contexts) : contexts_(contexts) {}

  bool bit(std::uint32_t context, bool bit) {
    const Probability p = contexts_[context];
    cost_ += bit_cost(bit ? p.scaled() : (1U << Probability::kBits) - p.scaled());
    return bit;
  }
  std::uint64_t raw(unsigned count, std::uint64_t value) {
    cost_ += std::uint64_t{256} * count;
    return value;
  }
  [[nodiscard]] std::uint64_t cost() const { return cost_; }

private:
  const std::vector<Probability>& contexts_;
  std::uint64_t cost_ = 0;
};

} // namespace ptet::file
