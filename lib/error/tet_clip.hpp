// The part of one tet in another, as tets: cut at one plane after the other, first where the fewest pieces are left.
#pragma once

#include "error/barycentric.hpp"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace ptet {

/// Sums over the planes of sets of planes, a byte a plane.
inline constexpr std::array<std::uint32_t, 16> kCountByPlane = [] {
  std::array<std::uint32_t, 16> bytes{};
  for (unsigned set = 0; set < 16; ++set)
    for (unsigned plane = 0; plane < 4; ++plane)
      bytes[set] += (set >> plane & 1U) << 8 * plane;
  return bytes;
}();

/// By the set of corners of a tet that lie beyond a plane: all of them, those inside first.
inline constexpr std::array<std::array<std::uint8_t, 4>, 16> kInsideFirst = [] {
  std::array<std::array<std::uint8_t, 4>, 16> orders{};
  for (unsigned outside = 0; outside < 16; ++outside) {
    std::size_t first = 0;
    std::size_t last = 4;
    for (std::uint8_t k = 0; k < 4; ++k)
      orders[outside][(outside >> k & 1U) == 0 ? first++ : --last] = k;
  }
  return orders;
}();

/// A corner of a tet that is being clipped.
template <std::size_t N>
struct ClipCorner {
  Barycentric barycentric;       ///< in the version
  std::array<double, N> carried; ///< what is linear on the tet, and wanted of its part
  unsigned beyond;               ///< bits: the planes of the version that it lies strictly on the outer side of
};
template <std::size_t N>
using ClipCorners = std::array<const ClipCorner<N>*, 4>;

/// Clips a tet to the version: calls `use(corners, volume)` for each of the tets that its part falls into. Of their
/// corners only what is carried is known.
template <std::size_t N, class Use>
class TetClip {
public:
  explicit TetClip(Use& use) : use_(use) {}

  /// The part of a tet on the inner side of `planes` (a set of bits).
  void part_of(const ClipCorners<N>& corners, double volume, unsigned planes) {
    const std::array<unsigned, 4> beyond{corners[0]->beyond & planes, corners[1]->beyond & planes,
                                         corners[2]->beyond & planes, corners[3]->beyond & planes};
    if ((beyond[0] & beyond[1] & beyond[2] & beyond[3]) != 0) return;
    const unsigned cutting = beyond[0] | beyond[1] | beyond[2] | beyond[3];
    if (cutting == 0) {
      use_(corners, volume);
      return;
    }
    if ((cutting & (cutting - 1)) == 0) {
      cut_at<true>(corners, volume, static_cast<unsigned>(std::countr_zero(cutting)), 0);
      return;
    }
    // First the plane that leaves the fewest pieces: the one with the most corners beyond it.
    const std::uint32_t count =
        kCountByPlane[beyond[0]] + kCountByPlane[beyond[1]] + kCountByPlane[beyond[2]] + kCountByPlane[beyond[3]];
    unsigned plane = 0;
    for (unsigned other = 1; other < 4; ++other)
      if ((count >> 8 * other & 0xFFU) > (count >> 8 * plane & 0xFFU)) plane = other;
    cut_at<false>(corners, volume, plane, cutting & ~(1U << plane));
  }

private:
  /// Cuts at a plane that has corners on both sides. Last: at no others after it.
  template <bool Last>
  void cut_at(const ClipCorners<N>& corners, double volume, unsigned plane, unsigned others) {
    unsigned outside = 0;
    for (unsigned k = 0; k < 4; ++k)
      outside |= (corners[k]->beyond >> plane & 1U) << k;
    const auto& order = kInsideFirst[outside];
    const ClipCorners<N> c{corners[order[0]], corners[order[1]], corners[order[2]], corners[order[3]]};
    // The edge from c[i], inside, to c[j] is cut at `s` of its length; `rest` = 1 - s.
    struct Cut {
      ClipCorner<N> corner;
      double s, rest;
    };
    const auto cut = [&](std::size_t i, std::size_t j, Cut& made) {
      const ClipCorner<N>& a = *c[i];
      const ClipCorner<N>& b = *c[j];
      const double per_length = 1 / (a.barycentric[plane] - b.barycentric[plane]);
      made.s = a.barycentric[plane] * per_length;
      made.rest = -b.barycentric[plane] * per_length;
      for (std::size_t k = 0; k < N; ++k)
        made.corner.carried[k] = made.rest * a.carried[k] + made.s * b.carried[k];
      if constexpr (!Last)
        made.corner.beyond = combine(made.rest, a.barycentric, made.s, b.barycentric, made.corner.barycentric);
    };
    const auto go_on = [&](const ClipCorners<N>& piece, double part) {
      if constexpr (Last)
        use_(piece, part * volume);
      else
        part_of(piece, part * volume, others);
    };
    Cut p, q, r, s;
    switch (std::popcount(outside)) {
    case 3:
      cut(0, 1, p);
      cut(0, 2, q);
      cut(0, 3, r);
      go_on({c[0], &p.corner, &q.corner, &r.corner}, p.s * q.s * r.s);
      return;
    case 2: // a prism between triangles (c0, p, q) and (c1, r, s)
      cut(0, 2, p);
      cut(0, 3, q);
      cut(1, 2, r);
      cut(1, 3, s);
      go_on({c[0], &p.corner, &q.corner, &s.corner}, p.s * q.s * s.rest);
      go_on({c[0], &p.corner, &r.corner, &s.corner}, p.s * r.rest * s.s);
      go_on({c[0], c[1], &r.corner, &s.corner}, r.s * s.s);
      return;
    default: // a prism between triangles (c0, c1, c2) and (p, q, r)
      cut(0, 3, p);
      cut(1, 3, q);
      cut(2, 3, r);
      go_on({c[0], c[1], c[2], &r.corner}, r.s);
      go_on({c[0], c[1], &q.corner, &r.corner}, q.s * r.rest);
      go_on({c[0], &p.corner, &q.corner, &r.corner}, p.s * q.rest * r.rest);
      return;
    }
  }

  Use& use_;
};

} // namespace ptet
