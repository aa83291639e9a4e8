// Real meshes, built by the real builder, asked for random cuts: topology, orientation, volume, errors, budgets and
// focus. PTET_REQUESTS sets the number of requests for each mesh.
#include "formats/vtk/read.hpp"
#include "ptet/build.hpp"
#include "ptet/dataset.hpp"
#include "support/mesh_checks.hpp"
#include "support/meshes.hpp"
#include "support/session_checks.hpp"
#include "support/temp_folder.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <random>
#include <sstream>
#include <unordered_map>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

std::string row_of(const PointArray& array, std::size_t row) {
  return {reinterpret_cast<const char*>(array.bytes.data()) + row * array.row_bytes(), array.row_bytes()};
}

double area_of(const TetMesh& mesh, const std::vector<test::Face>& faces) {
  double area = 0;
  for (const test::Face& face : faces) {
    const Point a = mesh.position(face[0]), b = mesh.position(face[1]), c = mesh.position(face[2]);
    const Point u{b[0] - a[0], b[1] - a[1], b[2] - a[2]}, v{c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    area += std::hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]) / 2;
  }
  return area;
}

/// A mesh with what is known of it, and its .ptet file in a folder of its own.
struct Real {
  explicit Real(const std::string& path)
      : mesh(read_mesh(path)), facts(test::examine(mesh)), area(area_of(mesh, facts.boundary)) {
    BuildOptions options;
    options.prediction = Prediction::kQuadric;
    options.evaluation = Evaluation::kVertices; // cuts do not depend on how errors were measured
    build_file(mesh, folder / "mesh.ptet", options);
    dataset = Dataset::open(folder / "mesh.ptet");
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
      vertex_at[row_of(mesh.positions, v)] = VertexId{v};
    for (const Tet& tet : mesh.tets)
      tets.push_back(test::sorted_keeping_orientation(tet));
    std::sort(tets.begin(), tets.end());
  }
  test::TempFolder folder;
  TetMesh mesh;
  test::MeshFacts facts;
  double area;
  std::shared_ptr<const Dataset> dataset;
  std::unordered_map<std::string, VertexId> vertex_at; ///< by the bits of the position
  std::vector<Tet> tets;                               ///< sorted
};

class RandomRequests {
public:
  RandomRequests(const DatasetInfo& info, unsigned seed) : info_(info), random_(seed) {}

  Request request() {
    Request request;
    const unsigned kind = random_() % 5;
    if (kind == 0 || kind == 4) request.field_error.push_back({"", {std::pow(uniform(), 3), true}});
    if (kind == 1) request.domain_error = Bound{std::pow(uniform(), 3) * 0.02, true};
    if (kind == 2) request.max_tets = random_() % info_.tets;
    if (kind == 3) request.max_vertices = random_() % info_.vertices;
    for (unsigned i = kind == 4 ? 1 + random_() % 2 : random_() % 2; i > 0; --i)
      request.focus.push_back({region()});
    return request;
  }

private:
  double uniform() { return static_cast<double>(random_() % 1000001) / 1e6; }
  Region region() {
    Point centre{};
    for (std::size_t i = 0; i < 3; ++i)
      centre[i] = info_.box_min[i] + uniform() * (info_.box_max[i] - info_.box_min[i]);
    const double size = 0.15 * uniform() * info_.diagonal;
    if (random_() % 2 == 0) return Sphere{centre, size};
    Box box{centre, centre};
    for (double& x : box.max)
      x += size * (0.2 + uniform());
    return box;
  }

  const DatasetInfo& info_;
  std::mt19937 random_;
};

/// Whether one of the tet's corners or its centroid lies in the region.
bool touches(const Region& region, const TetMesh& mesh, const Tet& tet) {
  std::array<Point, 5> points{};
  for (std::size_t i = 0; i < 4; ++i) {
    points[i] = mesh.position(tet[i]);
    for (std::size_t axis = 0; axis < 3; ++axis)
      points[4][axis] += points[i][axis] / 4;
  }
  return std::any_of(points.begin(), points.end(), [&](const Point& p) {
    if (const Sphere* const sphere = std::get_if<Sphere>(&region))
      return std::hypot(p[0] - sphere->centre[0], p[1] - sphere->centre[1], p[2] - sphere->centre[2]) <= sphere->radius;
    const Box& box = std::get<Box>(region);
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (p[axis] < box.min[axis] || p[axis] > box.max[axis]) return false;
    return true;
  });
}

/// The original vertex at each vertex of the extraction, bit for bit in all arrays.
std::vector<VertexId> originals(const Real& real, const TetMesh& mesh) {
  std::vector<VertexId> found;
  bool same_rows = true;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const VertexId original = real.vertex_at.at(row_of(mesh.positions, v));
    for (std::size_t a = 0; a < mesh.point_arrays.size(); ++a)
      same_rows &= row_of(mesh.point_arrays[a], v) == row_of(real.mesh.point_arrays[a], original.index());
    found.push_back(original);
  }
  CHECK(same_rows);
  return found;
}

void check(const Real& real, const Request& request, const Extraction& cut) {
  const test::MeshFacts facts = test::examine(cut.mesh);
  CHECK(facts.inverted_tets == 0);
  CHECK(facts.repeated_tets == 0);
  CHECK(facts.crowded_faces == 0);
  CHECK(facts.folded_faces == 0);
  CHECK(facts.components == real.facts.components);
  CHECK(facts.boundary_euler_characteristic == real.facts.boundary_euler_characteristic);
  // A boundary that moves by no more than d encloses what it did but for a layer of that thickness, on either side.
  CHECK(std::abs(facts.volume - real.facts.volume) <=
        2 * cut.domain_error * std::max(real.area, area_of(cut.mesh, facts.boundary)) + 1e-9 * real.facts.volume);

  const std::vector<VertexId> original = originals(real, cut.mesh);
  std::vector<Tet> tets;
  bool only_originals_in_focus = true;
  for (const Tet& tet : cut.mesh.tets) {
    Tet renamed = tet;
    for (VertexId& v : renamed)
      v = original[v.index()];
    tets.push_back(test::sorted_keeping_orientation(renamed));
    for (const Focus& focus : request.focus)
      if (touches(focus.region, cut.mesh, tet))
        only_originals_in_focus &= std::binary_search(real.tets.begin(), real.tets.end(), tets.back());
  }
  CHECK(only_originals_in_focus);
  std::sort(tets.begin(), tets.end());
  bool all_originals_in_focus = true;
  for (const Tet& tet : real.tets)
    for (const Focus& focus : request.focus)
      if (touches(focus.region, real.mesh, tet))
        all_originals_in_focus &= std::binary_search(tets.begin(), tets.end(), tet);
  CHECK(all_originals_in_focus);

  if (request.focus.empty()) {
    if (request.max_tets)
      CHECK(cut.mesh.tets.size() <= std::max<std::uint64_t>(*request.max_tets, real.dataset->info().base_tets));
    if (request.max_vertices)
      CHECK(cut.mesh.vertex_count() <=
            std::max<std::uint64_t>(*request.max_vertices, real.dataset->info().base_vertices));
  }
  if (!request.field_error.empty())
    for (std::size_t f = 0; f < cut.field_error.size(); ++f)
      CHECK(cut.field_error[f] <= request.field_error[0].bound.value * real.dataset->info().fields[f].range);
}

} // namespace

TEST_CASE("random cuts of real meshes") {
  const char* const wanted = std::getenv("PTET_REQUESTS");
  const int requests = wanted != nullptr ? std::atoi(wanted) : 8;
  for (const char* const name : {"fire_ug.vtu", "pulley.vtu", "fea_bracket.vtu", "seamount.vtu", "bluntfin.vtu"}) {
    const auto path = test::data_file(name);
    if (!path) {
      WARN(name << " is not there: looked in " << test::data_dir() << "; set PTET_DATA. Skipped.");
      continue;
    }
    const Real real(*path);
    const DatasetInfo& info = real.dataset->info();
    CHECK(info.base_vertices <= 0.02 * static_cast<double>(info.vertices));
    const Extraction full = real.dataset->extract({});
    CHECK(full.mesh.tets.size() == real.mesh.tets.size());
    check(real, {}, full);
    RandomRequests random(info, 2026);
    for (int i = 0; i < requests; ++i) {
      INFO(name << ", request " << i);
      const Request request = random.request();
      check(real, request, real.dataset->extract(request));
    }
  }
}

namespace {

/// Stands for a face, three vertices in any order; of opposite sign for the two orientations.
std::uint64_t token_of(const test::Face& face) {
  test::Face key = face;
  bool is_turned = false;
  for (const auto& [i, j] : {std::pair(0, 1), std::pair(1, 2), std::pair(0, 1)})
    if (key[j] < key[i]) {
      std::swap(key[i], key[j]);
      is_turned = !is_turned;
    }
  std::uint64_t hash = 0x9E3779B97F4A7C15;
  for (const VertexId v : key) {
    hash = (hash ^ v.index()) * 0xFF51AFD7ED558CCD;
    hash ^= hash >> 29;
  }
  return is_turned ? 0 - hash : hash;
}

/// Whether the faces of the tets cancel one another but for the boundary that is stated, whatever else: all positively
/// oriented, they cover what it encloses once.
bool is_closed_up(const Extraction& cut) {
  std::uint64_t sum = 0;
  bool is_oriented = true;
  for (const Tet& t : cut.mesh.tets) {
    sum += token_of({t[1], t[2], t[3]}) + token_of({t[0], t[3], t[2]}) + token_of({t[0], t[1], t[3]}) +
           token_of({t[0], t[2], t[1]});
    is_oriented &= test::orientation(cut.mesh.position(t[0]), cut.mesh.position(t[1]), cut.mesh.position(t[2]),
                                     cut.mesh.position(t[3])) > 0;
  }
  for (const test::Face& face : cut.boundary_faces)
    sum -= token_of(face);
  return is_oriented && sum == 0;
}

} // namespace

// PTET_SESSION_REQUESTS sets the number of requests for each mesh, PTET_SESSION_MESHES (names without .vtu, separated
// by blanks) which meshes; then every thousandth request is told.
TEST_CASE("a session goes through random requests of real meshes") {
  const char* const wanted = std::getenv("PTET_SESSION_REQUESTS");
  const int requests = wanted != nullptr ? std::atoi(wanted) : 30;
  const char* const chosen = std::getenv("PTET_SESSION_MESHES");
  std::istringstream names(chosen != nullptr ? chosen : "fire_ug pulley fea_bracket");
  for (std::string name; names >> name;) {
    const auto path = test::data_file(name + ".vtu");
    if (!path) {
      WARN(name << ".vtu is not there: looked in " << test::data_dir() << "; set PTET_DATA. Skipped.");
      continue;
    }
    test::TempFolder folder;
    BuildOptions options;
    options.prediction = Prediction::kQuadric;
    options.evaluation = Evaluation::kVertices;
    build_file(read_mesh(*path), folder / "mesh.ptet", options);
    const auto dataset = Dataset::open(folder / "mesh.ptet");
    const auto other = Dataset::open(folder / "mesh.ptet");
    Session session(dataset);
    test::SlotCopy copy;
    test::RandomRequests random(dataset->info(), 2027);
    for (int i = 0; i < requests; ++i) {
      INFO(name << ", request " << i);
      const Request request = random.next();
      const SessionUpdate& update = session.update(request);
      const Extraction fresh = other->extract(request);
      REQUIRE(test::difference(session, update, fresh) == "");
      copy.follow(session, update);
      REQUIRE(copy.difference(session) == "");
      REQUIRE(is_closed_up(fresh));
      if (i % 1000 == 999) std::cerr << name << ": " << i + 1 << " requests\n";
      if (i % 10 != 0) continue;
      const test::MeshFacts facts = test::examine(fresh.mesh);
      REQUIRE(facts.inverted_tets + facts.repeated_tets + facts.crowded_faces + facts.folded_faces == 0);
    }
  }
}
