// Everything a request can ask for of each record by itself, against the plain way: look at every record of the file,
// take those that are wanted, and with them whatever they depend on. And what the answers promise, looked at point by
// point in the meshes alone.
#include "formats/ptet/reader.hpp"
#include "formats/ptet/writer.hpp"
#include "lod/camera.hpp"
#include "lod/region.hpp"
#include "ptet/dataset.hpp"
#include "support/mesh_checks.hpp"
#include "support/meshes.hpp"
#include "support/naive_simplifier.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <set>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

double product(const Point& a, const Point& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Point along(const Point& from, const Point& to) {
  return {to[0] - from[0], to[1] - from[1], to[2] - from[2]};
}

/// The distance of a point from a region, by the formula for each shape.
double distance_of(const Region& region, const Point& p) {
  if (const Box* const box = std::get_if<Box>(&region)) {
    Point d{};
    for (std::size_t i = 0; i < 3; ++i)
      d[i] = std::max({box->min[i] - p[i], p[i] - box->max[i], 0.0});
    return std::sqrt(product(d, d));
  }
  if (const Sphere* const sphere = std::get_if<Sphere>(&region)) {
    const Point d = along(sphere->centre, p);
    return std::max(0.0, std::sqrt(product(d, d)) - sphere->radius);
  }
  if (const HalfSpace* const half = std::get_if<HalfSpace>(&region))
    return std::max(0.0, product(half->normal, p) - half->offset) / std::sqrt(product(half->normal, half->normal));
  const OrientedBox& box = std::get<OrientedBox>(region);
  double squared = 0;
  for (const Point& half : box.half_axes) {
    const double length = std::sqrt(product(half, half));
    const double beyond = std::max(0.0, std::fabs(product(along(box.centre, p), half)) / length - length);
    squared += beyond * beyond;
  }
  return std::sqrt(squared);
}

/// Points all over the hull of some corners.
std::vector<Point> points_in(const std::vector<Point>& corners) {
  constexpr int kSteps = 4;
  std::vector<Point> points;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j <= kSteps - i; ++j)
      for (int k = 0; k <= kSteps - i - j; ++k) {
        std::array<int, 4> weight = {i, j, k, kSteps - i - j - k};
        if (corners.size() == 3 && weight[3] != 0) continue;
        Point p{};
        for (std::size_t c = 0; c < corners.size(); ++c)
          for (std::size_t axis = 0; axis < 3; ++axis)
            p[axis] += weight[c] / double(kSteps) * corners[c][axis];
        points.push_back(p);
      }
  return points;
}

/// A file, and all that is in it laid open.
struct Opened {
  std::vector<std::byte> bytes;
  file::Header header;
  file::Content content;

  explicit Opened(std::vector<std::byte> file) : bytes(std::move(file)), content(load()) {}
  [[nodiscard]] std::shared_ptr<const Dataset> open() const { return Dataset::open_memory(bytes); }
  [[nodiscard]] double error(RecordId r, std::size_t code) const { return decoded(content.own, r, code); }
  /// With the differences at original vertices outside of the mesh.
  [[nodiscard]] double monotone_error(RecordId r, std::size_t code) const { return decoded(content.monotone, r, code); }
  /// C(r), then F(r): the corners that are vertices.
  [[nodiscard]] std::vector<std::vector<VertexId>> star(RecordId r, bool with_fine) const {
    const Refinement& refinement = content.refinement;
    std::vector<std::vector<VertexId>> coarse, fine;
    for (const Tet& tet : refinement.fine_tets(r)) {
      std::vector<VertexId> corners;
      bool is_deleted = false;
      for (const VertexId v : tet) {
        if (v != kDummyVertex) corners.push_back(v);
        is_deleted |= v == refinement.target(r);
      }
      fine.push_back(corners);
      if (is_deleted) continue;
      std::replace(corners.begin(), corners.end(), refinement.vertex_of(r), refinement.target(r));
      coarse.push_back(corners);
    }
    if (with_fine) coarse.insert(coarse.end(), fine.begin(), fine.end());
    return coarse;
  }
  [[nodiscard]] Point position(VertexId v) const {
    return {content.positions.value(v.index(), 0), content.positions.value(v.index(), 1),
            content.positions.value(v.index(), 2)};
  }
  [[nodiscard]] std::vector<Point> positions(const std::vector<VertexId>& corners) const {
    std::vector<Point> points;
    for (const VertexId v : corners)
      points.push_back(position(v));
    return points;
  }
  [[nodiscard]] std::set<std::uint32_t> closure(std::set<std::uint32_t> wanted) const {
    std::vector<std::uint32_t> open(wanted.begin(), wanted.end());
    while (!open.empty()) {
      const RecordId r{open.back()};
      open.pop_back();
      for (const RecordId parent : content.refinement.parents(r))
        if (wanted.insert(parent.index()).second) open.push_back(parent.index());
    }
    return wanted;
  }

private:
  [[nodiscard]] double decoded(const std::vector<ErrorCode16>& codes, RecordId r, std::size_t code) const {
    double scale = header.diagonal;
    std::size_t at = 0;
    for (const file::ArrayInfo& array : header.arrays)
      if (array.governing && at++ == code) scale = array.range;
    return decode_error(codes[r.index() * std::size_t{content.errors_per_record} + code], scale);
  }
  file::Content load() {
    file::Reader reader(file::over_memory(bytes));
    file::Content all = reader.read_base();
    std::vector<std::uint32_t> blocks(reader.blocks().size());
    std::iota(blocks.begin(), blocks.end(), 0U);
    reader.load(blocks, all);
    header = reader.header();
    return all;
  }
};

std::vector<Opened> make_samples() {
  std::vector<Opened> samples;
  for (auto& [name, mesh] : test::sample_meshes(29)) {
    samples.emplace_back(file::encode(mesh, test::simplify_naively(mesh), {}));
  }
  return samples;
}
const std::vector<Opened>& samples() {
  static const std::vector<Opened> made = make_samples();
  return made;
}

class Random {
public:
  Random(const DatasetInfo& info, unsigned seed) : info_(info), random_(seed) {}
  double uniform() { return static_cast<double>(random_() % 1000001) / 1e6; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  bool one_in(unsigned n) { return random_() % n == 0; }
  double small() { return std::pow(uniform(), 4); }
  Point point() {
    Point p{};
    for (std::size_t i = 0; i < 3; ++i)
      p[i] = uniform(info_.box_min[i], info_.box_max[i]);
    return p;
  }
  Point direction() { return {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)}; }
  Region region() {
    const double size = info_.diagonal * (0.02 + 0.3 * small());
    if (one_in(4)) return Sphere{point(), size};
    if (one_in(3)) {
      const Point normal = direction();
      return HalfSpace{normal, product(normal, point())};
    }
    if (one_in(2)) {
      Box box{point(), {}};
      for (std::size_t i = 0; i < 3; ++i)
        box.max[i] = box.min[i] + size * uniform();
      return box;
    }
    const double turn = uniform(0, 7), tilt = uniform(0, 7), s = std::sin(turn), c = std::cos(turn), t = std::sin(tilt),
                 u = std::cos(tilt);
    OrientedBox box{point(), {{{c, s, 0}, {-s * u, c * u, t}, {s * t, -c * t, u}}}};
    for (Point& half : box.half_axes) {
      const double length = size * uniform(0.01, 1);
      for (double& x : half)
        x *= length;
    }
    return box;
  }
  View view() {
    View view;
    const Point at = point();
    view.direction = direction();
    const double far = info_.diagonal * uniform(0, 1.5) / std::sqrt(product(view.direction, view.direction));
    for (std::size_t i = 0; i < 3; ++i)
      view.eye[i] = at[i] - far * view.direction[i];
    view.up = direction();
    view.vertical_angle = uniform(0.05, 2);
    view.width = 1 + random_() % 2000;
    view.height = 1 + random_() % 2000;
    view.max_pixels = uniform(0, 50);
    if (one_in(2)) view.outside = 1 + 20 * small();
    return view;
  }
  ValuesOfInterest values() {
    if (one_in(3)) { // the length of a vector
      const double least = uniform(0, 100);
      return {"flow", least, one_in(2) ? least : least + 50 * small()};
    }
    const double at = uniform(-1, 3);
    return {"pressure", at, one_in(2) ? at : at + small()};
  }
  Request request() {
    Request request;
    if (one_in(2)) request.field_error.push_back({one_in(2) ? "" : "pressure", {small(), true}});
    if (one_in(3)) request.domain_error = Bound{small() * 0.3, true};
    for (unsigned i = random_() % 3; i > 0; --i) {
      Focus focus{region()};
      if (one_in(2)) focus.error = {small(), true};
      if (one_in(2)) focus.falloff = Bound{uniform(0, 3), true};
      request.focus.push_back(focus);
    }
    for (unsigned i = random_() % 3; i > 0; --i)
      request.values.push_back(values());
    if (one_in(3)) request.view = view();
    return request;
  }

private:
  const DatasetInfo& info_;
  std::mt19937 random_;
};

double least_distance(const Region& region, const std::vector<Point>& corners) {
  double least = INFINITY;
  for (const Point& p : points_in(corners))
    least = std::min(least, distance_of(region, p));
  return least;
}

struct Picture {
  explicit Picture(const View& view) : view_(view) {
    forward_ = unit(view.direction);
    right_ = unit(cross_of(forward_, view.up));
    up_ = cross_of(right_, forward_);
  }
  /// Pixels from the middle, right and up, and the depth.
  [[nodiscard]] Point project(const Point& p) const {
    const Point at = along(view_.eye, p);
    const double depth = product(at, forward_);
    const double focal = view_.height / 2.0 / std::tan(view_.vertical_angle / 2);
    return {focal * product(at, right_) / depth, focal * product(at, up_) / depth, depth};
  }
  [[nodiscard]] bool sees(const Point& p) const {
    const Point at = project(p);
    return at[2] > 0 && std::fabs(at[0]) <= view_.width / 2.0 && std::fabs(at[1]) <= view_.height / 2.0;
  }

private:
  static Point cross_of(const Point& a, const Point& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  }
  static Point unit(const Point& a) {
    const double length = std::sqrt(product(a, a));
    return {a[0] / length, a[1] / length, a[2] / length};
  }
  View view_;
  Point forward_{}, right_{}, up_{};
};

struct Span {
  double low = INFINITY, high = -INFINITY;
};
/// Values at points all over a tet: of vectors the norm of what lies between.
Span values_in(const PointArray& array, const std::vector<VertexId>& corners) {
  constexpr int kSteps = 5;
  Span span;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j <= kSteps - i; ++j)
      for (int k = 0; k <= kSteps - i - j; ++k) {
        const std::array<int, 4> weight = {i, j, k, kSteps - i - j - k};
        if (corners.size() == 3 && weight[3] != 0) continue;
        double squared = 0, value = 0;
        for (std::uint32_t component = 0; component < array.components; ++component) {
          value = 0;
          for (std::size_t c = 0; c < corners.size(); ++c)
            value += weight[c] / double(kSteps) * array.value(corners[c].index(), component);
          squared += value * value;
        }
        if (array.components > 1) value = std::sqrt(squared);
        span.low = std::min(span.low, value);
        span.high = std::max(span.high, value);
      }
  return span;
}

const PointArray& array_of(const Opened& file, const std::string& name) {
  return *std::find_if(file.content.arrays.begin(), file.content.arrays.end(),
                       [&](const PointArray& array) { return array.name == name; });
}

/// The place of the field among the codes.
std::size_t code_of(const ValuesOfInterest& values) {
  return values.field == "pressure" ? 0 : 1;
}
/// What surely meets an interval: seen at points inside. `wider`: by so much less or more.
bool takes(const Opened& file, const ValuesOfInterest& values, const std::vector<VertexId>& corners, double wider) {
  const Span span = values_in(array_of(file, values.field), corners);
  return span.low - wider <= values.max && span.high + wider >= values.min;
}

/// The records whose splits are in an extraction.
std::set<std::uint32_t> applied_in(const Opened& file, const Extraction& extraction) {
  std::set<std::uint32_t> applied;
  for (const VertexId v : extraction.vertex_in_file)
    if (const RecordId r = file.content.refinement.record_of(v); !r.is_none()) applied.insert(r.index());
  return applied;
}

bool is_mesh(const Extraction& extraction) {
  const test::MeshFacts facts = test::examine(extraction.mesh);
  return facts.inverted_tets == 0 && facts.repeated_tets == 0 && facts.crowded_faces == 0 && facts.folded_faces == 0 &&
         facts.boundary.size() == extraction.boundary_faces.size();
}

/// The corners of each tet as vertices of the file.
std::vector<std::vector<VertexId>> tets_in_file(const Extraction& extraction) {
  std::vector<std::vector<VertexId>> tets;
  for (const Tet& tet : extraction.mesh.tets) {
    tets.emplace_back();
    for (const VertexId v : tet)
      tets.back().push_back(extraction.vertex_in_file[v.index()]);
  }
  return tets;
}

/// Records that surely are wanted: what points inside their versions tell. A few more may be.
std::set<std::uint32_t> surely_wanted(const Opened& file, const Request& request, const DatasetInfo& info) {
  std::set<std::uint32_t> wanted;
  const std::size_t domain = info.max_field_error.size();
  const auto scale = [&](std::size_t code) { return code == domain ? info.diagonal : info.fields[code].range; };
  const auto exceeds = [&](RecordId r, const Bound& base, double more) {
    for (std::size_t code = 0; code <= domain; ++code)
      if (file.error(r, code) > (base.absolute(scale(code)) + more * scale(code)) * (1 + 1e-9)) return true;
    return false;
  };
  const bool has_bounds = !request.field_error.empty() || request.domain_error || request.view;
  for (std::uint32_t i = 0; i < file.header.record_count; ++i) {
    const RecordId r{i};
    bool is_wanted = false;
    for (const Focus& focus : request.focus)
      for (const auto& corners : file.star(r, true)) {
        const double apart = least_distance(focus.region, file.positions(corners));
        if (apart == 0) is_wanted |= focus.error.value == 0 || exceeds(r, focus.error, 0);
        if (focus.falloff) is_wanted |= exceeds(r, focus.error, focus.falloff->value * apart / info.diagonal);
      }
    if (has_bounds || !request.values.empty())
      for (const auto& corners : file.star(r, false)) {
        if (is_wanted) break;
        bool is_there = request.values.empty();
        for (const ValuesOfInterest& values : request.values)
          is_there |= takes(file, values, corners, file.monotone_error(r, code_of(values)));
        if (!is_there) continue;
        is_wanted |= !has_bounds;
        double factor = 1;
        if (request.view) {
          const Picture picture(*request.view);
          const auto points = points_in(file.positions(corners));
          if (std::none_of(points.begin(), points.end(), [&](const Point& p) { return picture.sees(p); }))
            factor = request.view->outside;
        }
        for (const FieldBound& bound : request.field_error)
          for (std::size_t code = 0; code < domain; ++code)
            if (bound.field.empty() || bound.field == info.fields[code].name)
              is_wanted |=
                  (request.values.empty() && !request.view ? file.error(r, code) : file.monotone_error(r, code)) >
                  factor * bound.bound.absolute(scale(code));
        if (request.domain_error && corners.size() == 3)
          is_wanted |= file.error(r, domain) > factor * request.domain_error->absolute(scale(domain));
      }
    if (is_wanted) wanted.insert(i);
  }
  return wanted;
}

void check_parts(const Opened& file, const Request& request, const DatasetInfo& info, const Extraction& answer) {
  const auto tets = tets_in_file(answer);
  const std::size_t fields = answer.field_error.size();
  std::size_t broken = 0, below = 0;
  for (std::size_t t = 0; t < tets.size(); ++t) {
    const RecordId made_by = answer.made_by[t];
    if (made_by.is_none()) continue;
    const std::vector<Point> corners = file.positions(tets[t]);
    const std::vector<Point> points = points_in(corners);
    for (std::size_t f = 0; f < fields; ++f) {
      const double error = file.error(made_by, f), range = info.fields[f].range;
      for (std::size_t k = 0; k < request.focus.size(); ++k) {
        const Focus& focus = request.focus[k];
        const double apart = least_distance(focus.region, corners);
        if (apart == 0) {
          broken += focus.error.value == 0 || error > focus.error.absolute(range) ? 1 : 0;
          below += answer.in_focus[k].field_error[f] < error ? 1 : 0;
        }
        if (focus.falloff)
          broken += error > (focus.error.value + focus.falloff->value * apart / info.diagonal) * range * (1 + 1e-9);
      }
      bool is_there = request.values.empty();
      for (std::size_t k = 0; k < request.values.size(); ++k)
        if (takes(file, request.values[k], tets[t], file.error(made_by, code_of(request.values[k])))) {
          is_there = true;
          below += answer.at_values[k].field_error[f] < error ? 1 : 0;
        }
      double factor = 1;
      if (request.view) {
        const Picture picture(*request.view);
        const bool is_seen = std::any_of(points.begin(), points.end(), [&](const Point& p) { return picture.sees(p); });
        if (is_seen) below += answer.in_view->field_error[f] < error ? 1 : 0;
        if (!is_seen) factor = request.view->outside;
      }
      if (!is_there) continue;
      for (const FieldBound& bound : request.field_error)
        if (bound.field.empty() || bound.field == info.fields[f].name)
          broken += error > factor * bound.bound.absolute(range) ? 1 : 0;
      if (request.field_error.empty() && !request.domain_error && !request.view && !request.values.empty()) ++broken;
    }
  }
  CHECK(broken == 0);
  CHECK(below == 0);
}

bool same_mesh(const Extraction& a, const Extraction& b) {
  return a.mesh.tets == b.mesh.tets && a.vertex_in_file == b.vertex_in_file && a.boundary_faces == b.boundary_faces;
}

} // namespace

TEST_CASE("demand: random requests of all kinds are met, by the same mesh whatever was read before") {
  std::size_t partial = 0, at_values = 0;
  for (const Opened& file : samples()) {
    const auto used = file.open();
    const DatasetInfo& info = used->info();
    Random random(info, 91);
    for (int i = 0; i < 60; ++i) {
      INFO("request " << i);
      Request request = random.request();
      const Extraction fresh = file.open()->extract(request);
      const Extraction again = used->extract(request);
      CHECK(same_mesh(fresh, again));
      CHECK(fresh.field_error == again.field_error);
      CHECK(is_mesh(fresh));
      request.origins = true;
      const Extraction answer = used->extract(request);
      CHECK(same_mesh(fresh, answer));
      check_parts(file, request, info, answer);

      const std::set<std::uint32_t> applied = applied_in(file, answer);
      CHECK(file.closure(applied) == applied);
      if (answer.limited_by == LimitedBy::kNothing) continue;
      const std::set<std::uint32_t> wanted = file.closure(surely_wanted(file, request, info));
      CHECK(std::includes(applied.begin(), applied.end(), wanted.begin(), wanted.end()));
      partial += wanted.size() > 10 && applied.size() < info.records ? 1 : 0;
      at_values += request.values.empty() ? 0 : 1;
    }
  }
  CHECK(partial > 60);
  CHECK(at_values > 60);
}

TEST_CASE("demand: no more is refined than what one record or another asks for") {
  // What a shape's exact test adds to what points inside tell is little: most answers are the same.
  std::size_t same = 0, all = 0, more = 0;
  for (const Opened& file : samples()) {
    const auto used = file.open();
    const DatasetInfo& info = used->info();
    Random random(info, 92);
    for (int i = 0; i < 40; ++i) {
      Request request = random.request();
      request.view.reset();
      if (request.focus.empty() && request.values.empty()) continue;
      const std::set<std::uint32_t> applied = applied_in(file, used->extract(request));
      const std::set<std::uint32_t> wanted = file.closure(surely_wanted(file, request, info));
      ++all;
      same += applied == wanted ? 1 : 0;
      more += applied.size() - wanted.size();
    }
  }
  CHECK(all > 100);
  CHECK(same > all / 3);
  CHECK(more < all * 10);
}

TEST_CASE("demand: near a box that has no turn there is what there is near the box, and no more") {
  std::size_t found = 0;
  for (const Opened& file : samples()) {
    const auto dataset = file.open();
    const DatasetInfo& info = dataset->info();
    Random random(info, 96);
    for (int i = 0; i < 40; ++i) {
      INFO("request " << i);
      Box box{random.point(), {}};
      OrientedBox oriented;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double half = info.diagonal * random.uniform(0.005, 0.1);
        box.max[axis] = box.min[axis] + 2 * half;
        oriented.centre[axis] = box.min[axis] + half;
        oriented.half_axes[axis] = {};
        oriented.half_axes[axis][axis] = half;
      }
      Request request;
      request.focus.push_back({box, {0, true}});
      request.focus.back().falloff = Bound{random.uniform(0.01, 1), true};
      const Extraction near_box = dataset->extract(request);
      request.focus.back().region = oriented;
      CHECK(same_mesh(dataset->extract(request), near_box));
      found += near_box.mesh.tets.size() > info.base_tets && near_box.mesh.tets.size() < info.tets ? 1 : 0;
    }
  }
  CHECK(found > 20);
}

TEST_CASE("demand: budgets of all kinds hold on top of it, and answers stay meshes") {
  for (const Opened& file : samples()) {
    const auto used = file.open();
    const DatasetInfo& info = used->info();
    Random random(info, 93);
    for (int i = 0; i < 40; ++i) {
      INFO("request " << i);
      Request request = random.request();
      Request least = request;
      least.field_error.clear();
      least.domain_error.reset();
      least.values.clear();
      least.view.reset();
      for (Focus& focus : least.focus)
        focus.falloff.reset();
      const Extraction whole = used->extract(request);
      const double share = random.uniform();
      const auto part = [&](std::size_t n) { return static_cast<std::uint64_t>(share * static_cast<double>(n)); };
      const auto bytes_of = [](const Extraction& extraction) {
        std::uint64_t bytes = extraction.mesh.positions.bytes.size();
        for (const PointArray& array : extraction.mesh.point_arrays)
          bytes += array.bytes.size();
        return bytes + 16 * extraction.mesh.tets.size() + 12 * extraction.boundary_faces.size();
      };
      const bool asks_outside = !request.field_error.empty() || request.domain_error || !request.values.empty() ||
                                request.view ||
                                std::any_of(request.focus.begin(), request.focus.end(),
                                            [](const Focus& focus) { return focus.falloff.has_value(); });
      if (!asks_outside) continue;
      switch (i % 3) {
      case 0: request.max_bytes = part(bytes_of(whole)); break;
      case 1: request.max_tets = part(whole.mesh.tets.size()); break;
      default: request.max_vertices = part(whole.mesh.vertex_count()); break;
      }
      const Extraction cut = file.open()->extract(request);
      CHECK(same_mesh(cut, used->extract(request)));
      CHECK(is_mesh(cut));
      const std::set<std::uint32_t> applied = applied_in(file, cut), all = applied_in(file, whole);
      CHECK(std::includes(all.begin(), all.end(), applied.begin(), applied.end()));
      std::set<std::uint32_t> promised;
      if (!least.focus.empty()) promised = applied_in(file, used->extract(least));
      CHECK(std::includes(applied.begin(), applied.end(), promised.begin(), promised.end()));
      if (applied.size() > promised.size()) {
        if (request.max_bytes) CHECK(bytes_of(cut) <= *request.max_bytes);
        if (request.max_tets) CHECK(cut.mesh.tets.size() <= *request.max_tets);
        if (request.max_vertices) CHECK(cut.mesh.vertex_count() <= *request.max_vertices);
      }
      if (applied != all) CHECK(cut.limited_by == LimitedBy::kBudget);
    }
  }
}

TEST_CASE("demand: the errors stated of a part are those of what meets it, among all tets") {
  for (const Opened& file : samples()) {
    const auto dataset = file.open();
    Random random(dataset->info(), 95);
    std::size_t looked_at = 0;
    for (int i = 0; i < 60; ++i) {
      Request request;
      request.origins = true; // so that all that made a tet is known
      request.field_error = {{"", {random.small(), true}}};
      for (int k = 0; k < 3; ++k)
        request.focus.push_back({random.region(), {0.3 * random.uniform(), true}});
      request.view = random.view();
      const Extraction cut = dataset->extract(request);
      const Camera camera(*request.view);
      std::vector<double> error(cut.made_by.size()), in_part(request.focus.size() + 1, 0);
      dataset->origin_values(cut.made_by, OriginValue::kFieldError, 0, error);
      for (std::size_t t = 0; t < error.size(); ++t) {
        std::vector<Point> corners;
        for (const VertexId v : cut.mesh.tets[t])
          corners.push_back({cut.mesh.positions.value(v.index(), 0), cut.mesh.positions.value(v.index(), 1),
                             cut.mesh.positions.value(v.index(), 2)});
        for (std::size_t k = 0; k < request.focus.size(); ++k)
          if (meets(request.focus[k].region, corners)) in_part[k] = std::max(in_part[k], error[t]);
        if (camera.meets(corners)) in_part.back() = std::max(in_part.back(), error[t]);
      }
      REQUIRE(cut.in_focus.size() == request.focus.size());
      for (std::size_t k = 0; k < request.focus.size(); ++k)
        if (!std::holds_alternative<HalfSpace>(request.focus[k].region)) // of another length in the library
          CHECK(cut.in_focus[k].field_error[0] == in_part[k]);
      REQUIRE(cut.in_view);
      CHECK(cut.in_view->field_error[0] == in_part.back());
      looked_at += std::count_if(in_part.begin(), in_part.end(), [](double e) { return e > 0; });
    }
    CHECK(looked_at > 60);
  }
}

TEST_CASE("demand: when time is up the answer is a mesh, and with time enough it is the whole") {
  for (const Opened& file : samples()) {
    const auto used = file.open();
    Random random(used->info(), 94);
    for (int i = 0; i < 20; ++i) {
      Request request = random.request();
      const Extraction whole = used->extract(request);
      request.max_milliseconds = 0;
      const Extraction base = file.open()->extract(request);
      CHECK(base.mesh.tets.size() == used->info().base_tets);
      CHECK(base.limited_by == LimitedBy::kTime);
      request.max_milliseconds = random.uniform(0, 1);
      const Extraction some = file.open()->extract(request);
      CHECK(is_mesh(some));
      request.max_milliseconds = 1e7;
      if (whole.limited_by == LimitedBy::kFocus) continue; // a budget is spent on what nothing else asks for
      CHECK(same_mesh(file.open()->extract(request), whole));
    }
  }
}
