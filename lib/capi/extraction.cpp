// ptet.h: extractions.
#include "capi/guard.hpp"
#include "capi/handles.hpp"
#include "ptet/dataset.hpp"

#include <algorithm>
#include <memory>
#include <type_traits>
#include <vector>

using namespace ptet;
using namespace ptet::capi;

namespace {

// Rows of ids are read as rows of numbers, which they are.
static_assert(sizeof(VertexId) == sizeof(std::uint32_t) && sizeof(RecordId) == sizeof(std::uint32_t));
static_assert(sizeof(Tet) == 4 * sizeof(std::uint32_t));
static_assert(std::is_standard_layout_v<VertexId> && std::is_standard_layout_v<RecordId>);

template <class Row>
const std::uint32_t* numbers_of(const std::vector<Row>& rows) {
  return rows.empty() ? nullptr : reinterpret_cast<const std::uint32_t*>(rows.data());
}

/// None where the request had no such part.
const PartErrors* part_of(const ptet_extraction* extraction, ptet_part part, std::uint32_t number) {
  if (extraction == nullptr) return nullptr;
  const Extraction& of = extraction->extraction;
  const auto at = [&](const std::vector<PartErrors>& parts) {
    return number < parts.size() ? &parts[number] : nullptr;
  };
  switch (part) {
  case PTET_PART_FOCUS: return at(of.in_focus);
  case PTET_PART_VALUES: return at(of.at_values);
  case PTET_PART_VIEW: return of.in_view && number == 0 ? &*of.in_view : nullptr;
  }
  return nullptr;
}

} // namespace

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
    fill(info, describe_failure(required(extraction, "the extraction").extraction.failures, failure), "the failure");
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

double ptet_extraction_field_error(const ptet_extraction* extraction, uint32_t field) {
  return extraction == nullptr ? kNotANumber
                               : error_at(extraction->extraction.field_error, extraction->governing, field);
}

double ptet_extraction_covered(const ptet_extraction* extraction) {
  return extraction == nullptr ? kNotANumber : extraction->extraction.covered.value_or(kNotANumber);
}

double ptet_extraction_rms_error(const ptet_extraction* extraction, uint32_t field) {
  return extraction == nullptr ? kNotANumber : error_at(extraction->extraction.rms_error, extraction->governing, field);
}

double ptet_extraction_part_field_error(const ptet_extraction* extraction, ptet_part part, uint32_t number,
                                        uint32_t field) {
  const PartErrors* const errors = part_of(extraction, part, number);
  return errors == nullptr ? kNotANumber : error_at(errors->field_error, extraction->governing, field);
}

double ptet_extraction_part_domain_error(const ptet_extraction* extraction, ptet_part part, uint32_t number) {
  const PartErrors* const errors = part_of(extraction, part, number);
  return errors == nullptr ? kNotANumber : errors->domain_error;
}

int32_t ptet_extraction_is_unmet(const ptet_extraction* extraction, const ptet_request* request, ptet_part part,
                                 uint32_t number) {
  if (extraction == nullptr || request == nullptr) return 0;
  try {
    const Request& all = request->request;
    Request wish;
    if (part == PTET_PART_FOCUS && number < all.focus.size()) wish.focus = {all.focus[number]};
    if (part == PTET_PART_VALUES && number < all.values.size()) wish.values = {all.values[number]};
    if (part == PTET_PART_VIEW && number == 0) wish.view = all.view;
    const UnmetWishes unmet = unmet_wishes(wish, extraction->extraction);
    return unmet.focus.empty() && unmet.values.empty() && !unmet.view ? 0 : 1;
  } catch (...) {
    return 0; // no memory to look
  }
}

double ptet_extraction_pixels_in_view(const ptet_extraction* extraction) {
  return extraction == nullptr ? kNotANumber : extraction->extraction.pixels_in_view;
}
