// The record stream: what the builder hands to the writer, and nothing of how it was found.
//
//   versions   0 .. original-1           the input: tets first, then one ghost tet for each boundary face
//              original .. count-1       made by collapses, in the order of the collapses
//   records    in collapse order (fine to coarse); record i consumed the fine versions F(i) and made the coarse
//              versions C(i):
//
//        F(i) = modified_0 .. modified_{m-1}, deleted_0 .. deleted_{d-1}     (the star of the removed vertex)
//                  |               |
//        C(i) = coarse_0   ..  coarse_{m-1}                                  (vertex replaced by target)
//
// Ghosts (a, b, c, kDummyVertex) stand in these lists like any other tet: they are the boundary faces.
#pragma once

#include "ptet/ids.hpp"
#include "ptet/mesh.hpp"

#include <algorithm>
#include <span>
#include <string>
#include <vector>

namespace ptet {

/// A field whose errors the records carry.
struct GoverningField {
  std::uint32_t array = 0; ///< index into TetMesh::point_arrays
  double range = 0;        ///< largest minus least value; for vectors the diagonal of the box of values
};

struct RecordStream {
  std::vector<GoverningField> fields;
  double diagonal = 0; ///< of the bounding box of the used vertices
  double volume = 0;   ///< of the original mesh

  // Versions.
  std::uint32_t original_tet_count = 0;
  std::uint32_t original_ghost_count = 0;
  /// Four vertices each; real tets positively oriented, ghosts oriented like the tets (so a ghost's face, seen from
  /// the dummy, is the boundary face seen from outside).
  std::vector<Tet> versions;

  // Records, in collapse order.
  std::vector<VertexId> removed;
  std::vector<VertexId> target;
  /// Non-decreasing. Records of one round do not depend on one another.
  std::vector<std::uint32_t> round;
  /// size()+1 offsets into `fine`.
  std::vector<std::uint64_t> fine_begin{0};
  /// Versions consumed: modified ones first.
  std::vector<VersionId> fine;
  std::vector<std::uint16_t> modified_count;
  /// First version of C(i); C(i)[m] comes from F(i)[m].
  std::vector<VersionId> coarse_begin;
  /// size() x fields.size(): largest field error over C(i), in field units. Where errors are measured everywhere, over
  /// what C(i) covers of the original's domain; otherwise all that was looked at.
  std::vector<double> field_error;
  /// Likewise at removed vertices that C(i) does not cover, each against the closest point of a tet of C(i). Empty
  /// where field_error has them.
  std::vector<double> outside_error;
  /// Largest domain error over the boundary faces in C(i), in mesh units; 0 where no boundary face moved. A bound on
  /// the distance to a face from all of the original boundary that it stands for, and back from any of its points.
  std::vector<double> domain_error;
  /// size() x fields.size(): by how much the collapse raised the integral of |Phi - phi|^2 over the domain, in field
  /// units squared times mesh units cubed, or of a field whose squares a double does not hold (holds_squares()) in
  /// squares of its range times mesh units cubed; may be negative. The integral of a cut is the sum over the records
  /// whose splits it has not applied. Empty when it was not measured.
  std::vector<double> squared_error;
  /// By how much the collapse raised the volume of that part of the domain which the mesh does not cover, in mesh units
  /// cubed: 0 where no boundary face moved; may be negative. Summed up over a cut as squared_error is, and empty when
  /// that was not measured.
  std::vector<double> uncovered_volume;
  /// size()+1 offsets into `also_needs`.
  std::vector<std::uint64_t> also_needs_begin{0};
  /// Later records whose splits must be applied before that of the record, besides those that consumed its coarse
  /// versions: without them boundary faces could stand together in a cut that never met while the mesh was collapsed,
  /// and cross. Ascending for each record.
  std::vector<std::uint32_t> also_needs;

  [[nodiscard]] std::size_t size() const { return removed.size(); }
  /// Those that there were before any collapse.
  [[nodiscard]] std::span<const Tet> original_tets() const { return {versions.data(), original_tet_count}; }
  [[nodiscard]] std::span<const VersionId> consumed(std::size_t record) const {
    return {fine.data() + fine_begin[record], fine.data() + fine_begin[record + 1]};
  }
  /// Whether the collapse moved the boundary: it consumed a ghost.
  [[nodiscard]] bool moves_boundary(std::size_t record) const;
  /// Appends the field errors, the squared errors and the uncovered volume of record `record` of `other`, which has the
  /// same fields: so many as `field_count`.
  void append_errors(const RecordStream& other, std::size_t record, std::size_t field_count);
  /// Of a record and a field, inside and outside.
  [[nodiscard]] double largest_error(std::size_t record, std::size_t field) const {
    const std::size_t i = record * fields.size() + field;
    return outside_error.empty() ? field_error[i] : std::max(field_error[i], outside_error[i]);
  }
  /// Whether squared errors are known, and so the mean square error of every cut over what it covers.
  [[nodiscard]] bool has_squared_errors() const {
    return volume > 0 && squared_error.size() == size() * fields.size() && uncovered_volume.size() == size();
  }
  [[nodiscard]] std::span<const std::uint32_t> others_needed(std::size_t record) const {
    return {also_needs.data() + also_needs_begin[record], also_needs.data() + also_needs_begin[record + 1]};
  }
  /// Explains the first broken invariant; empty when all hold. O(versions).
  [[nodiscard]] std::string validate() const;
};

/// Whether integrals of squared differences up to `range` over `volume` are doubles with all their digits.
[[nodiscard]] bool holds_squares(double range, double volume);

} // namespace ptet
