// ptet.h: sessions.
#include "ptet/session.hpp"

#include "capi/guard.hpp"
#include "capi/handles.hpp"

#include <cstddef>

using namespace ptet;
using namespace ptet::capi;

// NOLINTBEGIN(readability-identifier-naming): the names of the C interface
struct ptet_session {
  Session session;
  GoverningPlaces governing;
  std::vector<double> field_error, rms_error; ///< of the last update
  double covered;                             ///< likewise
  std::span<const BlockFailure> failures;     ///< likewise
};
// NOLINTEND(readability-identifier-naming)

template <>
inline constexpr std::uint64_t ptet::capi::kFirstSize<ptet_session_changes> = offsetof(ptet_session_changes,
                                                                                       renumbered);

namespace {

static_assert(sizeof(std::array<std::uint32_t, 4>) == 4 * sizeof(std::uint32_t));

template <class Row>
const std::uint32_t* rows_of(std::span<const Row> rows, std::uint64_t* slots) {
  if (slots != nullptr) *slots = rows.size();
  return rows.empty() ? nullptr : reinterpret_cast<const std::uint32_t*>(rows.data());
}

const std::uint32_t* no_rows(std::uint64_t* slots) {
  return rows_of(std::span<const std::uint32_t>(), slots);
}

ptet_session_changes describe(const SessionUpdate& update) {
  ptet_session_changes changes{};
  changes.changed_tets = rows_of(update.changed_tets, &changes.changed_tet_count);
  changes.changed_faces = rows_of(update.changed_faces, &changes.changed_face_count);
  changes.changed_vertices = rows_of(update.changed_vertices, &changes.changed_vertex_count);
  changes.tets = update.tets;
  changes.boundary_faces = update.boundary_faces;
  changes.vertices = update.vertices;
  changes.tets_added = update.tets_added;
  changes.tets_removed = update.tets_removed;
  changes.vertices_added = update.vertices_added;
  changes.vertices_removed = update.vertices_removed;
  changes.splits = update.splits;
  changes.collapses = update.collapses;
  changes.domain_error = update.domain_error;
  changes.seconds = update.seconds;
  changes.limited_by = number_of(update.limited_by);
  changes.complete = update.complete ? 1 : 0;
  changes.renumbered = update.renumbered ? 1 : 0;
  changes.failures = static_cast<std::uint32_t>(update.failures.size());
  return changes;
}

} // namespace

ptet_status ptet_session_open(const ptet_dataset* dataset, ptet_session** session, ptet_error** error) {
  if (session != nullptr) *session = nullptr;
  return guarded(error, [&] {
    (void)required(session, "where to put the session");
    const auto& data = required(dataset, "the dataset").data;
    *session = std::make_unique<ptet_session>(
                   ptet_session{Session(data), governing_places(data->info()), {}, {}, kNotANumber, {}})
                   .release();
  });
}

void ptet_session_free(ptet_session* session) {
  delete session;
}

ptet_status ptet_session_update(ptet_session* session, const ptet_request* request, ptet_progress_callback progress,
                                void* user, ptet_session_changes* changes, ptet_error** error) {
  return guarded(error, [&] {
    ptet_session& of = required(session, "the session");
    if (changes != nullptr) (void)known_size(changes, "the changes"); // before the session changes
    const SessionUpdate& update = [&]() -> const SessionUpdate& {
      try {
        return of.session.update(request == nullptr ? Request{} : request->request, progress_through(progress, user));
      } catch (const Error&) {
        throw; // the failures are still those of the last update
      } catch (...) {
        of.failures = {};
        throw;
      }
    }();
    of.field_error.assign(update.field_error.begin(), update.field_error.end());
    of.rms_error.assign(update.rms_error.begin(), update.rms_error.end());
    of.covered = update.covered.value_or(kNotANumber);
    of.failures = update.failures;
    if (changes != nullptr) fill(changes, describe(update), "the changes");
  });
}

ptet_status ptet_session_get_failure(const ptet_session* session, uint32_t failure, ptet_block_failure* info,
                                     ptet_error** error) {
  return guarded(
      error, [&] { fill(info, describe_failure(required(session, "the session").failures, failure), "the failure"); });
}

const uint32_t* ptet_session_tets(const ptet_session* session, uint64_t* slots) {
  return session == nullptr ? no_rows(slots) : rows_of(session->session.tets(), slots);
}

const uint32_t* ptet_session_boundary_faces(const ptet_session* session, uint64_t* slots) {
  return session == nullptr ? no_rows(slots) : rows_of(session->session.boundary_faces(), slots);
}

const uint32_t* ptet_session_made_by(const ptet_session* session, uint64_t* slots) {
  return session == nullptr ? no_rows(slots) : rows_of(session->session.made_by(), slots);
}

const uint32_t* ptet_session_vertices_in_file(const ptet_session* session, uint64_t* slots) {
  return session == nullptr ? no_rows(slots) : rows_of(session->session.vertex_in_file(), slots);
}

ptet_status ptet_session_get_positions(const ptet_session* session, ptet_array* positions, ptet_error** error) {
  return guarded(error, [&] {
    fill(positions, describe_array(required(session, "the session").session.positions()), "the array");
  });
}

ptet_status ptet_session_get_field(const ptet_session* session, uint32_t field, ptet_array* values,
                                   ptet_error** error) {
  return guarded(error, [&] {
    const auto arrays = required(session, "the session").session.point_arrays();
    fill(values, describe_array(array_at(arrays, field)), "the array");
  });
}

double ptet_session_field_error(const ptet_session* session, uint32_t field) {
  return session == nullptr ? kNotANumber : error_at(session->field_error, session->governing, field);
}

double ptet_session_covered(const ptet_session* session) {
  return session == nullptr ? kNotANumber : session->covered;
}

double ptet_session_rms_error(const ptet_session* session, uint32_t field) {
  return session == nullptr ? kNotANumber : error_at(session->rms_error, session->governing, field);
}

ptet_status ptet_session_extract(const ptet_session* session, ptet_extraction** extraction, ptet_error** error) {
  if (extraction != nullptr) *extraction = nullptr;
  return guarded(error, [&] {
    const ptet_session& of = required(session, "the session");
    (void)required(extraction, "where to put the extraction");
    *extraction = std::make_unique<ptet_extraction>(ptet_extraction{of.session.extraction(), of.governing}).release();
  });
}
