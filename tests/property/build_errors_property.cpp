// The errors that the builder records, against brute force: on sample meshes, random grids and real meshes.
#include "support/built.hpp"
#include "support/versions.hpp"
#ifdef PTET_TEST_WITH_VTK
#include "formats/vtk/read.hpp"
#endif

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <set>

#include <catch2/catch.hpp>

using namespace ptet;
using test::Built, test::build_all, test::check_sound, test::faces_of, test::field_array, test::meshes_to_build,
    test::to_the_end, test::vertices_left;

namespace {

struct BoxedTet {
  std::array<Point, 4> corner;
  Point low, high;
};

std::vector<BoxedTet> boxed(const Built& built, const std::vector<Tet>& tets) {
  std::vector<BoxedTet> result;
  for (const Tet& tet : tets) {
    BoxedTet box;
    for (std::size_t i = 0; i < 4; ++i)
      box.corner[i] = built.prepared.points[tet[i].index()];
    box.low = box.high = box.corner[0];
    for (const Point& p : box.corner)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        box.low[axis] = std::min(box.low[axis], p[axis]);
        box.high[axis] = std::max(box.high[axis], p[axis]);
      }
    result.push_back(box);
  }
  return result;
}

bool in_box(const BoxedTet& box, const Point& p, double slack) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (p[axis] < box.low[axis] - slack || p[axis] > box.high[axis] + slack) return false;
  return true;
}

/// For every vertex: at a tet that holds it, no error above those recorded by the tet's maker, inside and outside.
/// Where it lies inside of tets, no error above the one recorded by the maker of one of these, whatever holds it.
/// Returns how many vertices lay outside of all tets.
std::size_t check_field_errors(const Built& built, const std::vector<char>& is_split,
                               const std::vector<VertexId>& vertices) {
  const RecordStream& stream = built.stream;
  const std::vector<Point>& points = built.prepared.points;
  const std::size_t field_count = stream.fields.size();
  const test::CutMesh cut = test::cut_mesh(stream, is_split);
  const std::vector<BoxedTet> boxes = boxed(built, cut.tets);
  const auto holders = test::possible_holders(stream, points, is_split, vertices);
  const test::Versions all(stream);
  const std::vector<std::size_t> maker_of = test::makers(stream);
  const auto excess_at = [&](std::size_t f, VertexId v, const Tet& tet, const std::array<double, 4>& weight,
                             std::size_t maker, bool is_inside) {
    const double recorded = maker == test::CutMesh::kOriginal ? 0
                            : is_inside                       ? stream.field_error[maker * field_count + f]
                                                              : stream.largest_error(maker, f);
    return (test::interpolation_error(field_array(built, f), v, tet, weight) - recorded) / stream.fields[f].scale();
  };
  constexpr double kRounding = 1e-7;
  std::size_t outside_count = 0;
  double worst_inside = 0;
  double worst_held = 0;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const VertexId v = vertices[i];
    const Point& p = points[v.index()];
    std::vector<double> inside(field_count, std::numeric_limits<double>::infinity());
    for (std::size_t t = 0; t < boxes.size(); ++t) {
      if (!in_box(boxes[t], p, 1e-9 * stream.diagonal)) continue;
      const auto weight = test::barycentrics(p, boxes[t].corner);
      if (!weight || *std::min_element(weight->begin(), weight->end()) < test::kTouching) continue;
      for (std::size_t f = 0; f < field_count; ++f)
        inside[f] = std::min(inside[f], excess_at(f, v, cut.tets[t], *weight, cut.tet_maker[t], true));
    }
    if (std::isinf(inside[0]))
      ++outside_count;
    else
      worst_inside = std::max(worst_inside, *std::max_element(inside.begin(), inside.end()));

    std::vector<double> held(field_count, std::numeric_limits<double>::infinity());
    for (const VersionId t : holders[i]) {
      const Tet& tet = all.tets[t.index()];
      const auto nearest = test::nearest_on_tet(p, boxed(built, {tet})[0].corner);
      for (std::size_t f = 0; f < field_count; ++f)
        held[f] = std::min(held[f], excess_at(f, v, tet, nearest.weight, maker_of[t.index()], false));
    }
    worst_held = std::max(worst_held, *std::max_element(held.begin(), held.end()));
  }
  INFO(vertices.size() << " vertices looked at, " << outside_count << " outside; as parts of the range:");
  CHECK(worst_inside <= kRounding);
  CHECK(worst_held <= kRounding);
  return outside_count;
}

/// Points in the cells of a grid over their bounding box.
class PointGrid {
public:
  explicit PointGrid(const std::vector<Point>& points) : low_(points.at(0)), cells_(kSide * kSide * kSide) {
    Point high = low_;
    for (const Point& p : points)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low_[axis] = std::min(low_[axis], p[axis]);
        high[axis] = std::max(high[axis], p[axis]);
      }
    for (std::size_t axis = 0; axis < 3; ++axis)
      width_[axis] = std::max((high[axis] - low_[axis]) / kSide, 1e-300);
    for (std::uint32_t v = 0; v < points.size(); ++v)
      cells_[(cell(points[v], 0) * kSide + cell(points[v], 1)) * kSide + cell(points[v], 2)].emplace_back(v);
  }
  template <class Visit>
  void visit(const Point& low, const Point& high, const Visit& visit) const {
    for (std::size_t x = cell(low, 0); x <= cell(high, 0); ++x)
      for (std::size_t y = cell(low, 1); y <= cell(high, 1); ++y)
        for (std::size_t z = cell(low, 2); z <= cell(high, 2); ++z)
          for (const VertexId v : cells_[(x * kSide + y) * kSide + z])
            visit(v);
  }

private:
  static constexpr std::size_t kSide = 24;
  [[nodiscard]] std::size_t cell(const Point& p, std::size_t axis) const {
    return static_cast<std::size_t>(std::clamp((p[axis] - low_[axis]) / width_[axis], 0.0, kSide - 1.0));
  }
  Point low_;
  Point width_{};
  std::vector<std::vector<VertexId>> cells_;
};

/// No record states less than the error at a removed vertex that lies inside of a tet it made, however the vertex
/// came to lie there.
void check_every_version(const Built& built) {
  const RecordStream& stream = built.stream;
  const test::Versions all(stream);
  const std::vector<Point>& points = built.prepared.points;
  const std::size_t field_count = stream.fields.size();
  const PointGrid grid(points);
  std::vector<char> is_removed(points.size(), 0);
  std::size_t understated = 0;
  std::size_t seen = 0;
  double worst = 0;
  for (std::size_t i = 0; i < stream.size(); ++i) {
    is_removed[stream.removed[i].index()] = 1;
    for (std::size_t m = 0; m < stream.modified_count[i]; ++m) {
      const Tet& tet = all.tets[all.coarse_begin[i].index() + m];
      if (std::find(tet.begin(), tet.end(), kDummyVertex) != tet.end()) continue;
      const BoxedTet box = boxed(built, {tet})[0];
      grid.visit(box.low, box.high, [&](VertexId v) {
        const Point& p = points[v.index()];
        if (!is_removed[v.index()] || !in_box(box, p, 0)) return;
        const auto weight = test::barycentrics(p, box.corner);
        if (!weight || *std::min_element(weight->begin(), weight->end()) < -test::kTouching) return;
        ++seen;
        for (std::size_t f = 0; f < field_count; ++f) {
          const double excess = (test::interpolation_error(field_array(built, f), v, tet, *weight) -
                                 stream.field_error[i * field_count + f]) /
                                stream.fields[f].scale();
          understated += excess > 1e-7 ? 1 : 0;
          worst = std::max(worst, excess);
        }
      });
    }
  }
  INFO("understated by up to " << worst << " of the range");
  CHECK(understated == 0);
  CHECK(seen > 0);
}

/// Removed vertices of the boundary and centroids of its original faces, against the boundary faces that are there.
void check_domain_errors(const Built& built, const test::CutMesh& cut, const std::vector<Point>& samples) {
  const double recorded = test::largest_domain_error(built.stream, cut);
  const std::vector<Face> faces = faces_of(cut.ghosts);
  double worst = 0;
  for (const Point& p : samples) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Face& face : faces) {
      const auto at = [&](std::size_t i) { return built.prepared.points[face[i].index()]; };
      nearest = std::min(nearest, test::nearest_on_triangle(p, {at(0), at(1), at(2)}).distance);
    }
    worst = std::max(worst, nearest);
  }
  CHECK(worst <= recorded + 1e-9 * built.stream.diagonal);
}

std::vector<Point> boundary_samples(const Built& built, const test::CutMesh& cut) {
  std::set<VertexId> on_boundary;
  std::vector<Point> samples;
  for (const Face& face : built.prepared.boundary_faces) {
    on_boundary.insert(face.begin(), face.end());
    Point centre{};
    for (const VertexId v : face)
      for (std::size_t axis = 0; axis < 3; ++axis)
        centre[axis] += built.prepared.points[v.index()][axis] / 3;
    samples.push_back(centre);
  }
  for (const VertexId v : cut.removed)
    if (on_boundary.count(v) != 0) samples.push_back(built.prepared.points[v.index()]);
  return samples;
}

template <class T>
std::vector<T> some_of(std::vector<T> all, std::size_t count, unsigned seed) {
  std::shuffle(all.begin(), all.end(), std::mt19937(seed));
  if (all.size() > count) all.resize(count);
  return all;
}

/// All splits of records with a field or domain error above `fraction` of the largest, and what they need.
std::vector<char> cut_at_error(const RecordStream& stream, double fraction) {
  const std::size_t k = stream.fields.size();
  std::vector<char> is_split(stream.size(), 0);
  const auto split_above = [&](std::size_t count, std::size_t offset, const auto& errors) {
    double largest = 0;
    for (std::size_t i = 0; i < stream.size(); ++i)
      largest = std::max<double>(largest, errors[i * count + offset]);
    for (std::size_t i = 0; i < stream.size(); ++i)
      if (errors[i * count + offset] > fraction * largest) is_split[i] = 1;
  };
  for (std::size_t f = 0; f < k; ++f)
    split_above(k, f, stream.field_error);
  split_above(1, 0, stream.domain_error);
  test::close_cut(stream, is_split);
  return is_split;
}

} // namespace

TEST_CASE("no error that brute force finds is above the recorded one", "[build]") {
  std::size_t outside_count = 0;
  for (const auto& [name, mesh] : meshes_to_build()) {
    INFO(name);
    const Built built = build_all(mesh, to_the_end());
    const std::size_t step = std::max<std::size_t>(built.stream.size() / 12, 1);
    for (std::size_t count = step; count <= built.stream.size(); count += step) {
      INFO("after " << count << " collapses");
      const std::vector<char> is_split = test::after_collapses(built.stream, count);
      const test::CutMesh cut = test::cut_mesh(built.stream, is_split);
      outside_count += check_field_errors(built, is_split, cut.removed);
      check_domain_errors(built, cut, boundary_samples(built, cut));
    }
    for (const double fraction : {0.5, 0.2, 0.05}) {
      INFO("cut at " << fraction << " of the largest error");
      const std::vector<char> is_split = cut_at_error(built.stream, fraction);
      const test::CutMesh cut = test::cut_mesh(built.stream, is_split);
      outside_count += check_field_errors(built, is_split, cut.removed);
      check_domain_errors(built, cut, boundary_samples(built, cut));
    }
  }
  CHECK(outside_count > 100); // else the test has lost its point
}

TEST_CASE("no record states less than the error at a removed vertex inside of what it made", "[build]") {
  for (const auto& [name, mesh] : meshes_to_build()) {
    INFO(name);
    check_every_version(build_all(mesh, to_the_end()));
  }
  // Large enough for the boundary to leave vertices out and take them in again.
  check_every_version(build_all(
      test::grid(
          {{14, 14, 14}, [](int x, int y, int z) { return x * y + z * z + x * z > 40 || (x + y + z) % 3 > 0; }, 3, 9}),
      to_the_end()));
}

TEST_CASE("where the boundary stays, recorded field errors are those at the removed vertices and no larger",
          "[build]") {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    PreparedMesh prepared = prepare(test::grid({{7, 6, 6}, {}, 3, seed}));
    for (const Face& face : prepared.boundary_faces)
      for (const VertexId v : face)
        prepared.frozen[v.index()] = 1;
    BuildOptions options = to_the_end();
    options.prediction = Prediction::kQuadric;
    options.evaluation = Evaluation::kVertices;
    const Built built = build_all(std::move(prepared), options);
    const RecordStream& stream = built.stream;
    REQUIRE(stream.size() > 60);
    const test::Versions all(stream);
    const std::size_t k = stream.fields.size();
    std::vector<VertexId> removed;
    for (std::size_t i = 0; i < stream.size(); ++i) {
      removed.push_back(stream.removed[i]);
      REQUIRE(stream.domain_error[i] == 0);
      const auto first = all.tets.begin() + all.coarse_begin[i].index();
      const std::vector<Tet> made(first, first + stream.modified_count[i]);
      const std::vector<BoxedTet> boxes = boxed(built, made);
      for (std::size_t f = 0; f < k; ++f) {
        // On a face that bounds the star a vertex may be held by the tet behind it.
        double inside = 0;
        double inside_or_touching = 0;
        for (const VertexId v : removed)
          for (std::size_t t = 0; t < made.size(); ++t) {
            const auto weight = test::barycentrics(built.prepared.points[v.index()], boxes[t].corner);
            REQUIRE(weight);
            const double least = *std::min_element(weight->begin(), weight->end());
            if (least < test::kTouching) continue;
            const double error = test::interpolation_error(field_array(built, f), v, made[t], *weight);
            inside_or_touching = std::max(inside_or_touching, error);
            if (least > -test::kTouching) inside = std::max(inside, error);
          }
        const double slack = 1e-6 * stream.fields[f].scale();
        CHECK(stream.field_error[i * k + f] >= inside - slack);
        CHECK(stream.field_error[i * k + f] <= inside_or_touching + slack);
      }
    }
  }
}

TEST_CASE("fields of extreme ranges keep their errors", "[build]") {
  // Beyond single precision, and beyond where squares overflow or vanish.
  for (const double factor : {1e-60, 1e45, 1e-180, 1e200}) {
    INFO("factor " << factor);
    TetMesh mesh = test::grid({{4, 4, 4}, {}, 2, 8});
    mesh.point_arrays.clear();
    test::add_array(mesh, "wave", ScalarType::kFloat64, 1,
                    [](const Point& p) { return std::vector<double>{std::sin(p[0] / 9) + std::cos(p[1] / 7)}; });
    const Built plain = build_all(mesh, to_the_end());
    test::scale(mesh.point_arrays[0], factor);
    const Built built = build_all(mesh, to_the_end());
    CHECK(built.stream.validate() == "");
    CHECK(built.stream.fields[0].range == Approx(plain.stream.fields[0].range * factor).epsilon(1e-9));
    CHECK(built.report.field_error[0].second / built.stream.fields[0].range ==
          Approx(plain.report.field_error[0].second / plain.stream.fields[0].range).epsilon(0.25));
  }
}

#ifdef PTET_TEST_WITH_VTK
TEST_CASE("real meshes: sound, and no error that brute force finds is above the recorded one", "[build][data]") {
  for (const char* const name : {"fire_ug.vtu", "fea_bracket.vtu", "bluntfin.vtu"}) {
    const auto path = test::data_file(name);
    if (!path) {
      WARN("skipped: no " << name << " in " << test::data_dir() << " (set PTET_DATA)");
      continue;
    }
    INFO(name);
    BuildOptions options;
    options.target_vertices = 0.02;
    const Built built = build_all(read_mesh(*path), options);
    REQUIRE(built.stream.validate() == "");
    CHECK(vertices_left(built) < 0.05 * built.prepared.used_vertex_count);
    CHECK(built.report.domain_error <= 0.02 * built.stream.diagonal * (1 + 1e-6));
    test::check_rounds(built.stream);
    check_every_version(built);
    const test::MeshFacts original = test::examine(built.prepared.mesh);
    const auto done = [&](double part) {
      return test::after_collapses(built.stream,
                                   static_cast<std::size_t>(part * static_cast<double>(built.stream.size())));
    };
    unsigned seed = 0;
    for (const std::vector<char>& is_split : {done(0.6), done(0.95), done(1), cut_at_error(built.stream, 0.1)}) {
      INFO("cut " << ++seed);
      const test::CutMesh cut = test::cut_mesh(built.stream, is_split);
      check_sound(built, cut, original);
      check_field_errors(built, is_split, some_of(cut.removed, 400, seed));
      check_domain_errors(built, cut, some_of(boundary_samples(built, cut), 400, seed));
    }
  }
}
#else
TEST_CASE("real meshes: sound, and no error that brute force finds is above the recorded one", "[build][data]") {
  WARN("skipped: built without VTK, which reads the real meshes");
}
#endif
