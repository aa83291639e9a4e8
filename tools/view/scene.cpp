#include "scene.hpp"

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

} // namespace

void Cells::follow(const MeshRows& mesh, const Changes* changes) {
  points = mesh.positions;
  point_values = mesh.tet_values.empty() ? mesh.values : std::span<const double>();
  if (changes == nullptr) {
    tets.clear();
    cell_values.clear();
    slots_.clear();
    row_of_slot_.assign(mesh.tets.size(), kUnusedRow);
    for (std::uint32_t slot = 0; slot < mesh.tets.size(); ++slot)
      follow_slot(mesh, slot);
  } else {
    row_of_slot_.resize(mesh.tets.size(), kUnusedRow);
    for (const std::uint32_t slot : changes->tets)
      follow_slot(mesh, slot);
  }
}

// The last row goes where one is left.
void Cells::follow_slot(const MeshRows& mesh, std::uint32_t slot) {
  const auto& tet = mesh.tets[slot];
  const bool by_tet = !mesh.tet_values.empty();
  std::uint32_t& row = row_of_slot_[slot];
  if (tet[0] == kUnusedRow) {
    if (row == kUnusedRow) return;
    tets[row] = tets.back();
    if (by_tet) cell_values[row] = cell_values.back();
    row_of_slot_[slots_[row] = slots_.back()] = row;
    tets.pop_back();
    if (by_tet) cell_values.pop_back();
    slots_.pop_back();
    row = kUnusedRow;
    return;
  }
  if (row == kUnusedRow) {
    row = static_cast<std::uint32_t>(tets.size());
    tets.emplace_back();
    if (by_tet) cell_values.emplace_back();
    slots_.push_back(slot);
  }
  for (std::size_t i = 0; i < 4; ++i)
    tets[row][i] = tet[i];
  if (by_tet) cell_values[row] = mesh.tet_values[slot];
}

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

std::vector<double> errors_of_tets(const Dataset& dataset, std::span<const RecordId> made_by) {
  std::vector<double> values(made_by.size(), 0), of_field(made_by.size());
  const auto widen = [&](OriginValue what, std::size_t field, double whole) {
    dataset.origin_values(made_by, what, field, of_field);
    for (std::size_t t = 0; t < values.size() && whole > 0; ++t)
      values[t] = std::max(values[t], 100 * of_field[t] / whole);
  };
  std::size_t governing = 0;
  for (const FieldInfo& field : dataset.info().fields)
    if (field.governing) widen(OriginValue::kFieldError, governing++, field.range);
  // The domain's counts where no field has errors.
  if (governing == 0) widen(OriginValue::kDomainError, 0, dataset.info().diagonal);
  return values;
}

std::vector<double> levels_of_tets(const Dataset& dataset, std::span<const RecordId> made_by) {
  std::vector<double> values(made_by.size());
  dataset.origin_values(made_by, OriginValue::kLevel, 0, values);
  return values;
}

Scene::Scene(std::shared_ptr<const Dataset> dataset)
    : dataset_(dataset), placement_(dataset->info()), session_(std::move(dataset)), mesh_(placement_) {}

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
  const bool is_same = is_same_mesh && shows_alike(*last_, settings);
  mesh_.choose(0, settings.colour.field);
  mesh_.choose(1, settings.iso_field);
  mesh_.follow(session_, update);
  describe(update);
  if (!is_same) {
    if (by_tet)
      colour_tets(settings, update.changed_tets);
    else
      tet_values_.clear();
    const Changes changes{update.changed_tets, update.changed_faces, update.changed_vertices};
    const bool follows = last_ && shows_alike(*last_, settings) && !update.renumbered;
    make_geometry(settings, follows ? &changes : nullptr);
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
  return dataset_->bytes_read();
}

// By slot, of those that changed, unless another kind of colour was shown before.
void Scene::colour_tets(const Settings& settings, std::span<const std::uint32_t> changed) {
  const std::span<const RecordId> made_by = session_.made_by();
  const auto values_of = [&](std::span<const RecordId> makers) {
    return settings.colour.kind == ColourKind::kError ? errors_of_tets(*dataset_, makers)
                                                      : levels_of_tets(*dataset_, makers);
  };
  if (tet_values_.empty() || last_->colour.kind != settings.colour.kind) {
    tet_values_ = values_of(made_by);
    find_most();
    return;
  }
  makers_.clear();
  for (const std::uint32_t slot : changed)
    makers_.push_back(made_by[slot]);
  values_ = values_of(makers_);
  const bool is_cut_off = made_by.size() < tet_values_.size();
  tet_values_.resize(made_by.size());
  if (is_cut_off) find_most();
  bool is_above = false;
  for (std::size_t i = 0; i < changed.size(); ++i) {
    double& value = tet_values_[changed[i]];
    if (value == most_) --most_count_;
    value = values_[i];
    if (value == most_) ++most_count_;
    is_above = is_above || value > most_;
  }
  if (is_above || most_count_ == 0) find_most();
}

// A look at all, left out as long as one of the largest is still there.
void Scene::find_most() {
  most_ = 0;
  for (const double value : tet_values_)
    most_ = std::max(most_, value);
  most_count_ = static_cast<std::size_t>(std::count(tet_values_.begin(), tet_values_.end(), most_));
}

void Scene::make_geometry(const Settings& settings, const Changes* changes) {
  MeshRows mesh = mesh_.rows();
  mesh.tet_values = tet_values_;
  if (!tet_values_.empty() && (settings.show == Show::kSurface || settings.show == Show::kCells)) {
    boundary_tets_.follow(mesh, changes);
    mesh.behind = boundary_tets_.behind();
  }
  if (settings.show != Show::kVolume) frame_.cells = {};
  switch (settings.show) {
  case Show::kSurface: geometry_.boundary(mesh, frame_.polygons); break;
  case Show::kCells: geometry_.cut_open(mesh, placement_.drawn(settings.plane), frame_.polygons, changes); break;
  case Show::kSlice:
    measure_distances(placement_.drawn(settings.plane), changes);
    geometry_.level_set(mesh, distance_, 0, frame_.polygons, changes);
    break;
  case Show::kIsosurface:
    if (settings.isovalue)
      geometry_.level_set(mesh, mesh_.values(1), *settings.isovalue, frame_.polygons, changes);
    else
      frame_.polygons.clear();
    break;
  case Show::kVolume:
    frame_.polygons.clear();
    frame_.cells.follow(mesh, changes);
    break;
  }
}

void Scene::measure_distances(const Plane& plane, const Changes* changes) {
  const std::span<const Point> positions = mesh_.rows().positions;
  distance_.resize(positions.size());
  if (changes == nullptr) {
    for (std::size_t v = 0; v < distance_.size(); ++v)
      distance_[v] = plane.distance(positions[v]);
  } else {
    for (const std::uint32_t v : changes->vertices)
      distance_[v] = plane.distance(positions[v]);
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
  frame_.range = {0, most_};
}

} // namespace ptet::view
