// Barycentric coordinates of points in a tet, and on which side of its four planes they say that a point lies. Two at a
// time where the processor can: the same operations in the same order, and the same bits, everywhere.
#pragma once

#include <array>
#include <cstddef>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace ptet {

using Barycentric = std::array<double, 4>;

#if defined(__SSE2__)

namespace detail {
inline unsigned negative(__m128d low, __m128d high) {
  const __m128d zero = _mm_setzero_pd();
  return static_cast<unsigned>(_mm_movemask_pd(_mm_cmplt_pd(low, zero)) | _mm_movemask_pd(_mm_cmplt_pd(high, zero))
                                                                              << 2);
}
} // namespace detail

/// Bits: the coordinates below 0.
[[nodiscard]] inline unsigned negative(const Barycentric& b) {
  return detail::negative(_mm_loadu_pd(b.data()), _mm_loadu_pd(b.data() + 2));
}
/// made = x a + y b. Returns negative(made).
inline unsigned combine(double x, const Barycentric& a, double y, const Barycentric& b, Barycentric& made) {
  const __m128d xx = _mm_set1_pd(x);
  const __m128d yy = _mm_set1_pd(y);
  const auto two = [&](std::size_t k) {
    return _mm_add_pd(_mm_mul_pd(xx, _mm_loadu_pd(a.data() + k)), _mm_mul_pd(yy, _mm_loadu_pd(b.data() + k)));
  };
  const __m128d low = two(0);
  const __m128d high = two(2);
  _mm_storeu_pd(made.data(), low);
  _mm_storeu_pd(made.data() + 2, high);
  return detail::negative(low, high);
}

#else

/// Bits: the coordinates below 0.
[[nodiscard]] inline unsigned negative(const Barycentric& b) {
  return static_cast<unsigned>(b[0] < 0) | static_cast<unsigned>(b[1] < 0) << 1U |
         static_cast<unsigned>(b[2] < 0) << 2U | static_cast<unsigned>(b[3] < 0) << 3U;
}
/// made = x a + y b. Returns negative(made).
inline unsigned combine(double x, const Barycentric& a, double y, const Barycentric& b, Barycentric& made) {
  for (std::size_t k = 0; k < 4; ++k)
    made[k] = x * a[k] + y * b[k];
  return negative(made);
}

#endif

/// Bits: the coordinates of 0 or less.
[[nodiscard]] inline unsigned not_positive(const Barycentric& b) {
  return static_cast<unsigned>(b[0] <= 0) | static_cast<unsigned>(b[1] <= 0) << 1U |
         static_cast<unsigned>(b[2] <= 0) << 2U | static_cast<unsigned>(b[3] <= 0) << 3U;
}

} // namespace ptet
