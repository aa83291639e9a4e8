#include "build/field_samples.hpp"

#include "mesh/vec3.hpp"

#include <algorithm>
#include <cmath>

namespace ptet::build {
using namespace vec;
namespace {

/// No sample is nearer to a face than this part of the height over it: on a face two tets could hold it.
constexpr double kMargin = 1.0 / 64;

/// A number in [0, 1) that looks random (the finalizer of MurmurHash3, 64 bits).
double hashed(std::uint64_t key) {
  key = (key ^ (key >> 33U)) * 0xff51afd7ed558ccdULL;
  key = (key ^ (key >> 33U)) * 0xc4ceb9fe1a85ec53ULL;
  key ^= key >> 33U;
  return static_cast<double>(key >> 11U) * 0x1p-53;
}

/// Barycentric coordinates of the i-th sample of a tet.
std::array<double, 4> sample_weights(std::uint32_t tet, std::size_t i) {
  // Powers of 1/g with g^4 = g + 1.
  static constexpr std::array<double, 3> kStep{0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
  std::array<double, 3> u{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double x = hashed(3 * std::uint64_t{tet} + axis + 1) + static_cast<double>(i) * kStep[axis];
    u[axis] = x - std::floor(x);
  }
  std::sort(u.begin(), u.end());
  std::array<double, 4> weight{u[0], u[1] - u[0], u[2] - u[1], 1 - u[2]};
  for (double& w : weight)
    w = kMargin + (1 - 4 * kMargin) * w;
  return weight;
}

std::array<Vertex, 4> corners_of(const Tet& tet) {
  return {tet[0].index(), tet[1].index(), tet[2].index(), tet[3].index()};
}

} // namespace

double field_variation(const NormalizedFields& fields, const std::array<Vertex, 4>& corners) {
  double most_sq = 0;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j) {
      const double* const a = fields.at(corners[i]);
      const double* const b = fields.at(corners[j]);
      double sum_sq = 0;
      for (std::size_t c = 0; c < fields.channel_count(); ++c) {
        sum_sq += (a[c] - b[c]) * (a[c] - b[c]);
        if (!fields.ends_field(c)) continue;
        most_sq = std::max(most_sq, sum_sq);
        sum_sq = 0;
      }
    }
  return std::sqrt(most_sq);
}

std::vector<Sample> choose_samples(std::span<const Tet> tets, const NormalizedFields& fields, std::size_t count) {
  std::vector<double> up_to(tets.size()); // sums of variations
  double sum = 0;
  for (std::size_t t = 0; t < tets.size(); ++t)
    up_to[t] = sum += field_variation(fields, corners_of(tets[t]));
  std::vector<Sample> samples;
  if (!(sum > 0)) return samples;
  samples.reserve(count);
  for (std::size_t t = 0; t < tets.size(); ++t) {
    // Behind the last tet that varies the quotient is exactly 1.
    const auto end = static_cast<std::size_t>(static_cast<double>(count) * (up_to[t] / sum));
    for (std::size_t i = 0; samples.size() < end; ++i)
      samples.push_back({static_cast<std::uint32_t>(t), sample_weights(static_cast<std::uint32_t>(t), i)});
  }
  return samples;
}

std::vector<Sample> choose_samples(std::span<const Tet> tets, const NormalizedFields& fields) {
  return choose_samples(tets, fields, tets.size());
}

FieldSamples look_at(std::span<const Sample> samples, std::span<const Tet> tets, const std::vector<Point>& positions,
                     const NormalizedFields& fields) {
  const std::size_t channels = fields.channel_count();
  FieldSamples result;
  result.points.reserve(samples.size());
  result.values.reserve(samples.size() * channels);
  for (const auto& [tet, weight] : samples) {
    const std::array<Vertex, 4> corners = corners_of(tets[tet]);
    Point position{};
    for (std::size_t k = 0; k < 4; ++k)
      position = position + weight[k] * positions[corners[k]];
    result.points.push_back(position);
    for (std::size_t c = 0; c < channels; ++c) {
      const double first = fields.exact().at(corners[0])[c];
      double more = 0; // without a common offset
      for (std::size_t k = 1; k < 4; ++k)
        more += weight[k] * (fields.exact().at(corners[k])[c] - first);
      result.values.push_back(first + more);
    }
  }
  return result;
}

} // namespace ptet::build
