#include "error/mesh_comparison.hpp"

#include "error/comparison_parts.hpp"
#include "error/double_double.hpp"
#include "error/power_of_two.hpp"
#include "error/tet_overlap.hpp"
#include "error/tolerances.hpp"
#include "mesh/face_plane.hpp"

#include <cmath>
#include <limits>
#include <numeric>

#include <tbb/enumerable_thread_specific.h>

namespace ptet {
using namespace vec;
using namespace comparison;

namespace {

/// Tets with a height below this share of their longest edge are compared in numbers of twice a double's digits.
constexpr double kSliver = 1e-5;

int sign_of(const std::array<Point, 4>& tet) {
  return orientation(tet[0], tet[1], tet[2], tet[3]);
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
  return 3 * tet_volume(tet) / (largest_face * longest);
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
      const bool fine = sliver || of_.simplified_sliver_[simplified] != 0;
      const bool overlap =
          fine ? clip(Frame<DoubleDouble>(corners), corners, others, fine_) : clip(frame, corners, others, plain_);
      if (!overlap) return;
      if (fine) {
        evaluate(fine_, original, simplified, sum, cell_max, cell_volume);
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
    rounding_.assign(channels, 0);
    for (std::size_t i = 0; i < 8 * channels; ++i)
      rounding_[i % channels] = std::max(rounding_[i % channels], kValueRounding * std::abs(values_[i]));
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
        const auto rounded = static_cast<double>(d);
        const double difference = std::abs(rounded) <= rounding_[channel] ? 0 : rounded;
        difference_[id * channels + channel] = difference;
        square += difference * difference;
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
  Overlap<DoubleDouble> fine_;
  std::vector<double> values_, difference_;
  std::vector<double> rounding_; ///< by channel: differences up to this are rounding
  std::vector<char> known_;
};

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
  scale_values();
  original_tet_volume_.resize(original.tets.size());
  for (std::size_t t = 0; t < original.tets.size(); ++t) {
    original_tet_volume_[t] = original_sign_[t] == 0 ? 0 : tet_volume(corners_of(original, t));
    original_volume_ += original_tet_volume_[t];
  }
  simplified_sliver_.resize(simplified.tets.size());
  for (std::size_t t = 0; t < simplified.tets.size(); ++t) {
    if (simplified_sign_[t] == 0) continue;
    const std::array<Point, 4> corners = corners_of(simplified, t);
    simplified_volume_ += tet_volume(corners);
    simplified_sliver_[t] = !(flatness_of(corners) > kSliver);
  }
}

/// Divides the values of fields whose squares would be 0 or infinite by a power of two. Those of points that are in no
/// tet say nothing of the field, and may be anything.
void MeshComparison::scale_values() {
  constexpr double kLeastHarmless = 0x1p-150, kMostHarmless = 0x1p150; // squares are multiplied by volumes, too
  scale_.assign(components_.size(), 1);
  std::vector<double> by_channel;
  std::size_t channel = 0;
  for (std::size_t f = 0; f < components_.size(); ++f) {
    double most = 0;
    for (const ComparedMesh* const mesh : {&original_, &simplified_})
      for (const Tet& tet : mesh->tets)
        for (const VertexId v : tet)
          for (std::size_t c = channel; c < channel + components_[f]; ++c)
            if (const double value = mesh->values[v.index() * channel_count_ + c]; std::isfinite(value))
              most = std::max(most, std::abs(value));
    const double unit = most > 0 ? power_of_two_below(most) : 1;
    if (unit < kLeastHarmless || unit > kMostHarmless) scale_[f] = unit;
    by_channel.insert(by_channel.end(), components_[f], scale_[f]);
    channel += components_[f];
  }
  if (std::count(scale_.begin(), scale_.end(), 1.0) == static_cast<std::ptrdiff_t>(scale_.size())) return;
  const auto scaled = [&](std::span<const double>& values, std::vector<double>& into) {
    into.assign(values.begin(), values.end());
    for (std::size_t i = 0; i < into.size(); ++i)
      into[i] /= by_channel[i % channel_count_];
    values = into;
  };
  scaled(original_.values, original_scaled_);
  scaled(simplified_.values, simplified_scaled_);
}

void MeshComparison::to_units(std::vector<FieldDifference>& fields) const {
  for (std::size_t f = 0; f < fields.size(); ++f) {
    fields[f].max *= scale_[f];
    fields[f].scale = scale_[f];
  }
}

void MeshComparison::to_units(std::vector<double>& by_field) const {
  for (std::size_t i = 0; i < by_field.size(); ++i)
    by_field[i] *= scale_[i % scale_.size()];
}

InsideDifference MeshComparison::exact_inside(const ProgressCallback& progress) const {
  const std::size_t tets = original_.tets.size(), fields = components_.size();
  InsideDifference result;
  result.fields.resize(fields);
  result.cell_volume.assign(tets, 0);
  result.cell_max.assign(tets * fields, std::numeric_limits<double>::quiet_NaN());
  tbb::enumerable_thread_specific<Clipper> clippers([this] { return Clipper(*this); });
  using Part = std::vector<FieldDifference>;
  const auto compare = [&](Part& part, std::size_t begin, std::size_t end) {
    Clipper& clipper = clippers.local();
    for (std::size_t t = begin; t < end; ++t)
      clipper.compare(static_cast<std::uint32_t>(t), part, result.cell_max.data() + t * fields, result.cell_volume[t]);
  };
  for_each_part(tets, "comparing fields", progress, Part(fields), compare,
                [&](const Part& part) { add(part, result.fields); });
  result.volume = std::accumulate(result.cell_volume.begin(), result.cell_volume.end(), 0.0);
  divide(result.fields, result.volume);
  to_units(result.fields);
  to_units(result.cell_max);
  return result;
}

std::uint64_t count_boundary_intersections(std::span<const Point> points, std::span<const Face> faces,
                                           const ProgressCallback& progress) {
  const std::vector<Triangle> triangles = triangles_of(points, faces);
  std::vector<BoundingBox> boxes(triangles.size());
  std::transform(triangles.begin(), triangles.end(), boxes.begin(), [](const Triangle& t) { return box_of(t); });
  const BoxTree tree(boxes);
  const auto count = [&](std::uint64_t& pairs, std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      const FacePlane plane(faces[f], points);
      tree.each_meeting(boxes[f], static_cast<std::uint32_t>(f) + 1, [&](std::uint32_t other) {
        if (!plane.surely_misses(faces[other], points) && faces_meet_improperly(faces[f], faces[other], points))
          ++pairs;
      });
    }
  };
  std::uint64_t all = 0;
  for_each_part(faces.size(), "checking the boundary", progress, std::uint64_t{0}, count,
                [&](std::uint64_t pairs) { all += pairs; });
  return all;
}

} // namespace ptet
