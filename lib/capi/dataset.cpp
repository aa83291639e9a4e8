// ptet.h: datasets, and what all of the run-time interface hands out.
#include "ptet/dataset.hpp"

#include "capi/guard.hpp"
#include "capi/handles.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <new>
#include <optional>
#include <span>
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

static_assert(sizeof(RecordId) == sizeof(std::uint32_t) && std::is_standard_layout_v<RecordId>);
static_assert(PTET_FLOAT64 == static_cast<int>(ScalarType::kFloat64));

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

ptet_block_failure describe_failure(std::span<const BlockFailure> failures, std::uint32_t failure) {
  if (failure >= failures.size())
    refuse("there is no failure " + std::to_string(failure) + ": there are " + std::to_string(failures.size()));
  ptet_block_failure described{};
  described.message = failures[failure].message.c_str();
  described.byte_offset = failures[failure].byte_offset;
  described.block = failures[failure].block;
  described.status = status_of(failures[failure].code);
  return described;
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

uint64_t ptet_dataset_bytes_read(const ptet_dataset* dataset) {
  return dataset == nullptr ? 0 : dataset->data->bytes_read();
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
    filled.errors_are_bounds = of.errors_are_bounds ? 1 : 0;
    filled.base_covered = of.base_covered.value_or(kNotANumber);
    filled.overlaps_itself = of.overlaps_itself ? 1 : 0;
    filled.memory_for_all = of.memory_for_all;
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

const char* ptet_limit_name(ptet_limit limit) {
  const auto number = static_cast<std::size_t>(limit); // a negative one becomes large
  return number < kLimits.size() ? name_of(kLimits[number]) : "unknown";
}
