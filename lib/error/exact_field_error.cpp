#include "error/exact_field_error.hpp"

#include "error/barycentric.hpp"
#include "error/double_double.hpp"
#include "error/original_cells.hpp"
#include "error/tet_clip.hpp"
#include "error/tolerances.hpp"
#include "mesh/vec3.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace ptet {
using namespace vec;
namespace {

/// So many channels go through the clipping themselves. Of more, what goes through it are weights of the tet's corners.
constexpr std::size_t kMostCarried = 8;
/// What rounding can make of a zero among barycentric coordinates, against the lengths and the volume they come from;
/// in versions so flat that it would be more than kMostPlaneRounding it is taken for no more.
constexpr double kPlaneRounding = 64 * std::numeric_limits<double>::epsilon();
constexpr double kMostPlaneRounding = 1e-10;
/// What is flatter than twice a double's digits can tell, see OriginalCells::kFlatShape, is not measured but bounded.
constexpr double kFlattestShape = 1e-27;
/// What is left of kPlaneRounding with twice the digits.
constexpr double kFinePlaneRounding = 0x1p-94;
/// Clipping may hide this part of the differences at a tet's corners; that counts where their square is so many times
/// that of the error.
constexpr double kClipRounding = 4 * std::numeric_limits<double>::epsilon();
constexpr double kCornersThatCount = 1e14;
/// A part of so little of both tets is where they touch.
constexpr double kTouchingPart = 1e-27;
/// No difference but 0 is nearer to 0: its square is one that a double holds. Far below what an error code tells.
constexpr double kLeastDifference = 1e-140;

} // namespace

struct ExactFieldError::Impl : OriginalCells {
  using OriginalCells::OriginalCells;
};

ExactFieldError::Workspace::Workspace(const ExactFieldError& original)
    : vertices_(original.impl_->prepared.used_vertex_count), tet_stamp_(original.impl_->cells.size()) {}

ExactFieldError::ExactFieldError(const PreparedMesh& prepared, ChannelView channels)
    : impl_(std::make_unique<Impl>(prepared, channels)) {}
ExactFieldError::~ExactFieldError() = default;

/// One measurement: the walk over the original tets that a version meets.
class ExactFieldError::Walk {
public:
  /// `squared` empty: not wanted. `limit` empty: none.
  Walk(const Impl& original, const Tet& version, Workspace& w, std::span<double> errors, std::span<double> squared,
       std::span<const double> limit)
      : original_(original), channels_(original.channels.channels), version_(by_place(original, version)), w_(w),
        errors_(errors), squared_(squared), limit_(limit) {}

  /// False when it was given up.
  bool run() {
    if (!begin()) return true;
    // Around a vertex inside the domain the corner of the version is full of original tets. At the boundary there may
    // be none, and those that do not lie beyond one of the version's planes need not meet it.
    const auto start =
        std::find_if(version_.begin(), version_.end(), [&](std::uint32_t v) { return !original_.on_boundary[v]; });
    met_boundary_ = start == version_.end();
    if (!met_boundary_) {
      enter_star(*start);
      walk();
    }
    if (!met_boundary_ || beyond_limit_) return !beyond_limit_;
    const BoundingBox box = box_of<4>({original_.point(version_[0]), original_.point(version_[1]),
                                       original_.point(version_[2]), original_.point(version_[3])});
    original_.boundary_tree->each_meeting(box, [&](std::uint32_t face) {
      const HalfFace h = original_.boundary_faces[face];
      if (w_.tet_stamp_[h / 4] < queued() && !apart(original_.cells[h / 4], kOutwardFace[h % 4])) push(h / 4);
    });
    for (const std::uint32_t v : version_)
      enter_star(v);
    walk();
    return !beyond_limit_;
  }

private:
  using Row = Workspace::Row;
  using Cell = OriginalCells::Cell;
  static constexpr std::uint32_t kOutside = OriginalCells::kOutside;
  static constexpr std::uint32_t kLargeStar = OriginalCells::kLargeStar;
  static constexpr double kFlatShape = OriginalCells::kFlatShape;

  /// A tet's stamp while it waits in the queue and after it has left it.
  [[nodiscard]] std::uint32_t queued() const { return w_.stamp_; }
  [[nodiscard]] std::uint32_t done() const { return w_.stamp_ + 1; }
  [[nodiscard]] const double* difference(std::uint32_t row) const { return &w_.differences_[row * channels_]; }
  [[nodiscard]] const double* values(std::uint32_t v) const { return original_.channels.values.data() + v * channels_; }

  /// The corners in the order of their places, but for the last two where that would turn the version round.
  static std::array<std::uint32_t, 4> by_place(const Impl& original, const Tet& version) {
    std::array<std::uint32_t, 4> v{version[0].index(), version[1].index(), version[2].index(), version[3].index()};
    bool turned = false;
    const auto order = [&](std::size_t i, std::size_t j) {
      if (!(original.point(v[j]) < original.point(v[i]))) return;
      std::swap(v[i], v[j]);
      turned = !turned;
    };
    order(0, 1);
    order(2, 3);
    order(0, 2);
    order(1, 3);
    order(1, 2);
    if (turned) std::swap(v[2], v[3]);
    return v;
  }

  /// False for a flat version, and one that nothing can be measured in.
  bool begin() {
    origin_ = original_.point(version_[0]);
    const Vec3 e1 = original_.point(version_[1]) - origin_;
    const Vec3 e2 = original_.point(version_[2]) - origin_;
    const Vec3 e3 = original_.point(version_[3]) - origin_;
    const Vec3 n1 = cross(e2, e3);
    double det = dot(e1, n1);
    const double lengths = norm(e1) * norm(e2) * norm(e3);
    const double longest_sq = std::max({dot(e1, e1), dot(e2, e2), dot(e3, e3)});
    fine_ = !(det > kFlatShape * lengths) || !std::isfinite(1 / det);
    if (fine_) {
      det = begin_finely(lengths);
      if (!(det > 0)) return false;
      shape_rounding_ = 0;
      rounding_ = kFinePlaneRounding / det * longest_sq;
    } else {
      shape_rounding_ = kShapeRounding * norm(e1) * norm(e2) * norm(e3) / det;
      plane_ = {(1 / det) * n1, (1 / det) * cross(e3, e1), (1 / det) * cross(e1, e2)};
      rounding_ = kPlaneRounding / det * longest_sq;
    }
    per_length_ = {1 / norm(e1), 1 / norm(e2), 1 / norm(e3)};
    touching_ = kTouchingPart * det / 6;
    clear_workspace();
    add_corners();
    return true;
  }

  void clear_workspace() {
    w_.queue_.clear();
    w_.rows_.clear();
    w_.differences_.clear();
    w_.stamp_ += 2;
    if (w_.stamp_ < 2) { // the stamps have gone round
      std::fill(w_.vertices_.begin(), w_.vertices_.end(), Workspace::Mark{});
      std::fill(w_.tet_stamp_.begin(), w_.tet_stamp_.end(), 0);
      w_.stamp_ = 2;
    }
  }

  void add_corners() {
    origin_values_ = values(version_[0]);
    w_.edges_.clear();
    for (std::size_t i = 1; i < 4; ++i)
      for (std::size_t c = 0; c < channels_; ++c)
        w_.edges_.push_back(values(version_[i])[c] - origin_values_[c]);
    for (std::uint32_t i = 0; i < 4; ++i) { // at its own corners the version is exact
      w_.vertices_[version_[i]] = {w_.stamp_, i};
      Row& corner = w_.rows_.emplace_back();
      corner = {{}, static_cast<std::uint8_t>(0xF & ~(1U << i)), 0};
      corner.barycentric[i] = 1;
    }
    w_.differences_.resize(4 * channels_, 0.0);
  }

  /// The same with twice the digits: the determinant, 0 for a version that is flat or that these do not tell from one
  /// that is; of the latter a bound is taken in.
  double begin_finely(double lengths) {
    const std::array<Point, 4> x{origin_, original_.point(version_[1]), original_.point(version_[2]),
                                 original_.point(version_[3])};
    if (orientation(x[0], x[1], x[2], x[3]) <= 0) return 0;
    const FineVec3 e1 = fine_difference(x[1], origin_), e2 = fine_difference(x[2], origin_),
                   e3 = fine_difference(x[3], origin_);
    const FineVec3 n1 = cross(e2, e3);
    const DoubleDouble det = dot(e1, n1);
    if (!(det.high > kFlattestShape * lengths) || !std::isfinite(1 / det.high)) {
      bound_by_values();
      return 0;
    }
    const DoubleDouble per_det = DoubleDouble(1) / det;
    fine_plane_ = {per_det * n1, per_det * cross(e3, e1), per_det * cross(e1, e2)};
    return det.high;
  }

  /// In the version phi is between the values at its corners, and Phi between those at the corners of the original
  /// tets that come near it: no difference is greater than that of two of these.
  void bound_by_values() {
    const BoundingBox box = box_of<4>({original_.point(version_[0]), original_.point(version_[1]),
                                       original_.point(version_[2]), original_.point(version_[3])});
    for (const Cell& cell : original_.cells) {
      const auto at = [&](std::size_t k) { return original_.point(cell.v[k]); };
      if (!box.meets(box_of<4>({at(0), at(1), at(2), at(3)}))) continue;
      for (const std::uint32_t v : cell.v)
        for (const std::uint32_t corner : version_)
          take_in_values(v, corner);
    }
  }

  void take_in_values(std::uint32_t v, std::uint32_t w) {
    double norm_sq = 0;
    for (std::size_t c = 0; c < channels_; ++c) {
      const double d = values(v)[c] - values(w)[c];
      norm_sq += d * d;
      if (original_.ends_field[c] == 0) continue;
      const std::size_t field = original_.channels.field_of[c];
      raise_error(field, norm_sq * original_.scale_sq[field]);
      norm_sq = 0;
    }
  }

  /// The row of a vertex.
  std::uint32_t look_at(std::uint32_t v) {
    Workspace::Mark& mark = w_.vertices_[v];
    if (mark.stamp != w_.stamp_) {
      mark = {w_.stamp_, static_cast<std::uint32_t>(w_.rows_.size())};
      add_row(v);
    }
    return mark.row;
  }

  /// Barycentric coordinates in a flat version.
  [[nodiscard]] std::array<DoubleDouble, 4> fine_barycentric(std::uint32_t v) const {
    const FineVec3 from_origin = fine_difference(original_.point(v), origin_);
    std::array<DoubleDouble, 4> b{1};
    for (std::size_t i = 1; i < 4; ++i) {
      b[i] = dot(fine_plane_[i - 1], from_origin);
      b[0] = b[0] - b[i];
    }
    return b;
  }

  [[nodiscard]] double fine_difference_at(std::uint32_t v, const std::array<DoubleDouble, 4>& b, std::size_t c) const {
    DoubleDouble d = difference_of(values(v)[c], origin_values_[c]);
    for (std::size_t i = 1; i < 4; ++i)
      d = d - b[i] * difference_of(values(version_[i])[c], origin_values_[c]);
    return d.rounded();
  }

  void add_row(std::uint32_t v) {
    const Vec3 from_origin = original_.point(v) - origin_;
    std::array<DoubleDouble, 4> fine;
    Row row{{}, 0, 0};
    if (fine_) {
      fine = fine_barycentric(v);
      for (std::size_t i = 0; i < 4; ++i)
        row.barycentric[i] = fine[i].rounded();
    } else {
      for (std::size_t i = 1; i < 4; ++i)
        row.barycentric[i] = dot(plane_[i - 1], from_origin);
      row.barycentric[0] = 1 - row.barycentric[1] - row.barycentric[2] - row.barycentric[3];
    }
    const std::array<double, 4> unrounded = row.barycentric;
    // What lies on a plane of the version is not to be seen within: it may belong to what is on its other side, as at a
    // crack, where the field has another value.
    const double zero = std::min(kMostPlaneRounding, rounding_ * (std::abs(from_origin[0]) + std::abs(from_origin[1]) +
                                                                  std::abs(from_origin[2])));
    for (double& coordinate : row.barycentric)
      if (std::abs(coordinate) <= zero) coordinate = 0;
    row.beyond = static_cast<std::uint8_t>(not_positive(row.barycentric));
    row.strictly_beyond = static_cast<std::uint8_t>(negative(row.barycentric));
    w_.rows_.push_back(row);
    add_differences(v, unrounded, fine, norm(from_origin));
  }

  /// `b`, `fine`: the barycentric coordinates of the vertex, the latter of a flat version. `length`: its distance from
  /// corner 0.
  void add_differences(std::uint32_t v, const std::array<double, 4>& b, const std::array<DoubleDouble, 4>& fine,
                       double length) {
    const double b1 = b[1];
    const double b2 = b[2];
    const double b3 = b[3];
    const double* const at_v = values(v);
    const std::size_t begin = w_.differences_.size();
    w_.differences_.resize(begin + channels_);
    double* const differences = w_.differences_.data() + begin;
    const double* const e1 = w_.edges_.data();
    const double* const e2 = e1 + channels_;
    const double* const e3 = e2 + channels_;
    const auto rounding = [&](double b_i, double per_length) {
      return kValueRounding * std::abs(b_i) + shape_rounding_ * (length * per_length + std::abs(b_i));
    };
    const double r1 = rounding(b1, per_length_[0]);
    const double r2 = rounding(b2, per_length_[1]);
    const double r3 = rounding(b3, per_length_[2]);
    double sum = 0;
    for (std::size_t c = 0; c < channels_; ++c) {
      const double own = at_v[c] - origin_values_[c];
      const double t1 = b1 * e1[c];
      const double t2 = b2 * e2[c];
      const double t3 = b3 * e3[c];
      const double d = fine_ ? fine_difference_at(v, fine, c) : own - (t1 + t2 + t3);
      const double most =
          kValueRounding * std::abs(own) + r1 * std::abs(e1[c]) + r2 * std::abs(e2[c]) + r3 * std::abs(e3[c]);
      differences[c] = std::abs(d) <= most ? 0 : d + std::copysign(kLeastDifference, d);
      sum += d;
    }
    if (!std::isfinite(sum)) fail();
  }

  /// What cannot be computed is as bad as can be.
  void fail() {
    std::fill(errors_.begin(), errors_.end(), std::numeric_limits<double>::infinity());
    beyond_limit_ |= !limit_.empty();
  }

  /// Whether one plane of the version has all these corners of a tet on its outer side (or on it).
  template <std::size_t N>
  [[nodiscard]] bool apart(const Cell& cell, const std::array<std::uint8_t, N>& corners) {
    unsigned common = 0xF;
    for (const std::uint8_t k : corners)
      common &= w_.rows_[look_at(cell.v[k])].beyond;
    return common != 0;
  }

  void push(std::uint32_t t) {
    w_.tet_stamp_[t] = queued();
    w_.queue_.push_back(t);
  }

  void enter(std::uint32_t t) {
    if (w_.tet_stamp_[t] < queued() && !apart<4>(original_.cells[t], {0, 1, 2, 3})) push(t);
  }

  void enter_star(std::uint32_t v) {
    const std::uint32_t begin = original_.star_begin[v];
    const std::uint32_t end = original_.star_begin[v + 1];
    if (end - begin > kLargeStar) {
      enter_large_star(v);
      return;
    }
    for (std::uint32_t i = begin; i != end; ++i)
      enter(original_.star[i]);
  }

  /// The same tets in the same order, but for those that leave the corner in other directions.
  void enter_large_star(std::uint32_t v) {
    const auto& large = original_.large_stars;
    const auto place = std::lower_bound(large.begin(), large.end(), v) - large.begin();
    original_.cones[static_cast<std::size_t>(place)].find_near(original_.opposite(version_, v), w_.near_);
    for (const std::uint32_t i : w_.near_)
      enter(original_.star[original_.star_begin[v] + i]);
  }

  void walk() {
    for (; next_ < w_.queue_.size() && !beyond_limit_; ++next_) {
      const std::uint32_t t = w_.queue_[next_];
      w_.tet_stamp_[t] = done();
      const Cell& cell = original_.cells[t];
      std::array<std::uint32_t, 4> rows{};
      std::array<unsigned, 4> beyond{};
      for (std::size_t k = 0; k < 4; ++k) {
        rows[k] = look_at(cell.v[k]);
        beyond[k] = w_.rows_[rows[k]].beyond;
      }
      const bool flat = cell.is_flat();
      if (!flat && !see_tet(fine_ ? rows_by_place(cell) : rows, cell.volume)) continue;
      for (std::size_t k = 0; k < 4; ++k) {
        const auto& face = kOutwardFace[k];
        if ((beyond[face[0]] & beyond[face[1]] & beyond[face[2]]) != 0) continue;
        const std::uint32_t other = cell.neighbor[k];
        if (other == kOutside || original_.cells[other].is_flat() != flat) met_boundary_ = true;
        if (other != kOutside && w_.tet_stamp_[other] < queued()) push(other);
      }
    }
  }

  /// The rows of an original tet's corners in the order of their places. In a flat version what rounding makes of a
  /// part depends on the order, and the same tet, however numbered, is to be measured from the same parts.
  std::array<std::uint32_t, 4> rows_by_place(const Cell& cell) {
    std::array<std::uint32_t, 4> v = cell.v;
    std::sort(v.begin(), v.end(), [&](std::uint32_t a, std::uint32_t b) {
      return original_.point(a) != original_.point(b) ? original_.point(a) < original_.point(b) : a < b;
    });
    return {look_at(v[0]), look_at(v[1]), look_at(v[2]), look_at(v[3])};
  }

  /// Takes in the part of an original tet in the version; false when it has none.
  bool see_tet(const std::array<std::uint32_t, 4>& rows, double volume) {
    static_assert(kMostCarried == 8);
    switch (channels_) {
    case 1: return see_carried<1, true>(rows, volume);
    case 2: return see_some<2>(rows, volume);
    case 3: return see_some<3>(rows, volume);
    case 4: return see_some<4>(rows, volume);
    case 5: return see_some<5>(rows, volume);
    case 6: return see_some<6>(rows, volume);
    case 7: return see_some<7>(rows, volume);
    case 8: return see_some<8>(rows, volume);
    default: return see_weighted(rows, volume);
    }
  }

  template <std::size_t N>
  bool see_some(const std::array<std::uint32_t, 4>& rows, double volume) {
    return original_.scalars ? see_carried<N, true>(rows, volume) : see_carried<N, false>(rows, volume);
  }

  /// What is known of the N channels on the parts of one tet, from the differences at the corners.
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

  template <std::size_t N, bool Scalars>
  bool see_carried(const std::array<std::uint32_t, 4>& rows, double volume) {
    std::array<const Row*, 4> row;
    std::array<const double*, 4> d;
    unsigned common = 0xF;
    unsigned cutting = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      row[k] = &w_.rows_[rows[k]];
      d[k] = difference(rows[k]);
      common &= row[k]->strictly_beyond;
      cutting |= row[k]->strictly_beyond;
    }
    if (common != 0) return false;
    Seen<N, Scalars> seen;
    const char* const ends_field = original_.ends_field.data();
    if (cutting == 0) {
      seen.add(d, volume, ends_field);
    } else {
      std::array<ClipCorner<N>, 4> corners;
      for (std::size_t k = 0; k < 4; ++k) {
        corners[k].barycentric = row[k]->barycentric;
        corners[k].beyond = row[k]->strictly_beyond;
        std::copy_n(d[k], N, corners[k].carried.begin());
      }
      bool any = false;
      double covered = 0;
      auto use = [&](const ClipCorners<N>& piece, double part) {
        any = true;
        covered += part;
        seen.add(
            {piece[0]->carried.data(), piece[1]->carried.data(), piece[2]->carried.data(), piece[3]->carried.data()},
            part, ends_field);
      };
      TetClip<N, decltype(use)>(use).part_of({&corners[0], &corners[1], &corners[2], &corners[3]}, volume, 0xF);
      if (only_touches(covered, volume)) return any;
    }
    std::array<double, 4> corner_sq{};
    double integral = 0;
    for (std::size_t c = 0; c < N; ++c) {
      for (std::size_t k = 0; k < 4; ++k)
        corner_sq[k] += d[k][c] * d[k][c];
      integral += seen.integral[c];
      if (ends_field[c] == 0) continue;
      take_in(original_.channels.field_of[c], seen.greatest_sq[c], integral / 20, greatest(corner_sq));
      corner_sq = {};
      integral = 0;
    }
    return true;
  }

  static double greatest(const std::array<double, 4>& x) {
    return std::max(std::max(x[0], x[1]), std::max(x[2], x[3]));
  }

  /// The same for any number of channels: what is carried are weights of the tet's corners.
  bool see_weighted(const std::array<std::uint32_t, 4>& rows, double volume) {
    std::array<ClipCorner<4>, 4> corners;
    for (std::size_t k = 0; k < 4; ++k) {
      corners[k].barycentric = w_.rows_[rows[k]].barycentric;
      corners[k].beyond = w_.rows_[rows[k]].strictly_beyond;
      corners[k].carried = {};
      corners[k].carried[k] = 1;
    }
    bool any = false;
    double covered = 0;
    seen_sq_.assign(errors_.size(), 0.0);
    integral_.assign(errors_.size(), 0.0);
    auto use = [&](const ClipCorners<4>& piece, double part) {
      any = true;
      covered += part;
      std::array<double, 4> norm_sq{};
      double integral = 0;
      for (std::size_t c = 0; c < channels_; ++c) {
        double sum = 0;
        double sum_sq = 0;
        for (std::size_t k = 0; k < 4; ++k) {
          const auto& weight = piece[k]->carried;
          const double d = weight[0] * difference(rows[0])[c] + weight[1] * difference(rows[1])[c] +
                           weight[2] * difference(rows[2])[c] + weight[3] * difference(rows[3])[c];
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
    std::array<double, 4> corner_sq{};
    for (std::size_t c = 0; c < channels_; ++c) {
      for (std::size_t k = 0; k < 4; ++k)
        corner_sq[k] += difference(rows[k])[c] * difference(rows[k])[c];
      if (original_.ends_field[c] == 0) continue;
      const std::size_t field = original_.channels.field_of[c];
      take_in(field, seen_sq_[field], integral_[field], greatest(corner_sq));
      corner_sq = {};
    }
    return any;
  }

  /// Whether a part of an original tet has no volume but what rounding gave it. What touches from outside, as across a
  /// crack, may have another value there; what hangs together by faces is seen in a part with a volume.
  [[nodiscard]] bool only_touches(double covered, double volume) const {
    return !(covered > std::min(touching_, kTouchingPart * volume));
  }

  /// What was found on a part of an original tet, at the corners of which the squared error is up to `corner_sq`.
  void take_in(std::size_t field, double error_sq, double integral, double corner_sq) {
    if (error_sq <= kValueRounding * kValueRounding * corner_sq) return;
    const double scale_sq = original_.scale_sq[field];
    if (corner_sq > kCornersThatCount * error_sq) {
      const double most = std::sqrt(error_sq) + kClipRounding * std::sqrt(corner_sq);
      error_sq = most * most;
    }
    raise_error(field, error_sq * scale_sq);
    if (!squared_.empty()) squared_[field] += integral * scale_sq;
  }

  void raise_error(std::size_t field, double error_sq) {
    if (error_sq <= errors_[field] * errors_[field]) return;
    if (std::isnan(error_sq)) {
      fail();
      return;
    }
    errors_[field] = std::sqrt(error_sq);
    beyond_limit_ |= !limit_.empty() && errors_[field] > limit_[field];
  }

  const Impl& original_;
  std::size_t channels_;
  std::array<std::uint32_t, 4> version_;
  Workspace& w_;
  std::span<double> errors_;
  std::span<double> squared_;
  std::span<const double> limit_;
  bool beyond_limit_ = false;
  Point origin_{};
  const double* origin_values_ = nullptr;
  double shape_rounding_ = 0;
  bool fine_ = false;                      ///< a flat version: twice the digits
  std::array<FineVec3, 3> fine_plane_{};   ///< then in the place of plane_
  Vec3 per_length_{};                      ///< of the edges from corner 0
  std::array<Vec3, 3> plane_{};            ///< barycentric coordinates 1 to 3 of p: plane . (p - origin)
  std::vector<double> seen_sq_, integral_; ///< by field: of one tet
  double touching_ = 0;                    ///< parts of no larger volume touch
  double rounding_ = 0;                    ///< of these, for each unit of |p - origin|
  std::size_t next_ = 0;
  bool met_boundary_ = false;
};

void ExactFieldError::measure(const Tet& version, Workspace& workspace, std::span<double> errors) const {
  Walk(*impl_, version, workspace, errors, {}, {}).run();
}

void ExactFieldError::measure(const Tet& version, Workspace& workspace, std::span<double> errors,
                              std::span<double> squared) const {
  Walk(*impl_, version, workspace, errors, squared, {}).run();
}

bool ExactFieldError::measure(const Tet& version, Workspace& workspace, std::span<double> errors,
                              std::span<double> squared, std::span<const double> limit) const {
  return Walk(*impl_, version, workspace, errors, squared, limit).run();
}

} // namespace ptet
