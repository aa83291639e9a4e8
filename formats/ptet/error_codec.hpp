// The errors and the order of a record, as they are coded: contexts and expectations come from the records before it in
// the block.
#pragma once

#include "formats/ptet/seed_codec.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>

namespace ptet::file {

/// The own errors of record `r` and, where they are larger, those of the finer records that depend on it. `missed`: by
/// governing field how far the prediction of its value was off, as an error code.
template <class Coder>
void code_errors(Coder& coder, const Schema& schema, BlockState& state, Content& content, RecordId r, bool at_boundary,
                 std::span<const std::int32_t> missed) {
  const std::uint32_t codes = schema.code_count();
  for (std::uint32_t i = 0; i < codes; ++i) {
    ErrorCode16& own = content.own[r.index() * std::size_t{codes} + i];
    const bool domain = i + 1 == codes;
    const std::uint32_t place = domain ? (at_boundary ? 1 : 0) : (missed[i] > 0 ? 1 : 0);
    const bool zero = coder.bit(schema.own_zero + 4 * i + 2 * place + (state.last_own_zero[i] != 0 ? 1 : 0), own == 0);
    state.last_own_zero[i] = zero ? 1 : 0;
    std::int32_t value = 0;
    if (!zero) {
      const std::int32_t expected = state.last_own[i];
      const std::int32_t above = domain ? 0 : missed[i] - expected;
      const std::uint32_t relation = static_cast<std::uint32_t>(std::clamp((above + 16 * 16) / 16 - 16 + 4, 0, 7));
      const std::uint32_t first = schema.own + (i * Schema::kErrorClasses + relation) * Schema::kErrorContexts;
      value = code_near(coder, first, expected, own);
      if (value < 1 || value > kMaxErrorCode) fail_record(r, "an error is out of range");
      state.last_own[i] = value;
    }
    own = static_cast<ErrorCode16>(value);

    ErrorCode16& monotone = content.monotone[r.index() * std::size_t{codes} + i];
    const bool none = coder.bit(
        schema.above_zero + 4 * i + 2 * (zero ? 1 : 0) + (state.last_above_zero[i] != 0 ? 1 : 0), monotone == own);
    state.last_above_zero[i] = none ? 1 : 0;
    if (!none) {
      const std::uint32_t more =
          code_uint(coder, schema.above + Schema::kUintContexts * i, static_cast<std::uint32_t>(monotone - own) - 1);
      if (more >= static_cast<std::uint32_t>(kMaxErrorCode - value)) fail_record(r, "an error is out of range");
      value += static_cast<std::int32_t>(more) + 1;
    }
    monotone = static_cast<ErrorCode16>(value);
  }
}

/// Codes of the same step in volumes and in mean squares: 8 for each octave.
inline std::int32_t log_of_square(double x) {
  return x > 0 ? static_cast<std::int32_t>(std::bit_cast<std::uint64_t>(x) >> 49) : 0;
}

/// What the collapse raised the mean square errors by. That is about the own error squared times the volume of the
/// star, and a code of either is the same step; how much less it is, the records before tell. `six_star_volumes`: the
/// sum of six times the volumes of the tets of F(r).
template <class Coder>
void code_squared_errors(Coder& coder, const Schema& schema, BlockState& state, Content& content, RecordId r,
                         double six_star_volumes) {
  constexpr std::int32_t kAtOwnScale = 1600 - 1280;
  const std::int32_t size = log_of_square(six_star_volumes) - log_of_square(schema.volume) + kAtOwnScale;
  const std::size_t codes = schema.code_count();
  for (std::uint32_t i = 0; i + 1 < codes; ++i) {
    const std::int32_t own = content.own[r.index() * codes + i];
    SquaredErrorCode& squared = content.squared_error[r.index() * codes + i];
    std::uint8_t& last_sign = state.last_squared_sign[i];
    const std::uint32_t no_error = own == 0 ? 1 : 0;
    if (coder.bit(schema.squared_zero + 4 * i + 2 * no_error + (last_sign == 0 ? 1 : 0), squared == 0)) {
      squared = 0;
      last_sign = 0;
      continue;
    }
    const bool negative = coder.bit(schema.squared_negative + 6 * i + 3 * no_error + last_sign, squared < 0);
    last_sign = negative ? 2 : 1;
    std::int32_t& drift = state.squared_drift[i][negative ? 1 : 0];
    std::int32_t& last = state.last_squared[i][negative ? 1 : 0];
    const std::int32_t estimate = own + size;
    const std::int32_t expected =
        own == 0 ? last : std::clamp<std::int32_t>(estimate + drift / 16, 1, kMaxSquaredErrorCode);
    const std::uint32_t first = schema.squared + (4 * i + 2 * no_error + (negative ? 1 : 0)) * Schema::kErrorContexts;
    const std::int32_t value = code_near(coder, first, expected, std::abs(squared));
    if (value < 1 || value > kMaxSquaredErrorCode) fail_record(r, "a squared error is out of range");
    if (own == 0) {
      last = value;
    } else {
      drift += (16 * std::clamp(value - estimate, -4096, 4096) - drift) / 8;
    }
    squared = static_cast<SquaredErrorCode>(negative ? -value : value);
  }
}

/// What the collapse raised the uncovered part of the volume by: what the mesh lost, but for what of that lay outside
/// of the domain. `six_volumes_lost()`: six times what it lost.
template <class Coder, class Lost>
void code_uncovered(Coder& coder, const Schema& schema, BlockState& state, Content& content, RecordId r,
                    Lost&& six_volumes_lost) {
  const std::uint32_t i = schema.code_count() - 1;
  SquaredErrorCode& uncovered = content.squared_error[r.index() * schema.code_count() + i];
  const std::uint32_t stays = content.own[r.index() * schema.code_count() + i] == 0 ? 1 : 0;
  std::uint8_t& last_sign = state.last_squared_sign[i];
  if (coder.bit(schema.squared_zero + 4 * i + 2 * stays + (last_sign == 0 ? 1 : 0), uncovered == 0)) {
    uncovered = 0;
    last_sign = 0;
    return;
  }
  const double lost = six_volumes_lost();
  const std::uint32_t grows = lost > 0 ? 0 : 1;
  const bool negative = coder.bit(schema.squared_negative + 6 * i + 3 * stays + 1 + grows, uncovered < 0);
  last_sign = negative ? 2 : 1;
  const int greatest = greatest_uncovered_code(schema.record_count);
  const std::int32_t expected = std::clamp<std::int32_t>(
      log_of_square(std::fabs(lost)) - log_of_square(6 * schema.volume) + uncovered_code_of_all(schema.record_count), 1,
      greatest);
  const std::uint32_t first = schema.squared + (4 * i + 2 * grows + (negative ? 1 : 0)) * Schema::kErrorContexts;
  const std::int32_t value = code_near(coder, first, expected, std::abs(uncovered));
  if (value < 1 || value > greatest) fail_record(r, "what it uncovers is out of range");
  uncovered = static_cast<SquaredErrorCode>(negative ? -value : value);
}

/// When budgets undo the collapse (record/order_code.hpp): coded by how much less it is than the least of the parents'
/// and `largest`, that of the block.
template <class Coder>
void code_order(Coder& coder, const Schema& schema, std::uint32_t largest, Content& content, RecordId r) {
  std::uint32_t most = largest;
  for (const RecordId parent : content.refinement.parents(r))
    most = std::min<std::uint32_t>(most, content.order[parent.index()]);
  const std::uint32_t below = std::min((largest - most) / 8, Schema::kOrderClasses - 1);
  OrderCode& order = content.order[r.index()];
  const std::uint32_t less = code_uint(coder, schema.order + below * Schema::kUintContexts, most - order);
  if (less > most) fail_record(r, "its order code is out of range");
  order = static_cast<OrderCode>(most - less);
}

} // namespace ptet::file
