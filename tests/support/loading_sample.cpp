#include "support/loading_sample.hpp"

#include "formats/ptet/writer.hpp"
#include "support/brute_force.hpp"
#include "support/meshes.hpp"
#include "support/naive_simplifier.hpp"
#include "support/stream_extras.hpp"

#include <algorithm>
#include <map>
#include <string>

#include <catch2/catch.hpp>

namespace ptet::test {
namespace {

std::string position_of(const TetMesh& mesh, std::size_t v) {
  return {reinterpret_cast<const char*>(mesh.positions.bytes.data()) + v * mesh.positions.row_bytes(),
          mesh.positions.row_bytes()};
}

std::vector<Request> some_requests(const DatasetInfo& info) {
  std::vector<Request> requests{{}, error_request(0.3), error_request(0.02)};
  Point quarter{};
  for (std::size_t i = 0; i < 3; ++i)
    quarter[i] = info.box_min[i] + (info.box_max[i] - info.box_min[i]) / 4;
  Request focus = error_request(0.2);
  focus.focus = {{Box{info.box_min, quarter}}};
  requests.push_back(focus);
  Request budget;
  budget.max_vertices = info.vertices / 2;
  requests.push_back(budget);
  budget.focus = {{Sphere{quarter, info.diagonal / 20}}};
  budget.max_vertices = info.vertices / 4;
  requests.push_back(budget);
  return requests;
}

/// Of parts that need different blocks, if there are cells enough.
void add_requests_at_ends(const DatasetInfo& info, std::vector<Request>& requests) {
  for (const bool at_end : {false, true}) {
    Box part{info.box_min, info.box_max};
    const double length = info.box_max[0] - info.box_min[0];
    (at_end ? part.min[0] : part.max[0]) = info.box_min[0] + length * (at_end ? 0.9 : 0.1);
    Request request = error_request(1);
    request.focus = {{part}};
    requests.push_back(request);
  }
}

LoadingSample make_sample(TetMesh mesh) {
  LoadingSample s;
  s.mesh = std::move(mesh);
  s.stream = simplify_naively(s.mesh);
  add_random_squared_errors(s.stream, 3);
  add_budget_weights(s.stream);
  s.facts = examine(s.mesh);
  s.bytes = file::encode(s.mesh, s.stream, {});
  file::Reader reader(file::over_memory(s.bytes));
  s.base_vertices = reader.header().base_vertex_count;
  s.blocks = reader.blocks();
  for (std::uint32_t b = 0; b < s.blocks.size(); ++b)
    s.decoded_bytes += reader.decoded_bytes(b);
  const auto dataset = Dataset::open_memory(s.bytes);
  std::map<std::string, std::uint32_t> at;
  for (std::uint32_t v = 0; v < s.mesh.vertex_count(); ++v)
    at[position_of(s.mesh, v)] = v;
  const Extraction full = dataset->extract({});
  for (std::size_t v = 0; v < full.mesh.vertex_count(); ++v)
    s.to_original.emplace_back(at.at(position_of(full.mesh, v)));
  s.requests = some_requests(dataset->info());
  return s;
}

void find_answers(LoadingSample& s) {
  for (const Request& request : s.requests)
    s.answers.push_back(Dataset::open_memory(s.bytes)->extract(request));
}

std::vector<VertexId> kept_vertices(const Extraction& answer, const std::vector<char>& left) {
  std::vector<VertexId> kept;
  for (const VertexId v : answer.vertex_in_file) {
    bool is_there = true;
    for (std::size_t b = 0; b < left.size(); ++b) {
      const auto& block = sample().blocks[b];
      const std::uint32_t record = v.index() - sample().base_vertices;
      if (left[b] == 0 && v.index() >= sample().base_vertices && record >= block.first_record &&
          record < block.first_record + block.record_count)
        is_there = false;
    }
    if (is_there) kept.push_back(v);
  }
  return kept;
}

} // namespace

Request error_request(double bound) {
  Request request;
  request.field_error.push_back({"", {bound, true}});
  return request;
}

const LoadingSample& sample() {
  static const LoadingSample made = [] {
    LoadingSample s = make_sample(grid({{11, 11, 11}, {}, 2, 5}));
    find_answers(s);
    return s;
  }();
  return made;
}

const LoadingSample& long_sample() {
  static const LoadingSample made = [] {
    LoadingSample s = make_sample(grid({{96, 6, 6}, {}, 2, 5}));
    add_requests_at_ends(Dataset::open_memory(s.bytes)->info(), s.requests);
    find_answers(s);
    return s;
  }();
  return made;
}

bool same_mesh(const Extraction& a, const Extraction& b) {
  return a.mesh.tets == b.mesh.tets && a.vertex_in_file == b.vertex_in_file && a.mesh.positions == b.mesh.positions &&
         a.mesh.point_arrays == b.mesh.point_arrays && a.field_error == b.field_error &&
         a.domain_error == b.domain_error && a.rms_error == b.rms_error && a.covered == b.covered;
}

std::vector<char> left_without(const std::set<std::uint32_t>& lost) {
  const auto& blocks = sample().blocks;
  std::vector<char> left(blocks.size(), 1);
  for (const std::uint32_t b : lost)
    left[b] = 0;
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t b = 0; b < blocks.size(); ++b)
      for (const std::uint32_t needed : blocks[b].needs)
        if (left[b] != 0 && left[needed] == 0) {
          left[b] = 0;
          changed = true;
        }
  }
  return left;
}

void check_sound(const Extraction& extraction, const LoadingSample& s) {
  const MeshFacts facts = examine(extraction.mesh);
  CHECK(facts.inverted_tets + facts.repeated_tets + facts.crowded_faces + facts.folded_faces == 0);
  CHECK(facts.components == s.facts.components);
  CHECK(facts.boundary_euler_characteristic == s.facts.boundary_euler_characteristic);

  std::vector<char> is_there(s.mesh.vertex_count(), 0);
  for (const VertexId v : extraction.vertex_in_file)
    is_there[s.to_original.at(v.index()).index()] = 1;
  std::vector<char> applied;
  for (const VertexId v : s.stream.removed)
    applied.push_back(is_there[v.index()]);
  std::vector<char> closed = applied;
  close_cut(s.stream, closed);
  CHECK(closed == applied);
  const CutMesh cut = cut_mesh(s.stream, applied);
  std::set<Tet> expected, found;
  for (const Tet& tet : cut.tets)
    expected.insert(sorted_keeping_orientation(tet));
  for (Tet tet : extraction.mesh.tets) {
    for (VertexId& v : tet)
      v = s.to_original.at(extraction.vertex_in_file.at(v.index()).index());
    found.insert(sorted_keeping_orientation(tet));
  }
  CHECK(found == expected);
  const std::size_t fields = s.stream.fields.size();
  REQUIRE(extraction.field_error.size() == fields);
  for (std::size_t f = 0; f < fields; ++f) {
    double most = 0;
    for (const std::size_t maker : cut.tet_maker)
      if (maker != CutMesh::kOriginal) most = std::max(most, s.stream.field_error[maker * fields + f]);
    CHECK(extraction.field_error[f] >= most);
  }
  CHECK(extraction.domain_error >= largest_domain_error(s.stream, cut));
}

std::size_t check_origins(const Session& session) {
  const LoadingSample& s = sample();
  std::vector<char> is_there(s.mesh.vertex_count(), 0), applied;
  for (const VertexId v : session.vertex_in_file())
    if (!v.is_none()) is_there[s.to_original.at(v.index()).index()] = 1;
  for (const VertexId v : s.stream.removed)
    applied.push_back(is_there[v.index()]);
  const CutMesh cut = cut_mesh(s.stream, applied);
  std::map<Tet, std::size_t> maker;
  for (std::size_t t = 0; t < cut.tets.size(); ++t)
    maker[sorted_keeping_orientation(cut.tets[t])] = cut.tet_maker[t];
  std::size_t unknown = 0, checked = 0;
  for (std::size_t slot = 0; slot < session.tets().size(); ++slot) {
    if (session.tets()[slot][0] == Session::kUnused) continue;
    Tet tet;
    for (std::size_t i = 0; i < 4; ++i)
      tet[i] = s.to_original.at(session.vertex_in_file()[session.tets()[slot][i]].index());
    const std::size_t expected = maker.at(sorted_keeping_orientation(tet));
    const RecordId found = session.made_by()[slot];
    ++checked;
    if (found.is_none())
      unknown += expected != CutMesh::kOriginal ? 1 : 0;
    else if (expected == CutMesh::kOriginal ||
             s.to_original.at(s.base_vertices + found.index()) != s.stream.removed[expected])
      FAIL("slot " << slot << " was made by another record");
  }
  CHECK(checked == cut.tets.size());
  return unknown;
}

void check_answer_without(std::size_t i, const Extraction& extraction, const std::vector<char>& left) {
  check_sound(extraction);
  if (sample().requests[i].max_vertices) return;
  const std::vector<VertexId> kept = kept_vertices(sample().answers[i], left);
  const auto& found = extraction.vertex_in_file;
  CHECK(std::includes(kept.begin(), kept.end(), found.begin(), found.end()));
  const bool is_whole = sample().requests[i].focus.empty();
  if (is_whole) CHECK(found.size() == kept.size());
}

} // namespace ptet::test
