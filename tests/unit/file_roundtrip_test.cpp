// What is written is read back: the full mesh bit for bit, and of every closed set of blocks the same records.
#include "formats/ptet/reader.hpp"
#include "formats/ptet/writer.hpp"
#include "ptet/error.hpp"
#include "record/error_code.hpp"
#include "support/file_checks.hpp"
#include "support/meshes.hpp"
#include "support/naive_simplifier.hpp"
#include "support/stream_extras.hpp"

#include <limits>
#include <random>

#include <catch2/catch.hpp>

using namespace ptet;
using namespace ptet::test;

TEST_CASE("a file gives back every vertex, value and tet of the mesh") {
  for (const auto& [name, mesh] : sample_meshes(1)) {
    INFO(name);
    check_round_trip(mesh, simplify_naively(mesh));
  }
}

TEST_CASE("dependencies that the tets do not tell are read back") {
  for (const auto& [name, mesh] : sample_meshes(4)) {
    INFO(name);
    RecordStream records = simplify_naively(mesh);
    add_random_dependencies(records, 9);
    REQUIRE(records.validate() == "");
    REQUIRE(records.also_needs.size() > 4);
    check_round_trip(mesh, records);
  }
}

TEST_CASE("squared errors are read back, rounded up") {
  for (const auto& [name, mesh] : sample_meshes(5)) {
    INFO(name);
    RecordStream records = simplify_naively(mesh);
    add_random_squared_errors(records, 10);
    REQUIRE(records.validate() == "");
    check_round_trip(mesh, records);
    // The stream may have its fields in another order than the mesh its arrays.
    REQUIRE(records.fields.size() == 2);
    std::swap(records.fields[0], records.fields[1]);
    for (auto* table : {&records.field_error, &records.squared_error})
      for (std::size_t i = 0; i < table->size(); i += 2)
        std::swap((*table)[i], (*table)[i + 1]);
    check_round_trip(mesh, records);
  }
}

TEST_CASE("squared errors that the file cannot hold are refused") {
  const TetMesh mesh = grid({});
  RecordStream records = simplify_naively(mesh);
  add_random_squared_errors(records, 10);
  for (const double wrong : {std::numeric_limits<double>::quiet_NaN(), 1e300, -1e300}) {
    RecordStream spoiled = records;
    spoiled.squared_error[1] = wrong;
    CHECK_THROWS_AS(file::encode(mesh, spoiled, {}), Error);
    spoiled = records;
    spoiled.uncovered_volume[1] = wrong;
    CHECK_THROWS_AS(file::encode(mesh, spoiled, {}), Error);
  }
  records.fields[0].range = 0;
  std::fill(records.field_error.begin(), records.field_error.end(), 0);
  CHECK_THROWS_AS(file::encode(mesh, records, {}), Error);
}

TEST_CASE("a mesh that cannot be simplified is a file without records") {
  const TetMesh mesh = single_tet();
  const auto records = simplify_naively(mesh);
  CHECK(records.size() == 0);
  check_round_trip(mesh, records);
}

TEST_CASE("places that are no manifold survive") {
  for (const TetMesh& mesh : {pinched_vertex(), pinched_edge()})
    check_round_trip(mesh, simplify_naively(mesh));
}

TEST_CASE("every numeric type keeps its bits, NaN payloads and signed zeros included") {
  TetMesh mesh = grid({});
  std::mt19937_64 random(7);
  for (int type = 0; type <= 9; ++type) {
    for (const bool smooth : {false, true}) {
      PointArray array{"array", static_cast<ScalarType>(type), 2, {}};
      array.name += std::to_string(type) + (smooth ? " smooth" : " random");
      array.resize(mesh.vertex_count());
      if (!smooth) {
        for (std::byte& byte : array.bytes)
          byte = static_cast<std::byte>(random());
      }
      mesh.point_arrays.push_back(array);
    }
  }
  auto* floats = reinterpret_cast<float*>(mesh.point_arrays.back().bytes.data());
  floats[3] = -0.0F;
  floats[9] = std::numeric_limits<float>::infinity();
  // The extra arrays are carried, not governing.
  TetMesh bare = mesh;
  bare.point_arrays.resize(2);
  check_round_trip(mesh, simplify_naively(bare));
}

TEST_CASE("decimal numbers are coded as such and read back exactly") {
  for (const ScalarType type : {ScalarType::kFloat32, ScalarType::kFloat64}) {
    TetMesh mesh = grid({});
    std::mt19937 random(3);
    add_array(mesh, "decimal", type, 1, [&](const Point& at) {
      // Some values that are no short decimals are escapes.
      if (random() % 100 == 0) return std::vector<double>{at[0] / 3};
      return std::vector<double>{static_cast<double>(random() % 200000) / 1000 - 100};
    });
    TetMesh bare = mesh;
    bare.point_arrays.pop_back();
    check_round_trip(mesh, simplify_naively(bare));
  }
}

TEST_CASE("any closed set of blocks decodes to the same records") {
  const TetMesh mesh = grid({{12, 12, 12}, {}, 2, 5});
  auto records = simplify_naively(mesh);
  add_random_dependencies(records, 3, 400);
  add_random_squared_errors(records, 3);
  const auto bytes = file::encode(mesh, records, {});
  file::Reader whole(file::over_memory(bytes));
  file::Content all = whole.read_base();
  std::vector<std::uint32_t> every(whole.header().block_count);
  for (std::uint32_t b = 0; b < every.size(); ++b)
    every[b] = b;
  whole.load(every, all);
  REQUIRE(every.size() >= 3);
  std::mt19937 random(11);
  for (int round = 0; round < 10; ++round) {
    file::Reader reader(file::over_memory(bytes));
    file::Content some = reader.read_base();
    for (int step = 0; step < 3; ++step) {
      const auto start = static_cast<std::uint32_t>(random() % every.size());
      auto closed = closed_under_needs(reader, {start});
      std::shuffle(closed.begin(), closed.end(), random);
      reader.load(closed, some);
      CHECK(some.refinement.validate().empty());
    }
    check_same_records(whole, all, some);
  }
}

TEST_CASE("a manifest is read back") {
  const TetMesh mesh = two_tets_sharing_a_face();
  const file::Manifest manifest{"0.1.0", "name.vtu", "xxh64:0", {{"fields", "p"}, {"rounds", ""}}, {"first", "second"}};
  const auto bytes = file::encode(mesh, simplify_naively(mesh), manifest);
  CHECK(file::Reader(file::over_memory(bytes)).manifest() == manifest);
}

TEST_CASE("the same mesh makes the same bytes") {
  const TetMesh mesh = grid({});
  const auto records = simplify_naively(mesh);
  CHECK(file::encode(mesh, records, {}) == file::encode(mesh, records, {}));
}

TEST_CASE("errors that the file cannot hold are refused") {
  const TetMesh mesh = grid({});
  auto records = simplify_naively(mesh);
  REQUIRE(records.size() > 0);
  records.domain_error[0] = std::numeric_limits<float>::quiet_NaN();
  CHECK_THROWS_AS(file::encode(mesh, records, {}), Error);
  records.domain_error[0] = -1;
  CHECK_THROWS_AS(file::encode(mesh, records, {}), Error);
}

TEST_CASE("writing can be cancelled") {
  const TetMesh mesh = grid({});
  CHECK_THROWS_AS(file::encode(mesh, simplify_naively(mesh), {}, [](const Progress&) { return false; }), Error);
}
