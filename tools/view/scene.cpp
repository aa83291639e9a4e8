#include "scene.hpp"

#include "lod/dataset_impl.hpp"
#include "record/error_code.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

namespace ptet::view {
namespace {

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

/// Whether the two need other polygons of the same mesh.
bool shows_alike(const Settings& a, const Settings& b) {
  if (a.show != b.show || a.colour != b.colour) return false;
  if (a.show == Show::kCells || a.show == Show::kSlice) return a.plane == b.plane;
  return a.show != Show::kIsosurface || (a.iso_field == b.iso_field && a.isovalue == b.isovalue);
}

void collect_cells(const MeshRows& mesh, std::vector<std::uint32_t>& row, Cells& out) {
  out.points.clear();
  out.point_values.clear();
  out.cell_values.clear();
  out.tets.clear();
  row.assign(mesh.positions.size(), kUnusedRow);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const auto& tet = mesh.tets[t];
    if (tet[0] == kUnusedRow) continue;
    std::array<std::int64_t, 4> corners{};
    for (std::size_t i = 0; i < 4; ++i) {
      const std::uint32_t v = tet[i];
      if (row[v] == kUnusedRow) {
        row[v] = static_cast<std::uint32_t>(out.points.size());
        out.points.push_back(mesh.positions[v]);
        if (mesh.tet_values.empty()) out.point_values.push_back(mesh.values[v]);
      }
      corners[i] = row[v];
    }
    out.tets.push_back(corners);
    if (!mesh.tet_values.empty()) out.cell_values.push_back(mesh.tet_values[t]);
  }
}

} // namespace

Request request_of(const Settings& settings) {
  Request request;
  request.origins = settings.colour.kind != ColourKind::kField;
  request.max_tets = settings.max_tets;
  request.max_vertices = settings.max_vertices;
  const bool has_budget = settings.max_tets || settings.max_vertices;
  // To ask for nothing at all is to ask for the original; a bound of 0 would leave out what was collapsed at no error.
  const bool is_original = settings.error && *settings.error == 0;
  if (is_original && !has_budget) return request;
  if (settings.error && !is_original) {
    request.field_error.push_back({"", {*settings.error, true}});
    request.domain_error = Bound{*settings.error, true};
  }
  if (settings.focus) request.focus.push_back({*settings.focus});
  if (!settings.error && !has_budget && !settings.focus) request.max_tets = 0;
  return request;
}

std::vector<double> errors_of_tets(const Dataset& dataset, const std::vector<RecordId>& made_by) {
  const Hierarchy& hierarchy = dataset.impl().hierarchy;
  const std::size_t count = hierarchy.errors_per_record();
  std::vector<double> values(made_by.size(), 0);
  const auto lock = hierarchy.lock();
  for (std::size_t t = 0; t < made_by.size(); ++t) {
    if (made_by[t].is_none()) continue;
    const ErrorCode16* const own = hierarchy.content().own.data() + made_by[t].index() * count;
    // The last is the domain's, which counts where no field has errors; codes grow with what they stand for.
    values[t] = 100 * decode_error(*std::max_element(own, own + std::max<std::size_t>(count - 1, 1)), 1);
  }
  return values;
}

std::vector<double> levels_of_tets(const Dataset& dataset, const std::vector<RecordId>& made_by) {
  const DatasetInfo& info = dataset.info();
  std::vector<double> values(made_by.size(), 0);
  for (std::size_t t = 0; t < made_by.size(); ++t) {
    if (made_by[t].is_none()) continue;
    // Records come from coarse to fine: so many vertices were there when this one made the tet, about.
    const auto vertices = static_cast<double>(info.base_vertices + made_by[t].index() + 1);
    values[t] = 1 + std::floor(std::log2(static_cast<double>(info.vertices) / vertices));
  }
  return values;
}

Scene::Scene(std::shared_ptr<const Dataset> dataset) : dataset_(dataset), session_(std::move(dataset)) {}

const Frame& Scene::step(const Settings& settings, std::optional<double> max_ms) {
  const std::uint64_t bytes_before = bytes_read();
  const auto begin = Clock::now();
  Request request = request_of(settings);
  request.max_milliseconds = max_ms;
  const SessionUpdate& update = session_.update(request);
  const double cut_ms = ms_since(begin);

  const auto geometry_begin = Clock::now();
  const bool by_tet = settings.colour.kind != ColourKind::kField;
  const bool is_same_mesh = last_ && update.changed_tets.empty() && update.changed_vertices.empty();
  // What made a tet may have been read only now.
  const bool is_same = is_same_mesh && shows_alike(*last_, settings) && (!by_tet || frame_.is_complete);
  mesh_.choose(0, settings.colour.field);
  mesh_.choose(1, settings.iso_field);
  mesh_.follow(session_, update);
  describe(update);
  if (!is_same) {
    if (by_tet)
      colour_tets(settings);
    else
      tet_values_.clear();
    make_geometry(settings);
    ++frame_.number;
  }
  set_range(settings);
  last_ = settings;
  if (!is_same) {
    frame_.cut_ms = cut_ms;
    frame_.has_read = bytes_read() != bytes_before;
    frame_.geometry_ms = ms_since(geometry_begin);
  }
  return frame_;
}

std::uint64_t Scene::bytes_read() const {
  const Hierarchy& hierarchy = dataset_->impl().hierarchy;
  const auto lock = hierarchy.lock();
  return hierarchy.bytes_read();
}

void Scene::colour_tets(const Settings& settings) {
  const Extraction extraction = session_.extraction();
  mesh_by_tet_.choose(0, settings.colour.field);
  mesh_by_tet_.choose(1, settings.iso_field);
  mesh_by_tet_.take(extraction);
  tet_values_ = settings.colour.kind == ColourKind::kError ? errors_of_tets(*dataset_, extraction.made_by)
                                                           : levels_of_tets(*dataset_, extraction.made_by);
}

void Scene::make_geometry(const Settings& settings) {
  const bool by_tet = settings.colour.kind != ColourKind::kField;
  const ShownMesh& shown = by_tet ? mesh_by_tet_ : mesh_;
  MeshRows mesh = shown.rows();
  mesh.tet_values = tet_values_;
  if (settings.show != Show::kVolume) frame_.cells = {};
  switch (settings.show) {
  case Show::kSurface: geometry_.boundary(mesh, frame_.polygons); break;
  case Show::kCells: geometry_.cut_open(mesh, settings.plane, frame_.polygons); break;
  case Show::kSlice:
    distance_.resize(mesh.positions.size());
    for (std::size_t v = 0; v < distance_.size(); ++v)
      distance_[v] = settings.plane.distance(mesh.positions[v]);
    geometry_.level_set(mesh, distance_, 0, frame_.polygons);
    break;
  case Show::kIsosurface:
    if (settings.isovalue)
      geometry_.level_set(mesh, shown.values(1), *settings.isovalue, frame_.polygons);
    else
      frame_.polygons.clear();
    break;
  case Show::kVolume:
    frame_.polygons.clear();
    collect_cells(mesh, row_, frame_.cells);
    break;
  }
}

void Scene::describe(const SessionUpdate& update) {
  frame_.tets = update.tets;
  frame_.vertices = update.vertices;
  frame_.boundary_faces = update.boundary_faces;
  frame_.field_error.assign(update.field_error.begin(), update.field_error.end());
  frame_.domain_error = update.domain_error;
  frame_.limited_by = update.limited_by;
  // What is damaged, or does not fit, stays so.
  frame_.is_complete =
      update.complete || (update.limited_by != LimitedBy::kTime && update.limited_by != LimitedBy::kLoading);
  frame_.failure.clear();
  if (update.failures.empty()) return;
  frame_.failure = update.failures.front().message;
  frame_.failure_code = update.failures.front().code;
}

void Scene::set_range(const Settings& settings) {
  if (settings.colour.kind == ColourKind::kField) {
    frame_.range = mesh_.range(0);
    return;
  }
  frame_.range = {};
  frame_.range.widen(0);
  for (const double value : tet_values_)
    frame_.range.widen(value);
}

} // namespace ptet::view
