#include "error/measured_parts.hpp"

#include "error/tet_clip.hpp"
#include "error/tolerances.hpp"

#include <limits>

namespace ptet {
namespace {

/// So many channels go through the clipping themselves. Of more, what goes through it are weights of the tet's corners.
constexpr std::size_t kMostCarried = 8;
/// Clipping may hide this part of the differences at a tet's corners; that counts where their square is so many times
/// that of the error.
constexpr double kClipRounding = 4 * std::numeric_limits<double>::epsilon();
constexpr double kCornersThatCount = 1e14;
/// A part of so little of both tets is where they touch.
constexpr double kTouchingPart = 1e-27;

double greatest(const std::array<double, 4>& x) {
  return std::max(std::max(x[0], x[1]), std::max(x[2], x[3]));
}

/// What is known of N channels on the parts of one tet, from the differences at the corners.
template <std::size_t N, bool Scalars>
struct Seen {
  std::array<double, N> integral{};    ///< 20 times that of the squared difference
  std::array<double, N> greatest_sq{}; ///< of a field, at its last channel

  void add(const std::array<const double*, 4>& d, double volume, const char* ends_field) {
    std::array<std::array<double, N>, 4> square;
    for (std::size_t k = 0; k < 4; ++k)
      for (std::size_t c = 0; c < N; ++c)
        square[k][c] = d[k][c] * d[k][c];
    for (std::size_t c = 0; c < N; ++c) {
      const double sum = (d[0][c] + d[1][c]) + (d[2][c] + d[3][c]);
      integral[c] += volume * (sum * sum + ((square[0][c] + square[1][c]) + (square[2][c] + square[3][c])));
    }
    for (std::size_t k = 0; k < 4; ++k) {
      if constexpr (!Scalars) // of a field's components the squares add up
        for (std::size_t c = 1; c < N; ++c)
          if (ends_field[c - 1] == 0) square[k][c] += square[k][c - 1];
      for (std::size_t c = 0; c < N; ++c)
        greatest_sq[c] = greatest_sq[c] < square[k][c] ? square[k][c] : greatest_sq[c];
    }
  }
};

} // namespace

bool MeasuredParts::take_in(const Rows& rows, double volume) {
  static_assert(kMostCarried == 8);
  switch (original_.channels.channels) {
  case 1: return carry<1, true>(rows, volume);
  case 2: return carry_some<2>(rows, volume);
  case 3: return carry_some<3>(rows, volume);
  case 4: return carry_some<4>(rows, volume);
  case 5: return carry_some<5>(rows, volume);
  case 6: return carry_some<6>(rows, volume);
  case 7: return carry_some<7>(rows, volume);
  case 8: return carry_some<8>(rows, volume);
  default: return weigh(rows, volume);
  }
}

template <std::size_t N>
bool MeasuredParts::carry_some(const Rows& rows, double volume) {
  return original_.scalars ? carry<N, true>(rows, volume) : carry<N, false>(rows, volume);
}

template <std::size_t N, bool Scalars>
bool MeasuredParts::carry(const Rows& rows, double volume) {
  std::array<const VersionView::Row*, 4> row;
  std::array<const double*, 4> d;
  unsigned common = 0xF;
  unsigned cutting = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    row[k] = &view_.row(rows[k]);
    d[k] = view_.difference(rows[k]);
    common &= row[k]->strictly_beyond;
    cutting |= row[k]->strictly_beyond;
  }
  if (common != 0) return false;
  Seen<N, Scalars> seen;
  const char* const ends_field = original_.ends_field.data();
  double covered = 0;
  if (cutting == 0) {
    covered = volume;
    seen.add(d, volume, ends_field);
  } else {
    std::array<ClipCorner<N>, 4> corners;
    for (std::size_t k = 0; k < 4; ++k) {
      corners[k].barycentric = row[k]->barycentric;
      corners[k].beyond = row[k]->strictly_beyond;
      std::copy_n(d[k], N, corners[k].carried.begin());
    }
    bool any = false;
    auto use = [&](const ClipCorners<N>& piece, double part) {
      any = true;
      covered += part;
      seen.add({piece[0]->carried.data(), piece[1]->carried.data(), piece[2]->carried.data(), piece[3]->carried.data()},
               part, ends_field);
    };
    TetClip<N, decltype(use)>(use).part_of({&corners[0], &corners[1], &corners[2], &corners[3]}, volume, 0xF);
    if (only_touches(covered, volume)) return any;
  }
  covered_ += covered;
  std::array<double, 4> corner_sq{};
  double integral = 0;
  for (std::size_t c = 0; c < N; ++c) {
    for (std::size_t k = 0; k < 4; ++k)
      corner_sq[k] += d[k][c] * d[k][c];
    integral += seen.integral[c];
    if (ends_field[c] == 0) continue;
    raise(original_.channels.field_of[c], seen.greatest_sq[c], integral / 20, greatest(corner_sq));
    corner_sq = {};
    integral = 0;
  }
  return true;
}

/// The same for any number of channels: what is carried are weights of the tet's corners.
bool MeasuredParts::weigh(const Rows& rows, double volume) {
  std::array<ClipCorner<4>, 4> corners;
  for (std::size_t k = 0; k < 4; ++k) {
    corners[k].barycentric = view_.row(rows[k]).barycentric;
    corners[k].beyond = view_.row(rows[k]).strictly_beyond;
    corners[k].carried = {};
    corners[k].carried[k] = 1;
  }
  const std::size_t channels = original_.channels.channels;
  const auto difference = [&](std::size_t k) { return view_.difference(rows[k]); };
  bool any = false;
  double covered = 0;
  seen_sq_.assign(errors_.size(), 0.0);
  integral_.assign(errors_.size(), 0.0);
  auto use = [&](const ClipCorners<4>& piece, double part) {
    any = true;
    covered += part;
    std::array<double, 4> norm_sq{};
    double integral = 0;
    for (std::size_t c = 0; c < channels; ++c) {
      double sum = 0;
      double sum_sq = 0;
      for (std::size_t k = 0; k < 4; ++k) {
        const auto& weight = piece[k]->carried;
        const double d = weight[0] * difference(0)[c] + weight[1] * difference(1)[c] + weight[2] * difference(2)[c] +
                         weight[3] * difference(3)[c];
        sum += d;
        sum_sq += d * d;
        norm_sq[k] += d * d;
      }
      integral += part / 20 * (sum * sum + sum_sq);
      if (original_.ends_field[c] == 0) continue;
      const std::size_t field = original_.channels.field_of[c];
      if (!(greatest(norm_sq) <= seen_sq_[field])) seen_sq_[field] = greatest(norm_sq);
      integral_[field] += integral;
      norm_sq = {};
      integral = 0;
    }
  };
  TetClip<4, decltype(use)>(use).part_of({&corners[0], &corners[1], &corners[2], &corners[3]}, volume, 0xF);
  if (only_touches(covered, volume)) return any;
  covered_ += covered;
  std::array<double, 4> corner_sq{};
  for (std::size_t c = 0; c < channels; ++c) {
    for (std::size_t k = 0; k < 4; ++k)
      corner_sq[k] += difference(k)[c] * difference(k)[c];
    if (original_.ends_field[c] == 0) continue;
    const std::size_t field = original_.channels.field_of[c];
    raise(field, seen_sq_[field], integral_[field], greatest(corner_sq));
    corner_sq = {};
  }
  return any;
}

void MeasuredParts::begin_values() {
  seen_sq_.assign(errors_.size(), 0.0);
}

void MeasuredParts::take_in_values(std::uint32_t v, std::uint32_t w) {
  double norm_sq = 0;
  for (std::size_t c = 0; c < original_.channels.channels; ++c) {
    const double d = view_.values(v)[c] - view_.values(w)[c];
    norm_sq += d * d;
    if (original_.ends_field[c] == 0) continue;
    const std::size_t field = original_.channels.field_of[c];
    raise_error(field, norm_sq * original_.scale_sq[field]);
    seen_sq_[field] = std::max(seen_sq_[field], norm_sq * original_.scale_sq[field]);
    norm_sq = 0;
  }
}

void MeasuredParts::take_values_everywhere() {
  if (squared_.empty()) return;
  const double volume = view_.most_volume();
  for (std::size_t field = 0; field < errors_.size(); ++field)
    if (seen_sq_[field] > 0) squared_[field] += seen_sq_[field] * volume;
}

void MeasuredParts::take_rest() {
  if (squared_.empty()) return;
  const double volume = view_.determinant() / 6;
  if (const double rest = volume - covered_; rest > kVolumeRounding * volume) squared_.back() += rest;
}

/// Whether a part of an original tet has no volume but what rounding gave it. What touches from outside, as across a
/// crack, may have another value there; what hangs together by faces is seen in a part with a volume.
bool MeasuredParts::only_touches(double covered, double volume) const {
  return !(covered > std::min(kTouchingPart * view_.determinant() / 6, kTouchingPart * volume));
}

/// By what was found on a part of an original tet, at the corners of which the squared error is up to `corner_sq`.
void MeasuredParts::raise(std::size_t field, double error_sq, double integral, double corner_sq) {
  if (error_sq <= kValueRounding * kValueRounding * corner_sq) return;
  const double scale_sq = original_.scale_sq[field];
  if (corner_sq > kCornersThatCount * error_sq) {
    const double most = std::sqrt(error_sq) + kClipRounding * std::sqrt(corner_sq);
    error_sq = most * most;
  }
  raise_error(field, error_sq * scale_sq);
  if (!squared_.empty()) squared_[field] += integral * scale_sq;
}

void MeasuredParts::raise_error(std::size_t field, double error_sq) {
  if (error_sq <= errors_[field] * errors_[field]) return;
  if (std::isnan(error_sq)) {
    fail();
    return;
  }
  errors_[field] = std::sqrt(error_sq);
  beyond_limit_ |= !limit_.empty() && errors_[field] > limit_[field];
}

} // namespace ptet
