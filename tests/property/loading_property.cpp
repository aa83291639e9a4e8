// Files that can only be read in part: damaged blocks, sources that fail, too little memory, queries while a thread
// loads. Every answer must be a closed cut, conforming, with errors that are true, and say what it lacks.
#include "formats/ptet/writer.hpp"
#include "lod/hierarchy.hpp"
#include "ptet/dataset.hpp"
#include "ptet/session.hpp"
#include "support/brute_force.hpp"
#include "support/file_parts.hpp"
#include "support/mesh_checks.hpp"
#include "support/meshes.hpp"
#include "support/naive_simplifier.hpp"
#include "support/session_checks.hpp"
#include "support/stream_extras.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <thread>

#include <catch2/catch.hpp>

using namespace ptet;
using namespace ptet::test;

namespace {

using Bytes = std::vector<std::byte>;

struct Sample {
  TetMesh mesh;
  RecordStream stream;
  Bytes bytes;
  MeshFacts facts;
  std::uint32_t base_vertices = 0;
  std::vector<file::BlockInfo> blocks;
  std::uint64_t decoded_bytes = 0;
  std::vector<VertexId> to_original; ///< by vertex of the file
  std::vector<Request> requests;
  std::vector<Extraction> answers; ///< of the whole file
};

std::string position_of(const TetMesh& mesh, std::size_t v) {
  return {reinterpret_cast<const char*>(mesh.positions.bytes.data()) + v * mesh.positions.row_bytes(),
          mesh.positions.row_bytes()};
}

Request error_request(double bound) {
  Request request;
  request.field_error.push_back({"", {bound, true}});
  return request;
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

const Sample& sample() {
  static const Sample made = [] {
    Sample s;
    s.mesh = grid({{11, 11, 11}, {}, 2, 5});
    s.stream = simplify_naively(s.mesh);
    add_random_squared_errors(s.stream, 3);
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
    for (const Request& request : s.requests)
      s.answers.push_back(Dataset::open_memory(s.bytes)->extract(request));
    return s;
  }();
  return made;
}

bool same_mesh(const Extraction& a, const Extraction& b) {
  return a.mesh.tets == b.mesh.tets && a.vertex_in_file == b.vertex_in_file && a.mesh.positions == b.mesh.positions &&
         a.mesh.point_arrays == b.mesh.point_arrays && a.field_error == b.field_error &&
         a.domain_error == b.domain_error && a.rms_error == b.rms_error;
}

/// Blocks that are left when those of `lost` and all that need them, directly or not, are gone.
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

/// The mesh is that of a closed cut of the records, sound, and its errors are no less than theirs that made its tets.
void check_sound(const Extraction& extraction) {
  const Sample& s = sample();
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

/// Each tet of the session's mesh was made by the record that replaying all records finds, or by one that is not there.
/// Returns how many of these there are.
std::size_t check_origins(const Session& session) {
  const Sample& s = sample();
  std::vector<char> is_there(s.mesh.vertex_count(), 0), applied;
  for (const VertexId v : session.vertices())
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
      tet[i] = s.to_original.at(session.vertices()[session.tets()[slot][i]].index());
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

/// Where the whole of `left` can be had and nothing else: what bounds ask for and is there; in a focus not more, since
/// what is there only for the sake of records that are not is not wanted.
void check_answer_without(std::size_t i, const Extraction& extraction, const std::vector<char>& left) {
  check_sound(extraction);
  if (sample().requests[i].max_vertices) return;
  const std::vector<VertexId> kept = kept_vertices(sample().answers[i], left);
  const auto& found = extraction.vertex_in_file;
  CHECK(std::includes(kept.begin(), kept.end(), found.begin(), found.end()));
  const bool is_whole = sample().requests[i].focus.empty();
  if (is_whole) CHECK(found.size() == kept.size());
}

} // namespace

TEST_CASE("a damaged block makes answers coarser that depend on it, and is told") {
  const Sample& s = sample();
  REQUIRE(s.blocks.size() >= 6);
  std::size_t incomplete = 0, complete = 0;
  for (std::uint32_t b = 0; b < s.blocks.size(); ++b) {
    Bytes damaged = s.bytes;
    flip(damaged, 8 * s.blocks[b].offset + 77 % (8 * s.blocks[b].stored_bytes));
    const auto dataset = Dataset::open_memory(damaged);
    const auto left = left_without({b});
    for (std::size_t i = 0; i < s.requests.size(); ++i) {
      INFO("block " << b << ", request " << i);
      const Extraction extraction = dataset->extract(s.requests[i]);
      check_answer_without(i, extraction, left);
      if (extraction.complete) {
        CHECK(extraction.failures.empty());
        CHECK(same_mesh(extraction, s.answers[i]));
        ++complete;
      } else {
        REQUIRE(extraction.failures.size() == 1);
        CHECK(extraction.failures[0].block == b);
        CHECK(extraction.failures[0].byte_offset == s.blocks[b].offset);
        CHECK(extraction.failures[0].code == ErrorCode::kCorruptFile);
        CHECK(extraction.failures[0].message.find("hash") != std::string::npos);
        CHECK(extraction.limited_by == LimitedBy::kUnreadable);
        CHECK(extraction.mesh.tets.size() <= s.answers[i].mesh.tets.size());
        ++incomplete;
      }
      // The order of requests is no matter.
      CHECK(same_mesh(extraction, Dataset::open_memory(damaged)->extract(s.requests[i])));
    }
    CHECK_FALSE(dataset->extract({}).complete);
  }
  CHECK(incomplete > s.blocks.size());
  CHECK(complete > 0);
}

TEST_CASE("a block that is wrong under a right hash is found, or decodes to sound records") {
  const Sample& s = sample();
  std::mt19937_64 random(9);
  std::size_t found = 0;
  for (std::uint32_t b = 0; b < s.blocks.size(); ++b) {
    for (int bit = 0; bit < 4; ++bit) {
      FileParts parts(s.bytes);
      const auto rows = parts.rows();
      flip(parts.of(file::SectionKind::kBlocks), 8 * rows[b].info.offset + random() % (8 * rows[b].info.stored_bytes));
      parts.mend_blocks();
      const auto dataset = Dataset::open_memory(parts.join());
      for (std::size_t i = 0; i < s.requests.size(); ++i) {
        INFO("block " << b << ", request " << i);
        const Extraction extraction = dataset->extract(s.requests[i]);
        const MeshFacts facts = examine(extraction.mesh);
        CHECK(facts.repeated_tets + facts.crowded_faces == 0);
        CHECK(facts.components == s.facts.components);
        if (extraction.complete) continue;
        ++found;
        REQUIRE_FALSE(extraction.failures.empty());
        // What is wrong may be noticed in a block that builds on it. Nothing of either is in the answer.
        std::set<std::uint32_t> lost;
        for (const BlockFailure& failure : extraction.failures)
          lost.insert(failure.block);
        if (lost.count(b) != 0) check_answer_without(i, extraction, left_without(lost));
      }
    }
  }
  CHECK(found > 100);
}

TEST_CASE("every read fails in turn: opening is refused, answers are coarser, and trying again helps") {
  const Sample& s = sample();
  std::size_t opened = 0;
  for (std::uint64_t failing = 1;; ++failing) {
    std::uint64_t count = 0;
    const auto source = std::make_shared<FailingSource>(
        s.bytes, [&count, failing](std::uint64_t, std::uint64_t) { return ++count == failing; });
    std::shared_ptr<const Dataset> dataset;
    try {
      dataset = Dataset::open(source);
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::kIo);
      CHECK(std::string(error.what()).find("the line is dead") != std::string::npos);
      continue;
    }
    ++opened;
    for (std::size_t i = 0; i < s.requests.size(); ++i)
      check_sound(dataset->extract(s.requests[i]));
    for (std::size_t i = 0; i < s.requests.size(); ++i) {
      const Extraction again = dataset->extract(s.requests[i]);
      CHECK(again.complete);
      CHECK(same_mesh(again, s.answers[i]));
    }
    if (count < failing) break; // it never came to that read
  }
  CHECK(opened > 1);
}

// With a time to keep blocks are read one after the other, with what they need: what failed once may be had the next
// time.
TEST_CASE("what is missing in the end is told, and nothing else") {
  const Sample& s = sample();
  std::size_t complete = 0;
  for (std::uint64_t failing = 1, count = failing; count >= failing; ++failing) {
    count = 0;
    const auto source = std::make_shared<FailingSource>(s.bytes);
    const auto dataset = Dataset::open(source);
    source->set([&count, failing](std::uint64_t, std::uint64_t) { return ++count == failing; });
    Request request = s.requests[failing % s.requests.size()];
    request.max_milliseconds = 1e6;
    const Extraction extraction = dataset->extract(request);
    CHECK(extraction.complete == extraction.failures.empty());
    if (!extraction.complete) continue;
    CHECK(same_mesh(extraction, s.answers[failing % s.requests.size()]));
    complete += count >= failing ? 1 : 0;
  }
  CHECK(complete > 0);
}

TEST_CASE("ranges that cannot be read cost what needs them, and no more") {
  const Sample& s = sample();
  for (std::uint32_t b = 0; b < s.blocks.size(); ++b) {
    const std::uint64_t bad = s.blocks[b].offset + s.blocks[b].stored_bytes / 2;
    const auto source = std::make_shared<FailingSource>(
        s.bytes, [bad](std::uint64_t offset, std::uint64_t count) { return offset <= bad && bad - offset < count; });
    OpenOptions options;
    options.max_gap = 1 << 16; // one request for all of them, then one for each
    const auto dataset = Dataset::open(source, options);
    for (std::size_t i = 0; i < s.requests.size(); ++i) {
      INFO("block " << b << ", request " << i);
      const Extraction extraction = dataset->extract(s.requests[i]);
      check_answer_without(i, extraction, left_without({b}));
      if (extraction.complete) continue;
      REQUIRE(extraction.failures.size() == 1);
      CHECK(extraction.failures[0].block == b);
      CHECK(extraction.failures[0].code == ErrorCode::kIo);
      CHECK(extraction.failures[0].byte_offset == s.blocks[b].offset);
    }
    source->set({});
    CHECK(same_mesh(dataset->extract({}), s.answers[0]));
  }
}

TEST_CASE("reads that fail at random") {
  const Sample& s = sample();
  for (unsigned seed = 0; seed < 6; ++seed) {
    auto random = std::make_shared<std::mt19937>(seed);
    const auto source = std::make_shared<FailingSource>(s.bytes);
    const auto dataset = Dataset::open(source);
    source->set([random](std::uint64_t, std::uint64_t) { return (*random)() % 3 == 0; });
    for (int round = 0; round < 4; ++round)
      for (std::size_t i = s.requests.size(); i-- > 0;) {
        const Extraction extraction = dataset->extract(s.requests[i]);
        check_sound(extraction);
        if (!extraction.failures.empty()) CHECK_FALSE(extraction.complete);
        if (extraction.complete) CHECK(same_mesh(extraction, s.answers[i]));
      }
    source->set({});
    for (std::size_t i = 0; i < s.requests.size(); ++i)
      CHECK(same_mesh(dataset->extract(s.requests[i]), s.answers[i]));
  }
}

TEST_CASE("few requests, and every byte counted") {
  const Sample& s = sample();
  const auto source = std::make_shared<FailingSource>(s.bytes);
  const auto dataset = Dataset::open(source);
  CHECK(source->reads() <= 4);
  const Extraction full = dataset->extract({});
  CHECK(full.read_requests <= 5); // the blocks lie one behind the other
  CHECK(full.read_requests == source->reads());
  CHECK(full.bytes_read == source->bytes_given());
  CHECK(full.bytes_read == s.bytes.size());
  CHECK(dataset->extract({}).bytes_read == full.bytes_read);
}

TEST_CASE("a thread loads while eight ask") {
  const Sample& s = sample();
  OpenOptions options;
  options.background = true;
  for (unsigned seed = 0; seed < 4; ++seed) {
    const auto source = std::make_shared<FailingSource>(s.bytes);
    const auto dataset = Dataset::open(source, options);
    auto random = std::make_shared<std::mt19937>(seed);
    source->set([random](std::uint64_t, std::uint64_t) {
      std::this_thread::sleep_for(std::chrono::microseconds((*random)() % 2000));
      return false;
    });
    std::vector<std::vector<Extraction>> answers(8);
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < answers.size(); ++t)
      threads.emplace_back([&, t] {
        for (std::size_t k = 0; k < 12; ++k)
          answers[t].push_back(dataset->extract(s.requests[(t + k) % s.requests.size()]));
      });
    for (std::thread& thread : threads)
      thread.join();
    std::size_t incomplete = 0;
    for (std::size_t t = 0; t < answers.size(); ++t)
      for (std::size_t k = 0; k < answers[t].size(); ++k) {
        const Extraction& answer = answers[t][k];
        if (answer.complete) {
          CHECK(same_mesh(answer, s.answers[(t + k) % s.requests.size()]));
          continue;
        }
        CHECK(answer.limited_by == LimitedBy::kLoading);
        CHECK(answer.failures.empty());
        if (k < 2) check_sound(answer);
        ++incomplete;
      }
    CHECK(incomplete > 0);
    for (std::size_t i = 0; i < s.requests.size(); ++i) {
      Extraction answer = dataset->extract(s.requests[i]);
      for (int round = 0; round < 100 && answer.limited_by == LimitedBy::kLoading; ++round) {
        dataset->wait_until_loaded();
        answer = dataset->extract(s.requests[i]);
      }
      CHECK(answer.complete);
      CHECK(same_mesh(answer, s.answers[i]));
    }
  }
}

TEST_CASE("a thread that loads meets damage, and is stopped at any time") {
  const Sample& s = sample();
  OpenOptions options;
  options.background = true;
  Bytes damaged = s.bytes;
  const auto last = static_cast<std::uint32_t>(s.blocks.size() - 1);
  flip(damaged, 8 * s.blocks[last].offset);
  {
    const auto dataset = Dataset::open_memory(damaged, options);
    (void)dataset->extract({});
    dataset->wait_until_loaded();
    const Extraction answer = dataset->extract({});
    CHECK(answer.limited_by == LimitedBy::kUnreadable);
    REQUIRE(answer.failures.size() == 1);
    check_answer_without(0, answer, left_without({last}));
    CHECK_NOTHROW(dataset->wait_until_loaded([](const Progress&) { return true; }));
  }
  for (int microseconds = 0; microseconds < 3000; microseconds += 100) {
    const auto dataset = Dataset::open_memory(s.bytes, options);
    (void)dataset->extract({});
    std::this_thread::sleep_for(std::chrono::microseconds(microseconds));
  }
  const auto source = std::make_shared<FailingSource>(s.bytes);
  const auto dataset = Dataset::open(source, options);
  std::atomic<bool> go_on{false};
  source->set([&](std::uint64_t, std::uint64_t) {
    while (!go_on)
      std::this_thread::yield();
    return false;
  });
  CHECK(dataset->extract({}).limited_by == LimitedBy::kLoading);
  CHECK_THROWS_AS(dataset->wait_until_loaded([](const Progress&) { return false; }), Error);
  go_on = true;
  dataset->wait_until_loaded();
  CHECK(same_mesh(dataset->extract({}), s.answers[0]));
}

TEST_CASE("within a limit of memory blocks are dropped and read again, or answers are coarser") {
  const Sample& s = sample();
  std::size_t complete = 0, incomplete = 0;
  for (const double share : {0.15, 0.4, 0.7, 0.95}) {
    OpenOptions options;
    options.memory_limit = static_cast<std::uint64_t>(share * static_cast<double>(s.decoded_bytes));
    const auto dataset = Dataset::open_memory(s.bytes, options);
    for (int round = 0; round < 2; ++round)
      for (std::size_t i = 0; i < s.requests.size(); ++i) {
        INFO("share " << share << ", request " << i);
        const Extraction answer = dataset->extract(s.requests[i]);
        check_sound(answer);
        CHECK(same_mesh(answer, Dataset::open_memory(s.bytes, options)->extract(s.requests[i])));
        if (answer.complete) {
          CHECK(same_mesh(answer, s.answers[i]));
          ++complete;
        } else {
          CHECK(answer.limited_by == LimitedBy::kMemory);
          CHECK(answer.failures.empty());
          ++incomplete;
        }
      }
    std::vector<std::vector<char>> right(4);
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < right.size(); ++t)
      threads.emplace_back([&, t] {
        for (std::size_t i = 0; i < s.requests.size(); ++i) {
          const std::size_t which = (t + i) % s.requests.size();
          const Extraction answer = dataset->extract(s.requests[which]);
          right[t].push_back(answer.complete                           ? same_mesh(answer, s.answers[which]) ? 1 : 0
                             : answer.limited_by == LimitedBy::kMemory ? 1
                                                                       : 0);
        }
      });
    for (std::thread& thread : threads)
      thread.join();
    for (const auto& answers : right)
      CHECK(std::count(answers.begin(), answers.end(), 1) == static_cast<std::ptrdiff_t>(s.requests.size()));
  }
  CHECK(complete > 4);
  CHECK(incomplete > 4);
}

TEST_CASE("pinned blocks stay where memory is short, under the same ids") {
  const Sample& s = sample();
  OpenOptions options;
  options.memory_limit = s.decoded_bytes * 6 / 10;
  Hierarchy hierarchy(file::over_memory(s.bytes), options);
  Loader& loader = hierarchy.loader();
  BlockSet first(s.blocks.size(), 0), all(s.blocks.size(), 1);
  first[0] = 1;
  loader.close(first);
  loader.pin(first);
  {
    const Loader::Turn turn(loader);
    BlockSet wanted = first;
    loader.load(wanted);
    REQUIRE(wanted == first);
  }
  std::uint64_t dropped = 0;
  for (std::uint32_t b = 0; b < s.blocks.size(); ++b) {
    const Loader::Turn turn(loader);
    BlockSet wanted(s.blocks.size(), 0);
    wanted[b] = 1;
    loader.close(wanted);
    loader.load(wanted);
    const auto lock = hierarchy.lock();
    CHECK(loader.holds(first));
    CHECK(loader.holds(wanted));
    CHECK(hierarchy.content().refinement.validate().empty());
    dropped = loader.revision();
  }
  BlockSet wanted = all;
  {
    const Loader::Turn turn(loader);
    loader.load(wanted);
  }
  CHECK(wanted != all);
  loader.unpin(first);
  // Nothing holds them any more once other blocks take all the room.
  const auto lock = hierarchy.lock();
  std::uint64_t bytes = 0;
  file::Reader reader(file::over_memory(s.bytes));
  for (std::uint32_t b = 0; b < s.blocks.size(); ++b)
    if (hierarchy.content().block_loaded[b] != 0) bytes += reader.decoded_bytes(b);
  CHECK(bytes <= options.memory_limit);
  CHECK(loader.revision() >= dropped);
}

TEST_CASE("limits are kept before anything is allocated, and named") {
  const Sample& s = sample();
  const auto refusal = [&](const std::function<void(Limits&)>& change) {
    OpenOptions options;
    change(options.limits);
    try {
      (void)Dataset::open_memory(s.bytes, options);
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::kLimit);
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK(refusal([&](Limits& limits) { limits.max_vertices = s.mesh.vertex_count(); }).empty());
  CHECK(refusal([&](Limits& limits) { limits.max_vertices = s.mesh.vertex_count() - 1; }).find("vertices") !=
        std::string::npos);
  CHECK(refusal([&](Limits& limits) { limits.max_tets = s.mesh.tets.size(); }).empty());
  CHECK(refusal([&](Limits& limits) { limits.max_tets = s.mesh.tets.size() - 1; }).find("tets") != std::string::npos);
  CHECK(refusal([](Limits& limits) { limits.max_bytes = 0; }).find("memory") != std::string::npos);
  // A header that promises too much is refused before the mesh is made.
  CHECK(refusal([&](Limits& limits) { limits.max_bytes = s.mesh.vertex_count() * 100; }).find("memory") !=
        std::string::npos);
  // Where the fixed part fits, blocks are let in one by one.
  file::Reader reader(file::over_memory(s.bytes));
  OpenOptions options;
  options.limits.max_bytes = reader.fixed_bytes() + s.decoded_bytes / 2;
  const Extraction answer = Dataset::open_memory(s.bytes, options)->extract({});
  CHECK(answer.limited_by == LimitedBy::kMemory);
  check_sound(answer);
}

TEST_CASE("a session over a damaged file has the meshes that extractions have") {
  const Sample& s = sample();
  std::size_t incomplete = 0;
  for (std::uint32_t b = 0; b < s.blocks.size(); b += 2) {
    Bytes damaged = s.bytes;
    flip(damaged, 8 * s.blocks[b].offset + 77 % (8 * s.blocks[b].stored_bytes));
    const auto dataset = Dataset::open_memory(damaged);
    Session session(dataset);
    RandomRequests requests(dataset->info(), b, 3);
    for (int i = 0; i < 20; ++i) {
      INFO("block " << b << ", request " << i);
      const Request request = requests.next();
      const SessionUpdate& update = session.update(request);
      const Extraction answer = dataset->extract(request);
      CHECK(update.complete == answer.complete);
      CHECK(difference(session, update, answer) == (answer.complete ? "" : "it is not complete"));
      CHECK(same_mesh(session.extraction(), answer));
      CHECK(update.failures.size() == answer.failures.size());
      incomplete += answer.complete ? 0 : 1;
    }
  }
  CHECK(incomplete > s.blocks.size());
}

TEST_CASE("a block that turns out wrong under a session makes it start over") {
  const Sample& s = sample();
  std::size_t damaged_files = 0;
  for (unsigned seed = 0; seed < 40 && damaged_files < 8; ++seed) {
    std::mt19937 random(seed);
    FileParts parts(s.bytes);
    Bytes& blocks = parts.of(file::SectionKind::kBlocks);
    flip(blocks, random() % (8 * blocks.size()));
    parts.mend_blocks();
    std::shared_ptr<const Dataset> dataset;
    try {
      dataset = Dataset::open_memory(parts.join());
    } catch (const Error&) {
      continue;
    }
    Session session(dataset);
    const SessionUpdate& coarse = session.update(error_request(0.3)); // before the damage is met, as a rule
    CHECK(coarse.tets > 0);
    for (const Request& request : {Request{}, error_request(0.02), error_request(0.3)}) {
      const SessionUpdate& update = session.update(request);
      const Extraction answer = dataset->extract(request);
      CHECK(difference(session, update, answer) == (answer.complete ? "" : "it is not complete"));
      damaged_files += answer.complete ? 0 : 1;
    }
  }
  CHECK(damaged_files > 4);
}

TEST_CASE("sessions live on where memory is short") {
  const Sample& s = sample();
  std::size_t complete = 0, incomplete = 0;
  for (const double share : {0.4, 0.7, 0.95}) {
    OpenOptions options;
    options.memory_limit = static_cast<std::uint64_t>(share * static_cast<double>(s.decoded_bytes));
    const auto dataset = Dataset::open_memory(s.bytes, options);
    std::vector<Session> sessions;
    for (int k = 0; k < 2; ++k)
      sessions.emplace_back(dataset);
    for (std::size_t i = 0; i < 4 * s.requests.size(); ++i) {
      INFO("share " << share << ", request " << i);
      (void)dataset->extract(
          s.requests[(i * 5 + 2) % s.requests.size()]); // what it needs drives out what others do not
      const std::size_t which = i % s.requests.size();
      Session& session = sessions[(i / 3) % 2];
      const SessionUpdate& update = session.update(s.requests[which]);
      if (update.complete) {
        CHECK(difference(session, update, s.answers[which]) == "");
        ++complete;
      } else {
        CHECK(update.limited_by == LimitedBy::kMemory);
        check_sound(session.extraction());
        ++incomplete;
      }
    }
  }
  CHECK(complete > 10);
  CHECK(incomplete > 4);
}

TEST_CASE("a session follows while a thread loads") {
  const Sample& s = sample();
  OpenOptions options;
  options.background = true;
  const auto dataset = Dataset::open_memory(s.bytes, options);
  Session session(dataset);
  for (std::size_t i = 0; i < s.requests.size(); ++i) {
    INFO("request " << i);
    for (int round = 0; round < 100 && !session.update(s.requests[i]).complete; ++round)
      dataset->wait_until_loaded();
    CHECK(difference(session, session.update(s.requests[i]), s.answers[i]) == "");
  }
}

TEST_CASE("a session reads as much as there is time for, and gets there") {
  const Sample& s = sample();
  for (const int delay_ms : {0, 15}) {
    const auto source = std::make_shared<FailingSource>(s.bytes);
    const auto dataset = Dataset::open(source);
    source->set([delay_ms](std::uint64_t, std::uint64_t) {
      std::this_thread::sleep_for(std::chrono::milliseconds(delay_ms));
      return false;
    });
    // One read, or as many as the time may have been enough for: each takes no less than the delay.
    const double ms = delay_ms == 0 ? 0 : 2.5 * delay_ms;
    const std::uint64_t reads_allowed = delay_ms == 0 ? 1 : 3;
    Session session(dataset);
    SlotCopy copy;
    std::size_t stopped = 0;
    for (const std::size_t i : {std::size_t{5}, std::size_t{3}, std::size_t{4}, std::size_t{2}, std::size_t{0}}) {
      INFO("request " << i << ", " << delay_ms << " ms a read");
      Request request = s.requests[i];
      request.max_milliseconds = ms;
      for (int round = 0; round < 1000; ++round) {
        const std::uint64_t reads = source->reads();
        const SessionUpdate& update = session.update(request);
        copy.follow(session, update);
        REQUIRE(copy.difference(session) == "");
        CHECK(source->reads() - reads <= reads_allowed);
        if (update.complete) break;
        CHECK(update.limited_by == LimitedBy::kTime);
        CHECK(update.failures.empty());
        if (source->reads() > reads && ++stopped % 8 == 1) check_sound(session.extraction());
      }
      const std::uint64_t reads = source->reads();
      CHECK(difference(session, session.update(s.requests[i]), s.answers[i]) == "");
      CHECK(source->reads() == reads);
    }
    CHECK(stopped >= s.blocks.size() / 3);
  }
}

TEST_CASE("who has little time does not wait for a thread that reads") {
  const Sample& s = sample();
  const auto source = std::make_shared<FailingSource>(s.bytes);
  const auto dataset = Dataset::open(source);
  Session session(dataset);
  std::atomic<bool> is_reading{false}, may_go_on{false};
  source->set([&](std::uint64_t, std::uint64_t) {
    is_reading = true;
    for (int ms = 0; ms < 10000 && !may_go_on; ++ms)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return false;
  });
  std::atomic<bool> is_read{false};
  std::thread reader([&] {
    (void)dataset->extract({});
    is_read = true;
  });
  while (!is_reading)
    std::this_thread::yield();
  Request request = s.requests[3];
  request.max_milliseconds = 20;
  const SessionUpdate& update = session.update(request);
  const Extraction extraction = dataset->extract(request);
  CHECK_FALSE(is_read);
  CHECK_FALSE(update.complete);
  CHECK(update.limited_by == LimitedBy::kTime);
  CHECK(update.failures.empty());
  CHECK(extraction.limited_by == LimitedBy::kTime);
  CHECK(extraction.failures.empty());
  CHECK(extraction.mesh.tets.size() == dataset->info().base_tets);
  may_go_on = true;
  reader.join();
  for (int round = 0; round < 100 && !session.update(request).complete; ++round) {
  }
  CHECK(difference(session, session.update(s.requests[3]), s.answers[3]) == "");
}

TEST_CASE("an extraction is cancelled while it reads and while it waits for another that does") {
  const Sample& s = sample();
  const auto source = std::make_shared<FailingSource>(s.bytes);
  const auto dataset = Dataset::open(source);
  const std::uint64_t opened = source->reads();
  std::atomic<bool> is_reading{false}, may_go_on{false};
  source->set([&](std::uint64_t offset, std::uint64_t count) {
    is_reading = true;
    std::this_thread::sleep_for(std::chrono::milliseconds(6));
    // No more than one block at a time.
    return std::any_of(s.blocks.begin(), s.blocks.end(), [&](const file::BlockInfo& block) {
      return block.offset > offset && block.offset < offset + count;
    });
  });
  int asked = 0;
  const auto third_time = [&](const Progress&) { return ++asked < 3; };
  const auto is_cancelled = [&] {
    asked = 0;
    try {
      (void)dataset->extract({}, third_time);
    } catch (const Error& error) {
      return error.code() == ErrorCode::kCancelled;
    }
    return false;
  };
  CHECK(is_cancelled());
  CHECK(source->reads() - opened <= 4);

  source->set([&](std::uint64_t, std::uint64_t) {
    is_reading = true;
    for (int ms = 0; ms < 10000 && !may_go_on; ++ms)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return false;
  });
  is_reading = false;
  std::thread reader([&] { (void)dataset->extract({}); });
  while (!is_reading)
    std::this_thread::yield();
  const std::uint64_t reads = source->reads();
  CHECK(is_cancelled());
  CHECK(source->reads() == reads);
  may_go_on = true;
  reader.join();
  source->set({});
  CHECK(same_mesh(dataset->extract({}), s.answers[0]));
}

TEST_CASE("loading that is cancelled leaves the blocks that were decoded, closed and sound") {
  const Sample& s = sample();
  std::set<std::ptrdiff_t> counts;
  for (int most = 1; most < 6; ++most) {
    Hierarchy hierarchy(file::over_memory(s.bytes));
    int asked = 0;
    const ProgressCallback progress = [&](const Progress&) {
      std::this_thread::sleep_for(std::chrono::milliseconds(6)); // so that it is asked the next time, too
      return ++asked <= most;
    };
    BlockSet all(s.blocks.size(), 1);
    try {
      Cancellation cancellation(progress);
      hierarchy.loader().load(all, &cancellation);
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::kCancelled);
      CHECK(asked == most + 1);
    }
    const BlockSet loaded = hierarchy.content().block_loaded;
    counts.insert(std::count(loaded.begin(), loaded.end(), 1));
    BlockSet closed = loaded;
    hierarchy.close(closed);
    CHECK(closed == loaded);
    const bool is_whole = closed == BlockSet(s.blocks.size(), 1);
    if (!is_whole) CHECK(hierarchy.content().refinement.validate().empty()); // packed once it is
    all.assign(s.blocks.size(), 1);
    hierarchy.load(all);
    CHECK(hierarchy.loader().holds(BlockSet(s.blocks.size(), 1)));
  }
  CHECK(counts.size() >= 3); // none, some, all
}

TEST_CASE("progress is told now and then, however many blocks there are") {
  const Sample& s = sample();
  for (const Request& asked : s.requests) {
    Request request = asked;
    request.max_milliseconds = 1e6;
    int calls = 0;
    const auto begin = std::chrono::steady_clock::now();
    const Extraction extraction = Dataset::open_memory(s.bytes)->extract(request, [&](const Progress&) {
      ++calls;
      return true;
    });
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    CHECK(extraction.complete);
    CHECK(calls >= 1);
    CHECK(calls <= 1 + 300 * seconds);
  }
}

TEST_CASE("what is dropped where memory is short need not be read again at once") {
  const Sample& s = sample();
  const auto source = std::make_shared<FailingSource>(s.bytes);
  OpenOptions options;
  options.memory_limit = s.decoded_bytes * 9 / 10;
  const auto dataset = Dataset::open(source, options);
  std::uint64_t stored = 0, answered = 0;
  for (const file::BlockInfo& block : s.blocks)
    stored += block.stored_bytes;
  const std::uint64_t opened = source->bytes_given();
  for (int round = 0; round < 6; ++round)
    for (const Request& request : s.requests)
      answered += dataset->extract(request).complete ? 1 : 0;
  CHECK(answered >= 6);
  CHECK(source->bytes_given() - opened <= stored);
}

TEST_CASE("a session with little time over a source that fails asks for a block once a call") {
  const Sample& s = sample();
  const std::uint64_t bad = s.blocks[1].offset;
  std::uint64_t failed = 0;
  const auto source = std::make_shared<FailingSource>(s.bytes, [&](std::uint64_t offset, std::uint64_t count) {
    const bool fails = offset <= bad && bad - offset < count;
    failed += fails ? 1 : 0;
    return fails;
  });
  const auto dataset = Dataset::open(source);
  Session session(dataset);
  Request request;
  request.max_milliseconds = 1e6;
  failed = 0;
  const SessionUpdate& update = session.update(request);
  CHECK_FALSE(update.complete);
  CHECK(update.limited_by == LimitedBy::kUnreadable);
  REQUIRE(update.failures.size() == 1);
  CHECK(update.failures[0].block == 1);
  CHECK(failed <= 2); // with its neighbours, and alone
  CHECK(difference(session, update, dataset->extract({})) == "it is not complete");
  source->set({});
  CHECK(session.update(request).complete);
  CHECK(difference(session, session.update(request), s.answers[0]) == "");
}

TEST_CASE("a session knows what made its tets as far as blocks are there") {
  const Sample& s = sample();
  for (unsigned seed = 0; seed < 4; ++seed) {
    // More and more of the file can be read: what was taken for an original tet turns out to be made.
    auto lost = std::make_shared<std::set<std::uint32_t>>();
    for (std::uint32_t b = 0; b < s.blocks.size(); ++b)
      lost->insert(b);
    const auto source = std::make_shared<FailingSource>(s.bytes, [&s, lost](std::uint64_t offset, std::uint64_t count) {
      return std::any_of(lost->begin(), lost->end(), [&](std::uint32_t b) {
        return offset < s.blocks[b].offset + s.blocks[b].stored_bytes && s.blocks[b].offset < offset + count;
      });
    });
    const auto dataset = Dataset::open(source);
    Session session(dataset);
    SlotCopy copy;
    std::mt19937 random(seed);
    RandomRequests requests(dataset->info(), seed, 10);
    std::size_t unknown = 0;
    for (int round = 0;; ++round) {
      Request request = requests.next();
      if (round % 2 == 0) { // what is read then is finer than what is split, and made tets that stay
        request = {};
        request.max_vertices = s.base_vertices + random() % (dataset->info().vertices / 3);
        request.origins = true;
      }
      const SessionUpdate& update = session.update(request);
      copy.follow(session, update);
      REQUIRE(copy.difference(session) == "");
      if (request.origins) {
        REQUIRE(difference(session, update, dataset->extract(request)) ==
                (update.complete ? "" : "it is not complete"));
        unknown += check_origins(session);
      }
      if (lost->empty()) {
        if (update.complete && request.origins) break;
        continue;
      }
      auto found = lost->begin();
      std::advance(found, random() % lost->size());
      lost->erase(found);
    }
    CHECK(unknown > 0);
    CHECK(check_origins(session) == 0);
  }
}

TEST_CASE("origins tell errors, levels and generations") {
  const Sample& s = sample();
  const auto dataset = Dataset::open_memory(s.bytes);
  Request request = error_request(0.1);
  const std::size_t fields = s.stream.fields.size();
  std::map<VertexId, std::size_t> brought; // by vertex of the original
  for (std::size_t i = 0; i < s.stream.removed.size(); ++i)
    brought[s.stream.removed[i]] = i;
  request.origins = true;
  const Extraction answer = dataset->extract(request);
  std::vector<double> values(answer.made_by.size());
  for (std::size_t f = 0; f <= fields; ++f) {
    dataset->origin_values(answer.made_by, f < fields ? OriginValue::kFieldError : OriginValue::kDomainError, f,
                           values);
    double most = 0;
    for (std::size_t t = 0; t < values.size(); ++t) {
      const RecordId r = answer.made_by[t];
      most = std::max(most, values[t]);
      if (r.is_none()) {
        CHECK(values[t] == 0);
        continue;
      }
      const std::size_t i = brought.at(s.to_original[s.base_vertices + r.index()]);
      const double exact = f < fields ? s.stream.field_error[i * fields + f] : s.stream.domain_error[i];
      CHECK(values[t] >= exact);
      CHECK(values[t] <= exact * 1.05 + 1e-9);
    }
    if (f < fields) CHECK(most == answer.field_error[f]);
  }
  std::vector<double> generations(values.size());
  dataset->origin_values(answer.made_by, OriginValue::kLevel, 0, values);
  dataset->origin_values(answer.made_by, OriginValue::kGeneration, 0, generations);
  for (std::size_t t = 0; t < values.size(); ++t) {
    const RecordId r = answer.made_by[t];
    CHECK((values[t] == 0) == r.is_none());
    if (r.is_none()) continue;
    const double share =
        static_cast<double>(s.base_vertices + r.index() + 1) / static_cast<double>(dataset->info().vertices);
    CHECK(share <= std::pow(2.0, 1 - values[t]));
    CHECK(share > std::pow(2.0, -values[t]));
    CHECK(generations[t] >= 0);
  }
  CHECK(*std::max_element(generations.begin(), generations.end()) > 1);
  const auto fresh = Dataset::open_memory(s.bytes);
  const std::vector<RecordId> last{RecordId{static_cast<std::uint32_t>(fresh->info().records - 1)}};
  std::vector<double> one(1);
  fresh->origin_values(last, OriginValue::kGeneration, 0, one);
  CHECK(std::isnan(one[0]));
  CHECK_THROWS_AS(fresh->origin_values(last, OriginValue::kFieldError, fields, one), Error);
  CHECK_THROWS_AS(fresh->origin_values(last, OriginValue::kLevel, 0, values), Error);
  const std::vector<RecordId> none_such{RecordId{static_cast<std::uint32_t>(fresh->info().records)}};
  CHECK_THROWS_AS(fresh->origin_values(none_such, OriginValue::kLevel, 0, one), Error);
}
