// The parts of MeshComparison that look at single points: samples of the volume, and the vertices.
#include "error/comparison_parts.hpp"
#include "error/double_double.hpp"
#include "error/mesh_comparison.hpp"
#include "error/tet_overlap.hpp"
#include "mesh/closest_point.hpp"

#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace ptet {
using namespace comparison;

namespace {

/// Numbers from a seed, a stream and a step, in any order: SplitMix64 (Steele, Lea, Flood 2014).
class Random {
public:
  Random(std::uint64_t seed, std::uint64_t stream) : state_(mixed(mixed(seed) ^ stream)) {}
  /// In [0, 1).
  double operator()() { return static_cast<double>(next() >> 11U) * 0x1p-53; }
  /// Barycentric coordinates of a point evenly distributed over a tet: the gaps between three sorted numbers.
  std::array<double, 4> in_tet() {
    std::array<double, 3> cut = {(*this)(), (*this)(), (*this)()};
    std::sort(cut.begin(), cut.end());
    return {cut[0], cut[1] - cut[0], cut[2] - cut[1], 1 - cut[2]};
  }

private:
  static std::uint64_t mixed(std::uint64_t x) {
    x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9U;
    x = (x ^ (x >> 27U)) * 0x94d049bb133111ebU;
    return x ^ (x >> 31U);
  }
  std::uint64_t next() { return mixed(state_ += 0x9e3779b97f4a7c15U); }
  std::uint64_t state_;
};

/// Enters the errors at one point: the maximum, and the squares for the mean.
void enter(std::span<const double> errors, const Point& p, std::vector<FieldDifference>& sum) {
  for (std::size_t f = 0; f < sum.size(); ++f)
    add(FieldDifference{errors[f], p, errors[f] * errors[f]}, sum[f]);
}

/// By item: the sum of the amounts up to and with it.
std::vector<double> running_sum(const std::vector<double>& amounts) {
  std::vector<double> sums(amounts.size());
  std::partial_sum(amounts.begin(), amounts.end(), sums.begin());
  return sums;
}

/// The item at `share` of the whole amount; share < 1 and there is some amount.
std::size_t item_at(const std::vector<double>& sums, double share) {
  const auto found = std::upper_bound(sums.begin(), sums.end(), share * sums.back());
  return static_cast<std::size_t>(std::min(found, sums.end() - 1) - sums.begin());
}

} // namespace

/// Compares at single points; one a block.
class MeshComparison::Sampler {
public:
  explicit Sampler(const MeshComparison& of)
      : of_(of), fields_(of.components_.size()), value_(of.channels()), error_(fields_) {}

  /// The field of the original at a point of one of its tets.
  void value_in(std::size_t tet, const std::array<double, 4>& weight) {
    std::fill(value_.begin(), value_.end(), 0.0);
    for (std::size_t k = 0; k < 4; ++k)
      for (std::size_t channel = 0; channel < value_.size(); ++channel)
        value_[channel] +=
            weight[k] * of_.original_.values[of_.original_.tets[tet][k].index() * value_.size() + channel];
  }
  void value_at(std::size_t vertex) {
    const auto row = of_.original_.values.subspan(vertex * value_.size(), value_.size());
    std::copy(row.begin(), row.end(), value_.begin());
  }

  /// Calls `visit(tet)` for each tet of the simplified mesh, boundary included, that holds p. Exact.
  template <class Visit>
  void each_holding(const Point& p, Visit&& visit) const {
    of_.simplified_tets_.each_meeting({p, p}, [&](std::uint32_t t) {
      if (holds(t, p)) visit(t);
    });
  }

  /// A random point of a tet of the original that no simplified tet holds, as its weights; false when none of `draws`
  /// is one.
  bool draw_outside(std::uint32_t tet, Random& random, int draws, std::array<double, 4>& weight) {
    const std::array<Point, 4> corners = look_around(tet);
    for (int draw = 0; draw < draws; ++draw) {
      weight = random.in_tet();
      const Point p = combine(corners, weight);
      const auto holder = std::find_if(near_.begin(), near_.end(), [&](std::uint32_t t) { return holds(t, p); });
      if (holder == near_.end()) return true;
      std::iter_swap(near_.begin(), holder); // it is likely to hold the next one too
    }
    return false;
  }
  /// How many simplified tets hold a random point of a tet of the original.
  std::size_t count_holders(std::uint32_t tet, Random& random) {
    const std::array<Point, 4> corners = look_around(tet);
    const Point p = combine(corners, random.in_tet());
    return static_cast<std::size_t>(
        std::count_if(near_.begin(), near_.end(), [&](std::uint32_t t) { return holds(t, p); }));
  }

  /// The errors by field of the value against a simplified tet that holds p.
  std::span<const double> against_tet(const Point& p, std::uint32_t t) {
    const std::array<Point, 4> corners = corners_of(of_.simplified_, t);
    std::array<double, 4> clamped;
    const auto clamp = [&](const auto& weights) {
      std::transform(weights.begin(), weights.end(), clamped.begin(),
                     [](const auto& w) { return std::clamp(static_cast<double>(w), 0.0, 1.0); });
    };
    if (of_.simplified_sliver_[t] != 0)
      clamp(Frame<DoubleDouble>(corners).weights(p));
    else
      clamp(Frame<double>(corners).weights(p));
    return against(of_.simplified_.tets[t], clamped);
  }
  /// The errors of the value against the point of the simplified boundary that is closest to p.
  std::span<const double> against_closest(const Point& p) {
    (void)of_.boundary_surface_.distance_sq(p, &nearest_);
    const Triangle triangle = of_.boundary_surface_.triangle(nearest_);
    return against(of_.boundary_[nearest_], closest_on_triangle(p, triangle[0], triangle[1], triangle[2]).weight);
  }

private:
  /// Finds the simplified tets that may hold points of a tet of the original. Returns its corners.
  std::array<Point, 4> look_around(std::uint32_t tet) {
    const std::array<Point, 4> corners = corners_of(of_.original_, tet);
    if (std::exchange(near_of_, tet) != tet) {
      near_.clear();
      of_.simplified_tets_.each_meeting(box_of(corners), [&](std::uint32_t t) {
        if (may_hold_any(t, corners)) near_.push_back(t);
      });
    }
    return corners;
  }

  /// On which side of the plane opposite corner k of a tet p lies: 1 on the corner's, if the tet is positive. Exact.
  [[nodiscard]] static int side_of(const std::array<Point, 4>& x, std::size_t k, const Point& p) {
    return orientation(k == 0 ? p : x[0], k == 1 ? p : x[1], k == 2 ? p : x[2], k == 3 ? p : x[3]);
  }
  [[nodiscard]] bool holds(std::uint32_t t, const Point& p) const {
    const int sign = of_.simplified_sign_[t];
    if (sign == 0) return false;
    const std::array<Point, 4> x = corners_of(of_.simplified_, t);
    for (std::size_t k = 0; k < 4; ++k)
      if (sign * side_of(x, k, p) < 0) return false;
    return true;
  }

  /// False where a plane of the simplified tet has all of another tet on its outer side, or on it: then it holds
  /// nothing from inside of that.
  [[nodiscard]] bool may_hold_any(std::uint32_t t, const std::array<Point, 4>& other) const {
    const int sign = of_.simplified_sign_[t];
    if (sign == 0) return false;
    const std::array<Point, 4> x = corners_of(of_.simplified_, t);
    for (std::size_t k = 0; k < 4; ++k)
      if (std::all_of(other.begin(), other.end(), [&](const Point& p) { return sign * side_of(x, k, p) <= 0; }))
        return false;
    return true;
  }

  template <std::size_t N>
  std::span<const double> against(const std::array<VertexId, N>& vertices, const std::array<double, N>& weight) {
    std::size_t channel = 0;
    for (std::size_t f = 0; f < fields_; ++f) {
      double square = 0;
      for (const std::size_t end = channel + of_.components_[f]; channel < end; ++channel) {
        double d = 0;
        for (std::size_t k = 0; k < N; ++k)
          d += weight[k] * (of_.simplified_.values[vertices[k].index() * value_.size() + channel] - value_[channel]);
        square += d * d;
      }
      error_[f] = std::sqrt(square);
    }
    return error_;
  }

  const MeshComparison& of_;
  std::size_t fields_;
  std::vector<double> value_, error_;
  std::uint32_t near_of_ = 0xffffffff; ///< tet of the original
  std::vector<std::uint32_t> near_;    ///< simplified tets that may hold a point of it
  std::uint32_t nearest_ = 0xffffffff;
};

MeshComparison::Sampled MeshComparison::sampled(std::uint64_t samples, std::uint64_t seed,
                                                const ProgressCallback& progress) const {
  struct Part {
    std::vector<FieldDifference> inside, outside;
    std::uint64_t inside_points = 0, outside_points = 0, compared = 0;
  };
  const std::size_t fields = components_.size();
  Sampled result;
  result.inside.fields.resize(fields);
  result.outside.fields.resize(fields);
  const std::vector<double> sums = running_sum(original_tet_volume_);
  if (samples == 0 || !(original_volume_ > 0)) return result;
  std::uint64_t compared = 0;
  const auto compare = [&](Part& part, std::size_t begin, std::size_t end) {
    Sampler sampler(*this);
    for (std::size_t i = begin; i < end; ++i) {
      Random random(seed, i);
      const std::size_t t = item_at(sums, (static_cast<double>(i) + random()) / static_cast<double>(samples));
      const std::array<double, 4> weight = random.in_tet();
      const Point p = combine(corners_of(original_, t), weight);
      sampler.value_in(t, weight);
      std::uint64_t holding = 0;
      sampler.each_holding(p, [&](std::uint32_t s) {
        enter(sampler.against_tet(p, s), p, part.inside);
        ++holding;
      });
      part.compared += holding;
      if (holding > 0) {
        ++part.inside_points;
      } else if (boundary_surface_.size() > 0) {
        enter(sampler.against_closest(p), p, part.outside);
        ++part.outside_points;
      }
    }
  };
  const Part none{std::vector<FieldDifference>(fields), std::vector<FieldDifference>(fields)};
  for_each_part(samples, "comparing samples", progress, none, compare, [&](const Part& part) {
    add(part.inside, result.inside.fields);
    add(part.outside, result.outside.fields);
    result.inside.points += part.inside_points;
    result.outside.points += part.outside_points;
    compared += part.compared;
  });
  divide(result.inside.fields, static_cast<double>(compared));
  divide(result.outside.fields, static_cast<double>(result.outside.points));
  to_units(result.inside.fields);
  to_units(result.outside.fields);
  const double volume_each = original_volume_ / static_cast<double>(samples);
  result.inside.volume = volume_each * static_cast<double>(compared);
  result.outside.volume = volume_each * static_cast<double>(result.outside.points);
  return result;
}

VertexDifference MeshComparison::at_vertices(const ProgressCallback& progress) const {
  const std::size_t vertices = original_.points.size(), fields = components_.size();
  VertexDifference result{std::vector<double>(vertices * fields, std::numeric_limits<double>::quiet_NaN()),
                          std::vector<char>(vertices)};
  std::vector<char> used(vertices);
  for (const Tet& tet : original_.tets)
    for (const VertexId v : tet)
      used[v.index()] = 1;
  for_each_block(vertices, "comparing vertices", progress, [&](std::size_t begin, std::size_t end) {
    Sampler sampler(*this);
    for (std::size_t v = begin; v < end; ++v) {
      if (!used[v]) continue;
      const Point& p = original_.points[v];
      double* const most = result.max.data() + v * fields;
      const auto raise = [&](std::span<const double> errors) {
        for (std::size_t f = 0; f < fields; ++f)
          if (!(errors[f] <= most[f])) most[f] = errors[f];
      };
      sampler.value_at(v);
      bool inside = false;
      sampler.each_holding(p, [&](std::uint32_t t) {
        raise(sampler.against_tet(p, t));
        inside = true;
      });
      if (inside) continue;
      result.outside[v] = 1;
      if (boundary_surface_.size() > 0) raise(sampler.against_closest(p));
    }
  });
  to_units(result.max);
  return result;
}

/// By original tet the volume that the simplified mesh leaves of it.
std::vector<double> MeshComparison::uncovered_volumes(const InsideDifference& inside, bool overlaps_itself,
                                                      std::uint64_t seed, const ProgressCallback& progress) const {
  // Tets that are covered but for this share count as covered: the rest is rounding, and a point in it hard to draw.
  constexpr double kCovered = 1e-9;
  const std::size_t tets = original_.tets.size();
  std::vector<double> uncovered(tets, 0);
  for (std::size_t t = 0; t < tets; ++t) {
    const double left = original_tet_volume_[t] - inside.cell_volume[t];
    if (left > kCovered * original_tet_volume_[t]) uncovered[t] = left;
    if (left < -kCovered * original_tet_volume_[t]) overlaps_itself = true;
  }
  if (!overlaps_itself) return uncovered;
  // What is left of a tet that is covered twice somewhere is not known: seen at points.
  constexpr std::size_t kPoints = 2'000'000;
  const std::size_t points = std::max<std::size_t>(1, kPoints / std::max<std::size_t>(1, tets));
  for_each_block(tets, "looking outside", progress, [&](std::size_t begin, std::size_t end) {
    Sampler sampler(*this);
    for (std::size_t t = begin; t < end; ++t) {
      if (!(inside.cell_volume[t] > 0)) continue;
      Random random(~seed, t);
      std::size_t outside = 0;
      bool is_twice = inside.cell_volume[t] > (1 + kCovered) * original_tet_volume_[t];
      for (std::size_t i = 0; i < points; ++i) {
        const std::size_t holders = sampler.count_holders(static_cast<std::uint32_t>(t), random);
        outside += holders == 0 ? 1 : 0;
        is_twice = is_twice || holders > 1;
      }
      if (is_twice) uncovered[t] = original_tet_volume_[t] * static_cast<double>(outside) / static_cast<double>(points);
    }
  });
  return uncovered;
}

OutsideDifference MeshComparison::sampled_outside(const InsideDifference& inside, bool overlaps_itself,
                                                  std::uint64_t samples, std::uint64_t seed,
                                                  const ProgressCallback& progress) const {
  constexpr int kDraws = 1000;
  OutsideDifference result;
  const std::size_t fields = components_.size();
  result.fields.resize(fields);
  const std::vector<double> uncovered = uncovered_volumes(inside, overlaps_itself, seed, progress);
  const std::vector<double> sums = running_sum(uncovered);
  if (sums.empty() || !(sums.back() > 0) || boundary_surface_.size() == 0) return result;
  result.volume = sums.back();
  struct Part {
    std::vector<FieldDifference> fields;
    std::uint64_t points = 0, missed = 0;
  };
  const auto compare = [&](Part& part, std::size_t begin, std::size_t end) {
    Sampler sampler(*this);
    std::size_t missed = uncovered.size(); // the last tet that was, and would be again: samples go from tet to tet
    for (std::size_t i = begin; i < end; ++i) {
      Random random(seed, i);
      const std::size_t t = item_at(sums, (static_cast<double>(i) + random()) / static_cast<double>(samples));
      std::array<double, 4> weight;
      if (t == missed || !sampler.draw_outside(static_cast<std::uint32_t>(t), random, kDraws, weight)) {
        missed = t;
        ++part.missed;
        continue;
      }
      const Point p = combine(corners_of(original_, t), weight);
      sampler.value_in(t, weight);
      enter(sampler.against_closest(p), p, part.fields);
      ++part.points;
    }
  };
  const Part none{std::vector<FieldDifference>(fields)};
  for_each_part(samples, "comparing outside", progress, none, compare, [&](const Part& part) {
    add(part.fields, result.fields);
    result.points += part.points;
    result.missed += part.missed;
  });
  divide(result.fields, static_cast<double>(result.points));
  to_units(result.fields);
  return result;
}

void MeshComparison::add_vertices(const VertexDifference& vertices, OutsideDifference& outside) const {
  const std::size_t fields = components_.size();
  for (std::size_t v = 0; v < vertices.outside.size(); ++v) {
    if (!vertices.outside[v]) continue;
    ++outside.vertices;
    for (std::size_t f = 0; f < fields; ++f)
      add(FieldDifference{vertices.max[v * fields + f], original_.points[v], 0}, outside.fields[f]);
  }
}

} // namespace ptet
