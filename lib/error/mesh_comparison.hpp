// Two tetrahedral meshes of about the same domain, each with its own piecewise linear fields: how far the fields are
// apart. Nothing is assumed of how one came from the other, and no adjacency is used: pairs of tets are found by boxes.
//
//      original tet O          O and S: a convex body, O cut by the four face planes of S into small tets. On each
//     ________________         the difference is linear: its norm is greatest at corners, and the integral of its
//     \      /S\     /         square is (|sum d_i|^2 + sum |d_i|^2) V / 20 over the corner differences d_i
//      \    /___\   /
//       \__________/           outside: points of O in no S; compared with the value at the closest point of the
//                              boundary of the simplified mesh
//
// The formula for the square of a linear function is that of the consistent mass matrix of linear tets (Zienkiewicz,
// The Finite Element Method, 8.8.2, volume coordinates).
#pragma once

#include "error/surface_distance.hpp"
#include "mesh/box_tree.hpp"
#include "mesh/predicates.hpp"
#include "ptet/mesh.hpp"
#include "ptet/progress.hpp"

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace ptet {

/// One of the two meshes. What the spans view must outlive the comparison.
struct ComparedMesh {
  std::span<const Point> points; ///< finite where tets use them
  std::span<const Tet> tets;     ///< ids in range; any orientation; flat ones (exact) have no interior and are skipped
  /// Vertex x channel, finite where tets use them. A field is one or more channels in a row; its difference is the
  /// Euclidean norm over them.
  std::span<const double> values;
};

struct FieldDifference {
  double max = 0;         ///< in the units of the field
  Point at{};             ///< where: the first place found with the greatest difference
  double mean_square = 0; ///< divided by the square of `scale`
  double scale = 1;       ///< a power of two; 1 unless squares of the field are nothing that a double holds

  [[nodiscard]] double rms() const { return scale * std::sqrt(mean_square); }
};

/// Over the part of the original's domain that the simplified mesh covers. Where tets overlap others of their own
/// mesh, every pair counts.
struct InsideDifference {
  double volume = 0;        ///< of the overlap; sampled: an estimate
  std::uint64_t points = 0; ///< sampled only: how many were compared
  std::vector<FieldDifference> fields;
  std::vector<double> cell_volume; ///< exact only; by original tet: the volume of its overlap
  std::vector<double> cell_max;    ///< exact only; original tet x field; NaN where there is no overlap
};

/// Over the rest of the original's domain.
struct OutsideDifference {
  double volume = 0;
  std::uint64_t vertices = 0, points = 0; ///< how many were compared
  /// How many more points were to be: in tets of which so little is outside that none was found there. What `points`
  /// are evenly spread over is less than `volume` by their share.
  std::uint64_t missed = 0;
  std::vector<FieldDifference> fields; ///< the maximum over both, the mean square over the points
};

struct VertexDifference {
  std::vector<double> max;   ///< original vertex x field; NaN for a vertex in no tet
  std::vector<char> outside; ///< by vertex: 1 when it is in a tet of the original and in none of the simplified mesh
};

class MeshComparison {
public:
  /// `components`: how many channels each field has, the same in both meshes. `simplified_boundary`: the boundary
  /// faces of the simplified mesh. Throws Error(kBadArgument) for values of other than vertices x channels.
  MeshComparison(const ComparedMesh& original, const ComparedMesh& simplified,
                 std::span<const Face> simplified_boundary, std::vector<std::uint32_t> components);

  /// Sums of the volumes of the tets, without regard to orientation.
  [[nodiscard]] double original_volume() const { return original_volume_; }
  [[nodiscard]] double simplified_volume() const { return simplified_volume_; }

  /// Exact to rounding: about 1e-11 of the values; overlaps narrower than 1e-12 of a tet's height do not count.
  /// Each function: throws Error(kCancelled); in parallel, same result on any number of threads.
  /// Cost: about 1 us for each pair of tets that meet.
  [[nodiscard]] InsideDifference exact_inside(const ProgressCallback& progress = {}) const;

  /// At `samples` points spread evenly over the volume of the original: those inside, and those outside. Same seed,
  /// same points.
  struct Sampled {
    InsideDifference inside;
    OutsideDifference outside;
  };
  [[nodiscard]] Sampled sampled(std::uint64_t samples, std::uint64_t seed, const ProgressCallback& progress = {}) const;

  /// At every vertex of the original that is in a tet: the greatest difference over the simplified tets that hold it
  /// (exact, boundaries included); outside, against the closest point.
  [[nodiscard]] VertexDifference at_vertices(const ProgressCallback& progress = {}) const;

  /// At about `samples` random points of the original outside the simplified mesh, evenly spread there: drawn in each
  /// original tet in proportion to what `inside` leaves of it; see OutsideDifference::missed. `overlaps_itself`: tets
  /// of the simplified mesh may overlap (also taken for so where a tet is covered by more than its volume); what is
  /// left of tets in which points are found that two tets hold is then an estimate. Adds no vertices.
  [[nodiscard]] OutsideDifference sampled_outside(const InsideDifference& inside, bool overlaps_itself,
                                                  std::uint64_t samples, std::uint64_t seed,
                                                  const ProgressCallback& progress = {}) const;

  /// Raises `outside` by the vertices that lie there.
  void add_vertices(const VertexDifference& vertices, OutsideDifference& outside) const;

private:
  class Clipper;
  class Sampler;
  [[nodiscard]] std::size_t channels() const { return channel_count_; }
  void scale_values();
  [[nodiscard]] std::vector<double> uncovered_volumes(const InsideDifference& inside, bool overlaps_itself,
                                                      std::uint64_t seed, const ProgressCallback& progress) const;
  void to_units(std::vector<FieldDifference>& fields) const;
  void to_units(std::vector<double>& by_field) const;

  ComparedMesh original_, simplified_;
  std::vector<std::uint32_t> components_;
  std::size_t channel_count_ = 0;
  std::vector<double> scale_;                               ///< by field, see FieldDifference
  std::vector<double> original_scaled_, simplified_scaled_; ///< the values over it, where it is not 1
  std::vector<int> original_sign_, simplified_sign_;        ///< exact orientation, by tet
  std::vector<char> simplified_sliver_; ///< by tet: 1 when it is so flat that it takes twice a double's digits
  std::vector<double> original_tet_volume_;
  double original_volume_ = 0, simplified_volume_ = 0;
  BoxTree simplified_tets_;
  std::vector<Face> boundary_;
  TriangleSurface boundary_surface_;
};

/// The number of pairs of boundary faces that have a point in common other than common vertices and edges; exact.
/// In parallel. Throws Error(kCancelled).
[[nodiscard]] std::uint64_t count_boundary_intersections(std::span<const Point> points, std::span<const Face> faces,
                                                         const ProgressCallback& progress = {});

} // namespace ptet
