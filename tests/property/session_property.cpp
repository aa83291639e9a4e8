// One session through many random requests: at each the mesh must be the one that a fresh extraction gives.
#include "formats/ptet/reader.hpp"
#include "formats/ptet/writer.hpp"
#include "ptet/session.hpp"
#include "support/mesh_checks.hpp"
#include "support/meshes.hpp"
#include "support/naive_simplifier.hpp"
#include "support/session_checks.hpp"
#include "support/stream_extras.hpp"

#include <atomic>
#include <cstdlib>
#include <map>
#include <new>
#include <thread>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

std::atomic<long> allocations{0};

} // namespace

// Every allocation of this program, counted. Not inlined: GCC 12 takes the inlined halves for a mismatched pair.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* const memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++allocations;
  return std::malloc(size == 0 ? 1 : size);
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace {

struct Sample {
  std::string name;
  std::vector<std::byte> bytes;
};

// With dependencies between any two records, squared errors, and budgets that go by errors; many blocks, so that they
// are read one after the other.
const std::vector<Sample>& samples() {
  static const std::vector<Sample> made = [] {
    std::vector<Sample> list;
    for (const auto& [name, mesh] : test::sample_meshes(29)) {
      RecordStream stream = test::simplify_naively(mesh);
      test::add_random_dependencies(stream, 31);
      test::add_random_squared_errors(stream, 37);
      test::add_budget_weights(stream);
      list.push_back({name, file::encode(mesh, stream, {"test", name, "", {}, {}})});
    }
    return list;
  }();
  return made;
}

/// What a session begins with.
Request base_mesh() {
  Request request;
  request.max_tets = 0;
  return request;
}

/// Conforming, whatever it is that the session stopped at.
void check_is_conforming(const Session& session) {
  const Extraction now = session.extraction();
  const test::MeshFacts facts = test::examine(now.mesh);
  CHECK(facts.repeated_tets == 0);
  CHECK(facts.crowded_faces == 0);
  CHECK(facts.folded_faces == 0);
  std::vector<test::Face> boundary;
  for (const test::Face& face : now.boundary_faces)
    boundary.push_back(test::turned(face));
  std::sort(boundary.begin(), boundary.end());
  CHECK(boundary == facts.boundary);
}

} // namespace

TEST_CASE("a session goes from any request to any other") {
  for (const Sample& sample : samples()) {
    const auto shared = Dataset::open_memory(sample.bytes);
    Session session(shared);
    test::SlotCopy copy;
    test::RandomRequests requests(shared->info(), 101);
    SessionUpdate before = session.update(base_mesh());
    copy.follow(session, before);
    for (int i = 0; i < 150; ++i) {
      INFO(sample.name << ", request " << i);
      const Request request = requests.next();
      const SessionUpdate& update = session.update(request);
      REQUIRE(test::difference(session, update, Dataset::open_memory(sample.bytes)->extract(request)) == "");
      copy.follow(session, update);
      REQUIRE(copy.difference(session) == "");
      REQUIRE(update.tets == before.tets + update.tets_added - update.tets_removed);
      REQUIRE(update.vertices == before.vertices + update.vertices_added - update.vertices_removed);
      REQUIRE(update.vertices_added <= update.vertices);
      const std::uint64_t tets = update.tets;
      before = update;
      const SessionUpdate& again = session.update(request);
      REQUIRE(again.splits + again.collapses + again.changed_tets.size() + again.changed_vertices.size() == 0);
      REQUIRE(again.tets == tets);
    }
  }
}

TEST_CASE("vertices of no tet come with the original and go with it") {
  test::GridOptions options;
  options.cells = {3, 3, 3};
  TetMesh mesh = test::grid(options);
  const auto more = [](PointArray& array) { array.bytes.resize(array.bytes.size() + 7 * array.row_bytes()); };
  more(mesh.positions);
  for (PointArray& array : mesh.point_arrays)
    more(array);
  const auto shared =
      Dataset::open_memory(file::encode(mesh, test::simplify_naively(mesh), {"test", "unused vertices", "", {}, {}}));
  Session session(shared);
  const std::uint64_t few = session.update(base_mesh()).vertices;
  const SessionUpdate whole = session.update({});
  CHECK(whole.vertices == mesh.vertex_count());
  CHECK(whole.vertices_added == mesh.vertex_count() - few);
  const SessionUpdate& again = session.update(base_mesh());
  CHECK(again.vertices_added == 0);
  CHECK(again.vertices_removed == mesh.vertex_count() - few);
}

TEST_CASE("a session needs a dataset") {
  CHECK_THROWS_AS(Session(nullptr), Error);
}

TEST_CASE("a refused request leaves a session as it was") {
  for (const Sample& sample : samples()) {
    const auto shared = Dataset::open_memory(sample.bytes);
    Session session(shared);
    Request request;
    request.field_error = {{"", {0.1, true}}};
    const SessionUpdate update = session.update(request);
    Request wrong;
    wrong.focus = {{Sphere{shared->info().box_min, shared->info().diagonal}}};
    wrong.values = {{"no such field", 0, 1}};
    wrong.origins = true;
    CHECK_THROWS_AS(session.update(wrong), Error);
    CHECK(test::difference(session, update, Dataset::open_memory(sample.bytes)->extract(request)) == "");
  }
}

TEST_CASE("where errors may grow by nothing on the way, they may not be there at all, however far") {
  for (const Sample& sample : samples()) {
    Request request;
    request.focus = {{Sphere{{1.5e308, 1.5e308, 1.5e308}, 1}, {0, true}, Bound{0, true}}};
    const Extraction cut = Dataset::open_memory(sample.bytes)->extract(request);
    for (const double error : cut.field_error)
      CHECK(error == 0);
  }
}

TEST_CASE("a session knows which record made each tet, as long as it is asked") {
  for (const Sample& sample : samples()) {
    // A dataset of its own: what made a tet may be read only when origins are asked for again.
    const auto own = Dataset::open_memory(sample.bytes);
    Session session(own);
    test::SlotCopy copy;
    test::RandomRequests requests(own->info(), 109, 6);
    for (int i = 0; i < 40; ++i) {
      INFO(sample.name << ", request " << i);
      const Request request = requests.next();
      const SessionUpdate& update = session.update(request);
      const Extraction fresh = Dataset::open_memory(sample.bytes)->extract(request);
      REQUIRE(test::difference(session, update, fresh) == "");
      copy.follow(session, update);
      REQUIRE(copy.difference(session) == "");
      REQUIRE(session.made_by().empty() == !request.origins);
    }
  }
}

TEST_CASE("slots are given back where hardly any are used, and stay otherwise") {
  const TetMesh mesh = test::grid({{10, 10, 10}, {}, 2, 5});
  const std::vector<std::byte> bytes = file::encode(mesh, test::simplify_naively(mesh), {"test", "grid", "", {}, {}});
  const auto shared = Dataset::open_memory(bytes);
  const std::uint64_t tets = shared->info().tets;
  REQUIRE(tets > 4096);
  REQUIRE(shared->info().base_tets < tets / 8);
  Session session(shared);
  test::SlotCopy copy;
  int renumbered = 0;
  for (const std::uint64_t max_tets :
       {tets, tets / 3, tets / 5, tets / 2, std::uint64_t{0}, tets, tets / 10, tets / 12, tets}) {
    for (const bool without_time : {true, false}) {
      Request request;
      request.max_tets = max_tets;
      request.origins = max_tets != tets / 2;
      if (without_time) request.max_milliseconds = 0;
      const std::size_t slots_before = session.tets().size();
      const std::vector<VertexId> before(session.vertex_in_file().begin(), session.vertex_in_file().end());
      const SessionUpdate& update = session.update(request);
      INFO("max_tets " << max_tets << ", " << slots_before << " slots before");
      if (without_time)
        check_is_conforming(session);
      else
        REQUIRE(test::difference(session, update, shared->extract(request)) == "");
      copy.follow(session, update);
      REQUIRE(copy.difference(session) == "");
      if (update.renumbered) {
        CHECK(update.complete);
        CHECK(session.tets().size() == update.tets);
        CHECK(session.boundary_faces().size() == update.boundary_faces);
        CHECK(session.vertex_in_file().size() == update.vertices);
        CHECK(session.positions().size() == update.vertices);
        CHECK(update.changed_tets.size() == update.tets);
        CHECK(slots_before > 4096);
        CHECK(4 * update.tets < slots_before);
        ++renumbered;
        continue;
      }
      if (update.complete) CHECK((slots_before <= 4096 || 4 * update.tets >= slots_before));
      std::map<VertexId, std::uint32_t> slot_of;
      for (std::uint32_t slot = 0; slot < session.vertex_in_file().size(); ++slot)
        if (!session.vertex_in_file()[slot].is_none()) slot_of[session.vertex_in_file()[slot]] = slot;
      bool stayed = session.tets().size() >= slots_before;
      for (std::uint32_t slot = 0; slot < before.size(); ++slot)
        if (const auto now = slot_of.find(before[slot]); now != slot_of.end()) stayed = stayed && now->second == slot;
      CHECK(stayed);
    }
  }
  CHECK(renumbered >= 2);
}

TEST_CASE("a session without time stops at a mesh, and gets there in the end") {
  for (const Sample& sample : samples()) {
    INFO(sample.name);
    const auto shared = Dataset::open_memory(sample.bytes);
    (void)shared->extract({}); // there is nothing to read
    Session session(shared);
    test::SlotCopy copy;
    test::RandomRequests requests(shared->info(), 103, 2);
    int stopped = 0;
    for (int i = 0; i < 40; ++i) {
      Request request = requests.next();
      request.max_milliseconds = 0;
      // A request is left for the next one before it is met, at times.
      for (int updates = 0; updates < (i % 3 == 0 ? 1 : 100); ++updates) {
        const SessionUpdate& update = session.update(request);
        copy.follow(session, update);
        REQUIRE(copy.difference(session) == "");
        check_is_conforming(session);
        if (request.origins) REQUIRE(test::differing_origin(session) == "");
        CHECK((update.limited_by == LimitedBy::kTime) == !update.complete);
        CHECK(session.extraction().complete); // no block is missing, whatever time there was
        if (update.complete) {
          request.max_milliseconds.reset();
          REQUIRE(test::difference(session, update, shared->extract(request)) == "");
          break;
        }
        REQUIRE(update.splits + update.collapses > 0);
        ++stopped;
      }
    }
    CHECK(stopped > 10);
  }
}

TEST_CASE("blocks that a session had no time to read are not missing") {
  for (const Sample& sample : samples()) {
    INFO(sample.name);
    const bool has_budget = GENERATE(false, true);
    CAPTURE(has_budget);
    const auto shared = Dataset::open_memory(sample.bytes);
    Session session(shared);
    Request request;
    request.max_milliseconds = 0;
    if (has_budget) request.max_tets = shared->info().tets;
    int stopped = 0;
    while (!session.update(request).complete) {
      REQUIRE(++stopped < 10'000);
      const Extraction now = session.extraction();
      CHECK(now.complete);
      CHECK(now.failures.empty());
      CHECK(now.limited_by == LimitedBy::kTime);
    }
    CHECK(stopped > 3);
  }
}

TEST_CASE("sessions of many threads share a dataset") {
  for (const Sample& sample : samples()) {
    INFO(sample.name);
    const auto shared = Dataset::open_memory(sample.bytes);
    std::vector<Session> sessions;
    std::vector<std::string> found(8);
    for (std::size_t i = 0; i < found.size(); ++i)
      sessions.emplace_back(shared);
    const auto run = [&](std::size_t first) {
      for (std::size_t i = first; i < sessions.size(); i += 2) {
        test::RandomRequests requests(shared->info(), static_cast<unsigned>(i));
        for (int k = 0; k < 10 && found[i].empty(); ++k) {
          const Request request = requests.next();
          const SessionUpdate& update = sessions[i].update(request);
          found[i] = test::difference(sessions[i], update, shared->extract(request));
        }
      }
    };
    std::thread other(run, 1);
    run(0);
    other.join();
    for (const std::string& difference : found)
      CHECK(difference == "");
  }
}

TEST_CASE("sessions of many threads share a dataset that is still read, whatever time and memory there is") {
  const TetMesh mesh = test::grid({{9, 9, 9}, {}, 2, 5});
  const std::vector<std::byte> bytes = file::encode(mesh, test::simplify_naively(mesh), {"test", "grid", "", {}, {}});
  const auto whole = Dataset::open_memory(bytes);
  (void)whole->extract({});
  const file::Reader reader(file::over_memory(bytes));
  std::uint64_t decoded_bytes = 0;
  for (std::uint32_t b = 0; b < reader.blocks().size(); ++b)
    decoded_bytes += reader.decoded_bytes(b);
  for (const bool background : {false, true}) {
    for (const double share : {0.0, 0.7}) {
      INFO("background " << background << ", memory " << share);
      OpenOptions options;
      options.background = background;
      options.memory_limit = static_cast<std::uint64_t>(share * static_cast<double>(decoded_bytes));
      const auto shared = Dataset::open_memory(bytes, options);
      std::vector<Session> sessions;
      std::vector<std::string> found(8);
      for (std::size_t i = 0; i < found.size(); ++i)
        sessions.emplace_back(shared);
      std::atomic<int> complete{0}, short_of_memory{0};
      // Origins take all blocks.
      const std::optional<unsigned> without_origins = share > 0 ? std::nullopt : std::optional(3U);
      const auto follow = [&](Session& session, Request request, bool in_steps) -> std::string {
        if (in_steps) request.max_milliseconds = 0;
        for (int round = 0; round < 10000; ++round) {
          const SessionUpdate& update = session.update(request);
          if (update.limited_by == LimitedBy::kLoading) shared->wait_until_loaded();
          if (update.limited_by == LimitedBy::kTime || update.limited_by == LimitedBy::kLoading) continue;
          if (!update.complete) {
            ++short_of_memory;
            return update.limited_by == LimitedBy::kMemory ? "" : "it is not complete";
          }
          ++complete;
          request.max_milliseconds.reset();
          return test::difference(session, update, whole->extract(request));
        }
        return "it does not end";
      };
      const auto run = [&](std::size_t first) {
        std::vector<test::RandomRequests> requests;
        for (std::size_t i = first; i < sessions.size(); i += 2)
          requests.emplace_back(shared->info(), static_cast<unsigned>(40 + i), without_origins);
        for (int k = 0; k < 12; ++k)
          for (std::size_t i = first; i < sessions.size(); i += 2)
            if (found[i].empty()) found[i] = follow(sessions[i], requests[i / 2].next(), k % 2 == 1);
      };
      std::thread other(run, 1);
      run(0);
      other.join();
      for (const std::string& difference : found)
        CHECK(difference == "");
      CHECK(complete > 3);
      CHECK((short_of_memory > 0) == (share > 0));
    }
  }
}

TEST_CASE("a session that has seen its requests allocates nothing") {
  for (const Sample& sample : samples()) {
    INFO(sample.name);
    const auto shared = Dataset::open_memory(sample.bytes);
    const DatasetInfo& info = shared->info();
    std::vector<Request> requests;
    for (int i = 0; i < 60; ++i) {
      Request request;
      const double way = i / 59.0;
      Point centre{};
      for (std::size_t axis = 0; axis < 3; ++axis)
        centre[axis] = info.box_min[axis] + way * (info.box_max[axis] - info.box_min[axis]);
      request.focus = {{Sphere{centre, 0.1 * info.diagonal}}};
      for (int nested = 1; nested < 12 && i % 6 == 5; ++nested) // more than one block's wants have room for at first
        request.focus.push_back({Sphere{centre, 0.1 * info.diagonal / nested}, {0.02 * nested, true}});
      if (i % 3 == 0) request.field_error = {{"", {0.05 + 0.01 * (i % 7), true}}};
      if (i % 3 == 1) request.max_tets = info.tets / 3;
      if (i % 6 == 4) {
        request.view = View{info.box_max, {-1, -1, -1 + 0.02 * i}};
        request.view->max_pixels = 1;
      }
      request.origins = true;
      requests.push_back(request);
    }
    Session session(shared);
    std::uint64_t changes = 0;
    for (int round = 0; round < 2; ++round)
      for (const Request& request : requests)
        session.update(request);
    const long before = allocations;
    for (const Request& request : requests) {
      const SessionUpdate& update = session.update(request);
      changes += update.splits + update.collapses;
    }
    CHECK(allocations == before);
    CHECK(changes > 100);
  }
}

TEST_CASE("a session that is asked the same again changes nothing, with a view and a budget too") {
  for (const Sample& sample : samples()) {
    const auto shared = Dataset::open_memory(sample.bytes);
    Request request;
    request.view = View{shared->info().box_max, {-1, -1, -1}};
    request.view->max_pixels = GENERATE(0.0, 1.0);
    request.max_tets = shared->info().tets / 2;
    Session session(shared);
    const std::uint64_t tets = session.update(request).tets;
    session.update(request);
    const long before = allocations;
    const SessionUpdate& again = session.update(request);
    CHECK(allocations == before);
    CHECK(again.splits + again.collapses == 0);
    CHECK(again.tets == tets);
    CHECK(again.limited_by == shared->extract(request).limited_by);
  }
}
