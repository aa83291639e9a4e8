// The C interface beside the C++ one: the same answers, byte for byte, and no exception leaves it, whatever is thrown.
#include "formats/ptet/writer.hpp"
#include "ptet/dataset.hpp"
#include "ptet/ptet.h"
#include "ptet/ptet_build.h"
#include "support/meshes.hpp"
#include "support/naive_simplifier.hpp"

#include <cmath>
#include <cstring>
#include <functional>
#include <memory>
#include <stdexcept>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

const std::vector<std::byte>& file_bytes() {
  static const std::vector<std::byte> bytes = [] {
    const TetMesh mesh = test::grid({{5, 4, 3}, {}, 2, 3});
    RecordStream records = test::simplify_naively(mesh);
    records.volume = 50;
    records.squared_error.assign(records.field_error.size(), 0);
    records.squared_error[0] = 8;
    records.uncovered_volume.assign(records.size(), 0);
    records.uncovered_volume[0] = 5;
    return file::encode(mesh, records, {"1.2.3", "in.vtu", "", {}, {}});
  }();
  return bytes;
}

struct Freed {
  void operator()(ptet_dataset* x) const { ptet_dataset_free(x); }
  void operator()(ptet_request* x) const { ptet_request_free(x); }
  void operator()(ptet_extraction* x) const { ptet_extraction_free(x); }
  void operator()(ptet_error* x) const { ptet_error_free(x); }
  void operator()(ptet_builder* x) const { ptet_builder_free(x); }
};
template <class T>
using Owned = std::unique_ptr<T, Freed>;

Owned<ptet_dataset> open_c() {
  ptet_dataset* dataset = nullptr;
  REQUIRE(ptet_dataset_open_memory(file_bytes().data(), file_bytes().size(), nullptr, &dataset, nullptr) == PTET_OK);
  return Owned<ptet_dataset>(dataset);
}

template <class Struct>
Struct sized() {
  Struct made{};
  made.struct_size = sizeof(Struct);
  return made;
}

void check_equal(const ptet_array& c, const PointArray& cpp) {
  CHECK(c.name == cpp.name);
  CHECK(c.type == static_cast<int>(cpp.type));
  CHECK(c.components == cpp.components);
  REQUIRE(c.rows == cpp.size());
  CHECK(std::memcmp(c.data, cpp.bytes.data(), cpp.bytes.size()) == 0);
}

template <class Row>
void check_equal(const std::uint32_t* c, const std::vector<Row>& cpp) {
  if (cpp.empty())
    CHECK(c == nullptr);
  else
    CHECK(std::memcmp(c, cpp.data(), cpp.size() * sizeof(Row)) == 0);
}

void check_equal(const ptet_extraction* c, const Extraction& cpp, const DatasetInfo& of) {
  auto info = sized<ptet_extraction_info>();
  REQUIRE(ptet_extraction_get_info(c, &info, nullptr) == PTET_OK);
  REQUIRE(info.vertices == cpp.mesh.vertex_count());
  REQUIRE(info.tets == cpp.mesh.tets.size());
  REQUIRE(info.boundary_faces == cpp.boundary_faces.size());
  REQUIRE(info.fields == cpp.mesh.point_arrays.size());
  CHECK(info.domain_error == cpp.domain_error);
  CHECK(info.bytes_read == cpp.bytes_read);
  CHECK(std::string(ptet_limit_name(info.limited_by)) == name_of(cpp.limited_by));
  auto array = sized<ptet_array>();
  REQUIRE(ptet_extraction_get_positions(c, &array, nullptr) == PTET_OK);
  check_equal(array, cpp.mesh.positions);
  std::size_t governing = 0;
  for (std::uint32_t f = 0; f < info.fields; ++f) {
    REQUIRE(ptet_extraction_get_field(c, f, &array, nullptr) == PTET_OK);
    check_equal(array, cpp.mesh.point_arrays[f]);
    if (of.fields[f].governing) {
      CHECK(ptet_extraction_field_error(c, f) == cpp.field_error.at(governing));
      CHECK(ptet_extraction_rms_error(c, f) == cpp.rms_error.at(governing));
      ++governing;
    } else {
      CHECK(std::isnan(ptet_extraction_field_error(c, f)));
    }
  }
  CHECK(ptet_extraction_covered(c) == cpp.covered.value());
  check_equal(ptet_extraction_tets(c), cpp.mesh.tets);
  check_equal(ptet_extraction_boundary_faces(c), cpp.boundary_faces);
  check_equal(ptet_extraction_vertices_in_file(c), cpp.vertex_in_file);
  check_equal(ptet_extraction_made_by(c), cpp.made_by);
}

/// What the call answers and says, which it does without throwing.
std::pair<ptet_status, std::string> answer(const std::function<ptet_status(ptet_error**)>& call) {
  ptet_error* error = nullptr;
  ptet_status status = PTET_OK;
  CHECK_NOTHROW(status = call(&error));
  const Owned<ptet_error> owned(error);
  CHECK(ptet_error_status(error) == status);
  return {status, ptet_error_message(error)};
}

} // namespace

TEST_CASE("C interface: what a file says of itself is what the C++ interface says") {
  const auto cpp = Dataset::open_memory(file_bytes());
  const auto c = open_c();
  auto info = sized<ptet_dataset_info>();
  REQUIRE(ptet_dataset_get_info(c.get(), &info, nullptr) == PTET_OK);
  const DatasetInfo& of = cpp->info();
  CHECK(info.vertices == of.vertices);
  CHECK(info.tets == of.tets);
  CHECK(info.base_vertices == of.base_vertices);
  CHECK(info.base_tets == of.base_tets);
  CHECK(info.records == of.records);
  CHECK(info.blocks == of.blocks);
  CHECK(info.file_bytes == of.file_bytes);
  CHECK(info.position_type == static_cast<int>(of.position_type));
  CHECK(Point{info.box_min[0], info.box_min[1], info.box_min[2]} == of.box_min);
  CHECK(Point{info.box_max[0], info.box_max[1], info.box_max[2]} == of.box_max);
  CHECK(info.diagonal == of.diagonal);
  CHECK(info.max_domain_error == of.max_domain_error);
  CHECK((of.base_covered ? info.base_covered == *of.base_covered : std::isnan(info.base_covered)));
  REQUIRE(info.fields == of.fields.size());
  std::size_t governing = 0;
  for (std::uint32_t f = 0; f < info.fields; ++f) {
    auto field = sized<ptet_field_info>();
    REQUIRE(ptet_dataset_get_field(c.get(), f, &field, nullptr) == PTET_OK);
    CHECK(field.name == of.fields[f].name);
    CHECK(field.components == of.fields[f].components);
    CHECK(field.range == of.fields[f].range);
    REQUIRE((field.governing == 1) == of.fields[f].governing);
    if (!of.fields[f].governing) continue;
    CHECK(field.max_error == of.max_field_error.at(governing));
    CHECK(field.max_rms == of.base_rms_error.at(governing));
    ++governing;
  }
  CHECK(governing == 2);
  CHECK(ptet_dataset_provenance(c.get()) == of.provenance_json);
}

TEST_CASE("C interface: the same request gives the same mesh as the C++ interface") {
  struct Asked {
    Request cpp;
    Owned<ptet_request> c{ptet_request_new()};
  };
  std::vector<Asked> all(13);
  const std::array<double, 3> low{10, 10, 10}, high{30, 25, 20};
  for (std::size_t i = 1; i < all.size(); ++i) {
    Request& cpp = all[i].cpp;
    ptet_request* const c = all[i].c.get();
    if (i == 1 || i == 6) {
      cpp.field_error.push_back({"", {0.05, true}});
      REQUIRE(ptet_request_add_field_error(c, nullptr, 0.05, 1, nullptr) == PTET_OK);
    }
    if (i == 2) {
      cpp.field_error.push_back({"flow", {0.7, false}});
      cpp.domain_error = Bound{1.5, false};
      REQUIRE(ptet_request_add_field_error(c, "flow", 0.7, 0, nullptr) == PTET_OK);
      REQUIRE(ptet_request_set_domain_error(c, 1.5, 0, nullptr) == PTET_OK);
    }
    if (i == 3) {
      cpp.max_tets = 150;
      REQUIRE(ptet_request_set_max_tets(c, 150, nullptr) == PTET_OK);
    }
    if (i == 4 || i == 7) {
      cpp.max_vertices = 70;
      REQUIRE(ptet_request_set_max_vertices(c, 70, nullptr) == PTET_OK);
    }
    if (i >= 5 && i <= 7) {
      cpp.focus.push_back({Box{low, high}, {0, true}, {}});
      cpp.origins = true;
      REQUIRE(ptet_request_add_focus_box(c, low.data(), high.data(), nullptr) == PTET_OK);
      REQUIRE(ptet_request_set_origins(c, 1, nullptr) == PTET_OK);
    }
    if (i == 6 || i == 7) {
      cpp.focus.push_back({Sphere{high, 9}, {0.01, true}, Bound{0.3, true}});
      cpp.focus.front().error = {0.01, true};
      cpp.focus.front().falloff = Bound{0.5, true};
      REQUIRE(ptet_request_add_focus_sphere(c, high.data(), 9, nullptr) == PTET_OK);
      REQUIRE(ptet_request_set_focus_error(c, 0.01, 1, nullptr) == PTET_OK);
      REQUIRE(ptet_request_set_focus_falloff(c, 0.3, 1, nullptr) == PTET_OK);
      REQUIRE(ptet_request_set_region_falloff(c, 0, 0.5, 1, nullptr) == PTET_OK);
    }
  }
  {
    Request& cpp = all[8].cpp;
    ptet_request* const c = all[8].c.get();
    const double axes[9] = {6, 6, 0, -5, 5, 0, 0, 0, 9};
    cpp.focus.push_back({OrientedBox{high, {{{6, 6, 0}, {-5, 5, 0}, {0, 0, 9}}}}, {0, true}, {}});
    cpp.focus.push_back({HalfSpace{{1, 2, 0}, 20}, {0.02, true}, {}});
    REQUIRE(ptet_request_add_focus_oriented_box(c, high.data(), axes, nullptr) == PTET_OK);
    const double normal[3] = {1, 2, 0};
    REQUIRE(ptet_request_add_focus_half_space(c, normal, 20, nullptr) == PTET_OK);
    REQUIRE(ptet_request_set_region_error(c, 1, 0.02, 1, nullptr) == PTET_OK);
  }
  for (const std::size_t i : {9, 10}) {
    all[i].cpp.values.push_back({"pressure", 1, i == 9 ? 1 : 2.5});
    all[i].cpp.field_error.push_back({"", {0.05, true}});
    REQUIRE(ptet_request_add_values(all[i].c.get(), "pressure", 1, i == 9 ? 1 : 2.5, nullptr) == PTET_OK);
    REQUIRE(ptet_request_add_field_error(all[i].c.get(), "", 0.05, 1, nullptr) == PTET_OK);
  }
  {
    View view;
    view.eye = {-50, 20, 20};
    view.direction = {1, 0, 0};
    view.up = {0, 0, 1};
    view.width = 200;
    view.height = 100;
    view.outside = 3;
    all[11].cpp.view = view;
    auto seen = sized<ptet_view>();
    std::copy(view.eye.begin(), view.eye.end(), seen.eye);
    std::copy(view.direction.begin(), view.direction.end(), seen.direction);
    std::copy(view.up.begin(), view.up.end(), seen.up);
    seen.vertical_angle = view.vertical_angle;
    seen.width = view.width;
    seen.height = view.height;
    seen.max_pixels = view.max_pixels;
    seen.outside = view.outside;
    REQUIRE(ptet_request_set_view(all[11].c.get(), &seen, nullptr) == PTET_OK);
    all[12].cpp.max_bytes = 8000;
    REQUIRE(ptet_request_set_max_bytes(all[12].c.get(), 8000, nullptr) == PTET_OK);
  }
  const auto cpp = Dataset::open_memory(file_bytes());
  const auto c = open_c();
  std::size_t sizes = 0, last = 0;
  for (const Asked& asked : all) {
    const Extraction expected = cpp->extract(asked.cpp);
    sizes += expected.mesh.tets.size() != last ? 1U : 0U;
    last = expected.mesh.tets.size();
    ptet_extraction* got = nullptr;
    REQUIRE(ptet_dataset_extract(c.get(), asked.c.get(), nullptr, nullptr, &got, nullptr) == PTET_OK);
    const Owned<ptet_extraction> owned(got);
    check_equal(got, expected, cpp->info());
  }
  CHECK(sizes > 4); // the requests are not all the same
}

TEST_CASE("C interface: what a callback throws becomes an error") {
  const auto c = open_c();
  const Owned<ptet_request> request(ptet_request_new());
  REQUIRE(ptet_request_set_max_tets(request.get(), 150, nullptr) == PTET_OK);
  ptet_extraction* extraction = nullptr;
  const ptet_progress_callback progress = [](const char*, std::uint64_t, std::uint64_t, void* user) -> std::int32_t {
    if (user != nullptr) throw std::runtime_error("thrown while looking on");
    throw 42;
  };
  int user = 0;
  const auto extract = [&](void* with) {
    return answer([&](ptet_error** error) {
      return ptet_dataset_extract(c.get(), request.get(), progress, with, &extraction, error);
    });
  };
  CHECK(extract(&user) == std::pair<ptet_status, std::string>(PTET_INTERNAL_ERROR, "thrown while looking on"));
  CHECK(extract(nullptr).first == PTET_INTERNAL_ERROR);
  CHECK(extraction == nullptr);
  // The dataset is none the worse for it.
  REQUIRE(ptet_dataset_extract(c.get(), request.get(), nullptr, nullptr, &extraction, nullptr) == PTET_OK);
  ptet_extraction_free(extraction);

  auto source = sized<ptet_source>();
  source.size = file_bytes().size();
  source.read = [](void*, std::uint64_t, std::uint64_t, void*) -> std::int32_t { throw std::bad_alloc(); };
  ptet_dataset* dataset = nullptr;
  const auto open = [&](ptet_error** error) { return ptet_dataset_open_source(&source, nullptr, &dataset, error); };
  CHECK(answer(open).first == PTET_OUT_OF_MEMORY);
  source.read = [](void*, std::uint64_t, std::uint64_t, void*) -> std::int32_t { throw Error(ErrorCode::kIo, "no"); };
  CHECK(answer(open) == std::pair<ptet_status, std::string>(PTET_IO_ERROR, "no"));
  CHECK(dataset == nullptr);

  const Owned<ptet_builder> builder(ptet_builder_new());
  const TetMesh mesh = test::six_cycle();
  REQUIRE(ptet_builder_set_points(builder.get(), static_cast<int>(mesh.positions.type), mesh.vertex_count(),
                                  mesh.positions.bytes.data(), nullptr) == PTET_OK);
  REQUIRE(ptet_builder_set_tets(builder.get(), mesh.tets.size(),
                                reinterpret_cast<const std::uint32_t*>(mesh.tets.data()), nullptr) == PTET_OK);
  std::vector<double> values(mesh.vertex_count());
  for (std::size_t v = 0; v < values.size(); ++v)
    values[v] = static_cast<double>(v);
  REQUIRE(ptet_builder_add_field(builder.get(), "f", PTET_FLOAT64, 1, values.data(), nullptr) == PTET_OK);
  ptet_bytes* bytes = nullptr;
  CHECK(answer([&](ptet_error** error) {
          return ptet_builder_build_memory(builder.get(), progress, &user, &bytes, nullptr, error);
        }) == std::pair<ptet_status, std::string>(PTET_INTERNAL_ERROR, "thrown while looking on"));
  CHECK(bytes == nullptr);
}

TEST_CASE("C interface: sizes that no memory holds are refused") {
  const Owned<ptet_builder> builder(ptet_builder_new());
  const std::uint32_t corner = 0;
  CHECK(answer([&](ptet_error** error) {
          return ptet_builder_set_tets(builder.get(), ~std::uint64_t{0} / 16, &corner, error);
        }).first == PTET_LIMIT);
  ptet_dataset* dataset = nullptr;
  CHECK(answer([&](ptet_error** error) {
          return ptet_dataset_open_memory(&corner, ~std::uint64_t{0} / 2 + 5, nullptr, &dataset, error);
        }).first == PTET_OUT_OF_MEMORY);
  CHECK(dataset == nullptr);
}
