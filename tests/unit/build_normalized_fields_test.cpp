// The governing fields: which, in what scale, and what is refused.
#include "build/normalized_fields.hpp"
#include "ptet/error.hpp"
#include "support/meshes.hpp"

#include <cmath>
#include <cstring>
#include <limits>

#include <catch2/catch.hpp>

using namespace ptet;
using build::NormalizedFields;

namespace {

/// Vertex 0 is in no tet; the others are those of a single tet.
TetMesh tet_and_a_loose_vertex() {
  return test::make_mesh({{9, 9, 9}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{1, 2, 3, 4}});
}

void set_double(TetMesh& mesh, const char* name, std::size_t row, double value) {
  for (PointArray& array : mesh.point_arrays)
    if (array.name == name) std::memcpy(array.bytes.data() + row * array.row_bytes(), &value, sizeof value);
}

/// The message with its code in front.
std::string refusal(const TetMesh& mesh, const std::vector<std::string>& names) {
  const PreparedMesh prepared = prepare(mesh);
  try {
    const NormalizedFields fields(prepared, names);
  } catch (const Error& error) {
    return (error.code() == ErrorCode::kBadArgument ? "argument: "
            : error.code() == ErrorCode::kBadInput  ? "input: "
                                                    : "other: ") +
           std::string(error.what());
  }
  return "accepted";
}

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

} // namespace

TEST_CASE("fields: values are fractions of the range of the used vertices", "[build][fields]") {
  TetMesh mesh = tet_and_a_loose_vertex();
  // 90 at the loose vertex, 10 + 2 x elsewhere.
  test::add_array(mesh, "heat", ScalarType::kFloat32, 1,
                  [](const Point& p) { return std::vector<double>{p[0] > 8 ? 90 : 10 + 2 * p[0]}; });
  // Components range over 3, 4 and 12: a box with a diagonal of 13.
  test::add_array(mesh, "flow", ScalarType::kFloat64, 3, [](const Point& p) {
    return std::vector<double>{3 * p[0], 4 * p[1], p[0] > 8 ? 1e9 : 12 * p[2]};
  });
  test::add_array(mesh, "same", ScalarType::kFloat64, 1, [](const Point&) { return std::vector<double>{5}; });
  test::add_array(mesh, "count", ScalarType::kInt32, 1, [](const Point& p) { return std::vector<double>{p[0]}; });
  const PreparedMesh prepared = prepare(mesh);
  const NormalizedFields fields(prepared, {});
  REQUIRE(fields.field_count() == 3); // "count" is no floating-point array
  CHECK(fields.fields()[0].array == 0);
  CHECK(fields.fields()[0].range == 2);
  CHECK(fields.fields()[1].range == Approx(13));
  CHECK(fields.fields()[2].range == 0); // constant
  CHECK(fields.fields()[2].scale() == 1);
  REQUIRE(fields.channel_count() == 5);
  const std::array<std::size_t, 5> field_of = {0, 1, 1, 1, 2};
  for (std::size_t c = 0; c < 5; ++c)
    CHECK(fields.field_of(c) == field_of[c]);
  for (std::uint32_t v = 0; v < prepared.used_vertex_count; ++v) {
    const Point& p = prepared.points[v];
    CHECK(fields.at(v)[0] == Approx(5 + p[0]));
    CHECK(fields.at(v)[1] == Approx(3 * p[0] / 13));
    CHECK(fields.at(v)[2] == Approx(4 * p[1] / 13));
    CHECK(fields.at(v)[3] == Approx(12 * p[2] / 13));
  }
}

TEST_CASE("fields: values far from 0 keep the digits of their differences", "[build][fields]") {
  TetMesh mesh = tet_and_a_loose_vertex();
  const auto add = [&](const char* name, double origin, double spread) {
    test::add_array(mesh, name, ScalarType::kFloat64, 1, [=](const Point& p) {
      return std::vector<double>{p[0] > 8 ? -1 : origin + spread * (p[0] + 0.25 * p[1])};
    });
  };
  add("air", 101325, 0x1p-20);
  add("same", 7.1, 0);
  add("below", -0x1p40, 0x1p-10);
  add("near", 15, 1);
  const PreparedMesh prepared = prepare(mesh);
  const NormalizedFields fields(prepared, {});
  for (std::uint32_t v = 0; v < prepared.used_vertex_count; ++v) {
    const Point& p = prepared.points[v];
    CHECK(fields.at(v)[0] == p[0] + 0.25 * p[1]);
    CHECK(fields.at(v)[1] == 0);
    CHECK(fields.at(v)[2] == p[0] + 0.25 * p[1]);
    CHECK(fields.at(v)[3] == 15 + p[0] + 0.25 * p[1]);
  }
}

TEST_CASE("fields: chosen by name, once each, or arrays of integers when there is nothing else", "[build][fields]") {
  TetMesh mesh = tet_and_a_loose_vertex();
  test::add_array(mesh, "count", ScalarType::kInt16, 1, [](const Point& p) { return std::vector<double>{7 * p[0]}; });
  test::add_array(mesh, "mark", ScalarType::kUInt8, 1, [](const Point& p) { return std::vector<double>{p[1]}; });
  CHECK(NormalizedFields(prepare(mesh), {}).field_count() == 2);
  test::add_array(mesh, "heat", ScalarType::kFloat32, 1, [](const Point& p) { return std::vector<double>{p[2]}; });
  const PreparedMesh prepared = prepare(mesh);
  const NormalizedFields by_default(prepared, {});
  REQUIRE(by_default.field_count() == 1);
  CHECK(by_default.fields()[0].array == 2);
  const NormalizedFields named(prepared, {"heat", "count", "heat"});
  REQUIRE(named.field_count() == 2);
  CHECK(named.fields()[0].array == 2);
  CHECK(named.fields()[1].array == 0);
  CHECK(named.fields()[1].range == 7);
  CHECK(NormalizedFields(prepare(tet_and_a_loose_vertex()), {}).field_count() == 0);
}

TEST_CASE("fields: an unknown name is refused with the known ones", "[build][fields]") {
  TetMesh mesh = tet_and_a_loose_vertex();
  CHECK(holds(refusal(mesh, {"heat"}), "argument: "));
  CHECK(holds(refusal(mesh, {"heat"}), "no point array"));
  test::add_test_fields(mesh);
  const std::string message = refusal(mesh, {"pressure", "presure"});
  CHECK(holds(message, "argument: "));
  CHECK(holds(message, "'presure'"));
  for (const char* const known : {"'pressure'", "'flow'", "'marker'"})
    CHECK(holds(message, known));
  CHECK(refusal(mesh, {"flow", "marker"}) == "accepted");
}

TEST_CASE("fields: a value that is not finite is refused by field and vertex of the given mesh", "[build][fields]") {
  // Prepared meshes are numbered along a curve: the far corner comes last there, and first here.
  TetMesh mesh = test::make_mesh({{5, 5, 5}, {4, 0, 0}, {0, 0, 0}, {0, 4, 0}, {9, 9, 9}}, {{0, 1, 2, 3}});
  mesh.tets[0] = {VertexId{2}, VertexId{1}, VertexId{3}, VertexId{0}};
  test::add_array(mesh, "heat", ScalarType::kFloat64, 1, [](const Point& p) { return std::vector<double>{p[0]}; });
  test::add_array(mesh, "wind", ScalarType::kFloat64, 1, [](const Point& p) { return std::vector<double>{p[1]}; });
  REQUIRE(prepare(mesh).original_vertex[0] != VertexId{0});
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()})
    for (const std::size_t vertex : {0U, 1U, 2U, 3U}) {
      TetMesh spoilt = mesh;
      set_double(spoilt, "wind", vertex, bad);
      const std::string message = refusal(spoilt, {});
      CHECK(holds(message, "input: "));
      CHECK(holds(message, "'wind'"));
      CHECK(holds(message, "vertex " + std::to_string(vertex) + ":"));
      CHECK(refusal(spoilt, {"heat"}) == "accepted"); // a carried array may hold anything
    }
  set_double(mesh, "wind", 4, std::nan("")); // in no tet
  CHECK(refusal(mesh, {}) == "accepted");
}

TEST_CASE("fields: integers of 64 bits keep what a double does not hold", "[build][fields]") {
  TetMesh mesh = tet_and_a_loose_vertex();
  for (const ScalarType type : {ScalarType::kInt64, ScalarType::kUInt64})
    for (const std::uint64_t base : {std::uint64_t{1} << 60U, std::uint64_t{1'700'000'000'000'000'000U}}) {
      TetMesh with = mesh;
      test::add_array(with, "n", type, 1, [](const Point&) { return std::vector<double>{0}; });
      const std::array<std::uint64_t, 5> above = {0, 5, 6, 3, 154};
      for (std::size_t v = 0; v < 5; ++v) {
        const std::uint64_t value = base + above[v];
        std::memcpy(with.point_arrays[0].bytes.data() + 8 * v, &value, 8);
      }
      const PreparedMesh prepared = prepare(with);
      const NormalizedFields fields(prepared, {"n"});
      CHECK(fields.fields()[0].range == 151);
      for (std::uint32_t v = 0; v < 4; ++v) {
        const auto expected = static_cast<double>(above[prepared.original_vertex[v].index()]) -
                              static_cast<double>(above[prepared.original_vertex[0].index()]);
        CHECK((fields.at(v)[0] - fields.at(0)[0]) * 151 == Approx(expected).margin(1e-9));
        CHECK((fields.exact().at(v)[0] - fields.exact().at(0)[0]) * 128 == expected);
      }
    }
}

TEST_CASE("fields: integers further apart than a double can tell are refused", "[build][fields]") {
  TetMesh mesh = tet_and_a_loose_vertex();
  test::add_array(mesh, "n", ScalarType::kInt64, 1, [](const Point& p) { return std::vector<double>{p[0]}; });
  const auto set = [&](std::size_t row, std::int64_t value) {
    std::memcpy(mesh.point_arrays[0].bytes.data() + 8 * row, &value, 8);
  };
  const std::int64_t far = std::int64_t{1} << 53U;
  set(0, std::numeric_limits<std::int64_t>::min()); // in no tet
  set(1, -far / 2);
  set(2, far / 2 - 1);
  CHECK(refusal(mesh, {"n"}) == "accepted");
  set(2, far / 2);
  CHECK(holds(refusal(mesh, {"n"}), "input: "));
  CHECK(holds(refusal(mesh, {"n"}), "'n' span 2^53"));
  set(1, std::numeric_limits<std::int64_t>::min());
  set(2, std::numeric_limits<std::int64_t>::max());
  CHECK(holds(refusal(mesh, {"n"}), "'n' span 2^53"));
}

TEST_CASE("fields: values are kept to the last bit, in units of a power of two", "[build][fields]") {
  TetMesh mesh = tet_and_a_loose_vertex();
  test::add_array(mesh, "heat", ScalarType::kFloat64, 1,
                  [](const Point& p) { return std::vector<double>{1e12 + p[0] / 3 + p[1] / 7}; });
  const PreparedMesh prepared = prepare(mesh);
  const NormalizedFields fields(prepared, {});
  const double range = fields.fields()[0].range;
  const double unit = std::exp2(std::floor(std::log2(range)));
  CHECK(fields.exact().scale(0) == unit / range);
  for (std::uint32_t v = 0; v < 4; ++v)
    CHECK(fields.exact().at(v)[0] * unit == prepared.mesh.point_arrays[0].value(v, 0));
}

TEST_CASE("fields: fill values are spoken of, and refused where they drown all else", "[build][fields]") {
  TetMesh mesh = test::grid({{3, 3, 3}, {}, 0, 1});
  mesh.point_arrays.clear();
  test::add_array(mesh, "heat", ScalarType::kFloat64, 1, [](const Point& p) { return std::vector<double>{p[0] + 3}; });
  CHECK(NormalizedFields(prepare(mesh), {}).notes().empty());
  set_double(mesh, "heat", 5, 1e20);
  const std::vector<std::string> notes = NormalizedFields(prepare(mesh), {}).notes();
  REQUIRE(notes.size() == 1);
  CHECK(holds(notes[0], "of 'heat'"));
  CHECK(holds(notes[0], "they range over 1e+20, half of them within"));
  CHECK(holds(notes[0], "fill values"));
  CHECK(refusal(mesh, {}) == "accepted");
  set_double(mesh, "heat", 6, 1e-300);
  CHECK(refusal(mesh, {}) == "accepted"); // as good as 0
  set_double(mesh, "heat", 5, 1.7e308);
  CHECK(holds(refusal(mesh, {}), "input: the values of field 'heat' range over 1.7e+308"));
  // A component beside which the others are nothing.
  TetMesh far = tet_and_a_loose_vertex();
  test::add_array(far, "wind", ScalarType::kFloat64, 2, [](const Point& p) {
    return std::vector<double>{1e300, 1e-10 * p[0]};
  });
  CHECK(holds(refusal(far, {}), "input: the values of field 'wind' range over 1e-10"));
}
