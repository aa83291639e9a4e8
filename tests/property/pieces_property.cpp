// Builds over pieces: what is decided in one piece does not touch another, the file does not depend on who collapsed
// the pieces, and it keeps all promises of a build of the whole: sound meshes, true errors, the original restored.
#include "build/builder.hpp"
#include "build/mesh_scales.hpp"
#include "build/piece_decisions.hpp"
#include "ptet/error.hpp"
#include "ptet/pieces_build.hpp"
#include "support/brute_force.hpp"
#include "support/file_checks.hpp"
#include "support/mesh_checks.hpp"
#include "support/meshes.hpp"
#include "support/methods.hpp"
#include "support/topology_checks.hpp"
#include "support/versions.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <set>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

using Bytes = std::vector<std::byte>;

BuildOptions options_of(std::uint32_t pieces, Prediction prediction = Prediction::kExact,
                        Evaluation evaluation = Evaluation::kExact) {
  BuildOptions options;
  options.pieces = pieces;
  options.prediction = prediction;
  options.evaluation = evaluation;
  options.target_vertices = 0.03;
  return options;
}

/// A build with everything in hand.
struct Built {
  Built(const TetMesh& mesh, const BuildOptions& options) : prepared(prepare(mesh)) {
    const build::PieceDecisions pieces(prepared, options);
    std::vector<Bytes> decided;
    for (std::uint32_t p = 0; p < pieces.piece_count(); ++p)
      decided.push_back(pieces.decide(p, {}));
    decisions = pieces.merge(decided);
  }
  void finish(const BuildOptions& options) { stream = build::build_records(prepared, options, report, {}, &decisions); }

  PreparedMesh prepared;
  build::Decisions decisions;
  RecordStream stream;
  BuildReport report;
};

std::array<Point, 4> corners(const PreparedMesh& prepared, const Tet& tet) {
  return {prepared.points[tet[0].index()], prepared.points[tet[1].index()], prepared.points[tet[2].index()],
          prepared.points[tet[3].index()]};
}

/// No inverted tet, no crowded face, components and boundary as in the original; the boundary does not meet itself.
void check_sound(const Built& built, const test::CutMesh& cut, const test::MeshFacts& original) {
  TetMesh mesh;
  mesh.positions = built.prepared.mesh.positions;
  mesh.tets = cut.tets;
  const test::MeshFacts facts = test::examine(mesh);
  CHECK(facts.inverted_tets == original.inverted_tets);
  test::check_same_topology(facts, original);
  CHECK(facts.boundary.size() == cut.ghosts.size());
  std::size_t meetings = 0;
  for (std::size_t i = 0; i < facts.boundary.size(); ++i)
    for (std::size_t j = i + 1; j < facts.boundary.size(); ++j)
      meetings += faces_meet_improperly(facts.boundary[i], facts.boundary[j], built.prepared.points) ? 1 : 0;
  CHECK(meetings == 0);
}

/// The field's values at a point of a tet, given by weights.
std::vector<double> values_at(const PointArray& field, const Tet& tet, const std::array<double, 4>& weight) {
  std::vector<double> values(field.components);
  for (std::uint32_t c = 0; c < field.components; ++c)
    for (std::size_t i = 0; i < 4; ++i)
      values[c] += weight[i] * field.value(tet[i].index(), c);
  return values;
}

/// At random points of original tets the field of the version there is no further off than the record says that made
/// it; corners of the original tets are among the points.
void check_errors_hold(const Built& built, const test::CutMesh& cut, std::mt19937& random, std::size_t points) {
  const std::vector<Tet>& tets = built.prepared.mesh.tets;
  std::size_t inside_of_made = 0;
  double worst_excess = -1;
  for (std::size_t n = 0; n < points; ++n) {
    const Tet& tet = tets[random() % tets.size()];
    std::array<double, 4> weight{};
    double sum = 0;
    for (double& w : weight)
      sum += w = random() % 4 == 0 ? 0 : static_cast<double>(random() % 1000 + 1);
    if (sum == 0) continue;
    Point p{};
    for (std::size_t i = 0; i < 4; ++i) {
      weight[i] /= sum;
      for (std::size_t axis = 0; axis < 3; ++axis)
        p[axis] += weight[i] * built.prepared.points[tet[i].index()][axis];
    }
    for (std::size_t t = 0; t < cut.tets.size(); ++t) {
      if (cut.tet_maker[t] == test::CutMesh::kOriginal) continue;
      const auto at = test::barycentrics(p, corners(built.prepared, cut.tets[t]));
      if (!at || *std::min_element(at->begin(), at->end()) < 1e-6) continue;
      ++inside_of_made;
      for (std::size_t f = 0; f < built.stream.fields.size(); ++f) {
        const PointArray& field = built.prepared.mesh.point_arrays[built.stream.fields[f].array];
        const std::vector<double> true_values = values_at(field, tet, weight);
        const std::vector<double> values = values_at(field, cut.tets[t], *at);
        double difference_sq = 0;
        for (std::size_t c = 0; c < values.size(); ++c)
          difference_sq += (values[c] - true_values[c]) * (values[c] - true_values[c]);
        const double stated = built.stream.field_error[cut.tet_maker[t] * built.stream.fields.size() + f];
        worst_excess = std::max(worst_excess, (std::sqrt(difference_sq) - stated) / built.stream.fields[f].range);
      }
    }
  }
  CHECK(inside_of_made > 0);
  CHECK(worst_excess < 1e-9);
}

/// Every removed vertex on the boundary is near the boundary of the cut, by the largest domain error that is stated.
void check_domain_error_holds(const Built& built, const test::CutMesh& cut) {
  const double stated = test::largest_domain_error(built.stream, cut);
  std::set<VertexId> on_boundary;
  for (const Face& face : built.prepared.boundary_faces)
    on_boundary.insert(face.begin(), face.end());
  double worst = 0;
  for (const VertexId v : cut.removed) {
    if (on_boundary.count(v) == 0) continue;
    double nearest = std::numeric_limits<double>::infinity();
    for (const Tet& ghost : cut.ghosts) {
      std::array<Point, 3> face{};
      std::size_t i = 0;
      for (const VertexId x : ghost)
        if (x != kDummyVertex) face[i++] = built.prepared.points[x.index()];
      nearest = std::min(nearest, test::nearest_on_triangle(built.prepared.points[v.index()], face).distance);
    }
    worst = std::max(worst, nearest);
  }
  CHECK(worst <= stated + 1e-9 * built.stream.diagonal);
}

/// What the records say of the squared error of the coarsest mesh, against the integral by brute force.
void check_squared_error(const Built& built) {
  const RecordStream& stream = built.stream;
  REQUIRE(stream.has_squared_errors());
  const test::CutMesh base = test::cut_mesh(stream, std::vector<char>(stream.size(), 0));
  const std::size_t fields = stream.fields.size();
  for (std::size_t f = 0; f < fields; ++f) {
    double stated = 0;
    for (std::size_t r = 0; r < stream.size(); ++r)
      stated += stream.squared_error[r * fields + f];
    double integral = 0, covered = 0;
    for (std::size_t t = 0; t < base.tets.size(); ++t) {
      if (base.tet_maker[t] == test::CutMesh::kOriginal) {
        covered += build::volume_of(built.prepared, base.tets[t]);
        continue;
      }
      for (const Tet& original : built.prepared.mesh.tets) {
        const auto found = test::integrals_over_overlap(
            built.prepared.points, built.prepared.mesh.point_arrays[stream.fields[f].array], original, base.tets[t]);
        integral = std::accumulate(found.squared.begin(), found.squared.end(), integral);
        covered += found.volume;
      }
    }
    CHECK(stated == Approx(integral).epsilon(1e-6));
    const double uncovered = std::accumulate(stream.uncovered_volume.begin(), stream.uncovered_volume.end(), 0.0);
    CHECK(std::abs(stream.volume - uncovered - covered) <= 1e-9 * stream.volume);
  }
}

/// What the first pass has made stays in its piece.
void check_pieces_apart(const Built& built, std::uint32_t pieces) {
  const build::MeshPieces cut(built.prepared, pieces);
  const RecordStream& stream = built.stream;
  const test::Versions all(stream);
  for (std::size_t r = 0; r < built.report.piece_records; ++r) {
    const std::uint32_t piece = cut.piece_of()[stream.removed[r].index()];
    REQUIRE(piece == built.decisions.piece[r]);
    for (std::uint32_t m = 0; m < stream.modified_count[r]; ++m)
      for (const VertexId v : all.tets[all.coarse_begin[r].index() + m])
        if (v != kDummyVertex) REQUIRE(cut.piece_of()[v.index()] == piece);
  }
}

void check_cuts(const Built& built, const test::MeshFacts& original, unsigned seed, bool errors_are_exact) {
  std::mt19937 random(seed);
  const std::size_t count = built.stream.size();
  std::vector<std::vector<char>> cuts{test::after_collapses(built.stream, built.report.piece_records),
                                      std::vector<char>(count, 0)};
  for (int n = 0; n < 2; ++n) {
    std::vector<char>& cut = cuts.emplace_back(count, 0);
    for (char& split : cut)
      split = random() % 40 == 0 ? 1 : 0;
    test::close_cut(built.stream, cut);
  }
  for (const std::vector<char>& is_split : cuts) {
    const test::CutMesh cut = test::cut_mesh(built.stream, is_split);
    check_sound(built, cut, original);
    if (!errors_are_exact) continue;
    check_errors_hold(built, cut, random, 300);
    check_domain_error_holds(built, cut);
  }
}

std::vector<test::NamedMesh> meshes_to_cut() {
  return {{"cube", test::grid({{6, 6, 6}, {}, 3, 5})},
          {"l-shape", test::grid({{8, 8, 4}, [](int x, int y, int) { return x < 4 || y < 4; }, 3, 6})},
          {"frame", test::grid({{9, 9, 3}, [](int x, int y, int) { return x < 3 || x > 5 || y < 3 || y > 5; }, 2, 7})},
          {"two components", test::grid({{11, 5, 5}, [](int x, int, int) { return x != 5; }, 3, 8})}};
}

} // namespace

TEST_CASE("pieces: sound meshes and true errors, for any number of pieces", "[pieces]") {
  const std::pair<std::uint32_t, std::uint32_t> counts[] = {{2, 5}, {1, 8}, {5, 8}, {2, 8}};
  std::size_t n = 0;
  for (const auto& [name, mesh] : meshes_to_cut()) {
    const test::MeshFacts original = test::examine(mesh);
    const auto [few, many] = counts[n++];
    for (const std::uint32_t pieces : {few, many}) {
      INFO(name << ", " << pieces << " pieces");
      BuildOptions options = options_of(pieces);
      options.fields = {pieces == 5 ? "flow" : "pressure"};
      Built built(mesh, options);
      built.finish(options);
      CHECK(built.stream.validate().empty());
      CHECK(built.report.piece_records > 0);
      CHECK(built.report.piece_records_dropped == 0);
      check_pieces_apart(built, pieces);
      check_cuts(built, original, pieces, true);
      if (pieces == 5) check_squared_error(built);
      test::check_round_trip(built.prepared.mesh, built.stream);
    }
  }
}

TEST_CASE("pieces: every method, the same bytes on any number of threads", "[pieces]") {
  const TetMesh mesh = test::grid({{7, 6, 6}, {}, 3, 9});
  const test::MeshFacts original = test::examine(mesh);
  for (const auto& [prediction, evaluation] : test::kMethods) {
    INFO(name_of(prediction) << ", " << name_of(evaluation));
    BuildOptions options = options_of(5, prediction, evaluation);
    options.fields = {"pressure"};
    options.threads = 1;
    BuildReport report;
    const Bytes one = build_memory(mesh, options, &report, "mesh", "hash");
    CHECK(report.pieces == 5);
    CHECK(report.piece_records > 0);
    CHECK(report.piece_records_dropped == 0);
    for (const unsigned threads : {2U, 5U}) {
      options.threads = threads;
      CHECK(build_memory(mesh, options, nullptr, "mesh", "hash") == one);
    }
    Built built(mesh, options);
    built.finish(options);
    check_cuts(built, original, 11, evaluation == Evaluation::kExact);
  }
}

TEST_CASE("pieces: bodies that cross one another in pairs, more pairs than a piece has faces", "[pieces]") {
  std::vector<Point> positions;
  std::vector<std::array<std::uint32_t, 4>> tets;
  for (int pair = 0; pair < 60; ++pair)
    for (const double shift : {0.0, 0.15}) {
      const auto first = static_cast<std::uint32_t>(positions.size());
      for (const Point& p : {Point{0, 0, 0}, Point{1, 0, 0}, Point{0, 1, 0}, Point{0, 0, 1}, Point{0.3, 0.3, 0.3}})
        positions.push_back({3.0 * pair + p[0] + shift, p[1] + shift, p[2] + shift / 2});
      for (std::uint32_t i = 0; i < 4; ++i) { // around the last one
        std::array<std::uint32_t, 4> tet = {first, first + 1, first + 2, first + 3};
        tet.at(i) = first + 4;
        tets.push_back(tet);
      }
    }
  TetMesh mesh = test::make_mesh(positions, tets, ScalarType::kFloat64);
  test::add_test_fields(mesh);
  BuildOptions options = options_of(16);
  options.fields = {"pressure"};
  BuildReport report;
  const Bytes one = build_memory(mesh, options, &report, "mesh", "hash");
  CHECK(report.piece_records > 60);
  options.threads = 2;
  CHECK(build_memory(mesh, options, nullptr, "mesh", "hash") == one);
}

TEST_CASE("pieces: in a piece errors are what they are in the whole mesh", "[pieces]") {
  // A piece that is all of the mesh decides what a build of the whole does.
  const TetMesh mesh = test::grid({{6, 6, 6}, {}, 3, 12});
  for (const auto& [prediction, evaluation] :
       {std::pair{Prediction::kExact, Evaluation::kExact}, std::pair{Prediction::kSimulate, Evaluation::kSamples}}) {
    BuildOptions options = options_of(1, prediction, evaluation);
    const Built built(mesh, options);
    BuildReport report;
    PreparedMesh prepared = built.prepared;
    const RecordStream whole = build::build_records(prepared, options, report, {});
    const std::size_t count = built.decisions.records.removed.size();
    REQUIRE(count > 100);
    REQUIRE(count <= whole.size());
    for (std::size_t r = 0; r < count; ++r) {
      CHECK(built.decisions.records.removed[r] == whole.removed[r]);
      CHECK(built.decisions.records.target[r] == whole.target[r]);
      CHECK(built.decisions.records.field_error[r] == whole.field_error[r]);
    }
  }
}

TEST_CASE("pieces: integers of 64 bits are like others", "[pieces]") {
  const TetMesh mesh = test::grid({{6, 6, 6}, {}, 3, 12});
  const auto decided = [&](ScalarType type, Evaluation evaluation) {
    TetMesh with = mesh;
    with.point_arrays.clear();
    test::add_array(with, "f", type, 1,
                    [](const Point& p) { return std::vector<double>(1, std::floor(1000 + 20 * p[0] + p[1] * p[2])); });
    return Built(with, options_of(4, Prediction::kSimulate, evaluation)).decisions.records;
  };
  for (const Evaluation evaluation : {Evaluation::kVertices, Evaluation::kSamples, Evaluation::kExact}) {
    const RecordStream narrow = decided(ScalarType::kInt32, evaluation);
    const RecordStream wide = decided(ScalarType::kInt64, evaluation);
    REQUIRE(narrow.removed.size() > 50);
    CHECK(wide.removed == narrow.removed);
    CHECK(wide.target == narrow.target);
    REQUIRE(wide.field_error.size() == narrow.field_error.size());
    for (std::size_t i = 0; i < wide.field_error.size(); ++i)
      CHECK(wide.field_error[i] == Approx(narrow.field_error[i]).epsilon(1e-9));
  }
}

TEST_CASE("pieces: collapsed elsewhere, in any order, they make the same file", "[pieces]") {
  const TetMesh mesh = test::grid({{8, 8, 5}, {}, 3, 10});
  BuildOptions options = options_of(5);
  options.fields = {"pressure"};
  const Bytes expected = build_memory(mesh, options, nullptr, "mesh", "hash");
  std::vector<Bytes> decided(options.pieces);
  for (const bool odd : {true, false}) {
    options.threads = odd ? 2 : 1;
    const PiecesBuild build(mesh, options);
    for (std::uint32_t p = build.piece_count(); p-- > 0;)
      if ((p % 2 == 1) == odd) decided[p] = build.decide(p);
  }
  PiecesBuild last(mesh, options);
  CHECK(last.write_memory(decided, nullptr, "mesh", "hash") == expected);
  CHECK_THROWS_AS(last.write_memory(decided), Error); // the mesh is gone
  // What is not of this build, or damaged, is refused.
  const auto refused = [&](std::vector<Bytes> wrong, ErrorCode code) {
    PiecesBuild build(mesh, options);
    try {
      static_cast<void>(build.write_memory(std::move(wrong)));
    } catch (const Error& error) {
      return error.code() == code;
    }
    return false;
  };
  std::vector<Bytes> wrong = decided;
  wrong.pop_back();
  CHECK(refused(wrong, ErrorCode::kBadArgument));
  wrong = decided;
  std::swap(wrong[0], wrong[1]);
  CHECK(refused(wrong, ErrorCode::kBadArgument));
  BuildOptions other = options;
  other.min_quality = 0.01;
  wrong = decided;
  wrong[2] = PiecesBuild(mesh, other).decide(2);
  CHECK(refused(wrong, ErrorCode::kBadArgument));
  wrong = decided;
  wrong[3].resize(wrong[3].size() / 2);
  CHECK(refused(wrong, ErrorCode::kCorruptFile));
}

TEST_CASE("pieces: what is not possible in the whole mesh is left to the second pass", "[pieces]") {
  const TetMesh mesh = test::grid({{7, 7, 7}, {}, 3, 13});
  const test::MeshFacts original = test::examine(mesh);
  BuildOptions options = options_of(4);
  options.fields = {"pressure"};
  Built built(mesh, options);
  // A collapse in the middle of piece 2 that takes a vertex away that has gone before.
  RecordStream& records = built.decisions.records;
  std::vector<std::size_t> of_piece;
  for (std::size_t r = 0; r < records.removed.size(); ++r)
    if (built.decisions.piece[r] == 2) of_piece.push_back(r);
  REQUIRE(of_piece.size() > 10);
  const std::size_t middle = of_piece.size() / 2;
  records.removed[of_piece[middle]] = records.removed[of_piece[0]];
  built.finish(options);
  CHECK(built.report.piece_records_dropped == of_piece.size() - middle);
  CHECK(built.stream.validate().empty());
  check_cuts(built, original, 14, true);
  check_squared_error(built);
}

TEST_CASE("pieces: limits hold", "[pieces]") {
  const TetMesh mesh = test::grid({{8, 8, 4}, [](int x, int y, int) { return x < 4 || y < 4; }, 3, 15});
  for (const Prediction prediction : {Prediction::kExact, Prediction::kQuadric}) {
    BuildOptions options = options_of(5, prediction);
    options.fields = {"pressure"};
    options.target_vertices = 0;
    options.max_field_error = {{"pressure", {0.04, true}}};
    options.max_domain_error = {0.01, true};
    Built built(mesh, options);
    built.finish(options);
    REQUIRE(built.report.piece_records > 0);
    for (std::size_t r = 0; r < built.stream.size(); ++r) {
      CHECK(built.stream.largest_error(r, 0) <= 0.04 * built.stream.fields[0].range);
      CHECK(built.stream.domain_error[r] <= 0.01 * built.stream.diagonal);
    }
  }
}

TEST_CASE("pieces: of meshes that have no room for them", "[pieces]") {
  std::vector<test::NamedMesh> meshes{{"single tet", test::single_tet()},
                                      {"two tets", test::two_tets_sharing_a_face()},
                                      {"six tets", test::six_cycle()},
                                      {"pinched vertex", test::pinched_vertex()},
                                      {"pinched edge", test::pinched_edge()},
                                      {"rod", test::grid({{40, 1, 1}, {}, 2, 16})},
                                      {"plate", test::grid({{12, 12, 1}, {}, 2, 17})}};
  // Beside a cube, tets whose corners all lie in one place.
  TetMesh heap =
      test::make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {3, 3, 3}, {3, 3, 3}, {3, 3, 3}, {3, 3, 3}},
                      {{0, 1, 2, 3}, {4, 5, 6, 7}});
  test::add_test_fields(heap);
  meshes.push_back({"heap", heap});
  for (auto& [name, mesh] : meshes) {
    if (mesh.point_arrays.empty()) test::add_test_fields(mesh);
    for (const std::uint32_t pieces : {2U, 7U, 1000U}) {
      INFO(name << ", " << pieces << " pieces");
      BuildOptions options = options_of(pieces);
      options.fields = {"pressure"};
      options.target_vertices = 0;
      Built built(mesh, options);
      built.finish(options);
      CHECK(built.stream.validate().empty());
      check_pieces_apart(built, pieces);
      test::check_round_trip(built.prepared.mesh, built.stream);
    }
  }
}

TEST_CASE("pieces: of a vertex on every boundary there are all faces", "[pieces]") {
  const TetMesh mesh =
      test::grid({{9, 9, 3}, [](int x, int y, int) { return x < 3 || x > 5 || y < 3 || y > 5; }, 2, 18});
  const PreparedMesh prepared = prepare(mesh);
  const build::MeshPieces pieces(prepared, 6);
  std::vector<std::uint32_t> times(prepared.used_vertex_count);
  for (std::uint32_t p = 0; p < pieces.count(); ++p) {
    const build::MeshPiece piece = pieces.piece(p, {});
    const auto whole = [&](VertexId v) { return piece.prepared.original_vertex[v.index()]; };
    const auto is_own = [&](VertexId v) { return pieces.piece_of()[v.index()] == p; };
    std::vector<std::size_t> tets_here(prepared.used_vertex_count), faces_here(tets_here), tets_all(tets_here),
        faces_all(tets_here);
    std::vector<char> touches_others(prepared.used_vertex_count);
    for (const Tet& tet : prepared.mesh.tets)
      for (const VertexId v : tet) {
        ++tets_all[v.index()];
        if (!std::all_of(tet.begin(), tet.end(), is_own)) touches_others[v.index()] = 1;
      }
    for (const Face& face : prepared.boundary_faces)
      for (const VertexId v : face)
        ++faces_all[v.index()];
    for (std::size_t t = 0; t < piece.tet.size(); ++t)
      for (std::size_t i = 0; i < 4; ++i) {
        const VertexId v = whole(piece.prepared.mesh.tets[t][i]);
        CHECK(v == prepared.mesh.tets[piece.tet[t]][i]);
        ++tets_here[v.index()];
      }
    for (const Face& face : piece.prepared.boundary_faces)
      for (const VertexId v : face)
        ++faces_here[whole(v).index()];
    for (std::uint32_t v = 0; v < piece.prepared.used_vertex_count; ++v) {
      const VertexId id = whole(VertexId{v});
      if (is_own(id)) {
        ++times[id.index()];
        CHECK(tets_here[id.index()] == tets_all[id.index()]);
        CHECK(faces_here[id.index()] == faces_all[id.index()]);
      }
      const bool may_move = is_own(id) && touches_others[id.index()] == 0 && prepared.frozen[id.index()] == 0;
      CHECK((piece.prepared.frozen[v] == 0) == may_move);
    }
  }
  CHECK(std::all_of(times.begin(), times.end(), [](std::uint32_t n) { return n == 1; }));
}

TEST_CASE("pieces: options that make no sense are refused, and a build can be stopped", "[pieces]") {
  const TetMesh mesh = test::grid({{5, 5, 5}, {}, 2, 19});
  const auto refused = [&](BuildOptions options) {
    try {
      static_cast<void>(build_memory(mesh, options));
    } catch (const Error& error) {
      return error.code() == ErrorCode::kBadArgument;
    }
    return false;
  };
  CHECK(refused(options_of(0)));
  CHECK(refused(options_of(65537)));
  BuildOptions with_checkpoint = options_of(2);
  with_checkpoint.checkpoint.path = "never.ckpt";
  CHECK(refused(with_checkpoint));
  BuildOptions unknown = options_of(2);
  unknown.fields = {"no such field"};
  CHECK(refused(unknown));
  CHECK_THROWS_AS(PiecesBuild(mesh, options_of(2)).decide(2), Error);

  std::set<std::string> stages;
  const auto all_stages = [&](const Progress& progress) {
    stages.emplace(progress.stage);
    return true;
  };
  static_cast<void>(build_memory(mesh, options_of(3), nullptr, {}, {}, all_stages));
  CHECK(stages.count("collapsing pieces") == 1);
  CHECK(stages.count("joining the pieces") == 1);
  for (const std::string& stage : stages) {
    INFO(stage);
    const auto stop_there = [&](const Progress& progress) { return progress.stage != stage; };
    try {
      static_cast<void>(build_memory(mesh, options_of(3), nullptr, {}, {}, stop_there));
      FAIL("it was not stopped");
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::kCancelled);
    }
  }
}
