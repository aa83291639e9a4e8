#include "error/version_view.hpp"

#include "error/barycentric.hpp"
#include "error/original_cells.hpp"
#include "error/tolerances.hpp"
#include "mesh/predicates.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace ptet {
using namespace vec;
namespace {

/// What rounding can make of a zero among barycentric coordinates, against the lengths and the volume they come from;
/// in versions so flat that it would be more than kMostPlaneRounding it is taken for no more.
constexpr double kPlaneRounding = 64 * std::numeric_limits<double>::epsilon();
constexpr double kMostPlaneRounding = 1e-10;
constexpr double kFlatShape = OriginalCells::kFlatShape;
/// What is flatter than twice a double's digits can tell.
constexpr double kFlattestShape = 1e-27;
/// What is left of kPlaneRounding with twice the digits.
constexpr double kFinePlaneRounding = 0x1p-94;
/// A difference of no more times what rounding of the coordinates may make of it is taken again.
constexpr double kMostOff = 0x1p26;
/// No difference but 0 is nearer to 0: its square is one that a double holds. Far below what an error code tells.
constexpr double kLeastDifference = 1e-140;

} // namespace

VersionView::VersionView(const OriginalCells& original)
    : original_(&original), values_(original.channels.values.data()), channels_(original.channels.channels),
      marks_(original.prepared.used_vertex_count) {}

VersionView::Corners VersionView::by_place(const Tet& version) const {
  Corners v{version[0].index(), version[1].index(), version[2].index(), version[3].index()};
  bool turned = false;
  const auto order = [&](std::size_t i, std::size_t j) {
    if (!(original_->point(v[j]) < original_->point(v[i]))) return;
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

VersionView::Shape VersionView::begin(const Tet& version) {
  corners_ = by_place(version);
  origin_ = original_->point(corners_[0]);
  const Vec3 e1 = original_->point(corners_[1]) - origin_;
  const Vec3 e2 = original_->point(corners_[2]) - origin_;
  const Vec3 e3 = original_->point(corners_[3]) - origin_;
  const Vec3 n1 = cross(e2, e3);
  double det = dot(e1, n1);
  const Vec3 length{norm(e1), norm(e2), norm(e3)};
  const double lengths = length[0] * length[1] * length[2];
  const double longest_sq = std::max({dot(e1, e1), dot(e2, e2), dot(e3, e3)});
  const auto [shortest, longest] = std::minmax({length[0], length[1], length[2]});
  // A short edge is in both sides of the first; but beside it others' coordinates along it are large.
  is_fine_ = !(det > kFlatShape * lengths) || !(shortest > kFlatShape * longest) || !std::isfinite(1 / det);
  has_fine_planes_ = false;
  if (is_fine_) {
    const Shape shape = begin_finely(lengths);
    if (shape != Shape::kSolid) return shape;
    det = determinant_;
    shape_rounding_ = 0;
    for (std::size_t i = 0; i < 3; ++i)
      plane_[i] = {fine_plane_[i][0].rounded(), fine_plane_[i][1].rounded(), fine_plane_[i][2].rounded()};
    rounding_ = kFinePlaneRounding / det * longest_sq;
  } else {
    determinant_ = det;
    shape_rounding_ = kShapeRounding * lengths / det;
    plane_ = {(1 / det) * n1, (1 / det) * cross(e3, e1), (1 / det) * cross(e1, e2)};
    rounding_ = kPlaneRounding / det * longest_sq;
  }
  plane_rounding_ = kPlaneRounding / det * longest_sq;
  per_length_ = {1 / length[0], 1 / length[1], 1 / length[2]};
  clear();
  add_corners();
  return Shape::kSolid;
}

/// The same with twice the digits.
VersionView::Shape VersionView::begin_finely(double lengths) {
  const std::array<Point, 4> x{origin_, original_->point(corners_[1]), original_->point(corners_[2]),
                               original_->point(corners_[3])};
  if (orientation(x[0], x[1], x[2], x[3]) <= 0) return Shape::kFlat;
  determinant_ = find_fine_planes().high;
  if (determinant_ > kFlattestShape * lengths && std::isfinite(1 / determinant_)) return Shape::kSolid;
  most_volume_ = std::max(determinant_, kFlattestShape * lengths) / 6;
  return Shape::kUntold;
}

/// Returns the determinant.
DoubleDouble VersionView::find_fine_planes() {
  has_fine_planes_ = true;
  const FineVec3 e1 = fine_difference(original_->point(corners_[1]), origin_),
                 e2 = fine_difference(original_->point(corners_[2]), origin_),
                 e3 = fine_difference(original_->point(corners_[3]), origin_);
  const FineVec3 n1 = cross(e2, e3);
  const DoubleDouble det = dot(e1, n1);
  const DoubleDouble per_det = DoubleDouble(1) / det;
  fine_plane_ = {per_det * n1, per_det * cross(e3, e1), per_det * cross(e1, e2)};
  return det;
}

void VersionView::clear() {
  rows_.clear();
  differences_.clear();
  is_finite_ = true;
  if (++stamp_ == 0) { // the stamps have gone round
    std::fill(marks_.begin(), marks_.end(), Mark{});
    stamp_ = 1;
  }
}

void VersionView::add_corners() {
  edges_.clear();
  for (std::size_t i = 1; i < 4; ++i)
    for (std::size_t c = 0; c < channels_; ++c)
      edges_.push_back(values(corners_[i])[c] - values(corners_[0])[c]);
  for (std::uint32_t i = 0; i < 4; ++i) { // at its own corners the version is exact
    marks_[corners_[i]] = {stamp_, i};
    Row& corner = rows_.emplace_back();
    corner = {{}, static_cast<std::uint8_t>(0xF & ~(1U << i)), 0};
    corner.barycentric[i] = 1;
  }
  differences_.resize(4 * channels_, 0.0);
}

bool VersionView::is_beyond(const BoundingBox& box) const {
  Vec3 middle{}, half{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double low = box.low[axis] - origin_[axis], high = box.high[axis] - origin_[axis];
    middle[axis] = (low + high) / 2;
    half[axis] = (high - low) / 2;
  }
  const double reach = std::abs(middle[0]) + half[0] + std::abs(middle[1]) + half[1] + std::abs(middle[2]) + half[2];
  const double slack = kMostPlaneRounding + plane_rounding_ * reach;
  const auto is_outer = [&](const Vec3& plane, double at_origin) { // false where it is not finite
    const double most = at_origin + dot(plane, middle) + std::abs(plane[0]) * half[0] + std::abs(plane[1]) * half[1] +
                        std::abs(plane[2]) * half[2];
    return most < -slack;
  };
  return is_outer(plane_[0], 0) || is_outer(plane_[1], 0) || is_outer(plane_[2], 0) ||
         is_outer(Vec3{} - plane_[0] - plane_[1] - plane_[2], 1);
}

/// Barycentric coordinates with twice the digits.
std::array<DoubleDouble, 4> VersionView::fine_barycentric(std::uint32_t v) {
  if (!has_fine_planes_) static_cast<void>(find_fine_planes());
  const FineVec3 from_origin = fine_difference(original_->point(v), origin_);
  std::array<DoubleDouble, 4> b{1};
  for (std::size_t i = 1; i < 4; ++i) {
    b[i] = dot(fine_plane_[i - 1], from_origin);
    b[0] = b[0] - b[i];
  }
  return b;
}

double VersionView::fine_difference_at(std::uint32_t v, const std::array<DoubleDouble, 4>& b, std::size_t c) const {
  const double at_origin = values(corners_[0])[c];
  DoubleDouble d = difference_of(values(v)[c], at_origin);
  for (std::size_t i = 1; i < 4; ++i)
    d = d - b[i] * difference_of(values(corners_[i])[c], at_origin);
  return d.rounded();
}

void VersionView::add_row(std::uint32_t v) {
  const Vec3 from_origin = original_->point(v) - origin_;
  std::array<DoubleDouble, 4> fine;
  Row row{{}, 0, 0};
  if (is_fine_) {
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
  const double zero = std::min(
      kMostPlaneRounding, rounding_ * (std::abs(from_origin[0]) + std::abs(from_origin[1]) + std::abs(from_origin[2])));
  for (double& coordinate : row.barycentric)
    if (std::abs(coordinate) <= zero) coordinate = 0;
  row.beyond = static_cast<std::uint8_t>(not_positive(row.barycentric));
  row.strictly_beyond = static_cast<std::uint8_t>(negative(row.barycentric));
  rows_.push_back(row);
  add_differences(v, unrounded, fine, norm(from_origin));
}

/// `b`, `fine`: the barycentric coordinates of the vertex, the latter where the version takes twice the digits.
/// `length`: its distance from corner 0.
void VersionView::add_differences(std::uint32_t v, const std::array<double, 4>& b, std::array<DoubleDouble, 4> fine,
                                  double length) {
  const double b1 = b[1];
  const double b2 = b[2];
  const double b3 = b[3];
  const double* const at_v = values(v);
  const double* const at_origin = values(corners_[0]);
  const std::size_t begin = differences_.size();
  differences_.resize(begin + channels_);
  double* const differences = differences_.data() + begin;
  const double* const e1 = edges_.data();
  const double* const e2 = e1 + channels_;
  const double* const e3 = e2 + channels_;
  const auto shape_rounding = [&](double b_i, double per_length) {
    return shape_rounding_ * (length * per_length + std::abs(b_i));
  };
  const double r1 = shape_rounding(b1, per_length_[0]);
  const double r2 = shape_rounding(b2, per_length_[1]);
  const double r3 = shape_rounding(b3, per_length_[2]);
  bool has_fine = is_fine_;
  double sum = 0;
  for (std::size_t c = 0; c < channels_; ++c) {
    const double own = at_v[c] - at_origin[c];
    const double t1 = b1 * e1[c];
    const double t2 = b2 * e2[c];
    const double t3 = b3 * e3[c];
    double d = is_fine_ ? fine_difference_at(v, fine, c) : own - (t1 + t2 + t3);
    const double most = kValueRounding * (std::abs(own) + std::abs(t1) + std::abs(t2) + std::abs(t3));
    const double off = r1 * std::abs(e1[c]) + r2 * std::abs(e2[c]) + r3 * std::abs(e3[c]);
    if (std::abs(d) > most && std::abs(d) <= most + kMostOff * off) {
      if (!std::exchange(has_fine, true)) fine = fine_barycentric(v);
      d = fine_difference_at(v, fine, c);
    }
    differences[c] = std::abs(d) <= most ? 0 : d + std::copysign(kLeastDifference, d);
    sum += d;
  }
  is_finite_ &= std::isfinite(sum);
}

} // namespace ptet
