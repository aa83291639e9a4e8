// How numbers are coded, once for the reader's side and the writer's (see range_coder.hpp for the sides): each function
// takes the true value on the writer's side and returns it on both.
//
//   unsigned   the length in bits by a tree of contexts, the two bits below the leading one by contexts, the rest as is
//   signed     the magnitude, then the sign
//   scalar     its rank, less that of the prediction: among the values of its type, or where the column has one of its
//              precision (see Precision)
//   code       of an error: its difference from what is expected
#pragma once

#include "formats/ptet/range_coder.hpp"
#include "formats/ptet/schema.hpp"
#include "mesh/scalar_dispatch.hpp"
#include "ptet/error.hpp"
#include "ptet/mesh.hpp"

#include <algorithm>
#include <bit>
#include <cfloat>
#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>

namespace ptet::file {

static_assert(FLT_EVAL_METHOD == 0 || FLT_EVAL_METHOD == 1,
              "doubles have to be computed with as such (32-bit x86: -msse2 -mfpmath=sse)");

[[noreturn]] inline void fail_record(RecordId r, const char* what) {
  throw Error(ErrorCode::kCorruptFile, "record " + std::to_string(r.index()) + " is corrupt: " + what);
}

/// Whether a coder is on the reader's side, where values are not known before.
template <class Coder>
inline constexpr bool kReads = std::is_same_v<Coder, RangeDecoder>;

/// The bits of `value` below 2^levels, high one first, in a tree of 2^levels contexts.
template <class Coder>
std::uint32_t code_tree(Coder& coder, std::uint32_t first_context, unsigned levels, std::uint32_t value) {
  if constexpr (kReads<Coder>) return coder.tree(first_context, levels) - (1U << levels);
  std::uint32_t node = 1;
  for (unsigned level = levels; level-- > 0;) {
    node = node << 1 | (coder.bit(first_context + node, (value >> level & 1) != 0) ? 1U : 0U);
  }
  return node - (1U << levels);
}

/// The bits of `value` below its leading one, given its length: the top two by contexts, the rest as they are.
template <class Coder>
std::uint64_t code_mantissa(Coder& coder, std::uint32_t first_context, unsigned length, std::uint64_t value) {
  if (length < 2) return length;
  const std::uint32_t context = first_context + 3 * length;
  unsigned left = length - 1;
  const bool high = coder.bit(context, (value >> --left & 1) != 0);
  std::uint64_t result = high ? 3 : 2;
  if (left > 0) {
    --left;
    result = result << 1 | (coder.bit(context + (high ? 2 : 1), (value >> left & 1) != 0) ? 1U : 0U);
  }
  const std::uint64_t rest = left == 0 ? 0 : coder.raw(left, value & ((std::uint64_t{1} << left) - 1));
  return result << left | rest;
}

/// An unsigned number below 2^31: Schema::kUintContexts contexts.
template <class Coder>
std::uint32_t code_uint(Coder& coder, std::uint32_t first_context, std::uint32_t value) {
  const std::uint32_t length = code_tree(coder, first_context, 5, static_cast<std::uint32_t>(std::bit_width(value)));
  return static_cast<std::uint32_t>(code_mantissa(coder, first_context + 32, length, value));
}

/// A signed one: 32 contexts more, for the sign by length.
template <class Coder>
std::int64_t code_int(Coder& coder, std::uint32_t first_context, std::int64_t value) {
  const auto magnitude = code_uint(coder, first_context, static_cast<std::uint32_t>(value < 0 ? -value : value));
  if (magnitude == 0) return 0;
  const bool negative = coder.bit(
      first_context + Schema::kUintContexts + static_cast<std::uint32_t>(std::bit_width(magnitude)), value < 0);
  return negative ? -static_cast<std::int64_t>(magnitude) : static_cast<std::int64_t>(magnitude);
}

/// The rank of the scalar that is to be coded, where it is known.
template <class Coder>
std::uint64_t known_rank(const Column& column, const std::byte* at) {
  if constexpr (kReads<Coder>) return 0;
  return load_rank(column.type, at);
}

/// A difference modulo 2^64, as sign and magnitude, in the contexts of a column and a spread.
template <class Coder>
std::uint64_t code_difference(Coder& coder, const Column& column, std::uint64_t spread, std::uint64_t difference,
                              RecordId r) {
  const unsigned spread_class =
      std::min(static_cast<unsigned>(std::bit_width(spread)), column.bits > 32 ? 64U : 32U) / 2;
  const bool negative = static_cast<std::int64_t>(difference) < 0;
  const std::uint64_t magnitude = negative ? 0 - difference : difference;
  const std::uint32_t length = code_tree(coder, column.length + (spread_class << column.length_levels),
                                         column.length_levels, static_cast<std::uint32_t>(std::bit_width(magnitude)));
  if (length == 0) return 0;
  if (length > (column.bits > 32 ? 64U : 32U)) fail_record(r, "a number has too many bits");
  const bool is_negative = coder.bit(column.sign, negative);
  const std::uint64_t coded = code_mantissa(coder, column.mantissa, length, magnitude);
  return is_negative ? 0 - coded : coded;
}

/// The rank of a scalar whose lowest `zero_bits` are 0, and not coded.
template <class Coder>
std::uint64_t code_rank(Coder& coder, const Column& column, unsigned zero_bits, double predicted, double spread,
                        std::uint64_t rank, RecordId r) {
  const std::uint64_t from = rank_of(column.type, predicted) >> zero_bits;
  const std::uint64_t apart = (rank_of(column.type, predicted + spread) >> zero_bits) - from;
  const unsigned unused = 64 - column.bits + zero_bits;
  // The difference modulo 2^bits, its sign extended.
  const auto difference =
      static_cast<std::uint64_t>(static_cast<std::int64_t>(((rank >> zero_bits) - from) << unused) >> unused);
  const auto apart_signed = static_cast<std::int64_t>(apart << unused) >> unused;
  const std::uint64_t coded = code_difference(coder, column,
                                              apart_signed < 0 ? 0 - static_cast<std::uint64_t>(apart_signed)
                                                               : static_cast<std::uint64_t>(apart_signed),
                                              difference, r);
  const std::uint64_t result = ((from + coded) << unused) >> unused;
  return zero_bits == 0 ? result : with_zeros(column.type, zero_bits, result);
}

/// A scalar by its rank, given a prediction and how far the numbers it was made from lie apart.
template <class Coder>
std::uint64_t code_scalar(Coder& coder, const Column& column, double predicted, double spread, std::uint64_t rank,
                          RecordId r) {
  if (column.decimals) {
    std::optional<std::int64_t> exact;
    if constexpr (!kReads<Coder>) exact = column.decimals->exact(rank);
    if (!coder.bit(column.escape, !exact.has_value())) {
      const std::int64_t from = column.decimals->nearest(predicted);
      const std::int64_t apart = column.decimals->nearest(predicted + spread) - from;
      const std::uint64_t difference =
          code_difference(coder, column, static_cast<std::uint64_t>(apart < 0 ? -apart : apart),
                          static_cast<std::uint64_t>(exact.value_or(0)) - static_cast<std::uint64_t>(from), r);
      const auto coded =
          column.decimals->value_rank(static_cast<std::int64_t>(static_cast<std::uint64_t>(from) + difference));
      if (!coded) fail_record(r, "a decimal number is out of range");
      return *coded;
    }
  }
  if (column.zero_bits != 0) {
    bool has_zeros = false;
    if constexpr (!kReads<Coder>) has_zeros = without_zeros(column.type, column.zero_bits, rank).has_value();
    if (!coder.bit(column.escape, !has_zeros))
      return code_rank(coder, column, column.zero_bits, predicted, spread, rank, r);
  }
  return code_rank(coder, column, 0, predicted, spread, rank, r);
}

/// A code by its difference from what is expected: Schema::kErrorContexts contexts.
template <class Coder>
std::int32_t code_near(Coder& coder, std::uint32_t first_context, std::int32_t expected, std::int32_t value) {
  const std::int32_t difference = value - expected;
  const auto magnitude = static_cast<std::uint32_t>(std::abs(difference));
  const std::uint32_t length =
      code_tree(coder, first_context, 4, static_cast<std::uint32_t>(std::bit_width(magnitude)));
  if (length == 0) return expected;
  const bool negative = coder.bit(first_context + 64, difference < 0);
  const auto coded = static_cast<std::int32_t>(code_mantissa(coder, first_context + 16, length, magnitude));
  return expected + (negative ? -coded : coded);
}

} // namespace ptet::file
