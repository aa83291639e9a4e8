// The record stream: what the builder hands to the writer, and nothing of how it was found.
//
//   slots      0 .. tets-1         the input's tets
//              tets .. slots-1     one ghost tet for each boundary face
//   records    in collapse order (fine to coarse). Record i took the removed vertex's star:
//
//        star(i) = modified_0 .. modified_{m-1}, deleted_0 .. deleted_{d-1}     (slots)
//                  '------- hold afterwards what they held before, the vertex replaced by the target
//                                                '------- hold nothing any more
//
//   versions   what a slot held at some time. F(i), the fine ones that collapse i consumed, are what the slots of its
//              star held before; C(i), the coarse ones that it made, what its modified slots held afterwards.
//
// So no version needs to be written down but one for each slot: the others follow by making the collapses, or undoing
// them. Ghosts (a, b, c, kDummyVertex) stand in slots like any other tet: they are the boundary faces.
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

  /// What its normalised values and errors are fractions of: the range, or 1 for a field that does not vary.
  [[nodiscard]] double scale() const { return range > 0 ? range : 1; }
};

/// What budgets are to keep small, beside undoing the last collapses first (budget_rank.hpp). Errors that are weighed
/// are those everywhere.
struct BudgetWeights {
  std::vector<double> maximum; ///< by field, of errors in field units; empty: greatest errors do not count
  double domain = 0;           ///< of domain errors in mesh units, beside those
  bool mean = false;           ///< whether mean squares count, of all fields alike
};

struct RecordStream {
  std::vector<GoverningField> fields;
  double diagonal = 0; ///< of the bounding box of the used vertices
  double volume = 0;   ///< of the original mesh
  /// Some of the original's tets were found to lie in one another: there a point has several values, and errors are
  /// those of each part by itself.
  bool overlaps_itself = false;
  BudgetWeights budget;

  std::uint32_t original_tet_count = 0;
  std::uint32_t original_ghost_count = 0;
  /// What each slot held last: one that a record deleted, when it was deleted; any other, in the base mesh. Real tets
  /// positively oriented, ghosts oriented like the tets (so a ghost's face, seen from the dummy, is the boundary face
  /// seen from outside).
  std::vector<Tet> slots;

  // Records, in collapse order.
  std::vector<VertexId> removed;
  std::vector<VertexId> target;
  /// Non-decreasing. Records of one round do not depend on one another.
  std::vector<std::uint32_t> round;
  /// size()+1 offsets into `stars`.
  std::vector<std::uint64_t> star_begin{0};
  /// Slots of the stars of the removed vertices: modified ones first.
  std::vector<std::uint32_t> stars;
  std::vector<std::uint16_t> modified_count;
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
  /// Later records whose splits must be applied before that of the record, besides those that took its modified slots
  /// next: without them boundary faces could stand together in a cut that never met while the mesh was collapsed,
  /// and cross. Ascending for each record.
  std::vector<std::uint32_t> also_needs;

  [[nodiscard]] std::size_t size() const { return removed.size(); }
  [[nodiscard]] std::size_t slot_count() const { return std::size_t{original_tet_count} + original_ghost_count; }
  /// Whether the slot holds ghosts: it does always or never.
  [[nodiscard]] bool is_ghost(std::uint32_t slot) const { return slot >= original_tet_count; }
  [[nodiscard]] std::span<const std::uint32_t> star(std::size_t record) const {
    return {stars.data() + star_begin[record], stars.data() + star_begin[record + 1]};
  }
  [[nodiscard]] std::span<const std::uint32_t> modified(std::size_t record) const {
    return star(record).first(modified_count[record]);
  }
  [[nodiscard]] std::span<const std::uint32_t> deleted(std::size_t record) const {
    return star(record).subspan(modified_count[record]);
  }
  /// Original tets and ghosts, and all that records made.
  [[nodiscard]] std::uint64_t version_count() const;
  /// Makes the collapse of `record` in `tets`, by slot: what the deleted slots hold stays.
  void collapse(std::size_t record, std::span<Tet> tets) const {
    replace(record, removed[record], target[record], tets);
  }
  /// Undoes it.
  void split(std::size_t record, std::span<Tet> tets) const { replace(record, target[record], removed[record], tets); }
  /// What the slots hold before the first collapse.
  [[nodiscard]] std::vector<Tet> original() const;
  /// Slots that no record deleted; ascending. What they hold are the tets and ghosts of the base mesh.
  [[nodiscard]] std::vector<std::uint32_t> base_slots() const;
  /// Whether the collapse moved the boundary: there is a ghost in its star.
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

private:
  void replace(std::size_t record, VertexId from, VertexId to, std::span<Tet> tets) const;
};

/// Whether integrals of squared differences up to `range` over `volume` are doubles with all their digits.
[[nodiscard]] bool holds_squares(double range, double volume);

} // namespace ptet
