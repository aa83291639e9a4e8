// The vertices of the original as one version sees them: barycentric coordinates in it, on which side of its planes
// they lie, and the difference of the value there and what the version's linear field would be.
//
// Each vertex is looked at once. A version so flat, or with so short an edge, that rounding would tell in its
// barycentric coordinates is seen in numbers of twice a double's digits.
//
// A common offset of the values is taken out before anything is interpolated, and a difference that rounding of the
// values may have made is none (tolerances.hpp); where that of the coordinates may have made it, it is taken again with
// twice the digits. The corners of the version are taken in an order that depends on their places only, so that the
// same tet, however numbered, is measured from the same differences.
#pragma once

#include "error/double_double.hpp"
#include "mesh/box_tree.hpp"
#include "mesh/vec3.hpp"
#include "ptet/mesh.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace ptet {

struct OriginalCells;

/// What one thread needs for it; reusable, for one version after the other.
class VersionView {
public:
  using Corners = std::array<std::uint32_t, 4>;
  enum class Shape : std::uint8_t {
    kFlat,   ///< exactly: there is no interior, and nothing to be seen
    kUntold, ///< so flat that even twice the digits do not tell its volume from none
    kSolid,
  };
  struct Row {
    std::array<double, 4> barycentric;
    std::uint8_t beyond = 0; ///< bits: the planes of the version that it lies on the outer side of, or on
    std::uint8_t strictly_beyond = 0;
  };

  /// `original` must outlive the object.
  explicit VersionView(const OriginalCells& original);

  /// Looks at another version. Of one that is not solid only the corners are known.
  Shape begin(const Tet& version);
  /// In the order of their places, but for the last two where that would turn the version round.
  [[nodiscard]] const Corners& corners() const { return corners_; }
  /// Whether it takes twice the digits.
  [[nodiscard]] bool is_fine() const { return is_fine_; }
  /// Of its edges: six times its volume.
  [[nodiscard]] double determinant() const { return determinant_; }
  /// Of one that is untold: the most that its volume may be.
  [[nodiscard]] double most_volume() const { return most_volume_; }

  /// Whether one plane of the version has all of the box on its outer side, further from it than rounding reaches:
  /// then it is so for the rows of all vertices in the box.
  [[nodiscard]] bool is_beyond(const BoundingBox& box) const;

  /// The row of a vertex, in the order of looking at them; the corners are the first.
  std::uint32_t look_at(std::uint32_t v) {
    Mark& mark = marks_[v];
    if (mark.stamp != stamp_) {
      mark = {stamp_, static_cast<std::uint32_t>(rows_.size())};
      add_row(v);
    }
    return mark.row;
  }
  [[nodiscard]] const Row& row(std::uint32_t row) const { return rows_[row]; }
  /// By channel.
  [[nodiscard]] const double* difference(std::uint32_t row) const { return &differences_[row * channels_]; }
  [[nodiscard]] const double* values(std::uint32_t v) const { return values_ + v * channels_; }
  /// False once a difference could not be computed.
  [[nodiscard]] bool is_finite() const { return is_finite_; }

private:
  struct Mark {
    std::uint32_t stamp = 0;
    std::uint32_t row = 0;
  };

  [[nodiscard]] Corners by_place(const Tet& version) const;
  Shape begin_finely(double lengths);
  DoubleDouble find_fine_planes();
  void clear();
  void add_corners();
  void add_row(std::uint32_t v);
  void add_differences(std::uint32_t v, const std::array<double, 4>& b, std::array<DoubleDouble, 4> fine,
                       double length);
  [[nodiscard]] std::array<DoubleDouble, 4> fine_barycentric(std::uint32_t v);
  [[nodiscard]] double fine_difference_at(std::uint32_t v, const std::array<DoubleDouble, 4>& b, std::size_t c) const;

  const OriginalCells* original_;
  const double* values_; ///< vertex x channel
  std::size_t channels_;
  std::vector<Mark> marks_; ///< by vertex: its row, where the stamp is that of the version
  std::uint32_t stamp_ = 0;

  Corners corners_{};
  Point origin_{}; ///< the place of corner 0
  bool is_fine_ = false;
  double determinant_ = 0;
  double most_volume_ = 0;
  std::array<Vec3, 3> plane_{};          ///< barycentric coordinates 1 to 3 of p: plane . (p - origin)
  std::array<FineVec3, 3> fine_plane_{}; ///< in its place where the version, or a difference, takes twice the digits
  bool has_fine_planes_ = false;
  double plane_rounding_ = 0; ///< of plane_, for each unit of |p - origin|
  double rounding_ = 0;       ///< the same of the planes that rows are made with
  double shape_rounding_ = 0;
  Vec3 per_length_{};         ///< of the edges from corner 0
  std::vector<double> edges_; ///< edge from corner 0 x channel: the difference of the values

  std::vector<Row> rows_;
  std::vector<double> differences_; ///< row x channel
  bool is_finite_ = true;
};

} // namespace ptet
