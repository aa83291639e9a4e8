#include "support/session_checks.hpp"

#include "support/mesh_checks.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

namespace ptet::test {
namespace {

constexpr std::uint32_t kUnused = Session::kUnused;

template <class Row>
bool is_unused(const Row& row) {
  return std::all_of(row.begin(), row.end(), [](std::uint32_t slot) { return slot == kUnused; });
}

/// Ids in the file for the slots of a row; a slot that is not used gives none.
template <std::size_t Corners>
std::array<VertexId, Corners> named(const Session& session, const std::array<std::uint32_t, Corners>& row) {
  std::array<VertexId, Corners> ids;
  for (std::size_t i = 0; i < Corners; ++i)
    if (row[i] < session.vertex_in_file().size()) ids[i] = session.vertex_in_file()[row[i]];
  return ids;
}

VertexId least_of(const Face& face) {
  return face[0];
}
VertexId least_of(const std::pair<Tet, RecordId>& made) {
  return made.first[0];
}

/// In ascending order, each row with its least vertex first, less than `vertices`. There may be millions: by that
/// vertex they are counted into place, and sorted only among those that share it.
template <class Row>
std::vector<Row> sorted(const std::vector<Row>& rows, std::size_t vertices) {
  std::vector<std::uint32_t> end(vertices + 1);
  for (const Row& row : rows)
    ++end[least_of(row).index() + 1];
  std::partial_sum(end.begin(), end.end(), end.begin());
  std::vector<Row> result(rows.size());
  for (const Row& row : rows)
    result[end[least_of(row).index()]++] = row; // a vertex's begin becomes its end
  std::uint32_t begin = 0;
  for (const std::uint32_t next : end) {
    std::sort(result.begin() + begin, result.begin() + next);
    begin = next;
  }
  return result;
}

/// Whether the rows are the same, in any order; those of `theirs` have vertices that are there.
template <class Row>
bool same_rows(const std::vector<Row>& mine, const std::vector<Row>& theirs) {
  std::size_t vertices = 0;
  for (const Row& row : theirs)
    vertices = std::max(vertices, least_of(row).index() + std::size_t{1});
  const auto is_there = [&](const Row& row) { return least_of(row).index() < vertices; };
  return mine.size() == theirs.size() && std::all_of(mine.begin(), mine.end(), is_there) &&
         sorted(mine, vertices) == sorted(theirs, vertices);
}

bool same_row(const PointArray& a, std::size_t row_a, const PointArray& b, std::size_t row_b) {
  return a.name == b.name && a.type == b.type && a.components == b.components &&
         std::memcmp(a.bytes.data() + row_a * a.row_bytes(), b.bytes.data() + row_b * b.row_bytes(), a.row_bytes()) ==
             0;
}

std::string differing_vertices(const Session& session, const Extraction& fresh) {
  std::vector<std::pair<VertexId, std::uint32_t>> slots;
  for (std::uint32_t slot = 0; slot < session.vertex_in_file().size(); ++slot)
    if (!session.vertex_in_file()[slot].is_none()) slots.emplace_back(session.vertex_in_file()[slot], slot);
  std::sort(slots.begin(), slots.end());
  if (slots.size() != fresh.vertex_in_file.size()) return "number of vertices";
  for (std::size_t v = 0; v < slots.size(); ++v) {
    const auto [id, slot] = slots[v];
    if (id != fresh.vertex_in_file[v]) return "vertices";
    if (!same_row(session.positions(), slot, fresh.mesh.positions, v)) return "positions";
    for (std::size_t i = 0; i < fresh.mesh.point_arrays.size(); ++i)
      if (!same_row(session.point_arrays()[i], slot, fresh.mesh.point_arrays[i], v)) return "point arrays";
  }
  return {};
}

// Each with the record that made it.
std::string differing_tets_only(const Session& session, const Extraction& fresh) {
  std::vector<std::pair<Tet, RecordId>> mine, theirs;
  const bool has_origins = !session.made_by().empty();
  if (has_origins != !fresh.made_by.empty()) return "whether there are origins";
  if (has_origins && session.made_by().size() != session.tets().size()) return "number of origins";
  for (std::size_t slot = 0; slot < session.tets().size(); ++slot) {
    const RecordId maker = has_origins ? session.made_by()[slot] : RecordId{};
    if (!is_unused(session.tets()[slot]))
      mine.emplace_back(sorted_keeping_orientation(named(session, session.tets()[slot])), maker);
    else if (!maker.is_none())
      return "origin of an unused slot";
  }
  for (std::size_t t = 0; t < fresh.mesh.tets.size(); ++t) {
    Tet tet = fresh.mesh.tets[t];
    for (VertexId& v : tet)
      v = fresh.vertex_in_file[v.index()];
    theirs.emplace_back(sorted_keeping_orientation(tet), has_origins ? fresh.made_by[t] : RecordId{});
  }
  return same_rows(mine, theirs) ? "" : "tets, or their origins";
}

std::string differing_tets(const Session& session, const Extraction& fresh) {
  if (const std::string found = differing_tets_only(session, fresh); !found.empty()) return found;
  std::vector<Face> my_faces, their_faces;
  for (const auto& row : session.boundary_faces())
    if (!is_unused(row)) my_faces.push_back(turned(named(session, row)));
  for (Face face : fresh.boundary_faces) {
    for (VertexId& v : face)
      v = fresh.vertex_in_file[v.index()];
    their_faces.push_back(turned(face));
  }
  if (!same_rows(my_faces, their_faces)) return "boundary faces";
  return {};
}

bool same(const PointArray& a, const PointArray& b) {
  return a.name == b.name && a.bytes == b.bytes;
}

std::string differing_extraction(const Extraction& mine, const Extraction& fresh) {
  const bool same_arrays = std::equal(mine.mesh.point_arrays.begin(), mine.mesh.point_arrays.end(),
                                      fresh.mesh.point_arrays.begin(), fresh.mesh.point_arrays.end(), same);
  if (!same_arrays || !same(mine.mesh.positions, fresh.mesh.positions)) return "arrays of the extraction";
  if (mine.mesh.tets != fresh.mesh.tets) return "tets of the extraction";
  if (mine.boundary_faces != fresh.boundary_faces) return "boundary faces of the extraction";
  if (mine.vertex_in_file != fresh.vertex_in_file) return "vertices of the extraction";
  if (mine.made_by != fresh.made_by) return "origins of the extraction";
  if (mine.field_error != fresh.field_error || mine.rms_error != fresh.rms_error || mine.covered != fresh.covered ||
      mine.domain_error != fresh.domain_error || mine.limited_by != fresh.limited_by)
    return "errors of the extraction";
  const auto same_parts = [](const auto& a, const auto& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const PartErrors& x, const PartErrors& y) {
      return x.field_error == y.field_error && x.domain_error == y.domain_error;
    });
  };
  if (!same_parts(mine.in_focus, fresh.in_focus) || !same_parts(mine.at_values, fresh.at_values) ||
      mine.in_view.has_value() != fresh.in_view.has_value() || mine.pixels_in_view != fresh.pixels_in_view)
    return "errors of parts of the extraction";
  return {};
}

/// Fills `copy` up to the size of `slots`, and its changed slots anew.
template <class Row>
void take(std::vector<Row>& copy, std::span<const Row> slots, std::span<const std::uint32_t> changed,
          const Row& unused) {
  copy.resize(slots.size(), unused);
  for (const std::uint32_t slot : changed)
    copy.at(slot) = slots[slot];
}

} // namespace

std::string difference(const Session& session, const SessionUpdate& update, const Extraction& fresh) {
  if (std::string found = differing_vertices(session, fresh); !found.empty()) return found;
  if (std::string found = differing_tets(session, fresh); !found.empty()) return found;
  if (update.tets != fresh.mesh.tets.size() || update.vertices != fresh.mesh.vertex_count() ||
      update.boundary_faces != fresh.boundary_faces.size())
    return "counts";
  if (!std::equal(update.field_error.begin(), update.field_error.end(), fresh.field_error.begin(),
                  fresh.field_error.end()))
    return "field errors";
  if (!std::equal(update.rms_error.begin(), update.rms_error.end(), fresh.rms_error.begin(), fresh.rms_error.end()))
    return "RMS errors";
  if (update.covered != fresh.covered) return "what is covered";
  if (update.domain_error != fresh.domain_error) return "domain error";
  if (update.limited_by != fresh.limited_by) return "what limited it";
  if (!update.complete) return "it is not complete";
  return differing_extraction(session.extraction(), fresh);
}

std::string differing_origin(const Session& session) {
  if (session.made_by().empty()) return "there are none";
  return differing_tets_only(session, session.extraction());
}

void SlotCopy::follow(const Session& session, const SessionUpdate& update) {
  take(tets_, session.tets(), update.changed_tets, {kUnused, kUnused, kUnused, kUnused});
  take(faces_, session.boundary_faces(), update.changed_faces, {kUnused, kUnused, kUnused});
  take(vertices_, session.vertex_in_file(), update.changed_vertices, VertexId{});
  take(made_by_, session.made_by(), session.made_by().empty() ? std::span<const std::uint32_t>() : update.changed_tets,
       RecordId{});
}

std::string SlotCopy::difference(const Session& session) const {
  const auto same_slots = [](const auto& copy, const auto& slots) {
    return std::equal(copy.begin(), copy.end(), slots.begin(), slots.end());
  };
  if (!same_slots(tets_, session.tets())) return "a tet changed and was not told";
  if (!same_slots(made_by_, session.made_by())) return "another record made a tet and it was not told";
  if (!same_slots(faces_, session.boundary_faces())) return "a boundary face changed and was not told";
  if (!same_slots(vertices_, session.vertex_in_file())) return "a vertex changed and was not told";
  return {};
}

Request RandomRequests::next() {
  Request request;
  const unsigned kind = random_() % 11;
  const std::string name = info_.fields.empty() || random_() % 2 == 0 ? "" : info_.fields.front().name;
  if (kind == 0 || kind == 4 || kind == 6 || kind >= 8)
    request.field_error.push_back({name, {std::pow(uniform(), 4), true}});
  if (kind == 1) request.domain_error = Bound{std::pow(uniform(), 3) * 0.02, true};
  if (kind == 2 || kind == 6 || (kind >= 8 && random_() % 4 == 0)) request.max_tets = random_() % (info_.tets + 10);
  if (kind == 3) request.max_vertices = random_() % (info_.vertices + 10);
  if (kind == 7) request.max_bytes = random_() % (200 * info_.vertices);
  if ((kind == 8 || kind == 9) && !info_.max_field_error.empty()) request.values.push_back(values());
  if (kind == 9 || kind == 10) request.view = view();
  for (unsigned i = kind == 4 || kind == 5 ? 1 + random_() % 2 : random_() % 2; i > 0; --i) {
    Focus focus{region()};
    if (random_() % 4 == 0) focus.error = {std::pow(uniform(), 4), true};
    if (random_() % 4 == 0) focus.falloff = Bound{std::pow(uniform(), 2) * 4, true};
    request.focus.push_back(focus);
  }
  request.origins = without_origins_ ? random_() % *without_origins_ != 0 : random_() % 8 == 0;
  return request;
}

Point RandomRequests::point() {
  Point at{};
  for (std::size_t i = 0; i < 3; ++i)
    at[i] = info_.box_min[i] + uniform() * (info_.box_max[i] - info_.box_min[i]);
  return at;
}

Region RandomRequests::region() {
  const Point centre = point();
  const double size = std::pow(uniform(), 3) * 0.4 * info_.diagonal;
  switch (random_() % 8) {
  case 0: return HalfSpace{{uniform() - 0.5, uniform() - 0.5, uniform() + 0.01}, centre[2]};
  case 1: {
    const double angle = 6.3 * uniform(), c = size * std::cos(angle), s = size * std::sin(angle);
    return OrientedBox{centre, {{{c, s, 0}, {-0.4 * s, 0.4 * c, 0}, {0, 0, size * uniform()}}}};
  }
  case 2:
  case 3:
  case 4: return Sphere{centre, size};
  default: break;
  }
  Box box{centre, centre};
  for (double& x : box.max)
    x += size * (0.2 + uniform());
  return box;
}

View RandomRequests::view() {
  View view;
  view.eye = point();
  const Point at = point();
  for (std::size_t i = 0; i < 3; ++i)
    view.direction[i] = at[i] - view.eye[i];
  view.up = {0.1, 0.2, 1};
  view.max_pixels = std::pow(uniform(), 2) * 20;
  if (random_() % 2 == 0) view.outside = 1 + 10 * uniform();
  return view;
}

// Somewhere about what the field takes: the range is known, the values are not.
ValuesOfInterest RandomRequests::values() {
  for (const FieldInfo& field : info_.fields)
    if (field.governing) {
      const double from = (2 * uniform() - 1) * field.range;
      return {field.name, from, from + std::pow(uniform(), 4) * field.range};
    }
  return {};
}

} // namespace ptet::test
