// The run-time wing: an opened .ptet file, a request, and the mesh that answers it.
//
//   Dataset --extract(Request)--> Extraction { mesh, origin of each vertex and tet, boundary faces, errors achieved }
//
// A request is met by a cut: a set of applied splits that is closed under dependency, so that the extracted mesh is
// conforming whatever was asked (De Floriani, Magillo, Puppo, Danovaro: multi-tessellations).
#pragma once

#include "ptet/error.hpp"
#include "ptet/mesh.hpp"
#include "ptet/progress.hpp"
#include "ptet/request.hpp"
#include "ptet/source.hpp"

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace ptet {

/// What kept the mesh from being finer.
enum class LimitedBy {
  kNothing,    ///< it is the original mesh
  kError,      ///< the asked error was reached
  kFocus,      ///< the focus was reached, nothing else was asked
  kBudget,     ///< the next split does not fit the budget
  kTime,       ///< the time was up
  kLoading,    ///< blocks that are still to be read, see OpenOptions::background; ask again
  kMemory,     ///< blocks that do not fit OpenOptions::memory_limit or Limits::max_bytes
  kUnreadable, ///< blocks that cannot be read or decoded, see Extraction::failures
};
[[nodiscard]] const char* name_of(LimitedBy limit);

struct FieldInfo {
  std::string name;
  ScalarType type = ScalarType::kFloat32;
  std::uint32_t components = 1;
  bool governing = false; ///< its errors are in the file
  double range = 0;       ///< largest minus least value; for vectors the diagonal of the box of values
};

struct DatasetInfo {
  std::uint64_t vertices = 0; ///< of the original
  std::uint64_t tets = 0;
  std::uint64_t base_vertices = 0;
  std::uint64_t base_tets = 0;
  std::uint64_t records = 0;
  std::uint64_t blocks = 0;
  std::uint64_t file_bytes = 0;
  ScalarType position_type = ScalarType::kFloat32;
  bool has_input_order = false;   ///< see Request::input_order
  bool errors_are_bounds = false; ///< else all errors are what the build has seen, and the true ones may be larger
  std::vector<FieldInfo> fields;
  Point box_min{};
  Point box_max{};
  double diagonal = 0;
  std::vector<double> max_field_error; ///< of the base mesh, one per governing field, in the order of `fields`
  double max_domain_error = 0;
  std::vector<double> base_rms_error; ///< of the base mesh, see Extraction::rms_error
  std::string provenance_json;        ///< the manifest as JSON text: tool version, options, input name and hash
};

/// The largest errors among the tets and boundary faces of a part of the mesh, stated as those of the whole mesh are.
struct PartErrors {
  std::vector<double> field_error; ///< one per governing field, field units
  double domain_error = 0;         ///< mesh units
};

struct Extraction {
  TetMesh mesh; ///< only the vertices that its tets use (all of them when it is the original)
  /// For each vertex its id in the file: stable from request to request.
  std::vector<VertexId> vertex_in_file;
  /// For each vertex its id in the mesh that the file was built from, ascending. Only when Request::input_order is set,
  /// else empty.
  std::vector<std::uint32_t> input_vertex;
  /// For each tet the record that made it; none: the tet is an original one, its error is 0. Only when
  /// Request::origins is set, else empty.
  std::vector<RecordId> made_by;
  /// Outward oriented boundary faces of `mesh`.
  std::vector<std::array<VertexId, 3>> boundary_faces;
  /// Largest error of any tet of the mesh as the file states it, one per governing field, in field units. In a file
  /// built with exact evaluation this is a bound: nowhere in the domain is the error larger, where the mesh covers it.
  /// Original vertices that it does not cover do not count here; but a bound that a request asks everywhere holds for
  /// them, too, each against the closest point of a tet near by (sampled: at vertices only).
  /// Of a block not read for this request the largest error of a tet counts, in the mesh or not.
  std::vector<double> field_error;
  /// Root of the mean square error: sqrt(integral of |Phi - phi|^2 / volume of the original), Phi the original field
  /// and phi that of the mesh, over the original domain where the mesh covers it; one per governing field, in field
  /// units, empty when the build did not measure it. Never below what the build measured, and above it only by the
  /// rounding of the file: up to 4.5% where no collapse lowered the error.
  std::vector<double> rms_error;
  /// Likewise of any boundary face: a bound on the distance to it from all of the original boundary that it stands for,
  /// and from any of its points to the original boundary, mesh units. So no point of either boundary is further from
  /// the other: neither one-sided Hausdorff distance is larger. Distances below 1e-12 of the diagonal count as none.
  /// In a file built without exact evaluation: sampled, from the original boundary only.
  double domain_error = 0;
  /// The same for parts of the mesh that the request names: what meets Request::focus[i]; what may take the values
  /// Request::values[i], widened by its own error; what meets the picture of Request::view.
  std::vector<PartErrors> in_focus;
  std::vector<PartErrors> at_values;
  std::optional<PartErrors> in_view;
  /// Largest domain error in the picture as the view counts it, pixels: infinite where a face with an error comes as
  /// near to the eye as the error is large. 0 without a view.
  double pixels_in_view = 0;
  LimitedBy limited_by = LimitedBy::kNothing;
  /// Whether all blocks were there that the request depends on. If not, limited_by says why; the mesh is conforming,
  /// coarser than asked where records are missing, and the errors stated are those of this mesh: field_error and
  /// domain_error may be above the bounds asked. Where made_by is none, the tet may then be made by a missing record.
  bool complete = true;
  /// The blocks among them that could not be had, ascending.
  std::vector<BlockFailure> failures;
  std::uint64_t bytes_read = 0;    ///< from the source for this dataset so far, opening included
  std::uint64_t read_requests = 0; ///< likewise: how often the source was asked
  double seconds = 0;              ///< wall time of the call
};

/// What a request asks of places that its answer has not.
struct UnmetWishes {
  std::vector<std::size_t> focus;  ///< places in Request::focus of regions that no tet of the mesh meets
  std::vector<std::size_t> values; ///< places in Request::values of intervals that no point of the mesh has a value in
};
/// `mesh`: of the Extraction that answered the request. Thread rule: const. Cost: next to nothing for what is met,
/// a look at every tet for what is not.
[[nodiscard]] UnmetWishes unmet_wishes(const Request& request, const TetMesh& mesh);

/// What the file says of a tet by the record that made it, see Extraction::made_by.
enum class OriginValue {
  kFieldError,  ///< largest error of a governing field among the tets that the record made, field units
  kDomainError, ///< likewise of the boundary faces, mesh units
  /// n: the mesh was down to between 1/2^(n-1) and 1/2^n of its vertices, as the order of the file tells it
  kLevel,
  kGeneration, ///< how many splits must be made one after the other before that of the record can be
};

/// An opened .ptet file. Shared and const: any number of threads may extract from one Dataset at a time; while one
/// loads blocks, those that need none go on. Where memory is limited, extractions take turns.
///
/// Opening throws for a damaged header, manifest, table or base mesh; a damaged block only makes the answers coarser
/// that depend on it, see Extraction::complete.
class Dataset {
public:
  /// Reads header, manifest, table and base mesh; record blocks are read as cuts need them.
  /// Throws Error: kIo, kCorruptFile (with byte offset), kLimit (see OpenOptions::limits), kBadArgument without a
  /// source.
  [[nodiscard]] static std::shared_ptr<const Dataset> open(const std::string& path, const OpenOptions& options = {});
  /// The same from bytes wherever they are.
  [[nodiscard]] static std::shared_ptr<const Dataset> open(std::shared_ptr<ByteSource> source,
                                                           const OpenOptions& options = {});
  /// The same over bytes in memory.
  [[nodiscard]] static std::shared_ptr<const Dataset> open_memory(std::vector<std::byte> bytes,
                                                                  const OpenOptions& options = {});

  [[nodiscard]] const DatasetInfo& info() const;

  /// The mesh that answers `request`.
  /// Throws Error: kBadArgument (unknown field, negative or non-finite bound, empty region or interval, a view without
  /// a direction, an order that the file does not keep), kCancelled, and for Request::input_order what reading it
  /// meets: kIo, kCorruptFile, kLimit; std::bad_alloc. Same request, same mesh, whatever was asked before, as long as
  /// Extraction::complete; only where time is a budget it depends on the machine. `progress` is called before and while
  /// blocks are read, and between some dozen that are decoded; it must not ask this dataset for anything. Cost:
  /// proportional to the mesh and to the blocks first read; with Request::input_order to the original, too.
  [[nodiscard]] Extraction extract(const Request& request, const ProgressCallback& progress = {}) const;

  /// Fills values[i] with what record made_by[i] says: 0 where it is none, for an original tet, and NaN where it is not
  /// in memory. `field`: for errors of a field its place among the governing ones.
  /// Throws Error(kBadArgument) for another number of values than of records, no such record or no such field.
  /// Cost: a look at each record, some nanoseconds.
  void origin_values(std::span<const RecordId> made_by, OriginValue what, std::size_t field,
                     std::span<double> values) const;

  /// Waits until the blocks that extractions asked for are loaded, or found not to be had; see
  /// OpenOptions::background. A budget's blocks are known one after the other: where the next extraction is still
  /// kLoading, wait and ask again.
  /// Throws Error(kCancelled) when `progress`, called now and then, returns false; std::bad_alloc.
  void wait_until_loaded(const ProgressCallback& progress = {}) const;

  /// From the source so far, opening included.
  [[nodiscard]] std::uint64_t bytes_read() const;

  class Impl;
  explicit Dataset(std::unique_ptr<Impl> impl);
  [[nodiscard]] Impl& impl() const { return *impl_; }
  ~Dataset();
  Dataset(const Dataset&) = delete;
  Dataset& operator=(const Dataset&) = delete;

private:
  std::unique_ptr<Impl> impl_;
};

} // namespace ptet
