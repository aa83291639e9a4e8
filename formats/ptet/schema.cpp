#include "formats/ptet/schema.hpp"

#include "ptet/error.hpp"

#include <algorithm>

namespace ptet::file {
namespace {

constexpr std::uint64_t kMaxContexts = 1U << 22;
/// Further components of an array share their contexts with the one in this place.
constexpr std::size_t kLastSlot = 3;

void set_precision(Column& column, Precision precision) {
  column.decimals = precision.decimal_digits != 0 ? &decimal_ranking(column.type, precision.decimal_digits) : nullptr;
  column.zero_bits = precision.zero_bits;
}

} // namespace

Schema::Schema(const Header& header, const std::vector<Precisions>& precisions) {
  std::uint64_t count = 0;
  const auto take = [&](std::uint64_t contexts) {
    const std::uint64_t first = count;
    count += contexts;
    if (count > kMaxContexts) throw Error(ErrorCode::kLimit, "the point arrays have too many components");
    return static_cast<std::uint32_t>(first);
  };
  const auto column = [&](ScalarType type, Precision precision) {
    Column result;
    result.type = type;
    result.bits = bits_of(type);
    result.length_levels = result.bits > 32 ? 7 : 6;
    set_precision(result, precision);
    const unsigned bits = result.bits > 32 ? 64 : 32;
    result.escape = take(1);
    result.sign = take(1);
    result.mantissa = take(std::uint64_t{3} * (bits + 1));
    result.length = take(std::uint64_t{bits / 2 + 1} << result.length_levels);
    return result;
  };

  source = take(2 * kUintContexts);
  index = take(2 * (kUintContexts + 32));
  fine = take(std::uint64_t{2} * 32);
  fine_rest = take(kUintContexts);
  corner = take(std::uint64_t{2} * 4);
  more_seeds = take(1);
  growth = take(kGrowthContexts);
  same = take(std::uint64_t{3} * 4 * 4 * 4);
  for (std::size_t axis = 0; axis < 3; ++axis)
    position[axis] = column(header.position_type, precisions[0][axis]);
  for (std::size_t a = 0; a < header.arrays.size(); ++a) {
    const ArrayInfo& info = header.arrays[a];
    auto& columns = arrays.emplace_back();
    for (std::size_t c = 0; c < info.components; ++c) {
      if (c <= kLastSlot) {
        columns.push_back(column(info.type, precisions[a + 1][c]));
      } else {
        columns.push_back(columns[kLastSlot]);
        set_precision(columns.back(), precisions[a + 1][c]);
      }
    }
    if (info.governing) {
      governing.push_back(static_cast<std::uint32_t>(a));
      scale.push_back(info.range);
    }
  }
  scale.push_back(header.diagonal);
  own_zero = take(std::uint64_t{4} * code_count());
  own = take(std::uint64_t{kErrorClasses} * kErrorContexts * code_count());
  above_zero = take(std::uint64_t{4} * code_count());
  above = take(std::uint64_t{kUintContexts} * code_count());
  has_squared_errors = header.has_squared_errors;
  volume = header.volume;
  record_count = header.record_count;
  if (has_squared_errors) {
    squared_zero = take(std::uint64_t{4} * code_count());
    squared_negative = take(std::uint64_t{6} * code_count());
    squared = take(std::uint64_t{4} * kErrorContexts * code_count());
  }
  order = take(std::uint64_t{kOrderClasses} * kUintContexts);
  context_count_ = static_cast<std::uint32_t>(count);
}

} // namespace ptet::file
