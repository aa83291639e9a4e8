#include "formats/ptet/writer.hpp"
#include "lod/request.hpp"
#include "ptet/build.hpp"
#include "ptet/dataset.hpp"
#include "ptet/session.hpp"
#include "support/mesh_checks.hpp"
#include "support/meshes.hpp"
#include "support/naive_simplifier.hpp"

#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <new>
#include <stdexcept>
#include <thread>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>

using namespace ptet;

namespace {

const TetMesh& mesh() {
  static const TetMesh made = test::grid({{4, 4, 3}, {}, 2, 2});
  return made;
}

std::shared_ptr<const Dataset> dataset() {
  static const auto opened = Dataset::open_memory(file::encode(
      mesh(), test::simplify_naively(mesh()), {"1.2.3", "in.vtu", "xxh64:0", {{"a", "b"}}, {"note \xFF"}}));
  return opened;
}

std::string refusal(const std::function<void(Request&)>& spoil) {
  Request request;
  spoil(request);
  try {
    (void)dataset()->extract(request);
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::kBadArgument);
    return error.what();
  }
  return "";
}

} // namespace

TEST_CASE("dataset: a forked process has no thread that reads, says so and does not wait for it") {
  BuildOptions ordered;
  ordered.keep_order = true;
  const auto bytes = build_memory(mesh(), ordered);
  Request in_order;
  in_order.input_order = true;
  OpenOptions options;
  options.background = true;
  for (int delay = 0; delay < 20; ++delay) {
    auto opened = Dataset::open_memory(bytes, options);
    auto session = std::make_unique<Session>(opened);
    (void)session->update({});
    // In the midst of reading, holding whatever it holds; the last time when all is done.
    if (delay == 19)
      opened->wait_until_loaded();
    else
      std::this_thread::sleep_for(std::chrono::microseconds(100 * delay));
    const pid_t child = ::fork();
    REQUIRE(child >= 0);
    if (child == 0) {
      ::alarm(10);
      const auto is_refused = [](const auto& call) {
        try {
          call();
          return false;
        } catch (const Error& error) {
          return error.code() == ErrorCode::kIo;
        }
      };
      const bool refuses =
          is_refused([&] { (void)opened->extract({}); }) && is_refused([&] { (void)opened->extract(in_order); }) &&
          is_refused([&] { (void)session->update({}); }) && is_refused([&] { opened->wait_until_loaded(); });
      // A new thread may have the number of the one that is not here.
      std::thread([&] {
        session.reset();
        opened.reset();
      }).join();
      ::_exit(refuses ? 0 : 1);
    }
    int status = 0;
    REQUIRE(::waitpid(child, &status, 0) == child);
    CHECK(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == 0);
  }
}

TEST_CASE("dataset: what it says of itself") {
  const DatasetInfo& info = dataset()->info();
  CHECK(info.vertices == mesh().vertex_count());
  CHECK(info.tets == mesh().tets.size());
  CHECK(info.base_vertices + info.records == info.vertices);
  CHECK(info.position_type == ScalarType::kFloat32);
  REQUIRE(info.fields.size() == 3);
  CHECK(info.fields[0].name == "pressure");
  CHECK(info.fields[0].governing);
  CHECK(info.fields[1].components == 3);
  CHECK(info.fields[1].type == ScalarType::kFloat64);
  CHECK_FALSE(info.fields[2].governing);
  REQUIRE(info.max_field_error.size() == 2);
  CHECK(info.max_field_error[0] > 0);
  CHECK(info.max_domain_error > 0);
  const auto json = nlohmann::json::parse(info.provenance_json);
  CHECK(json["tool_version"] == "1.2.3");
  CHECK(json["source_name"] == "in.vtu");
  CHECK(json["options"]["a"] == "b");
  CHECK(json["notes"].size() == 1); // whose text is not UTF-8
}

TEST_CASE("dataset: RMS errors are given where they were measured, and only there") {
  CHECK(dataset()->info().base_rms_error.empty());
  CHECK(dataset()->extract({}).rms_error.empty());
  CHECK_FALSE(dataset()->info().base_covered);
  CHECK_FALSE(dataset()->extract({}).covered);

  RecordStream records = test::simplify_naively(mesh());
  records.volume = 50;
  records.squared_error.assign(records.field_error.size(), 0);
  records.uncovered_volume.assign(records.size(), 0);
  const auto base_of = [&] { return Dataset::open_memory(file::encode(mesh(), records, {}))->info(); };
  CHECK(base_of().base_rms_error == std::vector<double>{0, 0});
  CHECK(base_of().base_covered == 1.0);

  // One collapse raises the integral of the first field by 8, another lowers it by 6.
  records.squared_error[0] = 8;
  records.squared_error[2] = -6;
  const auto opened = Dataset::open_memory(file::encode(mesh(), records, {}));
  REQUIRE(opened->info().base_rms_error.size() == 2);
  CHECK(opened->info().base_rms_error[0] == Approx(0.2).epsilon(1e-12));
  CHECK(opened->info().base_rms_error[1] == 0);
  CHECK(opened->extract({}).rms_error == std::vector<double>{0, 0});
  CHECK(opened->extract({}).covered == 1.0);

  // And of the volume, 50, one uncovers 26, another covers 1 again.
  records.uncovered_volume[0] = 26;
  records.uncovered_volume[3] = -1;
  CHECK(*base_of().base_covered == Approx(0.5).epsilon(1e-12));
  CHECK(base_of().base_rms_error[0] == Approx(std::sqrt(2.0 / 25)).epsilon(1e-12));
  // No mean is above the largest error, whatever little is covered, or nothing.
  const double largest = base_of().max_field_error[0];
  for (const double uncovered : {51 - 1e-9, 52.0}) {
    records.uncovered_volume[0] = uncovered;
    CHECK(base_of().base_rms_error[0] == largest);
    CHECK(*base_of().base_covered == Approx(0).margin(1e-10));
  }
}

TEST_CASE("dataset: requests that make no sense are refused, by name") {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  CHECK(refusal([](Request& r) {
          r.field_error = {{"density", {}}};
        }).find("there is no field 'density' in this file; those with errors are '") == 0);
  CHECK(refusal([](Request& r) { r.field_error = {{"marker", {}}}; }).find("did not govern") != std::string::npos);
  CHECK(refusal([](Request& r) {
          r.field_error = {{"pressure", {-1, false}}};
        }).find("'pressure'") != std::string::npos);
  CHECK(refusal([&](Request& r) { r.field_error = {{"", {nan, true}}}; }) != "");
  CHECK(refusal([&](Request& r) { r.domain_error = Bound{inf, false}; }) != "");
  CHECK(refusal([](Request& r) { r.focus = {{Box{{0, 0, 1}, {1, 1, 0}}}}; }).find("its least z") != std::string::npos);
  CHECK(refusal([&](Request& r) { r.focus = {{Box{{0, nan, 0}, {1, 1, 1}}}}; }) != "");
  CHECK(refusal([](Request& r) {
          r.focus = {{Sphere{{0, 0, 0}, -1.5e-9}}};
        }).find("radius of a focus sphere is -1.5e-09") != std::string::npos);
  CHECK(refusal([&](Request& r) { r.focus = {{Sphere{{inf, 0, 0}, 1}}}; }) != "");
  CHECK(refusal([](Request& r) { r.focus = {{Sphere{{0, 0, 0}, 1}, {-0.1, true}}}; }) != "");
  CHECK(refusal([](Request&) {}) == "");

  const auto of_focus = [&](const Region& region, Bound error = {0, true}, std::optional<Bound> falloff = {}) {
    return refusal([&](Request& r) { r.focus = {{region, error, falloff}}; });
  };
  const Sphere ball{{0, 0, 0}, 1};
  CHECK(of_focus(ball, {0, true}, Bound{-1, true}).find("falloff") != std::string::npos);
  CHECK(of_focus(ball, {0, true}, Bound{inf, true}).find("falloff") != std::string::npos);
  CHECK(of_focus(ball, {0.1, false}, Bound{0.5, false}) == "");
  CHECK(of_focus(HalfSpace{{0, 0, 0}, 1}).find("normal") != std::string::npos);
  CHECK(of_focus(HalfSpace{{0, nan, 0}, 1}).find("normal") != std::string::npos);
  CHECK(of_focus(HalfSpace{{0, 1, 0}, inf}).find("offset") != std::string::npos);
  CHECK(of_focus(HalfSpace{{0, 1e200, 0}, 1}) == "");
  CHECK(of_focus(OrientedBox{{0, 0, 0}, {{{1, 0, 0}, {0.1, 1, 0}, {0, 0, 1}}}}).find("perpendicular") !=
        std::string::npos);
  CHECK(of_focus(OrientedBox{{0, 0, inf}, {}}).find("centre") != std::string::npos);
  CHECK(of_focus(OrientedBox{{0, 0, 0}, {{{1, 0, 0}, {0, nan, 0}, {0, 0, 1}}}}).find("half axis") != std::string::npos);
  CHECK(of_focus(OrientedBox{{0, 0, 0}, {{{1, 0, 0}, {0, 0, 0}, {0, 0, 1}}}}) == ""); // flat

  const auto of_values = [&](const ValuesOfInterest& values) {
    return refusal([&](Request& r) { r.values = {values}; });
  };
  CHECK(of_values({"density", 0, 1}).find("there is no field 'density' in this file") == 0);
  CHECK(of_values({"marker", 0, 1}).find("did not govern") != std::string::npos);
  CHECK(of_values({"pressure", 1, 0}).find("empty") != std::string::npos);
  CHECK(of_values({"pressure", inf, inf}).find("empty") != std::string::npos);
  CHECK(of_values({"pressure", nan, 0}).find("not a number") != std::string::npos);
  CHECK(of_values({"pressure", -inf, inf}) == "");

  const auto of_view = [&](const std::function<void(View&)>& spoil) {
    return refusal([&](Request& r) {
      r.view = View{};
      spoil(*r.view);
    });
  };
  CHECK(of_view([](View&) {}) == "");
  CHECK(of_view([&](View& v) { v.eye[1] = nan; }).find("eye") != std::string::npos);
  CHECK(of_view([](View& v) { v.direction = {}; }).find("direction") != std::string::npos);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const double none : {static_cast<double>(NAN), static_cast<double>(INFINITY)}) {
      CHECK(of_view([&](View& v) { v.direction[axis] = none; }).find("viewing direction") != std::string::npos);
      CHECK(of_view([&](View& v) { v.up[axis] = none; }).find("up direction") != std::string::npos);
    }
  }
  CHECK(of_view([](View& v) { v.up = {}; }).find("up") != std::string::npos);
  CHECK(of_view([](View& v) { v.up = {0, 0, 5}; }).find("parallel") != std::string::npos);
  CHECK(of_view([](View& v) { v.vertical_angle = 0; }).find("angle") != std::string::npos);
  CHECK(of_view([](View& v) { v.vertical_angle = 3.2; }).find("angle") != std::string::npos);
  CHECK(of_view([](View& v) { v.height = 0; }).find("no pixels") != std::string::npos);
  CHECK(of_view([](View& v) { v.max_pixels = -1; }).find("pixels") != std::string::npos);
  CHECK(of_view([](View& v) { v.outside = 0.5; }).find("factor") != std::string::npos);
  CHECK(of_view([&](View& v) { v.outside = nan; }).find("factor") != std::string::npos);

  CHECK(refusal([](Request& r) { r.max_milliseconds = -1; }).find("milliseconds") != std::string::npos);
  CHECK(refusal([&](Request& r) { r.max_milliseconds = nan; }).find("milliseconds") != std::string::npos);
}

TEST_CASE("dataset: values of records and fields that there are not are refused") {
  const auto data = dataset();
  const std::vector<RecordId> made_by(3);
  std::vector<double> values(3, -1);
  data->origin_values(made_by, OriginValue::kFieldError, 0, values);
  CHECK(values == std::vector<double>(3, 0.0));
  for (const std::size_t field : {std::size_t{2}, std::size_t{3}, std::numeric_limits<std::size_t>::max()})
    CHECK_THROWS_AS(data->origin_values(made_by, OriginValue::kFieldError, field, values), Error);
  const std::vector<RecordId> unknown(3, RecordId{1'000'000});
  CHECK_THROWS_AS(data->origin_values(unknown, OriginValue::kLevel, 0, values), Error);
  values.pop_back();
  CHECK_THROWS_AS(data->origin_values(made_by, OriginValue::kLevel, 0, values), Error);
}

TEST_CASE("dataset: what limits an answer") {
  const auto answer = [](const Request& request) { return dataset()->extract(request).limited_by; };
  Request request;
  CHECK(answer(request) == LimitedBy::kNothing);
  request.field_error = {{"", {0.2, true}}};
  CHECK(answer(request) == LimitedBy::kError);
  request.max_tets = 10;
  CHECK(answer(request) == LimitedBy::kBudget);
  request.max_tets = 1000000;
  CHECK(answer(request) == LimitedBy::kError);
  request.field_error.clear();
  CHECK(answer(request) == LimitedBy::kNothing);
  request = {};
  request.focus = {{Box{{0, 0, 0}, {1, 1, 1}}}};
  CHECK(answer(request) == LimitedBy::kFocus);
  request.max_tets = 10; // the focus takes more
  CHECK(answer(request) == LimitedBy::kBudget);
  request.field_error = {{"", {1, true}}}; // and has no more error than that
  CHECK(answer(request) == LimitedBy::kBudget);
  Session session(dataset());
  CHECK(session.extraction().limited_by == LimitedBy::kError); // the base mesh, as long as nothing is asked
  CHECK(session.update(request).limited_by == LimitedBy::kBudget);
  request.max_tets = 1000000;
  CHECK(answer(request) == LimitedBy::kError);
  CHECK(session.update(request).limited_by == LimitedBy::kError);
  request = {};
  request.focus = {{Box{{-1e9, -1e9, -1e9}, {1e9, 1e9, 1e9}}}};
  CHECK(answer(request) == LimitedBy::kNothing);
  CHECK(session.update(request).limited_by == LimitedBy::kNothing);
  request.max_tets = 10; // the original it is all the same, and more than was allowed
  CHECK(answer(request) == LimitedBy::kBudget);
  CHECK(session.update(request).limited_by == LimitedBy::kBudget);
  request = {};
  request.max_milliseconds = 0;
  CHECK(answer(request) == LimitedBy::kTime);
  request = {};
  request.max_bytes = 5000;
  CHECK(answer(request) == LimitedBy::kBudget);
  request = {};
  request.values = {{"pressure", 1000, 1000}}; // nowhere
  CHECK(answer(request) == LimitedBy::kError);
  CHECK(std::string(name_of(LimitedBy::kBudget)) == "budget");
  CHECK(std::string(name_of(LimitedBy::kTime)) == "time");
}

TEST_CASE("dataset: a focus away from the mesh, and budgets below the base, give the base mesh") {
  Request away;
  away.focus = {{Sphere{{1e6, 0, 0}, 1}}};
  const Extraction base = dataset()->extract(away);
  CHECK(base.mesh.tets.size() == dataset()->info().base_tets);
  CHECK(base.field_error == dataset()->info().max_field_error);
  Request nothing;
  nothing.max_tets = 0;
  CHECK(dataset()->extract(nothing).mesh.tets == base.mesh.tets);
  CHECK(dataset()->extract(nothing).limited_by == LimitedBy::kBudget);
}

TEST_CASE("dataset: wishes that meet nothing are known by their places") {
  Request request;
  request.focus = {{Sphere{{1e6, 0, 0}, 1}}, {Sphere{{0, 0, 0}, 1}}, {Box{{-3, -3, -3}, {-1, -1, -1}}}};
  request.values = {{"pressure", 1e6, 2e6}, {"pressure", -1e6, 1e6}, {"flow", -2, -1}, {"flow", -1, 1e6}};
  const UnmetWishes unmet = unmet_wishes(request, dataset()->extract(request));
  CHECK(unmet.focus == std::vector<std::size_t>{0, 2});
  CHECK(unmet.values == std::vector<std::size_t>{0, 2});
  const Extraction whole = dataset()->extract({});
  CHECK(unmet_wishes({}, whole).focus.empty());
  CHECK(unmet_wishes({}, whole).values.empty());
  CHECK_FALSE(unmet.view);
  const Point eye{0, 0, 1e4}, at_it{0, 0, -1}, away{0, 0, 1};
  request.view = View{eye, at_it};
  CHECK_FALSE(unmet_wishes(request, whole).view);
  request.view = View{eye, away};
  CHECK(unmet_wishes(request, whole).view);
}

TEST_CASE("dataset: what a mesh that was cut short has not, the original may have") {
  // A peak at a vertex that the base does not have.
  const PointArray& pressure = *mesh().find("pressure");
  double greatest = -INFINITY;
  for (std::uint32_t v = 0; v < mesh().vertex_count(); ++v)
    greatest = std::max(greatest, pressure.value(v, 0));
  Request request;
  request.values = {{"pressure", greatest, greatest}, {"pressure", 1e6, 2e6}};
  request.focus = {{Sphere{{1e6, 0, 0}, 1}}};
  request.view = View{{0, 0, 1e4}, {0, 0, 1}};
  request.max_tets = 0;
  Extraction cut = dataset()->extract(request);
  REQUIRE(cut.limited_by == LimitedBy::kBudget);
  UnmetWishes unmet = unmet_wishes(request, cut);
  CHECK(unmet.values.empty());
  CHECK(unmet.focus.size() == 1);
  CHECK(unmet.view);
  // As far from the mesh as its domain error there may be something.
  Point beside{INFINITY, 0, 0};
  for (std::uint32_t v = 0; v < cut.mesh.vertex_count(); ++v)
    beside = std::min(beside, cut.mesh.position(VertexId(v)));
  beside[0] -= 1 + 0.5;
  request.focus = {{Sphere{beside, 1}}};
  cut.domain_error = 1;
  CHECK(unmet_wishes(request, cut).focus.empty());
  cut.limited_by = LimitedBy::kError;
  CHECK(unmet_wishes(request, cut).focus.size() == 1);
  CHECK(unmet_wishes(request, cut).values.size() >= 1);
  cut.complete = false;
  unmet = unmet_wishes(request, cut);
  CHECK(unmet.focus.empty());
  CHECK(unmet.values.empty());
}

TEST_CASE("dataset: vectors too long for a number are among the values of interest") {
  TetMesh vast = mesh();
  PointArray big{"big", ScalarType::kFloat64, 3, {}};
  for (std::size_t v = 0; v < vast.vertex_count(); ++v)
    for (int c = 0; c < 3; ++c) {
      const double x = 1.5e308 + 1e305 * static_cast<double>(v % 7);
      const auto* const bytes = reinterpret_cast<const std::byte*>(&x);
      big.bytes.insert(big.bytes.end(), bytes, bytes + sizeof x);
    }
  vast.point_arrays = {big};
  BuildOptions options;
  options.target_vertices = 0.3;
  options.threads = 1;
  const auto opened = Dataset::open_memory(build_memory(vast, options));
  Request request;
  request.values = {{"big", 1e308, INFINITY}};
  CHECK(opened->extract(request).mesh.tets.size() == vast.tets.size());
}

TEST_CASE("dataset: a half-space is the same however long its normal is") {
  const auto tets_of = [](double length) {
    Request request;
    request.max_tets = 0;
    request.focus = {{HalfSpace{{length, length, 0}, 3 * length}}};
    return dataset()->extract(request).mesh.tets;
  };
  const auto tets = tets_of(1);
  CHECK(tets.size() > dataset()->info().base_tets);
  CHECK(tets.size() < dataset()->info().tets);
  for (const double length : {0x1p-1060, 1e-300, 0x1p-3, 0x1p9, 1.5e307})
    CHECK(tets_of(length) == tets);
}

TEST_CASE("dataset: a focus box may reach as far as numbers go") {
  const DatasetInfo& info = dataset()->info();
  const double far = std::numeric_limits<double>::max();
  for (const double side : {info.diagonal, 1e30, far}) {
    Request request;
    const double middle = (info.box_min[0] + info.box_max[0]) / 2;
    request.focus = {{Box{{-side, -side, -side}, {middle, side, side}}}};
    const Extraction cut = dataset()->extract(request);
    request.focus = {{HalfSpace{{1, 0, 0}, middle}}};
    CHECK(cut.mesh.tets == dataset()->extract(request).mesh.tets);
    CHECK(cut.mesh.tets.size() < info.tets);
    CHECK(cut.in_focus[0].field_error[0] == 0);
    CHECK(cut.in_focus[0].domain_error == 0);
    CHECK(cut.limited_by == LimitedBy::kFocus);
  }
}

TEST_CASE("dataset: a single tet, and a vertex that no tet uses") {
  TetMesh one = test::single_tet();
  const auto opened = Dataset::open_memory(file::encode(one, test::simplify_naively(one), {}));
  const Extraction full = opened->extract({});
  CHECK(full.mesh.tets.size() == 1);
  CHECK(full.limited_by == LimitedBy::kNothing);
  CHECK(full.boundary_faces.size() == 4);

  TetMesh with_unused = mesh();
  const std::size_t count = with_unused.vertex_count() + 1;
  with_unused.positions.resize(count);
  for (PointArray& array : with_unused.point_arrays)
    array.resize(count);
  const auto larger = Dataset::open_memory(file::encode(with_unused, test::simplify_naively(with_unused), {}));
  CHECK(larger->extract({}).mesh.vertex_count() == count);
  Request coarse;
  coarse.max_vertices = count - 1;
  const Extraction cut = larger->extract(coarse);
  CHECK(cut.mesh.vertex_count() == count - 2); // all but the last split, and not the unused one
  coarse.max_vertices = count;
  CHECK(larger->extract(coarse).mesh.vertex_count() == count);
}

TEST_CASE("request: the limit is the largest code within the bound") {
  for (const double scale : {1.0, 0.3, 1e7})
    for (double bound = scale * 1e-6; bound < scale * 10; bound *= 1.013) {
      const ErrorCode16 code = limit_of(bound, scale);
      CHECK(decode_error(code, scale) <= bound);
      CHECK(decode_error(static_cast<ErrorCode16>(code + 1), scale) > bound);
    }
  CHECK(limit_of(0, 1) == 0);
  CHECK(limit_of(decode_error(700, 0.3), 0.3) == 700);
  CHECK(limit_of(1, 0) == kMaxErrorCode);
  CHECK(limit_of(0, 0) == kMaxErrorCode); // all codes stand for 0
  CHECK(limit_of(-0.0, -0.0) == kMaxErrorCode);
  // Where the scale is so small that codes share a value, all of them are within it.
  const ErrorCode16 least = limit_of(0, 0x1p-1070);
  CHECK(decode_error(least, 0x1p-1070) == 0);
  CHECK(decode_error(static_cast<ErrorCode16>(least + 1), 0x1p-1070) > 0);
}

TEST_CASE("dataset: a source that is none, or that does not know its size, is refused with the library's own error") {
  class Sizeless final : public ByteSource {
  public:
    explicit Sizeless(std::function<void()> fail) : fail_(std::move(fail)) {}
    std::uint64_t size() override {
      fail_();
      return 0;
    }
    void read(std::uint64_t, std::span<std::byte>) override {}

  private:
    std::function<void()> fail_;
  };
  const auto code_of = [](std::shared_ptr<ByteSource> source) {
    try {
      (void)Dataset::open(std::move(source));
    } catch (const Error& error) {
      return std::pair(error.code(), std::string(error.what()));
    }
    return std::pair(ErrorCode::kCancelled, std::string("none"));
  };
  CHECK(code_of(nullptr).first == ErrorCode::kBadArgument);
  const auto gone = code_of(std::make_shared<Sizeless>([] { throw std::runtime_error("the server is gone"); }));
  CHECK(gone.first == ErrorCode::kIo);
  CHECK(gone.second.find("the server is gone") != std::string::npos);
  CHECK(code_of(std::make_shared<Sizeless>([] { throw Error(ErrorCode::kLimit, "too large"); })).first ==
        ErrorCode::kIo);
  CHECK_THROWS_AS(Dataset::open(std::make_shared<Sizeless>([] { throw std::bad_alloc(); })), std::bad_alloc);
}
