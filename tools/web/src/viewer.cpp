// What the page's worker calls: one opened file, the session that follows its requests, and triangles to draw.
//
//   worker.js --open, update, draw, mesh--> Viewer --ByteSource--> reader.read(offset, bytes): there already, or not
//   yet
//
// Nothing waits: bytes that are not there yet make a block one that cannot be had for the time being, the answer is
// coarser there and says so, and the worker asks again when they have come.
#include "ptet/dataset.hpp"
#include "ptet/session.hpp"
#include "surfaces.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <new>
#include <utility>

#include <emscripten/bind.h>

namespace ptet::web {
namespace {

using emscripten::val;

/// Of the 2 GiB that the page's memory may grow to.
constexpr std::uint64_t kMaxBytes = 1'400'000'000;

class PageSource final : public ByteSource {
public:
  PageSource(val reader, std::uint64_t size) : reader_(std::move(reader)), size_(size) {}
  std::uint64_t size() override { return size_; }
  void read(std::uint64_t offset, std::span<std::byte> into) override {
    const val view(emscripten::typed_memory_view(into.size(), reinterpret_cast<std::uint8_t*>(into.data())));
    if (!reader_.call<bool>("read", static_cast<double>(offset), view))
      throw Error(ErrorCode::kIo, "not fetched yet", offset);
  }

private:
  val reader_;
  std::uint64_t size_;
};

/// A copy that the worker may hand on.
template <class T>
val copied(std::span<const T> values) {
  return val(emscripten::typed_memory_view(values.size(), values.data())).call<val>("slice");
}

template <class Range>
val list(const Range& values) {
  val result = val::array();
  for (const auto& value : values)
    result.call<void>("push", value);
  return result;
}

Point point_of(const val& numbers) {
  return {numbers[0].as<double>(), numbers[1].as<double>(), numbers[2].as<double>()};
}

std::optional<Plane> plane_of(const val& plane) {
  if (plane.isNull() || plane.isUndefined()) return std::nullopt;
  return Plane{point_of(plane["normal"]), plane["offset"].as<double>()};
}

val triangles_of(const Triangles& triangles) {
  val result = val::object();
  result.set("positions", copied<float>(triangles.positions));
  result.set("colours", copied<float>(triangles.colours));
  result.set("barycentric", copied<std::uint8_t>(triangles.barycentric));
  return result;
}

/// { name, type, components, bytes }
val array_of(const PointArray& array) {
  val result = val::object();
  result.set("name", array.name);
  result.set("type", std::string(name_of(array.type)));
  result.set("components", array.components);
  result.set("bytes",
             copied<std::uint8_t>({reinterpret_cast<const std::uint8_t*>(array.bytes.data()), array.bytes.size()}));
  return result;
}

/// What `f` returns, or what it throws as { error: kind, message }.
template <class F>
val guarded(F&& f) {
  const auto failure = [](const char* kind, const std::string& message) {
    val result = val::object();
    result.set("error", std::string(kind));
    result.set("message", message);
    return result;
  };
  try {
    return f();
  } catch (const Error& error) {
    switch (error.code()) {
    case ErrorCode::kIo: return failure("io", error.what());
    case ErrorCode::kCorruptFile: return failure("corrupt", error.what());
    case ErrorCode::kLimit: return failure("limit", error.what());
    default: return failure("request", error.what());
    }
  } catch (const std::bad_alloc&) {
    return failure("memory", "there is not enough memory in the page for this");
  } catch (const std::exception& error) {
    return failure("internal", error.what());
  }
}

} // namespace

class Viewer {
public:
  /// `reader`: an object with read(offset, bytes), which fills the bytes or returns false. Returns what is known of the
  /// file, or { error: "io" } until all that opening reads is there; then it is to be called again.
  val open(const val& reader, double size) {
    return guarded([&] {
      OpenOptions options;
      options.limits.max_bytes = kMaxBytes;
      session_.reset();
      dataset_ = Dataset::open(std::make_shared<PageSource>(reader, static_cast<std::uint64_t>(size)), options);
      session_ = std::make_unique<Session>(dataset_);
      return describe_file();
    });
  }

  /// `asked`: { fieldError, domainError: fractions, or null; focus: { min, max } or null }. With all null: the
  /// original. Returns sizes and errors of the mesh as it is then.
  val update(const val& asked) {
    return guarded([&] {
      Request request;
      if (!asked["fieldError"].isNull()) request.field_error.push_back({"", {asked["fieldError"].as<double>(), true}});
      if (!asked["domainError"].isNull()) request.domain_error = Bound{asked["domainError"].as<double>(), true};
      if (const val focus = asked["focus"]; !focus.isNull())
        request.focus.push_back({Box{point_of(focus["min"]), point_of(focus["max"])}});
      return describe(session_->update(request));
    });
  }

  /// `what`: { field: or null, for no colours; surface: whether; cut, slice: { normal, offset } or null; isosurface:
  /// { field, level } or null }. Returns the triangles of each, relative to the middle of the file's box, and the range
  /// of the fields.
  val draw(const val& what) {
    return guarded([&] {
      points_ = points();
      const val field = what["field"];
      const std::vector<double> colours =
          field.isNull() ? std::vector<double>(points_.size(), std::numeric_limits<double>::quiet_NaN())
                         : scalars(field.as<unsigned>());
      const Scene scene{session_->tets(), session_->boundary_faces(), points_, colours};
      const Point middle = centre();
      val result = val::object();
      result.set("range", range_of(colours));
      if (what["surface"].as<bool>())
        result.set("surface", triangles_of(surface(scene, plane_of(what["cut"]), middle)));
      if (const auto plane = plane_of(what["slice"]))
        result.set("slice", triangles_of(contour(scene, heights(points_, *plane), 0, middle)));
      if (const val iso = what["isosurface"]; !iso.isNull()) {
        const std::vector<double> values = scalars(iso["field"].as<unsigned>());
        result.set("isosurface", triangles_of(contour(scene, values, iso["level"].as<double>(), middle)));
      }
      return result;
    });
  }

  /// The mesh as it is now, in the order of Dataset::extract: { positions, arrays, tets }.
  val mesh() const {
    return guarded([&] {
      const Extraction extraction = session_->extraction();
      val result = val::object();
      result.set("positions", array_of(extraction.mesh.positions));
      val arrays = val::array();
      for (const PointArray& array : extraction.mesh.point_arrays)
        arrays.call<void>("push", array_of(array));
      result.set("arrays", arrays);
      const auto& tets = extraction.mesh.tets;
      result.set("tets", copied<std::uint32_t>({reinterpret_cast<const std::uint32_t*>(tets.data()), tets.size() * 4}));
      return result;
    });
  }

private:
  [[nodiscard]] Point centre() const {
    const DatasetInfo& info = dataset_->info();
    Point middle{};
    for (unsigned axis = 0; axis < 3; ++axis)
      middle[axis] = 0.5 * (info.box_min[axis] + info.box_max[axis]);
    return middle;
  }

  [[nodiscard]] val describe_file() const {
    const DatasetInfo& info = dataset_->info();
    val result = val::object();
    result.set("tets", static_cast<double>(info.tets));
    result.set("vertices", static_cast<double>(info.vertices));
    result.set("baseTets", static_cast<double>(info.base_tets));
    result.set("boxMin", list(info.box_min));
    result.set("boxMax", list(info.box_max));
    result.set("diagonal", info.diagonal);
    val fields = val::array();
    for (const FieldInfo& info_of_field : info.fields) {
      val field = val::object();
      field.set("name", info_of_field.name);
      field.set("components", info_of_field.components);
      field.set("governing", info_of_field.governing);
      field.set("range", info_of_field.range);
      fields.call<void>("push", field);
    }
    result.set("fields", fields);
    return result;
  }

  [[nodiscard]] static val describe(const SessionUpdate& update) {
    val result = val::object();
    result.set("tets", static_cast<double>(update.tets));
    result.set("vertices", static_cast<double>(update.vertices));
    result.set("fieldError", list(update.field_error));
    result.set("rmsError", list(update.rms_error));
    result.set("domainError", update.domain_error);
    result.set("limitedBy", std::string(name_of(update.limited_by)));
    result.set("complete", update.complete);
    result.set("milliseconds", 1e3 * update.seconds);
    val damaged = val::array();
    for (const BlockFailure& failure : update.failures)
      if (failure.code != ErrorCode::kIo) damaged.call<void>("push", failure.message);
    result.set("damaged", damaged);
    return result;
  }

  [[nodiscard]] std::vector<Point> points() const {
    const PointArray& positions = session_->positions();
    std::vector<Point> result(positions.size());
    for (std::size_t v = 0; v < result.size(); ++v)
      for (std::uint32_t axis = 0; axis < 3; ++axis)
        result[v][axis] = positions.value(v, axis);
    return result;
  }

  /// By vertex slot: the field, of several components its length.
  [[nodiscard]] std::vector<double> scalars(unsigned field) const {
    if (field >= session_->point_arrays().size()) throw Error(ErrorCode::kBadArgument, "there is no such field");
    const PointArray& array = session_->point_arrays()[field];
    std::vector<double> result(array.size());
    for (std::size_t v = 0; v < result.size(); ++v) {
      if (array.components == 1) {
        result[v] = array.value(v, 0);
        continue;
      }
      double sum = 0;
      for (std::uint32_t c = 0; c < array.components; ++c)
        sum += array.value(v, c) * array.value(v, c);
      result[v] = std::sqrt(sum);
    }
    return result;
  }

  /// Over the vertices in use.
  [[nodiscard]] val range_of(std::span<const double> values) const {
    double least = std::numeric_limits<double>::infinity(), greatest = -least;
    const auto vertices = session_->vertex_in_file();
    for (std::size_t v = 0; v < vertices.size(); ++v) {
      if (vertices[v].is_none() || !std::isfinite(values[v])) continue;
      least = std::min(least, values[v]);
      greatest = std::max(greatest, values[v]);
    }
    return list(std::array{least, greatest});
  }

  std::shared_ptr<const Dataset> dataset_;
  std::unique_ptr<Session> session_;
  std::vector<Point> points_; ///< by vertex slot, of the picture at hand
};

EMSCRIPTEN_BINDINGS(ptet_viewer) {
  emscripten::class_<Viewer>("Viewer")
      .constructor<>()
      .function("open", &Viewer::open)
      .function("update", &Viewer::update)
      .function("draw", &Viewer::draw)
      .function("mesh", &Viewer::mesh);
}

} // namespace ptet::web
