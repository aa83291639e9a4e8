// Integrals of the squared error against ones found by clipping every original tet with every version, and the sums
// over records that make the mean square error of a cut.
#include "build/builder.hpp"
#include "build/mesh_scales.hpp"
#include "error/exact_field_error.hpp"
#include "mesh/scalar_dispatch.hpp"
#include "record/ghost.hpp"
#include "support/brute_force.hpp"
#include "support/mesh_checks.hpp"
#include "support/meshes.hpp"
#include "support/versions.hpp"

#include <algorithm>
#include <map>
#include <random>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

/// "pressure" and "flow" of the test meshes: channels 0, and 1 to 3.
constexpr std::array<std::size_t, 4> kFieldOf = {0, 1, 1, 1};

std::vector<double> channels_of(const TetMesh& mesh) {
  std::vector<double> values;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    for (const char* const name : {"pressure", "flow"}) {
      const PointArray& array = *mesh.find(name);
      for (std::uint32_t c = 0; c < array.components; ++c)
        values.push_back(array.value(v, c));
    }
  return values;
}

using Sums = std::array<double, 3>;

/// Integrals of the squared error of pressure and flow over `version` and the domain, and the volume of `version` that
/// is outside.
Sums brute_force(const PreparedMesh& prepared, const Tet& version) {
  Sums integral{0, 0, build::volume_of(prepared, version)};
  const auto lies_apart = [&](const Tet& tet) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto span = [&](const Tet& t) {
        return std::minmax({prepared.points[t[0].index()][axis], prepared.points[t[1].index()][axis],
                            prepared.points[t[2].index()][axis], prepared.points[t[3].index()][axis]});
      };
      const auto [low, high] = span(tet);
      const auto [version_low, version_high] = span(version);
      if (high < version_low || low > version_high) return true;
    }
    return false;
  };
  for (const Tet& tet : prepared.mesh.tets) {
    if (lies_apart(tet) || build::volume_of(prepared, tet) == 0) continue;
    for (const std::size_t f : {0U, 1U}) {
      const auto found = test::integrals_over_overlap(prepared.points, prepared.mesh.point_arrays[f], tet, version);
      for (const double x : found.squared)
        integral[f] += x;
      if (f == 0) integral[2] -= found.volume;
    }
  }
  return integral;
}

/// What is measured of random versions, against every original tet by itself.
struct Compared {
  double largest_integral = 0;
  int outside = 0; ///< versions of which some part is
};
Compared compare_versions(const PreparedMesh& prepared, int versions, std::mt19937& random) {
  const std::vector<double> values = channels_of(prepared.mesh);
  const ExactFieldError exact(prepared, {values, 4, kFieldOf});
  ExactFieldError::Workspace workspace(exact);
  Compared compared;
  for (int i = 0; i < versions; ++i) {
    Tet version{};
    for (VertexId& v : version)
      v = VertexId{static_cast<std::uint32_t>(random() % prepared.used_vertex_count)};
    const auto at = [&](std::size_t k) { return prepared.points[version[k].index()]; };
    const int sign = test::orientation(at(0), at(1), at(2), at(3));
    if (sign == 0) continue;
    if (sign < 0) std::swap(version[2], version[3]);
    const double volume = build::volume_of(prepared, version);
    std::array<double, 2> errors{}, errors_alone{};
    Sums squared{};
    exact.measure(version, workspace, errors, squared);
    exact.measure(version, workspace, errors_alone);
    for (std::size_t f = 0; f < 2; ++f)
      CHECK(errors[f] == Approx(errors_alone[f]).epsilon(1e-12).margin(1e-14));
    const auto expected = brute_force(prepared, version);
    for (const std::size_t f : {0U, 1U})
      CHECK(squared[f] == Approx(expected[f]).epsilon(1e-10).margin(1e-12 * (1 + volume)));
    CHECK(std::abs(squared[2] - expected[2]) <= 1e-10 * volume);
    compared.largest_integral = std::max(compared.largest_integral, squared[0]);
    compared.outside += squared[2] > 0.01 * volume ? 1 : 0;
  }
  return compared;
}

/// A grid whose columns are pressed down, each in layers of its own: many tets are flat, and vertices with values of
/// their own stand in one place.
TetMesh pressed_grid(std::mt19937& random) {
  TetMesh mesh = test::grid({{4, 4, 5}, {}, 0, 1});
  std::map<std::pair<double, double>, std::array<float, 6>> heights;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    const Point p = mesh.position(VertexId{v});
    const auto [it, is_new] = heights.try_emplace({p[0], p[1]});
    for (std::size_t k = 1; is_new && k < it->second.size(); ++k)
      it->second[k] = it->second[k - 1] + static_cast<float>((random() % 4 == 0 ? 1 + random() % 16 : 0));
    store(mesh.positions.bytes.data() + v * mesh.positions.row_bytes() + 2 * sizeof(float),
          it->second[static_cast<std::size_t>(p[2] / 16)]);
  }
  return mesh;
}

} // namespace

TEST_CASE("the integral over any version, also one that leaves the domain") {
  std::mt19937 random(3);
  int outside = 0;
  for (const test::NamedMesh& named : test::sample_meshes(5)) {
    INFO(named.name);
    const Compared compared = compare_versions(prepare(named.mesh), 40, random);
    CHECK(compared.largest_integral > 10);
    outside += compared.outside;
  }
  CHECK(outside > 20);
}

TEST_CASE("the integral over any version of a mesh with flat tets") {
  std::mt19937 random(4);
  for (int i = 0; i < 20; ++i) {
    INFO(i);
    CHECK(compare_versions(prepare(pressed_grid(random)), 60, random).largest_integral > 10);
  }
}

TEST_CASE("the squared errors of the records that are not split add up to that of the cut") {
  std::mt19937 random(11);
  double most_uncovered = 0;
  for (const test::NamedMesh& named : test::sample_meshes(6)) {
    if (named.name == "cube" || named.name == "l-shape" || named.name == "cavity") continue;
    INFO(named.name);
    PreparedMesh prepared = prepare(named.mesh);
    BuildOptions options;
    options.target_vertices = 0;
    options.max_domain_error = {1, true};
    BuildReport report;
    const RecordStream records = build::build_records(prepared, options, report, {});
    REQUIRE(records.fields.size() == 2);
    CHECK(records.validate().empty());
    CHECK(records.volume == Approx(test::examine(named.mesh).volume).epsilon(1e-13));

    // Every version that was made, by itself: among them some with no corner inside the domain.
    const std::vector<double> values = channels_of(prepared.mesh);
    const ExactFieldError exact(prepared, {values, 4, kFieldOf});
    ExactFieldError::Workspace workspace(exact);
    std::map<Tet, Sums> integral_of;
    std::size_t wrong = 0;
    const test::Versions all(records);
    for (std::size_t t = records.slot_count(); t < all.tets.size(); ++t) {
      if (is_ghost(all.tets[t])) continue;
      const auto expected = integral_of[all.tets[t]] = brute_force(prepared, all.tets[t]);
      std::array<double, 2> errors{};
      Sums squared{};
      exact.measure(all.tets[t], workspace, errors, squared);
      for (std::size_t f = 0; f < 2; ++f)
        wrong += static_cast<std::size_t>(squared[f] != Approx(expected[f]).epsilon(1e-10).margin(1e-12));
      wrong += std::abs(squared[2] - expected[2]) > 1e-10 * records.volume ? 1 : 0;
    }
    CHECK(wrong == 0);

    std::array<double, 2> of_base{};
    for (std::size_t i = 0; i < 2 * records.size(); ++i)
      of_base[i % 2] += records.squared_error[i];
    for (const unsigned one_in : {0U, 300U, 30U, 5U}) {
      std::vector<char> is_split(records.size(), 0);
      for (char& split : is_split)
        split = static_cast<char>(one_in != 0 && random() % one_in == 0);
      test::close_cut(records, is_split);
      std::array<double, 2> stated{}, expected{};
      double uncovered = 0, covered = 0;
      for (std::size_t r = 0; r < records.size(); ++r) {
        if (is_split[r]) continue;
        for (std::size_t f = 0; f < 2; ++f)
          stated[f] += records.squared_error[2 * r + f];
        uncovered += records.uncovered_volume[r];
      }
      const test::CutMesh cut = test::cut_mesh(records, is_split);
      for (std::size_t t = 0; t < cut.tets.size(); ++t) {
        covered += build::volume_of(prepared, cut.tets[t]);
        if (cut.tet_maker[t] == test::CutMesh::kOriginal) continue;
        for (std::size_t f = 0; f < 2; ++f)
          expected[f] += integral_of.at(cut.tets[t])[f];
        covered -= integral_of.at(cut.tets[t])[2];
      }
      CHECK(std::abs(uncovered - (records.volume - covered)) <= 1e-9 * records.volume);
      most_uncovered = std::max(most_uncovered, uncovered / records.volume);
      for (std::size_t f = 0; f < 2; ++f) {
        CHECK(std::abs(stated[f] - expected[f]) <= 1e-9 * of_base[f]);
        if (one_in == 0) CHECK(stated[f] > 0);
      }
    }
  }
  CHECK(most_uncovered > 0.05);
}
