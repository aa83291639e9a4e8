#include "mesh/examination.hpp"

#include "mesh/governing.hpp"
#include "mesh/large_pages.hpp"
#include "mesh/near_points.hpp"
#include "mesh/number_text.hpp"
#include "mesh/overlaps.hpp"
#include "mesh/scalar_dispatch.hpp"
#include "mesh/shape.hpp"
#include "mesh/vec3.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <tuple>
#include <utility>

namespace ptet {

namespace {

constexpr std::size_t kListedIds = 8;
/// Beyond this, sixth powers of lengths, which quadrics contain, overflow.
constexpr double kLargestCoordinate = 1e50;
/// Below this extent, sixth powers of lengths vanish.
constexpr double kSmallestExtent = 1e-50;
/// Below this product of the sides of the box, determinants of tets need not be told from 0.
constexpr double kSmallestBox = 1e-250;
constexpr double kNearFlatShape = 1e-6;
/// Points no farther apart are so by rounding rather than by shape, as a part of the shortest edge there: the first in
/// any case, up to the second where the coordinates' type is that coarse.
constexpr double kLeastOfEdge = 1e-6, kMostOfEdge = 1e-2;

/// What a check has met: how often, and the first few ids.
class Tally {
public:
  void add(std::uint64_t id) { add(std::array{id}); }
  void add(VertexId v) { add(std::uint64_t{v.index()}); }
  /// An edge or a face: counts once, listed by its vertices.
  template <std::size_t N>
  void add(const std::array<VertexId, N>& vertices) {
    std::array<std::uint64_t, N> ids{};
    std::transform(vertices.begin(), vertices.end(), ids.begin(), [](VertexId v) { return v.index(); });
    add(ids);
  }
  template <std::size_t N>
  void add(const std::array<std::uint64_t, N>& ids) {
    ++count_;
    if (first_ids_.size() + N > kListedIds) return;
    for (std::size_t i = 0; i < N; ++i)
      list_ += (i > 0 ? "-" : first_ids_.empty() ? "" : ", ") + std::to_string(ids[i]);
    first_ids_.insert(first_ids_.end(), ids.begin(), ids.end());
    ++listed_;
  }

  [[nodiscard]] std::uint64_t count() const { return count_; }

  /// "3 <many> (0, 4, 5): <then>"
  [[nodiscard]] Finding finding(const char* code, Severity severity, const std::string& one, const std::string& many,
                                const std::string& then) const {
    return {code, severity, count_,
            std::to_string(count_) + " " + (count_ == 1 ? one : many) + " (" + list_ +
                (listed_ < count_ ? ", ...): " : "): ") + then,
            first_ids_};
  }

private:
  std::uint64_t count_ = 0, listed_ = 0;
  std::vector<std::uint64_t> first_ids_;
  std::string list_;
};

/// A power of ten that is no less, "1e-16"; also for 0, which tiny differences have as their length.
std::string brief_power(double x) {
  const double least = std::max(x, std::numeric_limits<double>::min());
  return "1e" + std::to_string(static_cast<int>(std::ceil(std::log10(least))));
}

class Examiner {
public:
  Examiner(const TetMesh& mesh, const ProgressCallback& progress) : mesh_(mesh), progress_(progress) {}

  Examination run() {
    check_limits();
    if (!read_points()) return std::move(out_);
    enter("checking points");
    check_points();
    enter("checking tets");
    select_sound_tets();
    orient_tets();
    enter("checking faces");
    link_faces();
    order_flat_tets();
    check_faces();
    check_overlaps();
    enter("checking vertices");
    check_links();
    check_unused_points();
    check_coincident_points();
    check_near_points();
    enter("checking fields");
    check_arrays();
    return std::move(out_);
  }

private:
  void enter(const char* stage) {
    stage_ = stage;
    look();
    ++stages_;
  }
  /// Asks whether to go on with the stage.
  void look() const {
    if (progress_ && !progress_({stage_, stages_, 5})) throw Error(ErrorCode::kCancelled, "cancelled");
  }

  void report(const Tally& tally, const char* code, Severity severity, const std::string& one, const std::string& many,
              const std::string& then) {
    if (tally.count() > 0) out_.findings.push_back(tally.finding(code, severity, one, many, then));
  }
  void report_defect(const char* code, std::string message) {
    out_.findings.push_back({code, Severity::kError, 1, std::move(message), {}});
  }

  void check_limits() const {
    if (mesh_.tets.size() > kMaxTets)
      throw Error(ErrorCode::kLimit, "the mesh has " + std::to_string(mesh_.tets.size()) + " tets, the limit is " +
                                         std::to_string(kMaxTets));
    if (mesh_.vertex_count() > kDummyVertex.index())
      throw Error(ErrorCode::kLimit, "the mesh has " + std::to_string(mesh_.vertex_count()) +
                                         " vertices, the limit is " + std::to_string(kDummyVertex.index()));
  }

  bool read_points() {
    const PointArray& positions = mesh_.positions;
    if (positions.components != 3 || positions.bytes.size() % positions.row_bytes() != 0) {
      report_defect("bad-positions", "the positions are not rows of 3 numbers: ptet cannot build from this mesh");
      return false;
    }
    out_.points.resize(mesh_.vertex_count());
    dispatch(positions.type, [&]<class T>(T) {
      const std::byte* from = positions.bytes.data();
      for (Point& p : out_.points)
        for (double& x : p) {
          x = static_cast<double>(load<T>(from));
          from += sizeof(T);
        }
    });
    return true;
  }

  void mark_referenced() {
    referenced_.resize(out_.points.size());
    for (const Tet& tet : mesh_.tets)
      for (const VertexId v : tet)
        if (v.index() < referenced_.size()) referenced_[v.index()] = 1;
  }

  /// The sides of the bounding box of the points in tets.
  [[nodiscard]] std::array<double, 3> extent() const {
    std::array<double, 3> sides{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double low = std::numeric_limits<double>::infinity(), high = -low;
      for (std::size_t v = 0; v < out_.points.size(); ++v) {
        if (!referenced_[v]) continue;
        low = std::min(low, out_.points[v][axis]);
        high = std::max(high, out_.points[v][axis]);
      }
      sides[axis] = std::max(0.0, high - low);
    }
    return sides;
  }

  void check_extent() {
    const std::array<double, 3> sides = extent();
    const double largest = *std::max_element(sides.begin(), sides.end());
    if (largest < kSmallestExtent) {
      report_defect("tiny-extent",
                    largest == 0 ? "all vertices of tets lie in one point: ptet cannot compute with that; where they "
                                   "should not, the coordinates' type is too coarse for their offset"
                                 : "the mesh's extent is below 1e-50 along every axis: ptet cannot "
                                   "compute with it, choose a smaller unit of length");
      return;
    }
    // A mesh in a plane of two axes has flat tets only, and no volumes to compute.
    const bool has_volume = std::all_of(sides.begin(), sides.end(), [](double side) { return side > 0; });
    if (has_volume && sides[0] * sides[1] * sides[2] < kSmallestBox)
      report_defect("tiny-extent", "the sides of the mesh's bounding box have a product below 1e-250: ptet cannot "
                                   "compute volumes in it, choose a smaller unit of length");
  }

  void check_points() {
    unsound_point_.resize(out_.points.size());
    mark_referenced();
    Tally infinite, large;
    for (std::size_t v = 0; v < out_.points.size(); ++v) {
      const Point& p = out_.points[v];
      if (!is_finite(p)) {
        infinite.add(v);
      } else if (!std::all_of(p.begin(), p.end(), [](double x) { return std::abs(x) <= kLargestCoordinate; })) {
        large.add(v);
      } else {
        continue;
      }
      unsound_point_[v] = 1;
    }
    if (infinite.count() == 0 && large.count() == 0 && !mesh_.tets.empty() && !out_.points.empty()) check_extent();
    report(infinite, "non-finite-positions", Severity::kError, "vertex whose position is not finite",
           "vertices whose positions are not finite", "ptet cannot build from this mesh");
    report(large, "huge-positions", Severity::kError, "vertex with a coordinate beyond 1e50",
           "vertices with coordinates beyond 1e50", "ptet cannot compute with it, choose a larger unit of length");
  }

  void select_sound_tets() {
    if (mesh_.tets.empty()) report_defect("no-tets", "the mesh has no tets: there is nothing to build from");
    reserve_large(out_.tets, mesh_.tets.size());
    reserve_large(tet_ids_, mesh_.tets.size());
    Tally out_of_range, repeated;
    for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
      const Tet& tet = mesh_.tets[t];
      const auto in_range = [&](VertexId v) { return v.index() < out_.points.size(); };
      if (!std::all_of(tet.begin(), tet.end(), in_range)) {
        out_of_range.add(t);
      } else if (tet[0] == tet[1] || tet[0] == tet[2] || tet[0] == tet[3] || tet[1] == tet[2] || tet[1] == tet[3] ||
                 tet[2] == tet[3]) {
        repeated.add(t);
      } else if (std::none_of(tet.begin(), tet.end(), [&](VertexId v) { return unsound_point_[v.index()]; })) {
        out_.tets.push_back(tet);
        tet_ids_.push_back(static_cast<std::uint32_t>(t));
      }
    }
    report(out_of_range, "ids-out-of-range", Severity::kError, "tet with a vertex id that names no vertex",
           "tets with vertex ids that name no vertex",
           "the mesh has " + std::to_string(out_.points.size()) + " vertices, ptet cannot build from it");
    report(repeated, "repeated-vertices", Severity::kError, "tet with the same vertex twice",
           "tets with the same vertex twice", "ptet cannot build from this mesh, remove them first");
  }

  void orient_tets() {
    is_flat_.resize(out_.tets.size());
    Tally inverted, flat, near_flat;
    for (std::size_t t = 0; t < out_.tets.size(); ++t) {
      Tet& tet = out_.tets[t];
      const Point &a = out_.points[tet[0].index()], &b = out_.points[tet[1].index()], &c = out_.points[tet[2].index()],
                  &d = out_.points[tet[3].index()];
      const int sign = orientation(a, b, c, d);
      if (sign == 0) {
        flat.add(tet_ids_[t]);
        is_flat_[t] = 1;
        continue;
      }
      if (std::abs(shape_quality(a, b, c, d)) < kNearFlatShape) near_flat.add(tet_ids_[t]);
      if (sign > 0) continue;
      inverted.add(tet_ids_[t]);
      std::swap(tet[2], tet[3]);
    }
    const bool other_convention = inverted.count() > 0 && inverted.count() + flat.count() == out_.tets.size();
    if (other_convention) {
      report(inverted, "inverted-tets", Severity::kNote, "inverted tet", "inverted tets",
             "that is all of them, the mesh orders vertices by the other convention; two vertices of each are swapped");
    } else {
      report(inverted, "inverted-tets", Severity::kWarning, "inverted tet", "inverted tets",
             "two vertices of each are swapped");
    }
    report(flat, "flat-tets", Severity::kWarning, "flat tet", "flat tets", "kept, they may never get worse");
    report(near_flat, "near-flat-tets", Severity::kNote, "nearly flat tet", "nearly flat tets",
           "kept, they may never get worse");
  }

  void link_faces() {
    out_.faces = build_face_table(out_.tets, out_.points.size());
    has_duplicates_ = !out_.faces.duplicates.empty();
    if (!has_duplicates_) return;
    Tally duplicates;
    std::size_t kept = 0, next = 0;
    for (std::size_t t = 0; t < out_.tets.size(); ++t) {
      if (next < out_.faces.duplicates.size() && out_.faces.duplicates[next].index() == t) {
        duplicates.add(tet_ids_[t]);
        ++next;
        continue;
      }
      out_.tets[kept] = out_.tets[t];
      is_flat_[kept] = is_flat_[t];
      tet_ids_[kept++] = tet_ids_[t];
    }
    out_.tets.resize(kept);
    is_flat_.resize(kept);
    tet_ids_.resize(kept);
    report(duplicates, "duplicate-tets", Severity::kError, "tet on the same vertices as an earlier one",
           "tets on the same vertices as earlier ones", "ptet cannot build from this mesh, remove them first");
    out_.faces = build_face_table(out_.tets, out_.points.size());
  }

  /// Positions cannot orient a flat tet, but its neighbours can: they should see their common face from opposite
  /// sides. From the tets with volume inwards, each flat tet goes by the majority of those settled before it.
  void order_flat_tets() {
    std::vector<char> settled(is_flat_.size()), flipped(is_flat_.size());
    std::vector<std::uint32_t> queue;
    const auto each_neighbour = [&](std::uint32_t t, auto&& visit) {
      for (HalfFace h = 4 * t; h < 4 * t + 4; ++h)
        if (out_.faces.is_interior(h)) visit(h, out_.faces.mate[h] / 4);
    };
    const auto enqueue = [&](std::uint32_t t) {
      if (!is_flat_[t] || settled[t]) return;
      settled[t] = 1;
      queue.push_back(t);
    };
    for (std::uint32_t t = 0; t < is_flat_.size(); ++t) {
      bool beside_volume = false;
      if (is_flat_[t]) each_neighbour(t, [&](HalfFace, std::uint32_t other) { beside_volume |= !is_flat_[other]; });
      if (beside_volume) enqueue(t);
    }
    std::vector<char> voted(is_flat_.size());
    bool changed = false;
    for (std::size_t i = 0; i < queue.size(); ++i) {
      const std::uint32_t t = queue[i];
      int agreement = 0;
      each_neighbour(t, [&](HalfFace h, std::uint32_t other) {
        if (!is_flat_[other] || voted[other])
          agreement += is_folded(out_.tets, out_.faces, h) != (flipped[other] != 0) ? -1 : 1;
        enqueue(other);
      });
      voted[t] = 1;
      flipped[t] = agreement < 0;
      changed |= agreement < 0;
    }
    if (!changed) return;
    for (std::size_t t = 0; t < is_flat_.size(); ++t)
      if (flipped[t]) std::swap(out_.tets[t][2], out_.tets[t][3]);
    out_.faces = build_face_table(out_.tets, out_.points.size());
  }

  void check_faces() {
    Tally crowded, folded;
    for (const HalfFace h : out_.faces.crowded)
      crowded.add(sorted(face_of(out_.tets, h)));
    for (HalfFace h = 0; h < out_.faces.mate.size(); ++h) {
      if (out_.faces.mate[h] <= h || !out_.faces.is_interior(h) || !is_folded(out_.tets, out_.faces, h)) continue;
      folded.add(sorted(face_of(out_.tets, h)));
      out_.folded.push_back(h);
    }
    report(crowded, "faces-of-many-tets", Severity::kError, "face of more than two tets", "faces of more than two tets",
           "ptet cannot build from this mesh");
    report(folded, "folded-faces", Severity::kWarning, "face with both its tets on the same side",
           "faces with both their tets on the same side",
           "the vertices of these tets are frozen, and errors there are those of each sheet by itself");
    out_.boundary = build_boundary(out_.tets, out_.faces, out_.points.size());
    Tally edges;
    for (const auto& edge : out_.boundary.non_manifold_edges)
      edges.add(edge);
    report(edges, "non-manifold-edges", Severity::kWarning, "boundary edge that is not in exactly two boundary faces",
           "boundary edges that are not in exactly two boundary faces", "their vertices are frozen");
  }

  /// Where tets lie in tets of other parts: looked for along the boundary, where there is one that tells inside.
  void check_overlaps() {
    out_.overlaps_itself = !out_.folded.empty();
    if (!out_.folded.empty() || !out_.faces.crowded.empty() || has_duplicates_) return;
    out_.overlaps_examined = true;
    Overlaps found = find_overlaps(out_.points, out_.tets, out_.boundary, rounding(), [this] { look(); });
    const char* const then = "parts of the mesh overlap, and errors there are those of each part by itself";
    Tally crossing, within;
    for (const auto& pair : found.crossing)
      crossing.add(std::array<std::uint64_t, 2>{tet_ids_[pair[0] / 4], tet_ids_[pair[1] / 4]});
    for (const std::uint32_t t : found.within)
      within.add(std::uint64_t{tet_ids_[t]});
    report(crossing, "crossing-boundary-faces", Severity::kWarning, "pair of boundary faces that cross, by their tets",
           "pairs of boundary faces that cross, by their tets", then);
    report(within, "overlapping-tets", Severity::kWarning, "tet at the boundary that others reach into",
           "tets at the boundary that others reach into", then);
    Tally hanging;
    for (const VertexId v : found.hanging)
      hanging.add(v);
    report(hanging, "hanging-vertices", Severity::kWarning,
           "boundary vertex that lies on a face or edge without being a corner of it",
           "boundary vertices that lie on faces or edges without being corners of these",
           "cells do not meet there face to face, as at a step of refinement: they are not joined, and each side is a "
           "boundary with errors of its own; where they should be joined, split the larger cells at these vertices");
    out_.overlaps_itself = !found.crossing.empty() || !found.within.empty();
    out_.crossing = std::move(found.crossing);
  }

  /// Of coordinates as they are stored, twice over: middles of edges, for one, are computed.
  [[nodiscard]] double rounding() const { return mesh_.positions.type == ScalarType::kFloat32 ? 0x1p-23 : 0x1p-50; }

  /// The same, but of float32 where coordinates were that before they were stored as float64.
  [[nodiscard]] double rounding_of_coordinates() const {
    const bool are_floats = std::all_of(out_.points.begin(), out_.points.end(), [](const Point& p) {
      return std::all_of(p.begin(), p.end(), [](double x) {
        return !(std::abs(x) < 1e38) || static_cast<double>(static_cast<float>(x)) == x;
      });
    });
    return are_floats ? 0x1p-23 : rounding();
  }

  static Face sorted(Face face) {
    std::sort(face.begin(), face.end());
    return face;
  }

  void check_links() {
    out_.links = examine_links(out_.tets, out_.faces, out_.boundary, out_.points.size());
    Tally pinched;
    for (const VertexId v : out_.links.non_manifold)
      pinched.add(v);
    report(pinched, "non-manifold-vertices", Severity::kWarning, "vertex where the mesh is no manifold",
           "vertices where the mesh is no manifold", "frozen");
  }

  void check_unused_points() {
    Tally unused;
    for (std::size_t v = 0; v < referenced_.size(); ++v)
      if (!referenced_[v]) unused.add(v);
    report(unused, "unused-points", Severity::kNote, "vertex in no tet", "vertices in no tet",
           "kept with the original mesh");
  }

  void check_coincident_points() {
    std::vector<std::pair<Point, std::uint32_t>> used;
    used.reserve(out_.links.used_count);
    for (std::uint32_t v = 0; v < out_.points.size(); ++v)
      if (out_.links.used[v]) used.emplace_back(out_.points[v], v);
    std::sort(used.begin(), used.end());
    std::vector<std::uint32_t> repeats;
    for (std::size_t i = 1; i < used.size(); ++i)
      if (used[i].first == used[i - 1].first) repeats.push_back(used[i].second);
    std::sort(repeats.begin(), repeats.end());
    Tally coincident;
    for (const std::uint32_t v : repeats)
      coincident.add(std::uint64_t{v});
    report(coincident, "coincident-points", Severity::kWarning, "vertex at the place of an earlier one",
           "vertices at the places of earlier ones",
           "kept apart; ptet build --weld makes one of those with the same values that no tet has two of");
  }

  /// Of the boundary's: those so near to another that rounding has set them apart, going by the edges there.
  void check_near_points() {
    using namespace vec;
    std::vector<double> shortest(out_.points.size(), std::numeric_limits<double>::infinity());
    for (const Face& face : out_.boundary.faces)
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t a = face[i].index(), b = face[(i + 1) % 3].index();
        const double length = norm(out_.points[a] - out_.points[b]);
        shortest[a] = std::min(shortest[a], length);
        shortest[b] = std::min(shortest[b], length);
      }
    // One for each place, of the shortest edge there.
    std::vector<std::uint32_t> vertices;
    for (std::uint32_t v = 0; v < out_.points.size(); ++v)
      if (std::isfinite(shortest[v])) vertices.push_back(v);
    std::sort(vertices.begin(), vertices.end(), [&](std::uint32_t a, std::uint32_t b) {
      return std::tie(out_.points[a], shortest[a], a) < std::tie(out_.points[b], shortest[b], b);
    });
    vertices.erase(std::unique(vertices.begin(), vertices.end(),
                               [&](std::uint32_t a, std::uint32_t b) { return out_.points[a] == out_.points[b]; }),
                   vertices.end());
    std::vector<Point> points;
    std::vector<double> distances;
    const double last_place = 2 * rounding_of_coordinates();
    for (const std::uint32_t v : vertices) {
      const Point& p = points.emplace_back(out_.points[v]);
      const double rounded = last_place * std::max({std::abs(p[0]), std::abs(p[1]), std::abs(p[2])});
      distances.push_back(std::clamp(rounded, kLeastOfEdge * shortest[v], kMostOfEdge * shortest[v]));
    }
    const NearPoints all(std::move(points));
    double farthest = 0;
    std::vector<std::uint32_t> near;
    for (std::uint32_t i = 0; i < all.size(); ++i) {
      const auto distance =
          all.any_after(i, distances[i], [&](std::uint32_t j, double away) { return away <= distances[j]; });
      if (!distance) continue;
      farthest = std::max(farthest, *distance);
      near.push_back(vertices[i]);
    }
    if (near.empty()) return;
    std::sort(near.begin(), near.end());
    Tally tally;
    for (const std::uint32_t v : near)
      tally.add(std::uint64_t{v});
    report(tally, "near-points", Severity::kNote, "boundary vertex that is hardly apart from another",
           "boundary vertices that are hardly apart from others",
           "by up to " + brief_power(farthest) +
               ", and kept so; where parts of the mesh were computed one by one and should meet, ptet build "
               "--weld-within makes one of those with values as near");
  }

  void check_arrays() {
    for (const PointArray& array : mesh_.point_arrays) {
      if (array.components == 0 || array.bytes.size() != out_.points.size() * array.row_bytes()) {
        report_defect("bad-array", "the point array '" + array.name + "' has not one row for each of the " +
                                       std::to_string(out_.points.size()) +
                                       " vertices: ptet cannot build from this mesh");
        continue;
      }
      report(non_finite_rows(array), "non-finite-values", Severity::kWarning,
             "vertex where '" + array.name + "' is not finite", "vertices where '" + array.name + "' is not finite",
             "the values are kept, but errors of this field cannot be measured");
      if (!std::isfinite(range_of(array, out_.links.used)))
        out_.findings.push_back({"too-wide-values",
                                 Severity::kWarning,
                                 1,
                                 "the values of '" + array.name +
                                     "' range over more than can be measured: the values are kept, but errors of this "
                                     "field cannot be measured",
                                 {}});
    }
  }

  Tally non_finite_rows(const PointArray& array) const {
    Tally rows;
    dispatch(array.type, [&]<class T>(T) {
      if constexpr (std::is_floating_point_v<T>) {
        for (std::size_t v = 0; v < out_.points.size(); ++v) {
          const std::byte* row = array.bytes.data() + v * array.row_bytes();
          bool finite = true;
          for (std::size_t i = 0; i < array.components; ++i)
            finite &= std::isfinite(load<T>(row + i * sizeof(T)));
          if (!finite && out_.links.used[v]) rows.add(v);
        }
      }
    });
    return rows;
  }

  const TetMesh& mesh_;
  const ProgressCallback& progress_;
  const char* stage_ = "";
  std::uint64_t stages_ = 0; ///< begun so far
  Examination out_;
  std::vector<char> unsound_point_, referenced_, is_flat_;
  bool has_duplicates_ = false;        ///< there were tets twice; they are taken out
  std::vector<std::uint32_t> tet_ids_; ///< of each sound tet
};

} // namespace

Examination examine(const TetMesh& mesh, const ProgressCallback& progress) {
  return Examiner(mesh, progress).run();
}

} // namespace ptet
