// ptet.h: datasets, requests and extractions over the C++ interface.
#include "capi/guard.hpp"
#include "capi/handles.hpp"
#include "ptet/dataset.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

using namespace ptet;
using namespace ptet::capi;

namespace {

/// What reads through the callbacks of a C program, and tells it when nothing will be read any more.
class CallbackSource final : public ByteSource {
public:
  explicit CallbackSource(const ptet_source& source) : source_(source) {}
  ~CallbackSource() override {
    if (source_.release != nullptr) source_.release(source_.user);
  }
  CallbackSource(const CallbackSource&) = delete;
  CallbackSource& operator=(const CallbackSource&) = delete;

  std::uint64_t size() override { return source_.size; }
  void read(std::uint64_t offset, std::span<std::byte> into) override {
    const std::int32_t answer = source_.read(source_.user, offset, into.size(), into.data());
    if (answer != 0)
      throw Error(ErrorCode::kIo,
                  "the read function answered " + std::to_string(answer) + " for " + std::to_string(into.size()) +
                      " bytes",
                  offset);
  }

private:
  ptet_source source_;
};

/// By their numbers in ptet.h, which stay as they are.
constexpr std::array kLimits{LimitedBy::kNothing, LimitedBy::kError,   LimitedBy::kFocus,  LimitedBy::kBudget,
                             LimitedBy::kTime,    LimitedBy::kLoading, LimitedBy::kMemory, LimitedBy::kUnreadable};

constexpr std::array kOriginValues{OriginValue::kFieldError, OriginValue::kDomainError, OriginValue::kLevel,
                                   OriginValue::kGeneration};

OpenOptions options_from(const ptet_open_options* given) {
  OpenOptions options;
  if (given == nullptr) return options;
  const ptet_open_options taken = take(given, "the options");
  const auto unless_zero = [](std::uint64_t& to, std::uint64_t value) { to = value == 0 ? to : value; };
  options.memory_limit = taken.memory_limit;
  options.max_gap = taken.max_gap;
  options.background = taken.background != 0;
  unless_zero(options.limits.max_bytes, taken.max_bytes);
  unless_zero(options.limits.max_vertices, taken.max_vertices);
  unless_zero(options.limits.max_tets, taken.max_tets);
  return options;
}

template <class Open>
ptet_status open_dataset(const ptet_open_options* options, ptet_dataset** dataset, ptet_error** error,
                         Open&& open) noexcept {
  if (dataset != nullptr) *dataset = nullptr;
  return guarded(error, [&] {
    (void)required(dataset, "where to put the dataset");
    *dataset = std::make_unique<ptet_dataset>(ptet_dataset{open(options_from(options))}).release();
  });
}

template <class Change>
ptet_status change(ptet_request* request, ptet_error** error, Change&& apply) noexcept {
  return guarded(error, [&] { apply(required(request, "the request").request); });
}

ptet_status add_region(ptet_request* request, ptet_error** error, const std::function<Region()>& region) noexcept {
  return guarded(error, [&] {
    ptet_request& to = required(request, "the request");
    to.request.focus.push_back({region(), to.focus_error, to.falloff});
  });
}

template <class Change>
ptet_status change_region(ptet_request* request, std::uint32_t region, ptet_error** error, Change&& apply) noexcept {
  return change(request, error, [&](Request& asked) {
    if (region >= asked.focus.size())
      refuse("there is no focus region " + std::to_string(region) + ": there are " +
             std::to_string(asked.focus.size()));
    apply(asked.focus[region]);
  });
}

Point point_at(const double* coordinates, const char* what) {
  (void)required(coordinates, what);
  return {coordinates[0], coordinates[1], coordinates[2]};
}

// Rows of ids are read as rows of numbers, which they are.
static_assert(sizeof(VertexId) == sizeof(std::uint32_t) && sizeof(RecordId) == sizeof(std::uint32_t));
static_assert(sizeof(Tet) == 4 * sizeof(std::uint32_t));
static_assert(std::is_standard_layout_v<VertexId> && std::is_standard_layout_v<RecordId>);
static_assert(PTET_FLOAT64 == static_cast<int>(ScalarType::kFloat64));

template <class Row>
const std::uint32_t* numbers_of(const std::vector<Row>& rows) {
  return rows.empty() ? nullptr : reinterpret_cast<const std::uint32_t*>(rows.data());
}

} // namespace

namespace ptet::capi {

GoverningPlaces governing_places(const DatasetInfo& info) {
  GoverningPlaces places;
  std::size_t count = 0;
  for (const FieldInfo& field : info.fields)
    places.push_back(field.governing ? std::optional(count++) : std::nullopt);
  return places;
}

double error_at(const std::vector<double>& errors, const GoverningPlaces& places, std::size_t field) {
  if (field >= places.size() || !places[field] || *places[field] >= errors.size()) return kNotANumber;
  return errors[*places[field]];
}

ptet_limit number_of(LimitedBy limit) {
  return static_cast<ptet_limit>(std::find(kLimits.begin(), kLimits.end(), limit) - kLimits.begin());
}

ptet_array describe_array(const PointArray& array) {
  ptet_array described{};
  described.name = array.name.c_str();
  described.data = array.bytes.empty() ? nullptr : array.bytes.data();
  described.rows = array.size();
  described.components = array.components;
  described.type = static_cast<ptet_scalar_type>(array.type);
  return described;
}

const PointArray& array_at(std::span<const PointArray> arrays, std::uint32_t field) {
  if (field >= arrays.size())
    refuse("there is no field " + std::to_string(field) + ": there are " + std::to_string(arrays.size()));
  return arrays[field];
}

} // namespace ptet::capi

// ---- Datasets

ptet_status ptet_dataset_open(const char* path, const ptet_open_options* options, ptet_dataset** dataset,
                              ptet_error** error) {
  return open_dataset(options, dataset, error, [&](const OpenOptions& with) {
    return Dataset::open(std::string(&required(path, "the path")), with);
  });
}

ptet_status ptet_dataset_open_memory(const void* bytes, uint64_t size, const ptet_open_options* options,
                                     ptet_dataset** dataset, ptet_error** error) {
  return open_dataset(options, dataset, error, [&](const OpenOptions& with) {
    if (size > 0) (void)required(static_cast<const std::byte*>(bytes), "the memory");
    const auto* const first = static_cast<const std::byte*>(bytes);
    if (size > static_cast<std::uint64_t>(std::numeric_limits<std::ptrdiff_t>::max())) throw std::bad_alloc();
    return Dataset::open_memory(std::vector<std::byte>(first, first + size), with);
  });
}

ptet_status ptet_dataset_open_source(const ptet_source* source, const ptet_open_options* options,
                                     ptet_dataset** dataset, ptet_error** error) {
  return open_dataset(options, dataset, error, [&](const OpenOptions& with) {
    const ptet_source given = take(source, "the source");
    if (given.read == nullptr) refuse("the source has no read function");
    auto* const made = new (std::nothrow) CallbackSource(given);
    if (made == nullptr && given.release != nullptr) given.release(given.user);
    if (made == nullptr) throw std::bad_alloc();
    return Dataset::open(std::shared_ptr<ByteSource>(made), with);
  });
}

void ptet_dataset_free(ptet_dataset* dataset) {
  delete dataset;
}

ptet_status ptet_dataset_get_info(const ptet_dataset* dataset, ptet_dataset_info* info, ptet_error** error) {
  return guarded(error, [&] {
    const DatasetInfo& of = required(dataset, "the dataset").data->info();
    ptet_dataset_info filled{};
    filled.vertices = of.vertices;
    filled.tets = of.tets;
    filled.base_vertices = of.base_vertices;
    filled.base_tets = of.base_tets;
    filled.records = of.records;
    filled.blocks = of.blocks;
    filled.file_bytes = of.file_bytes;
    filled.fields = static_cast<std::uint32_t>(of.fields.size());
    filled.position_type = static_cast<ptet_scalar_type>(of.position_type);
    std::copy(of.box_min.begin(), of.box_min.end(), filled.box_min);
    std::copy(of.box_max.begin(), of.box_max.end(), filled.box_max);
    filled.diagonal = of.diagonal;
    filled.max_domain_error = of.max_domain_error;
    filled.has_input_order = of.has_input_order ? 1 : 0;
    fill(info, filled, "the dataset info");
  });
}

ptet_status ptet_dataset_get_field(const ptet_dataset* dataset, uint32_t field, ptet_field_info* info,
                                   ptet_error** error) {
  return guarded(error, [&] {
    const DatasetInfo& of = required(dataset, "the dataset").data->info();
    if (field >= of.fields.size())
      refuse("there is no field " + std::to_string(field) + ": there are " + std::to_string(of.fields.size()));
    const auto places = governing_places(of);
    ptet_field_info filled{};
    filled.name = of.fields[field].name.c_str();
    filled.type = static_cast<ptet_scalar_type>(of.fields[field].type);
    filled.components = of.fields[field].components;
    filled.governing = of.fields[field].governing ? 1 : 0;
    filled.range = of.fields[field].range;
    filled.max_error = error_at(of.max_field_error, places, field);
    filled.max_rms = error_at(of.base_rms_error, places, field);
    fill(info, filled, "the field info");
  });
}

int32_t ptet_dataset_find_field(const ptet_dataset* dataset, const char* name) {
  if (dataset == nullptr || name == nullptr) return -1;
  const std::vector<FieldInfo>& fields = dataset->data->info().fields;
  const auto found = std::find_if(fields.begin(), fields.end(), [&](const FieldInfo& f) { return f.name == name; });
  return found == fields.end() ? -1 : static_cast<std::int32_t>(found - fields.begin());
}

const char* ptet_dataset_provenance(const ptet_dataset* dataset) {
  return dataset == nullptr ? "" : dataset->data->info().provenance_json.c_str();
}

ptet_status ptet_dataset_wait_until_loaded(const ptet_dataset* dataset, ptet_progress_callback progress, void* user,
                                           ptet_error** error) {
  return guarded(error,
                 [&] { required(dataset, "the dataset").data->wait_until_loaded(progress_through(progress, user)); });
}

// ---- Requests

ptet_request* ptet_request_new(void) {
  return new (std::nothrow) ptet_request{};
}

void ptet_request_free(ptet_request* request) {
  delete request;
}

ptet_status ptet_request_clear(ptet_request* request, ptet_error** error) {
  return guarded(error, [&] { required(request, "the request") = {}; });
}

ptet_status ptet_request_add_field_error(ptet_request* request, const char* field, double value, int32_t relative,
                                         ptet_error** error) {
  return change(request, error, [&](Request& asked) {
    asked.field_error.push_back({text_or_empty(field), {value, relative != 0}});
  });
}

ptet_status ptet_request_set_domain_error(ptet_request* request, double value, int32_t relative, ptet_error** error) {
  return change(request, error, [&](Request& asked) { asked.domain_error = Bound{value, relative != 0}; });
}

ptet_status ptet_request_set_max_tets(ptet_request* request, uint64_t tets, ptet_error** error) {
  return change(request, error, [&](Request& asked) { asked.max_tets = tets; });
}

ptet_status ptet_request_set_max_vertices(ptet_request* request, uint64_t vertices, ptet_error** error) {
  return change(request, error, [&](Request& asked) { asked.max_vertices = vertices; });
}

ptet_status ptet_request_set_max_milliseconds(ptet_request* request, double milliseconds, ptet_error** error) {
  return change(request, error, [&](Request& asked) { asked.max_milliseconds = milliseconds; });
}

ptet_status ptet_request_set_max_bytes(ptet_request* request, uint64_t bytes, ptet_error** error) {
  return change(request, error, [&](Request& asked) { asked.max_bytes = bytes; });
}

ptet_status ptet_request_add_focus_box(ptet_request* request, const double* min, const double* max,
                                       ptet_error** error) {
  return add_region(request, error, [&] {
    return Box{point_at(min, "the least corner"), point_at(max, "the greatest corner")};
  });
}

ptet_status ptet_request_add_focus_oriented_box(ptet_request* request, const double* centre, const double* half_axes,
                                                ptet_error** error) {
  return add_region(request, error, [&] {
    OrientedBox box;
    box.centre = point_at(centre, "the centre");
    (void)required(half_axes, "the half axes");
    for (std::size_t axis = 0; axis < 3; ++axis)
      box.half_axes[axis] = point_at(half_axes + 3 * axis, "a half axis");
    return box;
  });
}

ptet_status ptet_request_add_focus_sphere(ptet_request* request, const double* centre, double radius,
                                          ptet_error** error) {
  return add_region(request, error, [&] { return Sphere{point_at(centre, "the centre"), radius}; });
}

ptet_status ptet_request_add_focus_half_space(ptet_request* request, const double* normal, double offset,
                                              ptet_error** error) {
  return add_region(request, error, [&] { return HalfSpace{point_at(normal, "the normal"), offset}; });
}

ptet_status ptet_request_set_focus_error(ptet_request* request, double value, int32_t relative, ptet_error** error) {
  return guarded(error, [&] {
    ptet_request& of = required(request, "the request");
    of.focus_error = {value, relative != 0};
    for (Focus& focus : of.request.focus)
      focus.error = of.focus_error;
  });
}

ptet_status ptet_request_set_focus_falloff(ptet_request* request, double value, int32_t relative, ptet_error** error) {
  return guarded(error, [&] {
    ptet_request& of = required(request, "the request");
    of.falloff = Bound{value, relative != 0};
    for (Focus& focus : of.request.focus)
      focus.falloff = of.falloff;
  });
}

ptet_status ptet_request_set_region_error(ptet_request* request, uint32_t region, double value, int32_t relative,
                                          ptet_error** error) {
  return change_region(request, region, error, [&](Focus& focus) { focus.error = {value, relative != 0}; });
}

ptet_status ptet_request_set_region_falloff(ptet_request* request, uint32_t region, double value, int32_t relative,
                                            ptet_error** error) {
  return change_region(request, region, error, [&](Focus& focus) { focus.falloff = Bound{value, relative != 0}; });
}

ptet_status ptet_request_add_values(ptet_request* request, const char* field, double min, double max,
                                    ptet_error** error) {
  return change(request, error, [&](Request& asked) {
    asked.values.push_back({std::string(&required(field, "the name of the field")), min, max});
  });
}

ptet_status ptet_request_set_view(ptet_request* request, const ptet_view* view, ptet_error** error) {
  return change(request, error, [&](Request& asked) {
    const ptet_view given = take(view, "the view");
    View seen;
    seen.eye = point_at(given.eye, "the eye");
    seen.direction = point_at(given.direction, "the direction");
    seen.up = point_at(given.up, "the direction upwards");
    seen.vertical_angle = given.vertical_angle;
    seen.width = given.width;
    seen.height = given.height;
    seen.max_pixels = given.max_pixels;
    seen.outside = given.outside;
    asked.view = seen;
  });
}

ptet_status ptet_request_set_origins(ptet_request* request, int32_t origins, ptet_error** error) {
  return change(request, error, [&](Request& asked) { asked.origins = origins != 0; });
}

ptet_status ptet_request_set_input_order(ptet_request* request, int32_t input_order, ptet_error** error) {
  return change(request, error, [&](Request& asked) { asked.input_order = input_order != 0; });
}

// ---- Extractions

ptet_status ptet_dataset_extract(const ptet_dataset* dataset, const ptet_request* request,
                                 ptet_progress_callback progress, void* user, ptet_extraction** extraction,
                                 ptet_error** error) {
  if (extraction != nullptr) *extraction = nullptr;
  return guarded(error, [&] {
    (void)required(extraction, "where to put the extraction");
    const Dataset& data = *required(dataset, "the dataset").data;
    auto made = std::make_unique<ptet_extraction>();
    made->governing = governing_places(data.info());
    made->extraction =
        data.extract(request == nullptr ? Request{} : request->request, progress_through(progress, user));
    *extraction = made.release();
  });
}

void ptet_extraction_free(ptet_extraction* extraction) {
  delete extraction;
}

const char* ptet_limit_name(ptet_limit limit) {
  const auto number = static_cast<std::size_t>(limit); // a negative one becomes large
  return number < kLimits.size() ? name_of(kLimits[number]) : "unknown";
}

ptet_status ptet_extraction_get_info(const ptet_extraction* extraction, ptet_extraction_info* info,
                                     ptet_error** error) {
  return guarded(error, [&] {
    const Extraction& of = required(extraction, "the extraction").extraction;
    ptet_extraction_info filled{};
    filled.vertices = of.mesh.vertex_count();
    filled.tets = of.mesh.tets.size();
    filled.boundary_faces = of.boundary_faces.size();
    filled.fields = static_cast<std::uint32_t>(of.mesh.point_arrays.size());
    filled.limited_by = number_of(of.limited_by);
    filled.domain_error = of.domain_error;
    filled.bytes_read = of.bytes_read;
    filled.seconds = of.seconds;
    filled.read_requests = of.read_requests;
    filled.failures = static_cast<std::uint32_t>(of.failures.size());
    filled.complete = of.complete ? 1 : 0;
    fill(info, filled, "the extraction info");
  });
}

ptet_status ptet_extraction_get_failure(const ptet_extraction* extraction, uint32_t failure, ptet_block_failure* info,
                                        ptet_error** error) {
  return guarded(error, [&] {
    const std::vector<BlockFailure>& failures = required(extraction, "the extraction").extraction.failures;
    if (failure >= failures.size())
      refuse("there is no failure " + std::to_string(failure) + ": there are " + std::to_string(failures.size()));
    ptet_block_failure filled{};
    filled.message = failures[failure].message.c_str();
    filled.byte_offset = failures[failure].byte_offset;
    filled.block = failures[failure].block;
    filled.status = status_of(failures[failure].code);
    fill(info, filled, "the failure");
  });
}

ptet_status ptet_extraction_get_positions(const ptet_extraction* extraction, ptet_array* positions,
                                          ptet_error** error) {
  return guarded(error, [&] {
    fill(positions, describe_array(required(extraction, "the extraction").extraction.mesh.positions), "the array");
  });
}

ptet_status ptet_extraction_get_field(const ptet_extraction* extraction, uint32_t field, ptet_array* values,
                                      ptet_error** error) {
  return guarded(error, [&] {
    const Extraction& of = required(extraction, "the extraction").extraction;
    fill(values, describe_array(array_at(of.mesh.point_arrays, field)), "the array");
  });
}

const uint32_t* ptet_extraction_tets(const ptet_extraction* extraction) {
  return extraction == nullptr ? nullptr : numbers_of(extraction->extraction.mesh.tets);
}

const uint32_t* ptet_extraction_boundary_faces(const ptet_extraction* extraction) {
  return extraction == nullptr ? nullptr : numbers_of(extraction->extraction.boundary_faces);
}

const uint32_t* ptet_extraction_vertices_in_file(const ptet_extraction* extraction) {
  return extraction == nullptr ? nullptr : numbers_of(extraction->extraction.vertex_in_file);
}

const uint32_t* ptet_extraction_input_vertices(const ptet_extraction* extraction) {
  if (extraction == nullptr || extraction->extraction.input_vertex.empty()) return nullptr;
  return extraction->extraction.input_vertex.data();
}

const uint32_t* ptet_extraction_made_by(const ptet_extraction* extraction) {
  return extraction == nullptr ? nullptr : numbers_of(extraction->extraction.made_by);
}

ptet_status ptet_dataset_get_origin_values(const ptet_dataset* dataset, const uint32_t* made_by, uint64_t count,
                                           ptet_origin_value what, uint32_t field, double* values, ptet_error** error) {
  return guarded(error, [&] {
    const Dataset& data = *required(dataset, "the dataset").data;
    if (count == 0) return;
    const std::uint32_t& first = required(made_by, "the list of records");
    double& into = required(values, "where to put the values");
    const std::span records(reinterpret_cast<const RecordId*>(&first), static_cast<std::size_t>(count));
    const auto number = static_cast<std::size_t>(what); // a negative one becomes large
    if (number >= kOriginValues.size()) refuse("there is no origin value " + std::to_string(what));
    std::size_t place = 0;
    if (what == PTET_ORIGIN_FIELD_ERROR) {
      const GoverningPlaces places = governing_places(data.info());
      if (field >= places.size() || !places[field]) refuse("field " + std::to_string(field) + " does not govern");
      place = *places[field];
    }
    data.origin_values(records, kOriginValues[number], place, {&into, static_cast<std::size_t>(count)});
  });
}

double ptet_extraction_field_error(const ptet_extraction* extraction, uint32_t field) {
  return extraction == nullptr ? kNotANumber
                               : error_at(extraction->extraction.field_error, extraction->governing, field);
}

double ptet_extraction_rms_error(const ptet_extraction* extraction, uint32_t field) {
  return extraction == nullptr ? kNotANumber : error_at(extraction->extraction.rms_error, extraction->governing, field);
}
