#include "error/mesh_comparison.hpp"

#include "error/closest_point.hpp"
#include "mesh/vec3.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

namespace ptet {
using namespace vec;

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
/// Overlaps that are narrower than this, as a share of a tet's height, are rounding where tets only touch.
constexpr double kTouching = 1e-12;
/// Tets with a height below this share of their longest edge are compared in extended precision.
constexpr double kSliver = 1e-4;
/// Items of one partial sum: fixed, so that sums do not depend on the number of threads.
constexpr std::size_t kBlock = 256;
constexpr std::size_t kBlocksBetweenReports = 64;

/// Calls `work(block, begin, end)` for all blocks of `count` items, in parallel, with reports in between.
template <class Work>
void for_each_block(std::size_t count, const char* stage, const ProgressCallback& progress, Work&& work) {
  const std::size_t blocks = (count + kBlock - 1) / kBlock;
  for (std::size_t first = 0; first < blocks; first += kBlocksBetweenReports) {
    if (progress && !progress({stage, first * kBlock, count})) throw Error(ErrorCode::kCancelled, "cancelled");
    tbb::parallel_for(first, std::min(blocks, first + kBlocksBetweenReports),
                      [&](std::size_t block) { work(block, block * kBlock, std::min(count, (block + 1) * kBlock)); });
  }
}

std::size_t block_count(std::size_t count) {
  return (count + kBlock - 1) / kBlock;
}

template <class Mesh>
std::array<Point, 4> corners_of(const Mesh& mesh, std::size_t t) {
  const Tet& tet = mesh.tets[t];
  return {mesh.points[tet[0].index()], mesh.points[tet[1].index()], mesh.points[tet[2].index()],
          mesh.points[tet[3].index()]};
}

int sign_of(const std::array<Point, 4>& tet) {
  return orientation(tet[0], tet[1], tet[2], tet[3]);
}

double volume_of(const std::array<Point, 4>& tet) {
  return std::abs(dot(tet[1] - tet[0], cross(tet[2] - tet[0], tet[3] - tet[0]))) / 6;
}

/// The least height over the longest edge.
double flatness_of(const std::array<Point, 4>& tet) {
  double longest = 0, largest_face = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j)
      longest = std::max(longest, norm(tet[j] - tet[i]));
    const Point &a = tet[(i + 1) % 4], &b = tet[(i + 2) % 4], &c = tet[(i + 3) % 4];
    largest_face = std::max(largest_face, norm(cross(b - a, c - a)) / 2);
  }
  return 3 * volume_of(tet) / (largest_face * longest);
}

std::vector<BoundingBox> boxes_of(const ComparedMesh& mesh, const std::vector<int>& sign) {
  std::vector<BoundingBox> boxes(mesh.tets.size());
  for (std::size_t t = 0; t < boxes.size(); ++t)
    if (sign[t] != 0) boxes[t] = box_of(corners_of(mesh, t));
  // Flat tets take no part: a box of the first sound tet's corner keeps the tree finite.
  const auto sound = std::find_if(sign.begin(), sign.end(), [](int s) { return s != 0; });
  if (sound == sign.end()) return {};
  const Point corner = corners_of(mesh, static_cast<std::size_t>(sound - sign.begin()))[0];
  for (std::size_t t = 0; t < boxes.size(); ++t)
    if (sign[t] == 0) boxes[t].add(corner);
  return boxes;
}

std::vector<int> signs_of(const ComparedMesh& mesh) {
  std::vector<int> sign(mesh.tets.size());
  tbb::parallel_for(std::size_t{0}, sign.size(), [&](std::size_t t) { sign[t] = sign_of(corners_of(mesh, t)); });
  return sign;
}

std::vector<Triangle> triangles_of(std::span<const Point> points, std::span<const Face> faces) {
  std::vector<Triangle> triangles;
  triangles.reserve(faces.size());
  for (const Face& face : faces)
    triangles.push_back({points[face[0].index()], points[face[1].index()], points[face[2].index()]});
  return triangles;
}

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

/// Keeps the greater maximum, and of equal ones the earlier; adds the sums.
void add(const FieldDifference& more, FieldDifference& to) {
  if (more.max > to.max) {
    to.max = more.max;
    to.at = more.at;
  }
  to.mean_square += more.mean_square;
}

void add(const std::vector<FieldDifference>& more, std::vector<FieldDifference>& to) {
  for (std::size_t f = 0; f < more.size(); ++f)
    add(more[f], to[f]);
}

Point combine(const std::array<Point, 4>& corners, const std::array<double, 4>& weight) {
  Point p = corners[0];
  for (std::size_t i = 1; i < 4; ++i)
    p = p + weight[i] * (corners[i] - corners[0]);
  return p;
}

/// Barycentric coordinates with respect to one tet.
template <class Real>
class Frame {
public:
  explicit Frame(const std::array<Point, 4>& tet) : origin_(tet[0]) {
    std::array<std::array<Real, 3>, 3> edge;
    for (std::size_t i = 0; i < 3; ++i)
      edge[i] = from_origin(tet[i + 1]);
    const auto crossed = [](const std::array<Real, 3>& a, const std::array<Real, 3>& b) {
      return std::array<Real, 3>{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    };
    row_ = {crossed(edge[1], edge[2]), crossed(edge[2], edge[0]), crossed(edge[0], edge[1])};
    const Real det = edge[0][0] * row_[0][0] + edge[0][1] * row_[0][1] + edge[0][2] * row_[0][2];
    for (auto& row : row_)
      for (Real& x : row)
        x /= det;
    volume_ = std::abs(det) / 6;
  }

  [[nodiscard]] Real volume() const { return volume_; }
  [[nodiscard]] std::array<Real, 4> weights(const Point& p) const {
    const auto q = from_origin(p);
    std::array<Real, 4> weight;
    for (std::size_t i = 0; i < 3; ++i)
      weight[i + 1] = row_[i][0] * q[0] + row_[i][1] * q[1] + row_[i][2] * q[2];
    weight[0] = 1 - weight[1] - weight[2] - weight[3];
    return weight;
  }

private:
  [[nodiscard]] std::array<Real, 3> from_origin(const Point& p) const {
    return {Real(p[0]) - Real(origin_[0]), Real(p[1]) - Real(origin_[1]), Real(p[2]) - Real(origin_[2])};
  }
  Point origin_;
  std::array<std::array<Real, 3>, 3> row_;
  Real volume_;
};

/// Whether all four corners lie on or behind one face of a tet, going by their weights in it.
template <class Real>
bool is_apart(const std::array<std::array<Real, 4>, 4>& weights) {
  for (std::size_t k = 0; k < 4; ++k)
    if (std::max({weights[0][k], weights[1][k], weights[2][k], weights[3][k]}) <= Real(kTouching)) return true;
  return false;
}

/// The overlap of two tets as small tets on a common list of corners.
template <class Real>
class Overlap {
public:
  struct Corner {
    std::array<Real, 4> in_original, in_simplified;
  };
  struct Piece {
    std::array<std::uint32_t, 4> corner;
    Real share; ///< of the original tet's volume
  };

  /// False when the tets do not overlap. `in_simplified`: the weights of the original tet's corners.
  bool clip(const std::array<std::array<Real, 4>, 4>& in_simplified) {
    corners_.clear();
    for (std::size_t i = 0; i < 4; ++i) {
      corners_.push_back({{}, in_simplified[i]});
      corners_[i].in_original[i] = 1;
    }
    pieces_.assign(1, {{0, 1, 2, 3}, 1});
    for (std::size_t face = 0; face < 4 && !pieces_.empty(); ++face) {
      if (std::all_of(corners_.begin(), corners_.end(), [&](const Corner& c) { return c.in_simplified[face] >= 0; }))
        continue;
      kept_.clear();
      for (const Piece& piece : pieces_)
        cut(piece, face);
      pieces_.swap(kept_);
    }
    return !is_rounding();
  }

  [[nodiscard]] const std::vector<Corner>& corners() const { return corners_; }
  [[nodiscard]] const std::vector<Piece>& pieces() const { return pieces_; }

private:
  /// Whether what is left is a film on one face of either tet.
  [[nodiscard]] bool is_rounding() const {
    std::array<Real, 8> widest{};
    for (const Piece& piece : pieces_)
      for (const std::uint32_t c : piece.corner)
        for (std::size_t k = 0; k < 4; ++k) {
          widest[k] = std::max(widest[k], corners_[c].in_original[k]);
          widest[4 + k] = std::max(widest[4 + k], corners_[c].in_simplified[k]);
        }
    return *std::min_element(widest.begin(), widest.end()) <= Real(kTouching);
  }

  /// Where the edge from a to b passes through the face: the share of the way from a.
  Real passage(std::uint32_t a, std::uint32_t b, std::size_t face) const {
    const Real at_a = corners_[a].in_simplified[face], at_b = corners_[b].in_simplified[face];
    return at_a / (at_a - at_b);
  }

  std::uint32_t between(std::uint32_t a, std::uint32_t b, Real share, std::size_t face) {
    Corner corner;
    const Corner &from = corners_[a], &to = corners_[b];
    for (std::size_t k = 0; k < 4; ++k) {
      corner.in_original[k] = from.in_original[k] + share * (to.in_original[k] - from.in_original[k]);
      corner.in_simplified[k] = from.in_simplified[k] + share * (to.in_simplified[k] - from.in_simplified[k]);
    }
    corner.in_simplified[face] = 0;
    corners_.push_back(corner);
    return static_cast<std::uint32_t>(corners_.size() - 1);
  }

  void keep(const std::array<std::uint32_t, 4>& corner, Real share) {
    if (share > 0) kept_.push_back({corner, share});
  }

  /// Keeps the part of a piece before the plane of one face, as one tet or three.
  void cut(const Piece& piece, std::size_t face) {
    std::array<std::uint32_t, 4> v{};
    std::size_t inside = 0, outside = 4;
    for (const std::uint32_t c : piece.corner)
      (corners_[c].in_simplified[face] > 0 ? v[inside++] : v[--outside]) = c;
    if (inside == 4) {
      kept_.push_back(piece);
    } else if (inside == 1) {
      const Real s = passage(v[0], v[1], face), t = passage(v[0], v[2], face), u = passage(v[0], v[3], face);
      const std::uint32_t p = between(v[0], v[1], s, face), q = between(v[0], v[2], t, face),
                          r = between(v[0], v[3], u, face);
      keep({v[0], p, q, r}, piece.share * s * t * u);
    } else if (inside == 2) {
      // A wedge with the triangles a, ac, ad and b, bc, bd.
      const auto [a, b, c, d] = v;
      const Real ac = passage(a, c, face), ad = passage(a, d, face), bc = passage(b, c, face), bd = passage(b, d, face);
      const std::uint32_t p = between(a, c, ac, face), q = between(a, d, ad, face), r = between(b, c, bc, face),
                          s = between(b, d, bd, face);
      keep({a, p, q, b}, piece.share * ac * ad);
      keep({p, q, b, r}, piece.share * (1 - ac) * ad * bc);
      keep({q, b, r, s}, piece.share * (1 - ad) * bc * bd);
    } else if (inside == 3) {
      // A wedge with the triangles b, c, d and those points on the edges to a; x, y, z: shares of the way from a.
      const auto [b, c, d, a] = v;
      const Real x = passage(a, b, face), y = passage(a, c, face), z = passage(a, d, face);
      const std::uint32_t p = between(a, b, x, face), q = between(a, c, y, face), r = between(a, d, z, face);
      keep({p, b, c, d}, piece.share * (1 - x));
      keep({p, q, c, d}, piece.share * x * (1 - y));
      keep({p, q, r, d}, piece.share * x * y * (1 - z));
    }
  }

  std::vector<Corner> corners_;
  std::vector<Piece> pieces_, kept_;
};

} // namespace

/// Compares original tets one after another with what they overlap; one a thread.
class MeshComparison::Clipper {
public:
  explicit Clipper(const MeshComparison& of) : of_(of) {}

  /// Adds up in `sum` (mean_square: the integral); `cell_max`: by field.
  void compare(std::uint32_t original, std::vector<FieldDifference>& sum, double* cell_max, double& cell_volume) {
    if (of_.original_sign_[original] == 0) return;
    const std::array<Point, 4> corners = corners_of(of_.original_, original);
    const Frame<double> frame(corners);
    const bool sliver = !(flatness_of(corners) > kSliver);
    of_.simplified_tets_.each_meeting(box_of(corners), [&](std::uint32_t simplified) {
      if (of_.simplified_sign_[simplified] == 0) return;
      const std::array<Point, 4> others = corners_of(of_.simplified_, simplified);
      const bool extended = sliver || of_.simplified_sliver_[simplified] != 0;
      const bool overlap = extended ? clip(Frame<long double>(corners), corners, others, extended_)
                                    : clip(frame, corners, others, plain_);
      if (!overlap) return;
      if (extended) {
        evaluate(extended_, original, simplified, sum, cell_max, cell_volume);
      } else {
        evaluate(plain_, original, simplified, sum, cell_max, cell_volume);
      }
    });
  }

private:
  template <class Real>
  static bool clip(const Frame<Real>& frame, const std::array<Point, 4>& corners, const std::array<Point, 4>& others,
                   Overlap<Real>& overlap) {
    std::array<std::array<Real, 4>, 4> weights;
    for (std::size_t i = 0; i < 4; ++i)
      weights[i] = frame.weights(others[i]);
    if (is_apart(weights)) return false;
    const Frame<Real> other(others);
    for (std::size_t i = 0; i < 4; ++i)
      weights[i] = other.weights(corners[i]);
    return !is_apart(weights) && overlap.clip(weights);
  }

  template <class Real>
  void evaluate(const Overlap<Real>& overlap, std::uint32_t original, std::uint32_t simplified,
                std::vector<FieldDifference>& sum, double* cell_max, double& cell_volume) {
    const double volume = of_.original_tet_volume_[original];
    load(original, simplified);
    const std::size_t channels = of_.channels();
    difference_.resize(overlap.corners().size() * channels);
    known_.assign(overlap.corners().size(), 0);
    for (const auto& piece : overlap.pieces()) {
      for (const std::uint32_t c : piece.corner) {
        if (known_[c]) continue;
        known_[c] = 1;
        look_at(overlap.corners()[c], c, original, sum, cell_max);
      }
      const double piece_volume = volume * static_cast<double>(piece.share);
      cell_volume += piece_volume;
      std::size_t channel = 0;
      for (std::size_t f = 0; f < sum.size(); ++f) {
        double square = 0;
        for (const std::size_t end = channel + of_.components_[f]; channel < end; ++channel) {
          double total = 0;
          for (const std::uint32_t c : piece.corner) {
            const double d = difference_[c * channels + channel];
            total += d;
            square += d * d;
          }
          square += total * total;
        }
        sum[f].mean_square += square * piece_volume / 20;
      }
    }
  }

  /// The values at the corners of both tets, less one of them: differences then lose nothing to a common offset.
  void load(std::uint32_t original, std::uint32_t simplified) {
    const std::size_t channels = of_.channels();
    values_.resize(8 * channels);
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t u = of_.original_.tets[original][k].index(), v = of_.simplified_.tets[simplified][k].index();
      for (std::size_t channel = 0; channel < channels; ++channel) {
        values_[k * channels + channel] = of_.original_.values[u * channels + channel];
        values_[(4 + k) * channels + channel] = of_.simplified_.values[v * channels + channel];
      }
    }
    for (std::size_t i = 8 * channels; i-- > 0;)
      values_[i] -= values_[i % channels];
  }

  template <class Corner>
  void look_at(const Corner& corner, std::uint32_t id, std::uint32_t original, std::vector<FieldDifference>& sum,
               double* cell_max) {
    const std::size_t channels = of_.channels();
    std::size_t channel = 0;
    for (std::size_t f = 0; f < sum.size(); ++f) {
      double square = 0;
      for (const std::size_t end = channel + of_.components_[f]; channel < end; ++channel) {
        decltype(corner.in_original[0] + 0) d = 0;
        for (std::size_t k = 0; k < 4; ++k)
          d += corner.in_original[k] * values_[k * channels + channel] -
               corner.in_simplified[k] * values_[(4 + k) * channels + channel];
        difference_[id * channels + channel] = static_cast<double>(d);
        square += static_cast<double>(d) * static_cast<double>(d);
      }
      const double error = std::sqrt(square);
      if (!(error <= cell_max[f])) cell_max[f] = error;
      if (error > sum[f].max) {
        sum[f].max = error;
        std::array<double, 4> weight;
        std::transform(corner.in_original.begin(), corner.in_original.end(), weight.begin(),
                       [](auto w) { return static_cast<double>(w); });
        sum[f].at = combine(corners_of(of_.original_, original), weight);
      }
    }
  }

  const MeshComparison& of_;
  Overlap<double> plain_;
  Overlap<long double> extended_;
  std::vector<double> values_, difference_;
  std::vector<char> known_;
};

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
    const std::array<Point, 4> corners = corners_of(of_.original_, tet);
    near_.clear();
    of_.simplified_tets_.each_meeting(box_of(corners), [&](std::uint32_t t) { near_.push_back(t); });
    for (int draw = 0; draw < draws; ++draw) {
      weight = random.in_tet();
      const Point p = combine(corners, weight);
      const auto holder = std::find_if(near_.begin(), near_.end(), [&](std::uint32_t t) { return holds(t, p); });
      if (holder == near_.end()) return true;
      std::iter_swap(near_.begin(), holder); // it is likely to hold the next one too
    }
    return false;
  }

  /// The errors by field of the value against a simplified tet that holds p.
  std::span<const double> against_tet(const Point& p, std::uint32_t t) {
    const std::array<long double, 4> weight = Frame<long double>(corners_of(of_.simplified_, t)).weights(p);
    std::array<double, 4> clamped;
    std::transform(weight.begin(), weight.end(), clamped.begin(),
                   [](long double w) { return static_cast<double>(std::clamp(w, 0.0L, 1.0L)); });
    return against(of_.simplified_.tets[t], clamped);
  }
  /// The errors of the value against the point of the simplified boundary that is closest to p.
  std::span<const double> against_closest(const Point& p) {
    (void)of_.boundary_surface_.distance_sq(p, &nearest_);
    const Triangle& triangle = of_.boundary_surface_.triangle(nearest_);
    return against(of_.boundary_[nearest_], closest_on_triangle(p, triangle[0], triangle[1], triangle[2]).weight);
  }

private:
  [[nodiscard]] bool holds(std::uint32_t t, const Point& p) const {
    const int sign = of_.simplified_sign_[t];
    if (sign == 0) return false;
    const auto [a, b, c, d] = corners_of(of_.simplified_, t);
    return sign * orientation(p, b, c, d) >= 0 && sign * orientation(a, p, c, d) >= 0 &&
           sign * orientation(a, b, p, d) >= 0 && sign * orientation(a, b, c, p) >= 0;
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
  std::vector<std::uint32_t> near_;
  std::uint32_t nearest_ = 0xffffffff;
};

namespace {

/// Enters the errors at one point: the maximum, and the squares for the mean.
void enter(std::span<const double> errors, const Point& p, std::vector<FieldDifference>& sum) {
  for (std::size_t f = 0; f < sum.size(); ++f)
    add(FieldDifference{errors[f], p, errors[f] * errors[f]}, sum[f]);
}

void divide(std::vector<FieldDifference>& sum, double by) {
  for (FieldDifference& field : sum)
    field.mean_square = by > 0 ? field.mean_square / by : 0;
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

MeshComparison::MeshComparison(const ComparedMesh& original, const ComparedMesh& simplified,
                               std::span<const Face> simplified_boundary, std::vector<std::uint32_t> components)
    : original_(original), simplified_(simplified), components_(std::move(components)),
      channel_count_(std::accumulate(components_.begin(), components_.end(), std::size_t{0})),
      original_sign_(signs_of(original)), simplified_sign_(signs_of(simplified)),
      simplified_tets_(boxes_of(simplified, simplified_sign_)),
      boundary_(simplified_boundary.begin(), simplified_boundary.end()),
      boundary_surface_(triangles_of(simplified.points, simplified_boundary)) {
  if (original.values.size() != original.points.size() * channel_count_ ||
      simplified.values.size() != simplified.points.size() * channel_count_)
    throw Error(ErrorCode::kBadArgument, "a mesh to compare must have one value for each vertex and channel");
  original_tet_volume_.resize(original.tets.size());
  for (std::size_t t = 0; t < original.tets.size(); ++t) {
    original_tet_volume_[t] = original_sign_[t] == 0 ? 0 : volume_of(corners_of(original, t));
    original_volume_ += original_tet_volume_[t];
  }
  simplified_sliver_.resize(simplified.tets.size());
  for (std::size_t t = 0; t < simplified.tets.size(); ++t) {
    if (simplified_sign_[t] == 0) continue;
    const std::array<Point, 4> corners = corners_of(simplified, t);
    simplified_volume_ += volume_of(corners);
    simplified_sliver_[t] = !(flatness_of(corners) > kSliver);
  }
}

InsideDifference MeshComparison::exact_inside(const ProgressCallback& progress) const {
  const std::size_t tets = original_.tets.size(), fields = components_.size();
  InsideDifference result;
  result.fields.resize(fields);
  result.cell_volume.assign(tets, 0);
  result.cell_max.assign(tets * fields, kNaN);
  std::vector<std::vector<FieldDifference>> partial(block_count(tets), std::vector<FieldDifference>(fields));
  tbb::enumerable_thread_specific<Clipper> clippers([this] { return Clipper(*this); });
  for_each_block(tets, "comparing fields", progress, [&](std::size_t block, std::size_t begin, std::size_t end) {
    Clipper& clipper = clippers.local();
    for (std::size_t t = begin; t < end; ++t)
      clipper.compare(static_cast<std::uint32_t>(t), partial[block], result.cell_max.data() + t * fields,
                      result.cell_volume[t]);
  });
  for (const auto& part : partial)
    add(part, result.fields);
  result.volume = std::accumulate(result.cell_volume.begin(), result.cell_volume.end(), 0.0);
  divide(result.fields, result.volume);
  return result;
}

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
  std::vector<Part> parts(block_count(samples));
  for_each_block(samples, "comparing samples", progress, [&](std::size_t block, std::size_t begin, std::size_t end) {
    Part& part = parts[block];
    part.inside.resize(fields);
    part.outside.resize(fields);
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
  });
  std::uint64_t compared = 0;
  for (const Part& part : parts) {
    add(part.inside, result.inside.fields);
    add(part.outside, result.outside.fields);
    result.inside.points += part.inside_points;
    result.outside.points += part.outside_points;
    compared += part.compared;
  }
  divide(result.inside.fields, static_cast<double>(compared));
  divide(result.outside.fields, static_cast<double>(result.outside.points));
  const double volume_each = original_volume_ / static_cast<double>(samples);
  result.inside.volume = volume_each * static_cast<double>(result.inside.points);
  result.outside.volume = volume_each * static_cast<double>(result.outside.points);
  return result;
}

VertexDifference MeshComparison::at_vertices(const ProgressCallback& progress) const {
  const std::size_t vertices = original_.points.size(), fields = components_.size();
  VertexDifference result{std::vector<double>(vertices * fields, kNaN), std::vector<char>(vertices)};
  std::vector<char> used(vertices);
  for (const Tet& tet : original_.tets)
    for (const VertexId v : tet)
      used[v.index()] = 1;
  for_each_block(vertices, "comparing vertices", progress, [&](std::size_t, std::size_t begin, std::size_t end) {
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
  return result;
}

OutsideDifference MeshComparison::sampled_outside(const InsideDifference& inside, std::uint64_t samples,
                                                  std::uint64_t seed, const ProgressCallback& progress) const {
  // Tets that are covered but for this share count as covered: the rest is rounding, and a point in it hard to draw.
  constexpr double kCovered = 1e-9;
  constexpr int kDraws = 1000;
  OutsideDifference result;
  const std::size_t fields = components_.size();
  result.fields.resize(fields);
  std::vector<double> uncovered(original_.tets.size(), 0);
  for (std::size_t t = 0; t < uncovered.size(); ++t) {
    const double left = original_tet_volume_[t] - inside.cell_volume[t];
    if (left > kCovered * original_tet_volume_[t]) uncovered[t] = left;
  }
  const std::vector<double> sums = running_sum(uncovered);
  if (sums.empty() || !(sums.back() > 0) || boundary_surface_.size() == 0) return result;
  result.volume = sums.back();
  struct Part {
    std::vector<FieldDifference> fields;
    std::uint64_t points = 0;
  };
  std::vector<Part> parts(block_count(samples));
  for_each_block(samples, "comparing outside", progress, [&](std::size_t block, std::size_t begin, std::size_t end) {
    Part& part = parts[block];
    part.fields.resize(fields);
    Sampler sampler(*this);
    for (std::size_t i = begin; i < end; ++i) {
      Random random(seed, i);
      const std::size_t t = item_at(sums, (static_cast<double>(i) + random()) / static_cast<double>(samples));
      std::array<double, 4> weight;
      if (!sampler.draw_outside(static_cast<std::uint32_t>(t), random, kDraws, weight)) continue;
      const Point p = combine(corners_of(original_, t), weight);
      sampler.value_in(t, weight);
      enter(sampler.against_closest(p), p, part.fields);
      ++part.points;
    }
  });
  for (const Part& part : parts) {
    add(part.fields, result.fields);
    result.points += part.points;
  }
  divide(result.fields, static_cast<double>(result.points));
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

std::uint64_t count_boundary_intersections(std::span<const Point> points, std::span<const Face> faces,
                                           const ProgressCallback& progress) {
  const std::vector<Triangle> triangles = triangles_of(points, faces);
  std::vector<BoundingBox> boxes(triangles.size());
  std::transform(triangles.begin(), triangles.end(), boxes.begin(), [](const Triangle& t) { return box_of(t); });
  const BoxTree tree(boxes);
  std::vector<std::uint64_t> partial(block_count(faces.size()));
  for_each_block(faces.size(), "checking the boundary", progress,
                 [&](std::size_t block, std::size_t begin, std::size_t end) {
                   for (std::size_t f = begin; f < end; ++f)
                     tree.each_meeting(boxes[f], [&](std::uint32_t other) {
                       if (other > f && faces_meet_improperly(faces[f], faces[other], points)) ++partial[block];
                     });
                 });
  return std::accumulate(partial.begin(), partial.end(), std::uint64_t{0});
}

} // namespace ptet
