// ptet_build.h: the builder over the C++ interface.
#include "ptet/build.hpp"

#include "capi/guard.hpp"
#include "ptet/ptet_build.h"

#include <limits>
#include <memory>
#include <new>
#include <utility>

using namespace ptet;
using namespace ptet::capi;

// NOLINTBEGIN(readability-identifier-naming): the names of the C interface
struct ptet_builder {
  TetMesh mesh;
  bool has_points = false, has_tets = false;
  BuildOptions options;
  std::string source_name, source_hash;
};
struct ptet_bytes {
  std::vector<std::byte> bytes;
};
// NOLINTEND(readability-identifier-naming)

namespace {

static_assert(PTET_PREDICT_EXACT == static_cast<int>(Prediction::kExact));
static_assert(PTET_EVALUATE_EXACT == static_cast<int>(Evaluation::kExact));
static_assert(PTET_OBJECTIVE_BOTH == static_cast<int>(Objective::kBoth));

template <class Change>
ptet_status change(ptet_builder* builder, ptet_error** error, Change&& apply) noexcept {
  return guarded(error, [&] { apply(required(builder, "the builder")); });
}

/// The number as one of an enum whose last value is `last`.
template <class Enum>
Enum checked(std::int32_t number, Enum last, const char* what) {
  if (number < 0 || number > static_cast<std::int32_t>(last))
    refuse("there is no " + std::string(what) + " " + std::to_string(number));
  return static_cast<Enum>(number);
}

void check_count(std::uint64_t count, std::uint64_t most, const char* what) {
  if (count > most)
    throw Error(ErrorCode::kLimit,
                std::to_string(count) + " " + what + "; at most " + std::to_string(most) + " can be built from");
}

PointArray copy_array(const char* name, ptet_scalar_type type, std::uint32_t components, std::uint64_t rows,
                      const void* values) {
  PointArray array{name, checked(type, ScalarType::kFloat64, "scalar type"), components, {}};
  array.resize(static_cast<std::size_t>(rows));
  if (rows > 0) std::memcpy(array.bytes.data(), values, array.bytes.size());
  return array;
}

void hand_out(const BuildReport& from, ptet_build_report* report) {
  if (report == nullptr) return;
  ptet_build_report filled{};
  filled.input_vertices = from.input_vertices;
  filled.input_tets = from.input_tets;
  filled.base_vertices = from.base_vertices;
  filled.base_tets = from.base_tets;
  filled.records = from.records;
  filled.file_bytes = from.file_bytes;
  filled.domain_error = from.domain_error;
  filled.seconds = from.total_seconds;
  filled.peak_memory_bytes = from.peak_memory_bytes;
  fill(report, filled, "the report");
}

/// Before the build, which is long.
void check_report(const ptet_build_report* report) {
  if (report != nullptr) (void)known_size(report, "the report");
}

} // namespace

ptet_builder* ptet_builder_new(void) {
  return new (std::nothrow) ptet_builder{};
}

void ptet_builder_free(ptet_builder* builder) {
  delete builder;
}

// ---- The mesh

ptet_status ptet_builder_set_points(ptet_builder* builder, ptet_scalar_type type, uint64_t count, const void* xyz,
                                    ptet_error** error) {
  return change(builder, error, [&](ptet_builder& to) {
    if (to.has_points) refuse("the builder has its points already");
    check_count(count, kMostVerticesToBuild, "points");
    if (count > 0) (void)required(static_cast<const std::byte*>(xyz), "the array of points");
    to.mesh.positions = copy_array("", type, 3, count, xyz);
    to.has_points = true;
  });
}

ptet_status ptet_builder_set_tets(ptet_builder* builder, uint64_t count, const uint32_t* corners, ptet_error** error) {
  return change(builder, error, [&](ptet_builder& to) {
    if (to.has_tets) refuse("the builder has its tets already");
    check_count(count, kMostTetsToBuild, "tets");
    if (count > 0) (void)required(corners, "the array of tets");
    std::vector<Tet> tets(static_cast<std::size_t>(count));
    for (std::size_t t = 0; t < tets.size(); ++t)
      for (std::size_t corner = 0; corner < 4; ++corner)
        tets[t][corner] = VertexId{corners[4 * t + corner]};
    to.mesh.tets = std::move(tets);
    to.has_tets = true;
  });
}

ptet_status ptet_builder_add_field(ptet_builder* builder, const char* name, ptet_scalar_type type, uint32_t components,
                                   const void* values, ptet_error** error) {
  return change(builder, error, [&](ptet_builder& to) {
    const std::string named = &required(name, "the name of the field");
    if (!to.has_points) refuse("the builder must have its points before field '" + named + "'");
    if (named.empty()) refuse("the name of the field is empty");
    if (to.mesh.find(named) != nullptr) refuse("the builder has a field '" + named + "' already");
    if (components == 0 || components > kMostComponents)
      refuse("field '" + named + "' has " + std::to_string(components) + " components; 1 to " +
             std::to_string(kMostComponents) + " can be stored");
    const std::size_t rows = to.mesh.vertex_count();
    if (rows > 0) (void)required(static_cast<const std::byte*>(values), "the array of the field");
    to.mesh.point_arrays.push_back(copy_array(name, type, components, rows, values));
  });
}

// ---- Options

ptet_status ptet_builder_add_governing_field(ptet_builder* builder, const char* name, ptet_error** error) {
  return change(builder, error,
                [&](ptet_builder& to) { to.options.fields.emplace_back(&required(name, "the name of the field")); });
}

ptet_status ptet_builder_add_max_field_error(ptet_builder* builder, const char* name, double value, int32_t relative,
                                             ptet_error** error) {
  return change(builder, error, [&](ptet_builder& to) {
    to.options.max_field_error.push_back({text_or_empty(name), {value, relative != 0}});
  });
}

ptet_status ptet_builder_set_max_domain_error(ptet_builder* builder, double value, int32_t relative,
                                              ptet_error** error) {
  return change(builder, error, [&](ptet_builder& to) { to.options.max_domain_error = {value, relative != 0}; });
}

ptet_status ptet_builder_set_target_vertices(ptet_builder* builder, double vertices, ptet_error** error) {
  return change(builder, error, [&](ptet_builder& to) { to.options.target_vertices = vertices; });
}

ptet_status ptet_builder_set_prediction(ptet_builder* builder, ptet_prediction prediction, ptet_error** error) {
  return change(builder, error, [&](ptet_builder& to) {
    to.options.prediction = checked(prediction, Prediction::kExact, "prediction");
  });
}

ptet_status ptet_builder_set_evaluation(ptet_builder* builder, ptet_evaluation evaluation, ptet_error** error) {
  return change(builder, error, [&](ptet_builder& to) {
    to.options.evaluation = checked(evaluation, Evaluation::kExact, "evaluation");
  });
}

ptet_status ptet_builder_set_objective(ptet_builder* builder, ptet_objective objective, ptet_error** error) {
  return change(builder, error,
                [&](ptet_builder& to) { to.options.objective = checked(objective, Objective::kBoth, "objective"); });
}

ptet_status ptet_builder_set_min_quality(ptet_builder* builder, double quality, ptet_error** error) {
  return change(builder, error, [&](ptet_builder& to) { to.options.min_quality = quality; });
}

ptet_status ptet_builder_set_max_star(ptet_builder* builder, uint32_t cells, ptet_error** error) {
  return change(builder, error, [&](ptet_builder& to) { to.options.max_star = cells; });
}

ptet_status ptet_builder_set_round_fraction(ptet_builder* builder, double fraction, ptet_error** error) {
  return change(builder, error, [&](ptet_builder& to) { to.options.round_fraction = fraction; });
}

ptet_status ptet_builder_set_threads(ptet_builder* builder, uint32_t threads, ptet_error** error) {
  return change(builder, error, [&](ptet_builder& to) { to.options.threads = threads; });
}

ptet_status ptet_builder_set_memory_limit(ptet_builder* builder, uint64_t bytes, ptet_error** error) {
  return change(builder, error, [&](ptet_builder& to) { to.options.memory_limit = bytes; });
}

ptet_status ptet_builder_set_weld(ptet_builder* builder, int32_t weld, ptet_error** error) {
  return change(builder, error,
                [&](ptet_builder& to) { to.options.weld = weld != 0 ? std::optional(Bound{}) : std::nullopt; });
}

ptet_status ptet_builder_set_weld_within(ptet_builder* builder, double distance, int32_t relative, ptet_error** error) {
  return change(builder, error, [&](ptet_builder& to) { to.options.weld = Bound{distance, relative != 0}; });
}

ptet_status ptet_builder_set_keep_order(ptet_builder* builder, int32_t keep_order, ptet_error** error) {
  return change(builder, error, [&](ptet_builder& to) { to.options.keep_order = keep_order != 0; });
}

ptet_status ptet_builder_set_pieces(ptet_builder* builder, uint32_t pieces, ptet_error** error) {
  return change(builder, error, [&](ptet_builder& to) { to.options.pieces = pieces; });
}

ptet_status ptet_builder_set_source(ptet_builder* builder, const char* name, const char* hash, ptet_error** error) {
  return change(builder, error, [&](ptet_builder& to) {
    to.source_name = text_or_empty(name);
    to.source_hash = text_or_empty(hash);
  });
}

// ---- The build

ptet_status ptet_builder_build_file(const ptet_builder* builder, const char* path, ptet_progress_callback progress,
                                    void* user, ptet_build_report* report, ptet_error** error) {
  return guarded(error, [&] {
    const ptet_builder& from = required(builder, "the builder");
    const std::string to = &required(path, "the path");
    check_report(report);
    hand_out(
        build_file(from.mesh, to, from.options, from.source_name, from.source_hash, progress_through(progress, user)),
        report);
  });
}

ptet_status ptet_builder_build_memory(const ptet_builder* builder, ptet_progress_callback progress, void* user,
                                      ptet_bytes** bytes, ptet_build_report* report, ptet_error** error) {
  if (bytes != nullptr) *bytes = nullptr;
  return guarded(error, [&] {
    const ptet_builder& from = required(builder, "the builder");
    (void)required(bytes, "where to put the bytes");
    check_report(report);
    auto made = std::make_unique<ptet_bytes>();
    BuildReport filled;
    made->bytes = build_memory(from.mesh, from.options, &filled, from.source_name, from.source_hash,
                               progress_through(progress, user));
    hand_out(filled, report);
    *bytes = made.release();
  });
}

const void* ptet_bytes_data(const ptet_bytes* bytes) {
  return bytes == nullptr ? nullptr : bytes->bytes.data();
}

uint64_t ptet_bytes_size(const ptet_bytes* bytes) {
  return bytes == nullptr ? 0 : bytes->bytes.size();
}

void ptet_bytes_free(ptet_bytes* bytes) {
  delete bytes;
}
