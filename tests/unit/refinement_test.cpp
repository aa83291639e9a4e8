#include "record/ghost.hpp"
#include "record/refinement.hpp"
#include "support/mesh_checks.hpp"
#include "support/meshes.hpp"

#include <algorithm>
#include <set>

#include <catch2/catch.hpp>

using namespace ptet;

namespace ptet {

/// What no caller can do.
struct RefinementDamage {
  static void count_more(Refinement& r) { ++r.version_count_; }
  static void add_a_place(Refinement& r) { r.live_.emplace_back(); }
  static void swap_base(Refinement& r) {
    auto& tets = r.base_tets_;
    for (auto& live : r.live_)
      if (live.tet == tets.back()) std::swap(live.tet[0], live.tet[1]);
  }
  static void disown(Refinement& r) {
    for (auto& live : r.live_)
      if (live.tet[0] == r.vertex_of(RecordId{0})) std::swap(live.tet[1], live.tet[2]);
  }
  static void point_beyond(Refinement& r) { neighbour_of_first(r) = 1000; }
  static void point_elsewhere(Refinement& r) { neighbour_of_first(r) = 0; }
  static void point_one_way(Refinement& r) {
    const std::uint32_t behind = neighbour_of_first(r);
    auto& back = r.live_[behind].neighbour;
    *std::find(back.begin(), back.end(), 0U) = Refinement::kNoPlace;
  }

private:
  static std::uint32_t& neighbour_of_first(Refinement& r) {
    auto& neighbours = r.live_.front().neighbour;
    return *std::find_if(neighbours.begin(), neighbours.end(),
                         [](auto behind) { return behind != Refinement::kNoPlace; });
  }
};

} // namespace ptet

namespace {

Tet tet(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  return {VertexId{a}, VertexId{b}, VertexId{c}, VertexId{d}};
}
const std::uint32_t kW = kDummyVertex.index();

ErrorCode code_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.code();
  }
  FAIL("nothing was thrown");
  return ErrorCode::kBadArgument;
}

std::set<Tet> present_tets(const Refinement& r) {
  std::set<Tet> tets;
  for (std::uint32_t place = 0; place < r.place_count(); ++place)
    tets.insert(test::sorted_keeping_orientation(r.tet(place)));
  return tets;
}

std::uint32_t find(const Refinement& r, const Tet& wanted) {
  for (std::uint32_t place = 0; place < r.place_count(); ++place)
    if (test::sorted_keeping_orientation(r.tet(place)) == test::sorted_keeping_orientation(wanted)) return place;
  return Refinement::kNoPlace;
}

// The tet (0, 1, 2, 3) gains vertex 4, which takes over from vertex 0 the tet and its ghost at the face (0, 2, 1):
//
//   C = (0 1 2 3), (0 2 1 w)   ->   F = (4 1 2 3), (4 2 1 w), and around the edge (0, 4): (0 4 2 3), (0 1 4 3),
//                                       (0 2 4 w), (0 4 1 w)
void split_single_tet(Refinement& r, std::vector<GrowthFace>& asked) {
  const std::uint32_t seed = 0;
  r.split(RecordId{0}, VertexId{0}, std::span(&seed, 1), [&](const GrowthFace& face) {
    asked.push_back(face);
    return is_ghost(r.tet(face.behind)) && face.c == VertexId{3};
  });
}

} // namespace

TEST_CASE("refinement: the boundary of a single tet is closed by four ghosts, oriented like the tet") {
  const Refinement r({tet(0, 1, 2, 3)}, 4, 0);
  CHECK(r.base_place_count() == 5);
  CHECK(r.base_tet_count() == 1);
  CHECK(present_tets(r) == std::set<Tet>{tet(0, 1, 2, 3), test::sorted_keeping_orientation(tet(0, 2, 1, kW)),
                                         test::sorted_keeping_orientation(tet(1, 2, 3, kW)),
                                         test::sorted_keeping_orientation(tet(0, 3, 2, kW)),
                                         test::sorted_keeping_orientation(tet(0, 1, 3, kW))});
  CHECK(r.validate().empty());
}

TEST_CASE("refinement: a split of the single tet") {
  Refinement r({tet(0, 1, 2, 3)}, 4, 1);
  std::vector<GrowthFace> asked;
  split_single_tet(r, asked);
  CHECK(r.validate().empty());
  std::set<Tet> expected;
  for (const Tet& t : {tet(4, 1, 2, 3), tet(4, 2, 1, kW), tet(0, 4, 2, 3), tet(0, 1, 4, 3), tet(0, 2, 4, kW),
                       tet(0, 4, 1, kW), tet(1, 2, 3, kW), tet(0, 3, 2, kW), tet(0, 1, 3, kW)})
    expected.insert(test::sorted_keeping_orientation(t));
  CHECK(present_tets(r) == expected);
  CHECK(r.fine_count(RecordId{0}) == 6);
  CHECK(r.added_tet_count(RecordId{0}) == 2);
  CHECK(r.parents(RecordId{0}).empty());
  CHECK(r.target(RecordId{0}) == VertexId{0});
  CHECK(r.version_count() == 11);
  CHECK(r.consumer(0) == RecordId{0});
  for (std::uint32_t k = 0; k < 6; ++k) {
    const std::uint32_t place = r.fine_place(RecordId{0}, k);
    CHECK(r.fine_in_place(RecordId{0}, place) == k);
    CHECK(r.tet(place) == r.fine_tets(RecordId{0})[k]);
    CHECK(r.tet(place)[0] == VertexId{4});
    CHECK(r.consumer(place) == RecordId{0});
  }
  for (std::uint32_t place = 0, others = 0; place < r.place_count(); ++place)
    if (r.fine_in_place(RecordId{0}, place) == 6) {
      CHECK(++others <= 3);
      CHECK(r.consumer(place).is_none());
    }
  // Three faces of the tet, then two of the ghost; each seen from its region tet.
  REQUIRE(asked.size() == 5);
  for (std::size_t i = 0; i < 5; ++i) {
    CHECK(asked[i].u == VertexId{0});
    const Tet seen = test::sorted_keeping_orientation({asked[i].u, asked[i].a, asked[i].b, asked[i].c});
    CHECK(seen == test::sorted_keeping_orientation(i < 3 ? tet(0, 1, 2, 3) : tet(0, 2, 1, kW)));
  }
}

TEST_CASE("refinement: a second split knows its parent") {
  Refinement r({tet(0, 1, 2, 3)}, 4, 2);
  std::vector<GrowthFace> asked;
  split_single_tet(r, asked);
  const std::uint32_t seed = find(r, tet(4, 1, 2, 3));
  const std::set<Tet> region = {test::sorted_keeping_orientation(tet(4, 1, 2, 3)),
                                test::sorted_keeping_orientation(tet(1, 2, 3, kW))};
  r.split(RecordId{1}, VertexId{1}, std::span(&seed, 1), [&](const GrowthFace& face) {
    return region.count(test::sorted_keeping_orientation(r.tet(face.behind))) != 0;
  });
  CHECK(r.validate().empty());
  REQUIRE(r.parents(RecordId{1}).size() == 1);
  CHECK(r.parents(RecordId{1})[0] == RecordId{0});
  CHECK(r.applied_count() == 2);
}

TEST_CASE("refinement: boundary faces at a non-manifold edge have no neighbour there") {
  const TetMesh mesh = test::pinched_edge();
  const Refinement r(mesh.tets, 6, 1);
  CHECK(r.base_place_count() == 10);
  CHECK(r.validate().empty());
  const TetMesh vertex = test::pinched_vertex();
  CHECK(Refinement(vertex.tets, 7, 0).validate().empty());
}

TEST_CASE("refinement: vertices without a tet and an empty mesh are fine") {
  CHECK(Refinement({tet(0, 1, 2, 3)}, 9, 0).validate().empty());
  CHECK(Refinement({}, 0, 0).validate().empty());
  CHECK(Refinement({}, 3, 2).version_count() == 0);
}

TEST_CASE("refinement: a bad base mesh is refused") {
  const auto base = [](std::vector<Tet> tets) { return code_of([&] { const Refinement r(std::move(tets), 6, 0); }); };
  CHECK(base({tet(0, 1, 2, 6)}) == ErrorCode::kCorruptFile);
  CHECK(base({tet(0, 1, 2, kW)}) == ErrorCode::kCorruptFile);
  CHECK(base({tet(0, 1, 2, 1)}) == ErrorCode::kCorruptFile);
  CHECK(base({tet(0, 1, 2, 3), tet(0, 1, 2, 3)}) == ErrorCode::kCorruptFile);
  CHECK(base({tet(0, 1, 2, 3), tet(0, 2, 1, 4), tet(0, 2, 1, 5)}) == ErrorCode::kCorruptFile);
  CHECK(code_of([] { const Refinement r({}, 0xFFFFFFF0U, 0x20); }) == ErrorCode::kLimit);
  CHECK(code_of([] { const Refinement r({}, 0, 0x80000000U); }) == ErrorCode::kLimit);
}

TEST_CASE("refinement: a split that cannot be is refused") {
  const auto split = [](std::uint32_t record, std::uint32_t target, std::vector<std::uint32_t> seeds, bool joins) {
    Refinement r({tet(0, 1, 2, 3)}, 4, 1);
    return code_of(
        [&] { r.split(RecordId{record}, VertexId{target}, seeds, [&](const GrowthFace&) { return joins; }); });
  };
  CHECK(split(1, 0, {0}, false) == ErrorCode::kCorruptFile);    // no such record
  CHECK(split(0, 7, {0}, false) == ErrorCode::kCorruptFile);    // no such vertex
  CHECK(split(0, kW, {0}, false) == ErrorCode::kCorruptFile);   // the dummy
  CHECK(split(0, 4, {0}, false) == ErrorCode::kCorruptFile);    // itself
  CHECK(split(0, 0, {}, false) == ErrorCode::kCorruptFile);     // nowhere
  CHECK(split(0, 0, {5}, false) == ErrorCode::kCorruptFile);    // no such version
  CHECK(split(0, 0, {0, 0}, false) == ErrorCode::kCorruptFile); // twice
  CHECK(split(0, 0, {0}, true) == ErrorCode::kCorruptFile);     // the whole star

  Refinement r({tet(0, 1, 2, 3)}, 4, 2);
  std::vector<GrowthFace> asked;
  split_single_tet(r, asked);
  CHECK(code_of([&] { split_single_tet(r, asked); }) == ErrorCode::kCorruptFile); // again
  const std::uint32_t elsewhere = find(r, tet(1, 2, 3, kW));
  CHECK(code_of([&] {
          r.split(RecordId{1}, VertexId{0}, std::span(&elsewhere, 1), [](const GrowthFace&) { return false; });
        }) == ErrorCode::kCorruptFile);
}

TEST_CASE("refinement: regions that are no disk are refused") {
  // Six tets around the edge (0, 1). The link of vertex 0 is a sphere: a disk of six triangles around vertex 1, the
  // tets, and one of six around the dummy, the ghosts.
  const TetMesh mesh = test::six_cycle();
  const auto none = [](const GrowthFace&) { return false; };
  const Refinement base(mesh.tets, 8, 1);
  std::vector<std::uint32_t> tets, ghosts;
  for (std::uint32_t place = 0; place < base.place_count(); ++place) {
    const Tet& corners = base.tet(place);
    if (std::count(corners.begin(), corners.end(), VertexId{0}) == 1)
      (is_ghost(corners) ? ghosts : tets).push_back(place);
  }
  REQUIRE(tets.size() == 6);
  REQUIRE(ghosts.size() == 6);
  const auto split = [&](const std::vector<std::uint32_t>& region) {
    Refinement r(mesh.tets, 8, 1);
    r.split(RecordId{0}, VertexId{0}, region, none);
    CHECK(r.validate().empty());
  };
  const auto refused = [&](const std::vector<std::uint32_t>& region) {
    return code_of([&] { split(region); }) == ErrorCode::kCorruptFile;
  };
  CHECK_NOTHROW(split(tets));
  CHECK_NOTHROW(split(ghosts));
  CHECK_NOTHROW(split({tets[0], tets[1]}));
  CHECK(refused({tets[0], tets[3]})); // two disks that share a vertex

  std::vector<std::uint32_t> annulus = tets;
  annulus.insert(annulus.end(), ghosts.begin(), ghosts.end());
  annulus.erase(annulus.begin());
  annulus.pop_back();
  const Tet& first = base.tet(tets[0]);
  const Tet& last = base.tet(ghosts.back());
  REQUIRE(std::none_of(first.begin(), first.end(),
                       [&](VertexId v) { return v.index() > 1 && std::count(last.begin(), last.end(), v) != 0; }));
  CHECK(refused(annulus)); // all but two triangles that do not touch
}

TEST_CASE("refinement: a disk and a closed surface are no region, though their rim is one cycle") {
  // The link of the vertex that both tets share is two spheres of four triangles each.
  const TetMesh mesh = test::pinched_vertex();
  const Refinement base(mesh.tets, 8, 1);
  std::vector<VertexId> shared;
  for (const VertexId v : mesh.tets[0])
    if (std::count(mesh.tets[1].begin(), mesh.tets[1].end(), v) != 0) shared.push_back(v);
  REQUIRE(shared.size() == 1);
  const auto is_of = [](const Tet& corners, const Tet& tet) {
    return std::all_of(corners.begin(), corners.end(),
                       [&](VertexId v) { return v == kDummyVertex || std::count(tet.begin(), tet.end(), v) != 0; });
  };
  std::vector<std::uint32_t> sphere, disk;
  for (std::uint32_t place = 0; place < base.place_count(); ++place) {
    const Tet& corners = base.tet(place);
    if (std::count(corners.begin(), corners.end(), shared[0]) == 0) continue;
    if (is_of(corners, mesh.tets[0])) sphere.push_back(place);
    if (is_of(corners, mesh.tets[1]) && !is_ghost(corners)) disk.push_back(place);
  }
  REQUIRE(sphere.size() == 4);
  REQUIRE(disk.size() == 1);
  const auto split = [&](const std::vector<std::uint32_t>& region) {
    Refinement r(mesh.tets, 8, 1);
    r.split(RecordId{0}, shared[0], region, [](const GrowthFace&) { return false; });
  };
  CHECK_NOTHROW(split(disk));
  std::vector<std::uint32_t> both = sphere;
  both.insert(both.end(), disk.begin(), disk.end());
  CHECK(code_of([&] { split(both); }) == ErrorCode::kCorruptFile);
}

TEST_CASE("refinement: a split may wait for others, which are parents then like those found") {
  Refinement r({tet(0, 1, 2, 3)}, 4, 3);
  const auto split = [&](std::uint32_t record, std::vector<RecordId> others) {
    const std::uint32_t seed = find(r, tet(0, 1, 2, 3));
    r.split(
        RecordId{record}, VertexId{0}, std::span(&seed, 1),
        [&](const GrowthFace& face) { return is_ghost(r.tet(face.behind)) && face.c == VertexId{3}; }, others);
  };
  CHECK(code_of([&] { split(0, {RecordId{1}}); }) == ErrorCode::kCorruptFile);
  CHECK(code_of([&] { split(0, {RecordId{0}}); }) == ErrorCode::kCorruptFile);
  CHECK(code_of([&] { split(0, {RecordId{7}}); }) == ErrorCode::kCorruptFile);
  CHECK(r.applied_count() == 0);
  split(0, {});
  CHECK(r.parents(RecordId{0}).empty());
  // The tet (4 1 2 3) is of record 0, the tet (5 1 2 3) of record 1.
  const auto split_again = [&](std::uint32_t record, std::vector<RecordId> others) {
    const std::uint32_t seed = r.fine_place(RecordId{record - 1}, 0);
    r.split(
        RecordId{record}, r.vertex_of(RecordId{record - 1}), std::span(&seed, 1),
        [&](const GrowthFace& face) { return is_ghost(r.tet(face.behind)) && face.c == VertexId{3}; }, others);
    return std::vector(r.parents(RecordId{record}).begin(), r.parents(RecordId{record}).end());
  };
  CHECK(split_again(1, {RecordId{0}, RecordId{0}}) == std::vector{RecordId{0}});
  CHECK(split_again(2, {RecordId{0}}) == std::vector{RecordId{0}, RecordId{1}});
  CHECK(r.validate() == "");
}

// Many tets around the edge (0, 1); vertex 44 takes over most of them from vertex 0. Its link has more vertices than
// the packed triangles of a settled refinement can tell.
TEST_CASE("refinement: what is kept when settled is what was there") {
  constexpr std::uint32_t kAround = 42, kNew = kAround + 2;
  std::vector<Tet> tets;
  for (std::uint32_t i = 0; i < kAround; ++i)
    tets.push_back(tet(0, 1, 2 + i, 2 + (i + 1) % kAround));
  for (const std::uint32_t wanted : {3U, 36U}) {
    INFO(wanted);
    Refinement r(tets, kNew, 1);
    const std::uint32_t seed = 0;
    std::uint32_t region_size = 1;
    r.split(RecordId{0}, VertexId{0}, std::span(&seed, 1), [&](const GrowthFace& face) {
      if (is_ghost(r.tet(face.behind)) || region_size == wanted) return false;
      ++region_size;
      return true;
    });
    REQUIRE(r.validate().empty());
    REQUIRE(r.modified(RecordId{0}).size() == wanted);
    // In each of its places stands what split() left there.
    const std::uint32_t base_places = r.base_place_count();
    std::vector<std::array<VertexId, 3>> triangles;
    for (std::uint32_t k = 0; k < wanted; ++k) {
      const Tet fine = r.fine_tets(RecordId{0})[k];
      triangles.push_back(r.link_triangle(RecordId{0}, k));
      CHECK(fine == Tet{VertexId{kNew}, triangles[k][0], triangles[k][1], triangles[k][2]});
      CHECK(r.modified(RecordId{0})[k].index() < base_places);
      CHECK_FALSE(r.modified(RecordId{0})[k].is_ghost());
    }
    std::set<Tet> rim, expected;
    const auto around = r.rim(RecordId{0});
    for (std::size_t i = 0; i < around.size(); ++i)
      rim.insert(
          test::sorted_keeping_orientation({VertexId{kNew}, VertexId{0}, around[i], around[(i + 1) % around.size()]}));
    for (std::uint32_t k = wanted; k < r.fine_count(RecordId{0}); ++k)
      expected.insert(test::sorted_keeping_orientation(r.fine_tets(RecordId{0})[k]));
    CHECK(rim == expected);

    const std::vector<VertexId> before(around.begin(), around.end());
    r.settle();
    REQUIRE(r.is_settled());
    CHECK(std::equal(before.begin(), before.end(), r.rim(RecordId{0}).begin(), r.rim(RecordId{0}).end()));
    CHECK(r.place_count() == base_places + before.size());
    CHECK(r.rim_place(RecordId{0}) == base_places);
    for (std::uint32_t k = 0; k < wanted; ++k)
      CHECK(r.link_triangle(RecordId{0}, k) == triangles[k]);
    CHECK(r.base_kinds(RecordId{0}) == kHasTets);
    CHECK(r.base_tet(0) == tets[0]);
  }
}

TEST_CASE("refinement: validate() sees every kind of damage") {
  struct Damage {
    void (*make)(Refinement&);
    const char* told;
  };
  const Damage kinds[] = {{RefinementDamage::count_more, "have made other than"},
                          {RefinementDamage::add_a_place, "places, and there are"},
                          {RefinementDamage::swap_base, "is of no record"},
                          {RefinementDamage::disown, "not among those of the record"},
                          {RefinementDamage::point_beyond, "a neighbour that is not there"},
                          {RefinementDamage::point_elsewhere, "do not share their face"},
                          {RefinementDamage::point_one_way, "is not a neighbour of its neighbour"}};
  for (const Damage& damage : kinds) {
    Refinement r({tet(0, 1, 2, 3)}, 4, 2);
    std::vector<GrowthFace> asked;
    split_single_tet(r, asked);
    REQUIRE(r.validate().empty());
    damage.make(r);
    CHECK_THAT(r.validate(), Catch::Contains(damage.told));
  }
}
