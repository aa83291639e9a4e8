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
  kNothing,    ///< it is the original mesh, within the budget
  kError,      ///< the asked error was reached
  kFocus,      ///< the focus was reached, nothing else was asked
  kBudget,     ///< the next split does not fit the budget, or what is there in any case (focus, base) does not
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
  /// Largest minus least value; for vectors the diagonal of the box of values. 0 of a field that does not govern: the
  /// file does not tell.
  double range = 0;
};

struct DatasetInfo {
  std::uint64_t vertices = 0;      ///< of the original, with those in no tet
  std::uint64_t tets = 0;          ///< likewise
  std::uint64_t base_vertices = 0; ///< that tets of the base mesh use, the coarsest there is
  std::uint64_t base_tets = 0;     ///< likewise
  std::uint64_t records = 0;       ///< vertex splits: what leads from the base mesh to the original
  std::uint64_t blocks = 0;        ///< in which records are stored and read
  std::uint64_t file_bytes = 0;
  /// Limits::max_bytes with which all blocks fit: an estimate of the most that reading all of them, an extraction of
  /// the whole mesh and a session take at once, rather high. What is held once all is read is some quarter of it.
  std::uint64_t memory_for_all = 0;
  ScalarType position_type = ScalarType::kFloat32;
  bool has_input_order = false;   ///< see Request::input_order
  bool errors_are_bounds = false; ///< false: errors are those that the build has seen, and true ones may be larger
  /// Some of the original's tets were found to lie in one another, or to be folded over others: a point there has
  /// several values, and errors are those of each part by itself.
  bool overlaps_itself = false;
  std::vector<FieldInfo> fields;
  Point box_min{}; ///< of the bounding box of the original's tets, mesh units
  Point box_max{};
  double diagonal = 0; ///< of that box: what relative domain errors refer to
  /// The largest of any level, one per governing field, in the order of `fields`: no mesh of the file has a larger one.
  std::vector<double> max_field_error;
  double max_domain_error = 0;        ///< likewise, mesh units
  std::vector<double> base_rms_error; ///< of the base mesh, see Extraction::rms_error
  std::optional<double> base_covered; ///< likewise, see Extraction::covered
  std::string provenance_json;        ///< the manifest as JSON text: tool version, options, input name and hash
};

/// The largest errors among the tets and boundary faces of a part of the mesh, stated as those of the whole mesh are.
struct PartErrors {
  std::vector<double> field_error; ///< one per governing field, field units
  double domain_error = 0;         ///< mesh units
};

/// The mesh that answers a request. It owns all it has, and outlives the dataset.
struct Extraction {
  TetMesh mesh; ///< with the vertices that its tets use, no others (the original: with all that it had)
  /// For each vertex its id in the file: stable from request to request.
  std::vector<VertexId> vertex_in_file;
  /// For each vertex its id in the mesh that the file was built from, ascending. Only when Request::input_order is set,
  /// else empty.
  std::vector<std::uint32_t> input_vertex;
  /// For each tet the record that made it; none: the tet is an original one, its error is 0. Only when
  /// Request::origins is set, else empty.
  std::vector<RecordId> made_by;
  /// Boundary faces of `mesh`, oriented outward: counter-clockwise as seen from outside.
  std::vector<std::array<VertexId, 3>> boundary_faces;
  /// The largest error of a tet of the mesh, as the file states it: one number per governing field, in the order of
  /// DatasetInfo::fields and in field units. In a file built with exact evaluation (DatasetInfo::errors_are_bounds)
  /// no point that the mesh covers has a larger error.
  ///
  /// Original vertices outside of the mesh do not count here. But a bound that a request asks everywhere holds for
  /// them, too: each is compared with the closest point of a tet near by (that is sampled, at vertices only).
  /// Where a block was not read for this request, the largest error of its tets stands for those of the mesh, so the
  /// number may be larger than need be; Request::origins makes it as small as it is known.
  std::vector<double> field_error;
  /// Root of the mean square error: sqrt(integral of |Phi - phi|^2 / volume), Phi the original field and phi that of
  /// the mesh, over that part of the original domain which the mesh covers; one per governing field, in field units,
  /// empty when the build did not measure it. Never below what the build measured, and above it only by the rounding of
  /// the file: up to 4.5% where no collapse lowered the error, and by that of `covered`.
  std::vector<double> rms_error;
  /// So much of the volume of the original the mesh covers at least, from 0 to 1; none when the build did not measure
  /// it. Below the truth by the rounding of the file only: up to 9% of what is not covered where no collapse covered
  /// more, and 2^-8 of the volume for many small parts. No bound where the original overlaps itself.
  std::optional<double> covered;
  /// The largest domain error of a boundary face of the mesh, mesh units: how far the part of the original boundary
  /// that the face stands for is from it, and any of its points from the original boundary. In a file built with exact
  /// evaluation no point of either boundary is further from the other, which is to say that neither one-sided Hausdorff
  /// distance is larger; distances below 1e-12 of the diagonal count as none. In other files: sampled, from the
  /// original boundary only, or as predicted (Evaluation::kNone).
  double domain_error = 0;
  /// The same for parts of the mesh that the request names: in_focus[i] is of what meets Request::focus[i], its domain
  /// error of the faces too that are no further from it than that;
  /// at_values[i] of the tets whose values, widened by their own error, reach into Request::values[i], its domain error
  /// of the faces that have such values or stand for a part of the original that may; in_view of what meets the picture
  /// of Request::view, with such faces, too. Blocks that were not read count as above: for values all of them.
  std::vector<PartErrors> in_focus;
  std::vector<PartErrors> at_values;
  std::optional<PartErrors> in_view;
  /// The largest domain error in the picture of the view, in pixels: infinite where a face comes nearer to the eye than
  /// its error is large. 0 without a view.
  double pixels_in_view = 0;
  LimitedBy limited_by = LimitedBy::kNothing;
  /// Whether all blocks were there that the request depends on, as far as it had the time to ask for them: where
  /// limited_by is kTime, asking again may give more. If not, limited_by says why; the mesh is conforming,
  /// coarser than asked where records are missing, and the errors stated are those of this mesh: field_error and
  /// domain_error may be above the bounds asked. Where made_by is none, the tet may then be made by a missing record.
  bool complete = true;
  /// The blocks that the request depends on and that could not be had, ascending by number.
  std::vector<BlockFailure> failures;
  std::uint64_t bytes_read = 0;    ///< from the source for this dataset so far, opening included
  std::uint64_t read_requests = 0; ///< likewise: how often the source was asked
  double seconds = 0;              ///< wall time of the call
};

/// Regions, values and views that a request asks for and that the mesh has not: a focus beside it, values that no point
/// of it has, a camera that looks past it. As a rule a slip of the user's, who wants to be told.
struct UnmetWishes {
  std::vector<std::size_t> focus;  ///< indices into Request::focus of the regions that no tet of the mesh meets
  std::vector<std::size_t> values; ///< indices into Request::values of the intervals that no point has a value in
  bool view = false;               ///< whether Request::view is there and no tet of the mesh is in its picture
};
/// `answer`: what the request was answered with. Where that was cut short by a budget or by time, or is not complete,
/// what is missing may have what was asked for: then regions and views are named that are farther from the mesh than
/// its domain error, and no values. Thread rule: const. Cost: a look at every tet at most, and at a hundredth of them
/// for each further wish.
[[nodiscard]] UnmetWishes unmet_wishes(const Request& request, const Extraction& answer);

/// What the file says of a tet by the record that made it, see Extraction::made_by.
enum class OriginValue {
  kFieldError,  ///< largest error of a governing field among the tets that the record made, field units
  kDomainError, ///< likewise of the boundary faces, mesh units
  /// n: a budget undoes the collapse when it has room for between 1/2^n and 1/2^(n-1) of the vertices of the original
  kLevel,
  kGeneration, ///< how many splits must be made, one after the other, before that of the record
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
  /// blocks are read, and between some eight that are decoded; asking this dataset for more there may throw
  /// kBadArgument. Cost: proportional to the mesh and to the blocks first read; with Request::input_order to the
  /// original, too.
  [[nodiscard]] Extraction extract(const Request& request, const ProgressCallback& progress = {}) const;

  /// Fills values[i] with what record made_by[i] says of the tets it made; `made_by` is as in Extraction::made_by or
  /// Session::made_by(). 0 for an original tet (no record), NaN for a record that is not in memory. `field`: only for
  /// OriginValue::kFieldError, the place of the field among the governing ones.
  /// Throws Error(kBadArgument) for another number of values than of records, no such record or no such field.
  /// Cost: a look at each record, some nanoseconds.
  void origin_values(std::span<const RecordId> made_by, OriginValue what, std::size_t field,
                     std::span<double> values) const;

  /// With OpenOptions::background: waits until the blocks that extractions asked for are loaded, or found not to be
  /// had; without, returns at once. With a budget, which blocks it takes is found out one after the other: where the
  /// next extraction is still limited by kLoading, wait and ask again.
  /// Throws Error(kCancelled) when `progress`, called now and then, returns false; std::bad_alloc.
  void wait_until_loaded(const ProgressCallback& progress = {}) const;

  /// Bytes read from the source so far, opening included.
  [[nodiscard]] std::uint64_t bytes_read() const;

  // What follows is the library's own.
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
