// What a viewer shows of a .ptet file, without a window: settings in, polygons (or cells, for a volume) out.
//
//   Settings --request_of--> Session::update --changed slots--> ShownMesh --Geometry--> Frame
//
// A step is bounded in time and is called again until Frame::is_complete; blocks are read by the dataset's own thread
// meanwhile, see OpenOptions::background.
#pragma once

#include "boundary_tets.hpp"
#include "geometry.hpp"
#include "placement.hpp"
#include "ptet/dataset.hpp"
#include "ptet/session.hpp"
#include "shown_mesh.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace ptet::view {

enum class Show : std::uint8_t { kSurface, kCells, kSlice, kIsosurface, kVolume };

enum class ColourKind : std::uint8_t {
  kField,
  kError, ///< of the collapse that made the tet, the largest of all fields, percent of a field's range; originals: 0
  kLevel, ///< as OriginValue has it; originals: 0
};

struct ColourBy {
  ColourKind kind = ColourKind::kField;
  std::size_t field = 0; ///< row of DatasetInfo::fields

  friend bool operator==(const ColourBy&, const ColourBy&) = default;
};

struct Settings {
  Show show = Show::kSurface;
  ColourBy colour;
  Plane plane; ///< of slice and cells
  std::size_t iso_field = 0;
  std::optional<double> isovalue; ///< none: nothing is drawn of an isosurface

  /// Largest error everywhere: a fraction of each governing field's range, and of the diagonal for the boundary. 0: the
  /// original, or what of it fits. None: nothing is asked by error, and with nothing else asked it is the base mesh.
  std::optional<double> error;
  std::optional<std::uint64_t> max_tets, max_vertices;
  std::optional<Region> focus; ///< the original inside

  friend bool operator==(const Settings&, const Settings&) = default;
};

/// What the settings ask of the file.
[[nodiscard]] Request request_of(const Settings& settings);

/// The tets themselves, for a volume, kept from mesh to mesh by what changes.
class Cells {
public:
  /// `changes`: as of Geometry.
  void follow(const MeshRows& mesh, const Changes* changes);

  std::span<const Point> points; ///< of the mesh's rows, those of no use too
  std::span<const double> point_values;
  std::vector<double> cell_values;               ///< as in Polygons
  std::vector<std::array<std::int64_t, 4>> tets; ///< in no order

private:
  void follow_slot(const MeshRows& mesh, std::uint32_t slot);

  std::vector<std::uint32_t> slots_;       ///< by row of `tets`
  std::vector<std::uint32_t> row_of_slot_; ///< or kUnusedRow
};

struct Frame {
  Polygons polygons;        ///< where the scene's placement draws them, as the cells
  Cells cells;              ///< only when a volume is shown; of the scene's own memory
  std::uint64_t number = 0; ///< another one whenever polygons or cells are
  Range range;              ///< of the values that colour, seen so far

  std::uint64_t tets = 0, vertices = 0, boundary_faces = 0; ///< of the mesh
  std::vector<double> field_error;                          ///< achieved, see Extraction
  double domain_error = 0;
  LimitedBy limited_by = LimitedBy::kNothing;
  bool is_complete = true; ///< no further step with the same settings would change anything
  std::string failure;     ///< of the first block that cannot be had; the mesh is coarser there
  ErrorCode failure_code = ErrorCode::kCorruptFile;
  double cut_ms = 0;      ///< wall time of Session::update in the last step that changed anything
  double geometry_ms = 0; ///< and of what followed
  bool has_read = false;  ///< blocks were read or decoded in that time
};

class Scene {
public:
  explicit Scene(std::shared_ptr<const Dataset> dataset);

  /// Goes towards what `settings` ask for, for about `max_ms` (none: all the way, unless blocks are being loaded); the
  /// frame is then one of a conforming mesh whose errors are stated. Colours by error or level need all of the file.
  /// Throws what Session::update throws. The frame is valid until the next
  /// step.
  const Frame& step(const Settings& settings, std::optional<double> max_ms = std::nullopt);

  [[nodiscard]] const Frame& frame() const { return frame_; }
  [[nodiscard]] const Dataset& dataset() const { return *dataset_; }
  /// From the file's coordinates, which the settings are in, to those of the frame.
  [[nodiscard]] const Placement& placement() const { return placement_; }
  /// Where the mesh's vertices lie, slot by slot; those of no use too.
  [[nodiscard]] const ShownMesh& mesh() const { return mesh_; }

private:
  [[nodiscard]] std::uint64_t bytes_read() const;
  void colour_tets(const Settings& settings, std::span<const std::uint32_t> changed);
  void find_most();
  void make_geometry(const Settings& settings, const Changes* changes);
  void measure_distances(const Plane& plane, const Changes* changes);
  void describe(const SessionUpdate& update);
  void set_range(const Settings& settings);

  std::shared_ptr<const Dataset> dataset_;
  Placement placement_;
  Session session_;
  ShownMesh mesh_;
  std::vector<double> tet_values_; ///< by tet slot; empty where the colour is a field's
  double most_ = 0;                ///< of these
  std::size_t most_count_ = 0;     ///< how many are as large
  std::vector<RecordId> makers_;   ///< scratch
  std::vector<double> values_;
  Geometry geometry_;
  BoundaryTets boundary_tets_;   ///< where tets colour their faces
  std::vector<double> distance_; ///< by vertex, from the plane of a slice
  std::optional<Settings> last_;
  Frame frame_;
};

/// By tet, see ColourKind. `made_by` as an extraction with origins has it.
[[nodiscard]] std::vector<double> errors_of_tets(const Dataset& dataset, std::span<const RecordId> made_by);
[[nodiscard]] std::vector<double> levels_of_tets(const Dataset& dataset, std::span<const RecordId> made_by);

} // namespace ptet::view
