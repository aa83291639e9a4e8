// No cut's boundary crosses itself, not even where it mixes levels in a checkerboard: thin double sheets and real
// parts, every pair of boundary faces whose boxes meet. Nor does one body come to lie in another.
#include "build/builder.hpp"
#include "mesh/overlaps.hpp"
#include "mesh/predicates.hpp"
#include "mesh/topology.hpp"
#include "support/brute_force.hpp"
#include "support/meshes.hpp"
#include "support/versions.hpp"
#ifdef PTET_TEST_WITH_VTK
#include "formats/vtk/read.hpp"
#endif

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <random>
#include <set>
#include <utility>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

struct Built {
  PreparedMesh prepared;
  RecordStream records;
};

Built build_to_the_end(PreparedMesh prepared) {
  Built built{std::move(prepared), {}};
  BuildOptions options;
  options.target_vertices = 0;
  options.max_domain_error = {1, true};
  options.prediction = Prediction::kQuadric;
  options.evaluation = Evaluation::kVertices; // what is collapsed does not depend on it
  BuildReport report;
  built.records = build::build_records(built.prepared, options, report, {});
  CHECK(report.cut_dependencies == built.records.also_needs.size());
  return built;
}

/// The same without the dependencies under test.
RecordStream without_dependencies(RecordStream records) {
  records.also_needs.clear();
  std::fill(records.also_needs_begin.begin(), records.also_needs_begin.end(), 0);
  return records;
}

struct Bounded {
  Face face;
  Point low, high;
  std::size_t version;
};

/// The faces of the ghosts among `versions`.
std::vector<Bounded> faces_of(const std::vector<Tet>& versions, const std::vector<Point>& points) {
  std::vector<Bounded> faces;
  for (std::size_t t = 0; t < versions.size(); ++t) {
    if (std::find(versions[t].begin(), versions[t].end(), kDummyVertex) == versions[t].end()) continue;
    Bounded bounded{{}, {}, {}, t};
    std::copy_if(versions[t].begin(), versions[t].end(), bounded.face.begin(),
                 [](VertexId v) { return v != kDummyVertex; });
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto [low, high] =
          std::minmax({points[bounded.face[0].index()][axis], points[bounded.face[1].index()][axis],
                       points[bounded.face[2].index()][axis]});
      bounded.low[axis] = low;
      bounded.high[axis] = high;
    }
    faces.push_back(bounded);
  }
  return faces;
}

/// Calls `visit` for each pair of faces whose boxes meet.
template <class Visit>
void for_each_near_pair(std::vector<Bounded> faces, Visit&& visit) {
  std::sort(faces.begin(), faces.end(), [](const Bounded& a, const Bounded& b) { return a.low[0] < b.low[0]; });
  for (std::size_t i = 0; i < faces.size(); ++i)
    for (std::size_t j = i + 1; j < faces.size() && faces[j].low[0] <= faces[i].high[0]; ++j) {
      const Bounded& a = faces[i];
      const Bounded& b = faces[j];
      if (a.low[1] > b.high[1] || b.low[1] > a.high[1] || a.low[2] > b.high[2] || b.low[2] > a.high[2]) continue;
      visit(a, b);
    }
}

/// All the boundary faces there ever were, as versions, and all versions.
struct History {
  History(const RecordStream& records, const std::vector<Point>& at)
      : all(records), maker(test::makers(records)), consumer(all.tets.size(), test::CutMesh::kOriginal),
        faces(faces_of(all.tets, at)), points(at) {
    for (std::size_t r = 0; r < records.size(); ++r)
      for (const VersionId t : all.consumed(r))
        consumer[t.index()] = r;
  }
  test::Versions all;
  std::vector<std::size_t> maker, consumer; ///< by version: a record, or CutMesh::kOriginal
  std::vector<Bounded> faces;
  const std::vector<Point>& points;
};

/// Calls `visit` for the ghosts, as versions, of each pair of boundary faces of the cut that meet elsewhere than in
/// common vertices and edges.
template <class Visit>
void for_each_crossing(const History& history, const std::vector<char>& is_split, Visit&& visit) {
  const auto is_there = [&](const Bounded& face) {
    const std::size_t by = history.maker[face.version], to = history.consumer[face.version];
    return (by == test::CutMesh::kOriginal || is_split[by] == 0) &&
           (to == test::CutMesh::kOriginal || is_split[to] != 0);
  };
  std::vector<Bounded> faces = history.faces;
  std::erase_if(faces, [&](const Bounded& face) { return !is_there(face); });
  for_each_near_pair(std::move(faces), [&](const Bounded& a, const Bounded& b) {
    if (faces_meet_improperly(a.face, b.face, history.points)) visit(a.version, b.version);
  });
}

std::size_t crossings(const History& history, const std::vector<char>& is_split) {
  std::size_t count = 0;
  for_each_crossing(history, is_split, [&](std::size_t, std::size_t) { ++count; });
  return count;
}

/// By version: which curves it is of where the original's boundary crosses itself, itself or by what it stands for.
std::vector<std::set<std::size_t>> inherited_curves(const RecordStream& records, const History& history) {
  const test::Versions& versions = history.all;
  std::vector<std::size_t> curve(versions.tets.size()); // its smallest face, in the end
  std::iota(curve.begin(), curve.end(), std::size_t{0});
  std::vector<std::set<std::size_t>> curves(versions.tets.size());
  const std::vector<char> all(records.size(), 1);
  for (bool changed = true; changed;) {
    changed = false;
    for_each_crossing(history, all, [&](std::size_t f, std::size_t g) {
      changed |= curve[f] != curve[g];
      curve[f] = curve[g] = std::min(curve[f], curve[g]);
    });
  }
  for_each_crossing(history, all, [&](std::size_t f, std::size_t g) {
    curves[f] = {curve[f]};
    curves[g] = {curve[g]};
  });
  for (std::size_t r = 0; r < records.size(); ++r) {
    std::set<std::size_t> sum;
    for (const VersionId t : versions.consumed(r))
      sum.insert(curves[t.index()].begin(), curves[t.index()].end());
    for (std::uint32_t m = 0; m < records.modified_count[r]; ++m)
      curves[versions.coarse_begin[r].index() + m] = sum;
  }
  return curves;
}

/// Pairs of boundary faces that meet improperly and were there at the same time while the builder went on.
std::size_t pairs_at_one_time(const History& history) {
  const auto &maker = history.maker, &consumer = history.consumer;
  const auto is_there_when_made = [&](std::size_t f, std::size_t g) {
    return maker[g] == test::CutMesh::kOriginal || consumer[f] == test::CutMesh::kOriginal || consumer[f] > maker[g];
  };
  std::size_t count = 0;
  for_each_near_pair(history.faces, [&](const Bounded& a, const Bounded& b) {
    if (is_there_when_made(a.version, b.version) && is_there_when_made(b.version, a.version))
      count += static_cast<std::size_t>(faces_meet_improperly(a.face, b.face, history.points));
  });
  return count;
}

/// Pairs of all the boundary faces there ever were that meet improperly and that some closed cut holds both of.
std::size_t pairs_in_one_cut(const RecordStream& records, const History& history) {
  const auto &maker = history.maker, &consumer = history.consumer;
  std::vector<std::pair<std::size_t, std::size_t>> apart; // consumer of the one before the maker of the other
  std::size_t together = 0;
  for_each_near_pair(history.faces, [&](const Bounded& a, const Bounded& b) {
    for (const auto& [f, g] : {std::pair{a.version, b.version}, std::pair{b.version, a.version}})
      if (maker[g] != test::CutMesh::kOriginal && consumer[f] < maker[g] &&
          faces_meet_improperly(a.face, b.face, history.points))
        apart.emplace_back(consumer[f], maker[g]);
  });
  std::sort(apart.begin(), apart.end());
  std::vector<char> is_split;
  for (std::size_t i = 0; i < apart.size(); ++i) {
    if (i == 0 || apart[i].first != apart[i - 1].first) {
      is_split.assign(records.size(), 0);
      is_split[apart[i].first] = 1;
      test::close_cut(records, is_split);
    }
    together += static_cast<std::size_t>(is_split[apart[i].second] == 0);
  }
  return together;
}

/// Records to be split: in the black boxes of a checkerboard all, or those of the last part of the collapses; in the
/// white ones none, or those of a shorter last part. Not closed.
std::vector<char> checkerboard(const Built& built, std::mt19937& random) {
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() % 1000001) / 1e6;
  };
  const auto& points = built.prepared.points;
  const double width = built.records.diagonal * std::pow(2, uniform(-6, -2));
  const double shift = uniform(0, width);
  const double count = static_cast<double>(built.records.size());
  const double black_from = count * (random() % 2 == 0 ? 0 : uniform(0, 0.9));
  const double white_from = std::max(black_from, count * uniform(0.8, 1));
  std::vector<char> is_split(built.records.size());
  for (std::size_t r = 0; r < is_split.size(); ++r) {
    const Point& p = points[built.records.removed[r].index()];
    const double sum =
        std::floor((p[0] + shift) / width) + std::floor((p[1] + shift) / width) + std::floor((p[2] + shift) / width);
    const bool is_black = std::fmod(std::abs(sum), 2) == 1;
    is_split[r] = static_cast<char>(static_cast<double>(r) >= (is_black ? black_from : white_from));
  }
  return is_split;
}

/// Some records here and there.
std::vector<char> scattered(const Built& built, std::mt19937& random) {
  const unsigned one_in = 2U << (random() % 10);
  std::vector<char> is_split(built.records.size());
  for (char& split : is_split)
    split = static_cast<char>(random() % one_in == 0);
  return is_split;
}

/// The `number`th of a row of such cuts and of levels, closed.
std::vector<char> closed_cut(const Built& built, int number, std::mt19937& random) {
  std::vector<char> is_split = number % 4 == 3   ? scattered(built, random)
                               : number % 4 == 2 ? test::after_collapses(built.records, random() % built.records.size())
                                                 : checkerboard(built, random);
  test::close_cut(built.records, is_split);
  return is_split;
}

/// Crossings in random cuts, with the dependencies and without.
struct Tally {
  std::size_t cuts = 0;
  std::size_t crossings = 0;
  std::size_t cuts_crossed_without = 0;
};

Tally try_cuts(const Built& built, int cuts, std::mt19937& random) {
  const RecordStream bare = without_dependencies(built.records);
  const History history(bare, built.prepared.points);
  Tally tally;
  for (int i = 0; i < cuts; ++i) {
    const std::vector<char> wanted = i % 4 == 3 ? scattered(built, random) : checkerboard(built, random);
    std::vector<char> is_split = wanted;
    test::close_cut(built.records, is_split);
    tally.crossings += crossings(history, is_split);
    ++tally.cuts;
    std::vector<char> bare_split = wanted;
    test::close_cut(bare, bare_split);
    if (bare_split != is_split)
      tally.cuts_crossed_without += static_cast<std::size_t>(crossings(history, bare_split) > 0);
  }
  return tally;
}

/// Without its dependencies each record that has one takes part in a cut that crosses itself: that of what it needs
/// and of what is needed to undo the faces made by the record it should need. Returns the dependencies looked at.
std::size_t check_each_is_needed(const Built& built, std::size_t most) {
  const RecordStream bare = without_dependencies(built.records);
  const History history(bare, built.prepared.points);
  std::size_t looked_at = 0;
  const std::size_t step = std::max<std::size_t>(1, built.records.also_needs.size() / most);
  std::size_t number = 0;
  for (std::size_t r = 0; r < bare.size(); ++r)
    for (const std::uint32_t other : built.records.others_needed(r)) {
      if (number++ % step != 0) continue;
      ++looked_at;
      std::size_t crossed = 0;
      // One of the faces made there crosses one consumed here; to have it stand its consumer is split, if there is one.
      for (std::uint32_t m = 0; m < bare.modified_count[other] && crossed == 0; ++m) {
        std::vector<char> is_split(bare.size());
        is_split[r] = 1;
        if (const std::size_t by = history.consumer[history.all.coarse_begin[other].index() + m];
            by != test::CutMesh::kOriginal)
          is_split[by] = 1;
        test::close_cut(bare, is_split);
        CHECK(is_split[other] == 0);
        crossed = crossings(history, is_split);
      }
      CHECK(crossed > 0);
    }
  return looked_at;
}

/// Two boxes that reach into one another, and a thin plate close above the second one that touches neither.
TetMesh reaching_bodies() {
  std::vector<Point> positions;
  std::vector<std::array<std::uint32_t, 4>> tets;
  const auto add = [&](const test::GridOptions& options, const Point& at) {
    const TetMesh body = test::grid(options);
    const auto first = static_cast<std::uint32_t>(positions.size());
    for (std::uint32_t v = 0; v < body.vertex_count(); ++v) {
      const Point p = body.position(VertexId{v});
      positions.push_back({p[0] + at[0], p[1] + at[1], p[2] + at[2]});
    }
    for (const Tet& t : body.tets)
      tets.push_back({first + t[0].index(), first + t[1].index(), first + t[2].index(), first + t[3].index()});
  };
  add({{9, 8, 6}, {}, 2, 1}, {0, 0, 0});
  add({{9, 8, 6}, {}, 2, 2}, {103.3, 21.7, -41.9});
  add({{6, 8, 1}, {}, 2, 3}, {9 * 16 + 4.5, 21.7, 6 * 16 - 41.9 + 4.5});
  TetMesh mesh = test::make_mesh(positions, tets, ScalarType::kFloat64);
  test::add_test_fields(mesh);
  return mesh;
}

/// A block with a bumpy upper side, and in each of its dents a small tet that touches nothing.
TetMesh dusty_block(int cells) {
  const TetMesh flat = test::grid({{cells, cells, 3}, {}, 2, 5});
  std::mt19937 random(6);
  std::vector<Point> positions;
  std::vector<std::array<std::uint32_t, 4>> tets;
  std::vector<VertexId> upper;
  for (std::uint32_t v = 0; v < flat.vertex_count(); ++v) {
    Point p = flat.position(VertexId{v});
    if (p[2] > 3 * 16 - 3) {
      p[2] += 5.0 * static_cast<double>(random() % 1000) / 1000;
      upper.push_back(VertexId{v});
    }
    positions.push_back(p);
  }
  for (const Tet& tet : flat.tets)
    tets.push_back({tet[0].index(), tet[1].index(), tet[2].index(), tet[3].index()});
  const auto is_lowest_around = [&](VertexId v) {
    const Point& p = positions[v.index()];
    return std::all_of(upper.begin(), upper.end(), [&](VertexId other) {
      const Point& q = positions[other.index()];
      return other == v || std::hypot(p[0] - q[0], p[1] - q[1]) > 30 || q[2] > p[2] + 0.3;
    });
  };
  for (const VertexId v : upper) {
    const Point p = positions[v.index()];
    const bool is_inside = std::min(p[0], p[1]) > 8 && std::max(p[0], p[1]) < 16 * cells - 8;
    if (!is_inside || !is_lowest_around(v)) continue;
    const auto first = static_cast<std::uint32_t>(positions.size());
    for (const Point& step : {Point{0, 0, 0}, Point{0.05, 0, 0.05}, Point{0, 0.05, 0.05}, Point{0.05, 0.05, 0}})
      positions.push_back({p[0] + step[0], p[1] + step[1], p[2] + 0.1 + step[2]});
    tets.push_back({first, first + 1, first + 2, first + 3});
  }
  TetMesh mesh = test::make_mesh(positions, tets, ScalarType::kFloat64);
  test::add_test_fields(mesh);
  return mesh;
}

/// A block out of which the tets around some edges are taken, where they touch no such void.
TetMesh riddled_block(int cells, unsigned seed) {
  const TetMesh block = test::grid({{cells, cells, cells}, {}, 3, seed});
  std::mt19937 random(seed);
  std::vector<char> is_gone(block.tets.size()), is_at_void(block.vertex_count());
  for (std::size_t tries = 0; tries < block.tets.size() / 4; ++tries) {
    const Tet& some = block.tets[random() % block.tets.size()];
    const auto holds = [](const Tet& tet, VertexId v) { return std::find(tet.begin(), tet.end(), v) != tet.end(); };
    std::vector<std::size_t> around;
    for (std::size_t t = 0; t < block.tets.size(); ++t)
      if (holds(block.tets[t], some[0]) && holds(block.tets[t], some[1])) around.push_back(t);
    const auto touches = [&](std::size_t t) {
      return std::any_of(block.tets[t].begin(), block.tets[t].end(),
                         [&](VertexId v) { return is_at_void[v.index()] != 0; });
    };
    if (std::any_of(around.begin(), around.end(), touches)) continue;
    for (const std::size_t t : around) {
      is_gone[t] = 1;
      for (const VertexId v : block.tets[t])
        is_at_void[v.index()] = 1;
    }
  }
  std::vector<Point> positions;
  for (std::uint32_t v = 0; v < block.vertex_count(); ++v)
    positions.push_back(block.position(VertexId{v}));
  std::vector<std::array<std::uint32_t, 4>> tets;
  for (std::size_t t = 0; t < block.tets.size(); ++t)
    if (const Tet& tet = block.tets[t]; is_gone[t] == 0)
      tets.push_back({tet[0].index(), tet[1].index(), tet[2].index(), tet[3].index()});
  TetMesh mesh = test::make_mesh(positions, tets, ScalarType::kFloat64);
  test::add_test_fields(mesh);
  return mesh;
}

/// Tets of the cut that others of it hold the middle of.
std::size_t tets_within_others(const Built& built, const std::vector<char>& is_split) {
  const std::vector<Tet> tets = test::cut_mesh(built.records, is_split).tets;
  const std::vector<Point>& points = built.prepared.points;
  return find_overlaps(points, tets, build_boundary(tets, build_face_table(tets, points.size()), points.size()), 0,
                       [] {})
      .within.size();
}

/// Two sheets of one layer of cells, a small gap apart, waved alike, joined along one side.
TetMesh double_sheet(int cells, double gap, double wave) {
  const TetMesh flat = test::grid({{cells, cells, 3}, [](int x, int, int z) { return z != 1 || x == 0; }, 0, 1});
  const std::array<double, 4> height = {0, 8, 8 + gap, 16 + gap};
  std::vector<Point> positions;
  for (std::uint32_t v = 0; v < flat.vertex_count(); ++v) {
    Point p = flat.position(VertexId{v});
    p[2] = height.at(static_cast<std::size_t>(p[2] / 16));
    // The same in all layers.
    const double x = p[0], y = p[1];
    p[0] += 2 * std::sin(3 * x + y);
    p[1] += 2 * std::sin(x - 2 * y);
    p[2] += wave * std::sin(x / 20) * std::cos(y / 26) + std::sin(2 * x + 5 * y) / 4;
    positions.push_back(p);
  }
  std::vector<std::array<std::uint32_t, 4>> tets;
  for (const Tet& tet : flat.tets)
    tets.push_back({tet[0].index(), tet[1].index(), tet[2].index(), tet[3].index()});
  TetMesh mesh = test::make_mesh(positions, tets, ScalarType::kFloat64);
  test::add_test_fields(mesh);
  return mesh;
}

} // namespace

TEST_CASE("cuts of thin double sheets do not cross themselves") {
  std::mt19937 random(17);
  std::size_t dependencies = 0;
  std::size_t crossed_without = 0;
  std::size_t pairs_without = 0;
  for (const double gap : {1.0, 4.0})
    for (const double wave : {0.0, 8.0, 20.0}) {
      INFO("gap " << gap << ", wave " << wave);
      const Built built = build_to_the_end(prepare(double_sheet(14, gap, wave)));
      CHECK(built.records.validate().empty());
      const History history(built.records, built.prepared.points);
      REQUIRE(crossings(history, std::vector<char>(built.records.size(), 1)) == 0);
      CHECK(pairs_at_one_time(history) == 0);
      const Tally tally = try_cuts(built, 30, random);
      CHECK(tally.crossings == 0);
      check_each_is_needed(built, 8);
      CHECK(pairs_in_one_cut(built.records, history) == 0);
      dependencies += built.records.also_needs.size();
      crossed_without += tally.cuts_crossed_without;
      pairs_without += pairs_in_one_cut(without_dependencies(built.records), history);
    }
  CHECK(dependencies > 0);
  CHECK(crossed_without > 0);
  CHECK(pairs_without > dependencies);
}

//      ________________
//     |  first         | ~~~~~~~~~~~~  plate
//     |           _____|____________
//     |__________|_____|    second  |     The plate lies close to where the boxes cross, and crosses nothing.
//                |__________________|
TEST_CASE("cuts cross themselves only where the input does") {
  const Built built = build_to_the_end(prepare(reaching_bodies()));
  CHECK(built.records.validate().empty());
  // What crosses in the input holds nothing up: a tet of each body is left.
  CHECK(built.prepared.used_vertex_count - built.records.size() == 12);
  PreparedMesh all_forbidden = built.prepared;
  all_forbidden.crossing_curves.clear();
  CHECK(all_forbidden.used_vertex_count - build_to_the_end(all_forbidden).records.size() > 80);

  const History history(built.records, built.prepared.points);
  const std::vector<std::set<std::size_t>> curves = inherited_curves(built.records, history);
  std::mt19937 random(31);
  std::size_t crossed = 0;
  for (int i = 0; i < 40; ++i) {
    std::vector<char> is_split = i % 4 == 3 ? scattered(built, random) : checkerboard(built, random);
    if (i == 0) std::fill(is_split.begin(), is_split.end(), 0);
    test::close_cut(built.records, is_split);
    for_each_crossing(history, is_split, [&](std::size_t f, std::size_t g) {
      ++crossed;
      std::vector<std::size_t> both;
      std::set_intersection(curves[f].begin(), curves[f].end(), curves[g].begin(), curves[g].end(),
                            std::back_inserter(both));
      CHECK_FALSE(both.empty());
    });
  }
  CHECK(crossed > 100);
}

//        .      small bodies
//     __   ___   __
//    |  \_/   \_/  |   A lid on a dent crosses nothing, and holds what hovered in it.
//    |_____________|
TEST_CASE("no body comes to lie in another") {
  const Built built = build_to_the_end(prepare(dusty_block(12)));
  CHECK(built.records.validate().empty());
  const std::size_t bodies = built.prepared.mesh.tets.size() - std::size_t{6 * 12 * 12 * 3};
  CHECK(bodies > 4);
  const History history(built.records, built.prepared.points);
  REQUIRE(tets_within_others(built, std::vector<char>(built.records.size(), 1)) == 0);
  std::mt19937 random(18);
  for (int i = 0; i < 40; ++i) {
    const std::vector<char> is_split = closed_cut(built, i, random);
    CHECK(tets_within_others(built, is_split) == 0);
    CHECK(crossings(history, is_split) == 0);
  }
  CHECK(tets_within_others(built, std::vector<char>(built.records.size())) == 0);
}

//      ______        ______
//     |  /\  |      |      |
//     | <  > |  ->  | \><  |   A void whose near side goes through the far one, where both end at the same rim: their
//     |__\/__|      |______|   faces meet nowhere else.
TEST_CASE("small voids are not turned inside out") {
  std::mt19937 random(19);
  for (unsigned seed = 1; seed <= 12; ++seed) {
    INFO("seed " << seed);
    const Built built = build_to_the_end(prepare(riddled_block(7, seed)));
    const History history(built.records, built.prepared.points);
    REQUIRE(tets_within_others(built, std::vector<char>(built.records.size(), 1)) == 0);
    CHECK(tets_within_others(built, std::vector<char>(built.records.size())) == 0);
    for (int i = 0; i < 20; ++i) {
      CHECK(tets_within_others(built, closed_cut(built, i, random)) == 0);
    }
  }
}

TEST_CASE("dependencies and squared errors are the same on any number of threads") {
  PreparedMesh prepared = prepare(double_sheet(12, 1, 20));
  BuildOptions options;
  options.target_vertices = 0;
  options.max_domain_error = {1, true};
  BuildReport report;
  options.threads = 1;
  const RecordStream one = build::build_records(prepared, options, report, {});
  REQUIRE(!one.also_needs.empty());
  options.threads = 4;
  const RecordStream four = build::build_records(prepared, options, report, {});
  CHECK(one.also_needs == four.also_needs);
  CHECK(one.also_needs_begin == four.also_needs_begin);
  CHECK(one.squared_error == four.squared_error);
  CHECK(one.uncovered_volume == four.uncovered_volume);
}

#ifdef PTET_TEST_WITH_VTK
TEST_CASE("cuts of thin real parts do not cross themselves") {
  std::mt19937 random(23);
  for (const char* const name : {"pulley.vtu", "fea_bracket.vtu"}) {
    const auto path = test::data_file(name);
    if (!path) {
      WARN(name << " is not there: looked in " << test::data_dir() << "; set PTET_DATA. Skipped.");
      continue;
    }
    INFO(name);
    const Built built = build_to_the_end(prepare(read_mesh(*path)));
    const Tally tally = try_cuts(built, 12, random);
    CHECK(tally.crossings == 0);
    check_each_is_needed(built, 4);
    CHECK(pairs_in_one_cut(built.records, History(built.records, built.prepared.points)) == 0);
  }
}
#else
TEST_CASE("cuts of thin real parts do not cross themselves") {
  WARN("skipped: built without VTK, which reads the real meshes");
}
#endif
