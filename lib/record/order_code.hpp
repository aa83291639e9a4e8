// Order codes: when a budget has room for a record (budget_rank.hpp).
//
//   code   32 log2(vertices of the original / vertices of the mesh in which it and all before it are split), rounded up
//
//   original <--------- in the end ---------- base
//   0 .. 32 .. 64 .. 96 ...                               half the vertices, a quarter, an eighth, ...
//
// A record's code is at least that of every record that depends on it: a threshold on order codes is a closed cut.
#pragma once

#include <cstdint>

namespace ptet {

using OrderCode = std::uint16_t;
inline constexpr OrderCode kMaxOrderCode = 767;

/// 1 <= `left` <= `original`. Saturates at kMaxOrderCode, which stands for 2^23.97 times fewer vertices. The same on
/// every machine.
[[nodiscard]] OrderCode encode_order(std::uint64_t original, std::uint64_t left);
/// n, where between 1/2^n and 1/2^(n-1) of the vertices were left; at least 1.
[[nodiscard]] constexpr int halvings(OrderCode code) {
  constexpr int kCodesPerHalving = 32;
  return code == 0 ? 1 : 1 + (code - 1) / kCodesPerHalving;
}

} // namespace ptet
