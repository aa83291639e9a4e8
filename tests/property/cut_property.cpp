// Files made by a plain simplifier, asked for random cuts: what must hold for every one of them.
#include "formats/ptet/reader.hpp"
#include "formats/ptet/writer.hpp"
#include "ptet/dataset.hpp"
#include "record/order_code.hpp"
#include "support/brute_force.hpp"
#include "support/mesh_checks.hpp"
#include "support/meshes.hpp"
#include "support/naive_simplifier.hpp"
#include "support/region_checks.hpp"
#include "support/stream_extras.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <thread>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

struct Sample {
  std::string name;
  TetMesh mesh;
  RecordStream stream;
  test::MeshFacts facts;
  std::vector<std::byte> bytes;
  std::vector<VertexId> to_original;      ///< by vertex of the file
  std::array<std::vector<double>, 2> own; ///< field errors by record, as the file has them
  std::vector<std::size_t> place;         ///< by record of the stream: how many budgets undo before it

  [[nodiscard]] std::shared_ptr<const Dataset> open() const { return Dataset::open_memory(bytes); }
};

/// The bits of a row. Those of the positions tell sample vertices apart.
std::string row_of(const PointArray& array, std::size_t row) {
  return {reinterpret_cast<const char*>(array.bytes.data()) + row * array.row_bytes(), array.row_bytes()};
}
std::string bits_of(const PointArray& array) {
  return {reinterpret_cast<const char*>(array.bytes.data()), array.bytes.size()};
}

/// `extras`: with dependencies between any two records, squared errors, and budgets that go by errors.
std::vector<Sample> make_samples(bool extras) {
  std::vector<Sample> list;
  for (auto& [name, mesh] : test::sample_meshes(23)) {
    Sample sample{name, std::move(mesh), {}, {}, {}, {}, {}, {}};
    sample.stream = test::simplify_naively(sample.mesh);
    if (extras) {
      test::add_random_dependencies(sample.stream, 41);
      test::add_random_squared_errors(sample.stream, 43);
      test::add_budget_weights(sample.stream);
    }
    sample.place = test::places_in_budgets(sample.stream);
    sample.facts = test::examine(sample.mesh);
    sample.bytes = file::encode(sample.mesh, sample.stream, {"test", name, "", {{"order", "random"}}, {"a note"}});
    std::map<std::string, std::uint32_t> at;
    for (std::uint32_t v = 0; v < sample.mesh.vertex_count(); ++v)
      at[row_of(sample.mesh.positions, v)] = v;
    const Extraction full = sample.open()->extract({});
    for (std::size_t v = 0; v < full.mesh.vertex_count(); ++v)
      sample.to_original.emplace_back(at.at(row_of(full.mesh.positions, v)));
    file::Reader reader(file::over_memory(sample.bytes));
    file::Content content = reader.read_base();
    std::vector<std::uint32_t> blocks(reader.blocks().size());
    std::iota(blocks.begin(), blocks.end(), 0U);
    reader.load(blocks, content);
    for (std::size_t i = 0; i < 2; ++i)
      for (std::size_t r = 0; r < content.refinement.record_count(); ++r)
        sample.own[i].push_back(
            decode_error(content.own[r * content.errors_per_record + i], reader.header().arrays[i].range));
    list.push_back(std::move(sample));
  }
  return list;
}

const std::vector<Sample>& samples() {
  static const std::vector<Sample> made = make_samples(false);
  return made;
}
const std::vector<Sample>& samples_with_extras() {
  static const std::vector<Sample> made = make_samples(true);
  return made;
}

/// For each record of the stream whether its vertex is in the mesh: whether its split is applied.
std::vector<char> applied_in(const Sample& sample, const Extraction& extraction) {
  std::vector<char> is_there(sample.mesh.vertex_count(), 0);
  for (const VertexId v : extraction.vertex_in_file)
    is_there[sample.to_original.at(v.index()).index()] = 1;
  std::vector<char> applied;
  for (const VertexId v : sample.stream.removed)
    applied.push_back(is_there[v.index()]);
  return applied;
}

OrderCode order_code(const Sample& sample, std::size_t record) {
  const std::size_t vertices = sample.mesh.vertex_count(), without = vertices - sample.stream.size();
  return encode_order(vertices, without + sample.place[record] + 1);
}

/// The tets of an extraction in the numbering of the original mesh, sorted keeping their orientation.
std::set<Tet> in_original_ids(const Sample& sample, const Extraction& extraction) {
  std::set<Tet> tets;
  for (Tet tet : extraction.mesh.tets) {
    for (VertexId& v : tet)
      v = sample.to_original.at(extraction.vertex_in_file.at(v.index()).index());
    tets.insert(test::sorted_keeping_orientation(tet));
  }
  return tets;
}
std::set<Tet> original_tets(const Sample& sample) {
  std::set<Tet> tets;
  for (const Tet& tet : sample.mesh.tets)
    tets.insert(test::sorted_keeping_orientation(tet));
  return tets;
}

class RandomRequests {
public:
  RandomRequests(const DatasetInfo& info, unsigned seed) : info_(info), random_(seed) {}

  double uniform() { return static_cast<double>(random_() % 1000001) / 1e6; }
  bool coin() { return random_() % 2 == 0; }
  Point point() {
    Point p{};
    for (std::size_t i = 0; i < 3; ++i)
      p[i] = info_.box_min[i] + uniform() * (info_.box_max[i] - info_.box_min[i]);
    return p;
  }
  Region region() {
    // From half the mesh down to a point.
    const double size = coin() ? std::pow(uniform(), 8) : uniform() / 2;
    switch (random_() % 6) {
    case 0: return oriented_box(size);
    case 1: {
      const Point normal{uniform() - 0.5, uniform() - 0.5, uniform() - 0.5}, at = point();
      return HalfSpace{normal, normal[0] * at[0] + normal[1] * at[1] + normal[2] * at[2]};
    }
    case 2:
    case 3: return Sphere{point(), size * info_.diagonal / 2};
    default: break;
    }
    Box box{point(), point()};
    for (std::size_t i = 0; i < 3; ++i) {
      if (box.min[i] > box.max[i]) std::swap(box.min[i], box.max[i]);
      box.max[i] = box.min[i] + (box.max[i] - box.min[i]) * size;
    }
    return box;
  }
  OrientedBox oriented_box(double size) {
    const double turn = 7 * uniform(), tilt = 7 * uniform(), s = std::sin(turn), c = std::cos(turn), t = std::sin(tilt),
                 u = std::cos(tilt);
    OrientedBox box{point(), {{{c, s, 0}, {-s * u, c * u, t}, {s * t, -c * t, u}}}};
    for (Point& half : box.half_axes) {
      const double length = size * uniform() * info_.diagonal / 2;
      for (double& x : half)
        x *= length;
    }
    return box;
  }
  Request request() {
    Request request;
    if (coin()) request.field_error.push_back({coin() ? "" : "pressure", {std::pow(uniform(), 3), true}});
    if (coin()) request.domain_error = Bound{std::pow(uniform(), 3) * 0.2, true};
    if (coin()) request.max_tets = random_() % (info_.tets + 10);
    if (random_() % 4 == 0) request.max_vertices = random_() % (info_.vertices + 10);
    for (unsigned i = random_() % 3; i > 0; --i)
      request.focus.push_back({region(), {random_() % 3 == 0 ? std::pow(uniform(), 3) : 0, true}, {}});
    if (random_() % 5 == 0) request.max_bytes = random_() % (100 * info_.tets);
    request.origins = random_() % 3 == 0;
    return request;
  }

private:
  const DatasetInfo& info_;
  std::mt19937 random_;
};

bool same(const std::vector<PartErrors>& a, const std::vector<PartErrors>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const PartErrors& x, const PartErrors& y) {
    return x.field_error == y.field_error && x.domain_error == y.domain_error;
  });
}
bool same(const Extraction& a, const Extraction& b) {
  for (std::size_t i = 0; i < a.mesh.point_arrays.size(); ++i)
    if (bits_of(a.mesh.point_arrays[i]) != bits_of(b.mesh.point_arrays[i])) return false;
  return bits_of(a.mesh.positions) == bits_of(b.mesh.positions) && a.mesh.tets == b.mesh.tets &&
         a.vertex_in_file == b.vertex_in_file && a.made_by == b.made_by && a.boundary_faces == b.boundary_faces &&
         a.field_error == b.field_error && a.rms_error == b.rms_error && a.domain_error == b.domain_error &&
         a.limited_by == b.limited_by && same(a.in_focus, b.in_focus);
}

void check_mesh(const Sample& sample, const Extraction& extraction) {
  const test::MeshFacts facts = test::examine(extraction.mesh);
  CHECK(facts.inverted_tets == 0);
  CHECK(facts.repeated_tets == 0);
  CHECK(facts.crowded_faces == 0);
  CHECK(facts.folded_faces == 0);
  CHECK(facts.components == sample.facts.components);
  CHECK(facts.boundary_euler_characteristic == sample.facts.boundary_euler_characteristic);

  std::vector<test::Face> faces;
  for (const auto& face : extraction.boundary_faces)
    faces.push_back(test::turned(face));
  CHECK(test::enclosed_volume(extraction.mesh, faces) == Approx(facts.volume));
  std::sort(faces.begin(), faces.end());
  CHECK(faces == facts.boundary);

  CHECK(std::is_sorted(extraction.vertex_in_file.begin(), extraction.vertex_in_file.end()));
  REQUIRE(extraction.vertex_in_file.size() == extraction.mesh.vertex_count());
  REQUIRE(extraction.mesh.point_arrays.size() == sample.mesh.point_arrays.size());
  bool rows_are_the_original_ones = true;
  for (std::size_t v = 0; v < extraction.mesh.vertex_count(); ++v) {
    const std::size_t original = sample.to_original.at(extraction.vertex_in_file[v].index()).index();
    rows_are_the_original_ones &= row_of(extraction.mesh.positions, v) == row_of(sample.mesh.positions, original);
    for (std::size_t a = 0; a < extraction.mesh.point_arrays.size(); ++a)
      rows_are_the_original_ones &=
          row_of(extraction.mesh.point_arrays[a], v) == row_of(sample.mesh.point_arrays[a], original);
  }
  CHECK(rows_are_the_original_ones);
}

// What the focus needs is there, nothing is that neither it nor the bounds ask for, and of the rest a budget takes the
// records that come first in its order.
void check_budget_order(const Sample& sample, const Request& request, const Extraction& extraction) {
  Request focus, bounds;
  focus.focus = request.focus;
  bounds.field_error = request.field_error;
  bounds.domain_error = request.domain_error;
  const auto opened = sample.open();
  const std::vector<char> wanted = applied_in(sample, opened->extract(bounds));
  const std::vector<char> in_focus =
      request.focus.empty() ? std::vector<char>(wanted.size(), 0) : applied_in(sample, opened->extract(focus));
  const std::vector<char> applied = applied_in(sample, extraction);
  std::size_t missing = 0, unasked = 0;
  int least_taken = kMaxOrderCode + 1, most_left = -1;
  for (std::size_t i = 0; i < applied.size(); ++i) {
    if (in_focus[i] != 0) {
      missing += applied[i] == 0 ? 1 : 0;
    } else if (wanted[i] == 0) {
      unasked += applied[i] != 0 ? 1 : 0;
    } else if (applied[i] != 0) {
      least_taken = std::min<int>(least_taken, order_code(sample, i));
    } else {
      most_left = std::max<int>(most_left, order_code(sample, i));
    }
  }
  CHECK(missing == 0);
  CHECK(unasked == 0);
  CHECK(least_taken >= most_left);
  if (extraction.limited_by != LimitedBy::kBudget) CHECK(most_left == -1);
}

std::uint64_t bytes_of(const Extraction& extraction) {
  std::uint64_t bytes = extraction.mesh.positions.bytes.size();
  for (const PointArray& array : extraction.mesh.point_arrays)
    bytes += array.bytes.size();
  return bytes + 16 * extraction.mesh.tets.size() + 12 * extraction.boundary_faces.size();
}

/// What meets a focus region is the original, there and nowhere made coarser.
void check_focus(const Sample& sample, const Region& region, const Extraction& extraction) {
  const std::set<Tet> tets = in_original_ids(sample, extraction);
  bool all_there = true;
  for (const Tet& tet : sample.mesh.tets)
    if (test::surely_meets(region, sample.mesh, tet))
      all_there &= tets.count(test::sorted_keeping_orientation(tet)) != 0;
  CHECK(all_there);
  bool nothing_else = true;
  const std::set<Tet> originals = original_tets(sample);
  for (const Tet& tet : extraction.mesh.tets)
    if (test::surely_meets(region, extraction.mesh, tet)) {
      Tet original = tet;
      for (VertexId& v : original)
        v = sample.to_original[extraction.vertex_in_file[v.index()].index()];
      nothing_else &= originals.count(test::sorted_keeping_orientation(original)) != 0;
    }
  CHECK(nothing_else);
}

/// Whatever no record made is original, and the errors stated are those of the records that made the others.
void check_origins(const Sample& sample, const DatasetInfo& info, const Request& request,
                   const Extraction& extraction) {
  REQUIRE(extraction.made_by.size() == extraction.mesh.tets.size());
  const std::set<Tet> originals = original_tets(sample);
  bool none_means_original = true;
  for (std::size_t t = 0; t < extraction.mesh.tets.size(); ++t) {
    Tet tet = extraction.mesh.tets[t];
    for (VertexId& v : tet)
      v = sample.to_original[extraction.vertex_in_file[v.index()].index()];
    none_means_original &=
        extraction.made_by[t].is_none() == (originals.count(test::sorted_keeping_orientation(tet)) != 0);
  }
  CHECK(none_means_original);
  for (std::size_t i = 0; i < 2; ++i) {
    double most = 0;
    std::vector<double> most_in_focus(request.focus.size(), 0);
    for (std::size_t t = 0; t < extraction.mesh.tets.size(); ++t) {
      if (extraction.made_by[t].is_none()) continue;
      const double error = sample.own[i][extraction.made_by[t].index()];
      most = std::max(most, error);
      for (std::size_t k = 0; k < request.focus.size(); ++k)
        if (test::surely_meets(request.focus[k].region, extraction.mesh, extraction.mesh.tets[t]))
          most_in_focus[k] = std::max(most_in_focus[k], error);
    }
    CHECK(extraction.field_error[i] == most);
    REQUIRE(extraction.in_focus.size() == request.focus.size());
    for (std::size_t k = 0; k < request.focus.size(); ++k) {
      CHECK(most_in_focus[k] <= extraction.in_focus[k].field_error[i]);
      CHECK(extraction.in_focus[k].field_error[i] <= request.focus[k].error.absolute(info.fields[i].range));
    }
  }
}

void check_answer(const Sample& sample, const DatasetInfo& info, const Request& request, const Extraction& extraction) {
  const bool has_budget = request.max_tets || request.max_vertices || request.max_bytes;
  const bool passes_budget = (request.max_tets && extraction.mesh.tets.size() > *request.max_tets) ||
                             (request.max_bytes && bytes_of(extraction) > *request.max_bytes) ||
                             (request.max_vertices && extraction.mesh.vertex_count() > *request.max_vertices);
  if (passes_budget) {
    // The least there is: the focus, or without one the base mesh.
    Request least;
    least.focus = request.focus;
    if (request.focus.empty())
      CHECK(extraction.mesh.tets.size() == info.base_tets);
    else
      CHECK(extraction.mesh.tets == sample.open()->extract(least).mesh.tets);
  }
  if (extraction.limited_by == LimitedBy::kBudget) CHECK(has_budget);
  if (has_budget) check_budget_order(sample, request, extraction);
  if (extraction.limited_by == LimitedBy::kNothing) CHECK(extraction.mesh.tets.size() == info.tets);
  REQUIRE(extraction.field_error.size() == 2);
  if (extraction.limited_by != LimitedBy::kBudget) {
    for (const FieldBound& bound : request.field_error)
      for (std::size_t i = 0; i < 2; ++i)
        if (bound.field.empty() || bound.field == info.fields[i].name)
          CHECK(extraction.field_error[i] <= bound.bound.absolute(info.fields[i].range));
    if (request.domain_error) CHECK(extraction.domain_error <= request.domain_error->absolute(info.diagonal));
  }
  for (const Focus& focus : request.focus)
    if (!(focus.error.value > 0)) check_focus(sample, focus.region, extraction);
  if (request.origins)
    check_origins(sample, info, request, extraction);
  else
    CHECK(extraction.made_by.empty());
}

} // namespace

TEST_CASE("full refinement is the original") {
  for (const Sample& sample : samples()) {
    INFO(sample.name);
    REQUIRE(sample.stream.size() > 30);
    const auto dataset = sample.open();
    const Extraction full = dataset->extract({});
    CHECK(full.limited_by == LimitedBy::kNothing);
    CHECK(full.mesh.vertex_count() == sample.mesh.vertex_count());
    CHECK(in_original_ids(sample, full) == original_tets(sample));
    CHECK(full.mesh.tets.size() == sample.mesh.tets.size());
    CHECK(full.field_error == std::vector<double>{0, 0});
    CHECK(full.domain_error == 0);
    check_mesh(sample, full);
    CHECK(dataset->info().records == sample.stream.size());
  }
}

TEST_CASE("random requests") {
  for (const Sample& sample : samples()) {
    const auto used = sample.open();
    const DatasetInfo& info = used->info();
    RandomRequests random(info, 77);
    for (int i = 0; i < 50; ++i) {
      INFO(sample.name << ", request " << i);
      const Request request = random.request();
      const Extraction extraction = used->extract(request);
      check_mesh(sample, extraction);
      check_answer(sample, info, request, extraction);
      // Another file, just opened, gives the same.
      CHECK(same(extraction, sample.open()->extract(request)));
      // What is known of each tet once all is read bounds what is said when it is not.
      Request exact = request;
      exact.origins = true;
      const Extraction with_origins = used->extract(exact);
      CHECK(with_origins.mesh.tets == extraction.mesh.tets);
      CHECK(with_origins.field_error[0] <= extraction.field_error[0]);
      CHECK(with_origins.field_error[1] <= extraction.field_error[1]);
      CHECK(with_origins.domain_error <= extraction.domain_error);
      check_answer(sample, info, exact, with_origins);
    }
  }
}

TEST_CASE("random requests where records need others besides the makers of what they replace") {
  std::size_t held = 0;
  for (const Sample& sample : samples_with_extras()) {
    const auto used = sample.open();
    RandomRequests random(used->info(), 78);
    for (int i = 0; i < 50; ++i) {
      INFO(sample.name << ", request " << i);
      const Request request = random.request();
      const Extraction extraction = used->extract(request);
      check_mesh(sample, extraction);
      check_answer(sample, used->info(), request, extraction);
      CHECK(same(extraction, sample.open()->extract(request)));
      const std::vector<char> applied = applied_in(sample, extraction);
      std::size_t broken = 0;
      for (std::size_t record = 0; record < applied.size(); ++record)
        for (const std::uint32_t other : sample.stream.others_needed(record)) {
          broken += applied[record] != 0 && applied[other] == 0 ? 1 : 0;
          held += applied[record] != 0 && extraction.limited_by != LimitedBy::kNothing ? 1 : 0;
        }
      CHECK(broken == 0);
    }
  }
  CHECK(held > 1000);
}

TEST_CASE("the mean square error of any cut is the sum over the collapses that are not undone") {
  for (const Sample& sample : samples_with_extras()) {
    const auto used = sample.open();
    const std::size_t fields = sample.stream.fields.size();
    REQUIRE(fields == 2);
    RandomRequests random(used->info(), 79);
    const double volume = sample.stream.volume;
    const auto check_rms = [&](const std::vector<double>& rms, std::optional<double> covered,
                               const std::vector<double>& largest, const std::vector<char>& applied) {
      REQUIRE(rms.size() == fields);
      REQUIRE(covered);
      double uncovered = 0, at_most = 0;
      for (std::size_t i = 0; i < applied.size(); ++i) {
        if (applied[i] != 0) continue;
        const double part = sample.stream.uncovered_volume[i] / volume;
        uncovered += part;
        at_most +=
            part + std::max(0.0906 * std::fabs(part), part != 0 ? 0x1p-8 / static_cast<double>(applied.size()) : 0);
      }
      CHECK(*covered <= std::clamp(1 - uncovered, 0.0, 1.0) + 1e-12);
      CHECK(*covered >= std::clamp(1 - at_most, 0.0, 1.0) - 1e-12);
      for (std::size_t f = 0; f < fields; ++f) {
        double sum = 0, coarsely_rounded = 0;
        for (std::size_t i = 0; i < applied.size(); ++i) {
          if (applied[i] != 0) continue;
          const double squared = sample.stream.squared_error[i * fields + f];
          sum += squared;
          coarsely_rounded += squared + 0.0906 * std::fabs(squared);
        }
        CHECK(rms[f] <= largest[f]);
        const double integral = rms[f] * rms[f] * volume * *covered;
        CHECK(integral <= std::max(0.0, coarsely_rounded) * (1 + 1e-12));
        if (rms[f] < largest[f]) CHECK(integral >= sum * (1 - 1e-12));
      }
    };
    const DatasetInfo& info = used->info();
    check_rms(info.base_rms_error, info.base_covered, info.max_field_error, std::vector<char>(sample.stream.size(), 0));
    CHECK(used->extract({}).rms_error == std::vector<double>{0, 0});
    CHECK(used->extract({}).covered == 1.0);
    std::size_t partial = 0;
    for (int i = 0; i < 50; ++i) {
      INFO(sample.name << ", request " << i);
      Request request = random.request();
      const Extraction extraction = sample.open()->extract(request);
      check_rms(extraction.rms_error, extraction.covered, extraction.field_error, applied_in(sample, extraction));
      request.origins = true;
      const Extraction again = used->extract(request);
      CHECK(again.covered == extraction.covered);
      for (std::size_t f = 0; f < fields; ++f)
        CHECK(again.rms_error[f] == std::min(extraction.rms_error[f], again.field_error[f]));
      partial += extraction.limited_by != LimitedBy::kNothing && extraction.rms_error[0] > 0 ? 1 : 0;
    }
    CHECK(partial > 10);
  }
  for (const Sample& sample : samples()) {
    CHECK(sample.open()->info().base_rms_error.empty());
    CHECK(sample.open()->extract({}).rms_error.empty());
  }
}

TEST_CASE("a focus on a single point, where the domain has shrunk or grown too") {
  for (const Sample& sample : samples()) {
    INFO(sample.name);
    const auto dataset = sample.open();
    RandomRequests random(dataset->info(), 31);
    int covered = 0;
    for (int i = 0; i < 200; ++i) {
      const Point p = random.point();
      Request request;
      if (random.coin())
        request.focus = {{Sphere{p, 0}}};
      else
        request.focus = {{Box{p, p}}};
      const Extraction extraction = dataset->extract(request);
      std::set<Tet> expected, found;
      for (const Tet& tet : sample.mesh.tets)
        if (test::contains(sample.mesh, tet, p)) expected.insert(test::sorted_keeping_orientation(tet));
      for (const Tet& tet : extraction.mesh.tets) {
        if (!test::contains(extraction.mesh, tet, p)) continue;
        Tet original = tet;
        for (VertexId& v : original)
          v = sample.to_original[extraction.vertex_in_file[v.index()].index()];
        found.insert(test::sorted_keeping_orientation(original));
      }
      CHECK(found == expected);
      covered += expected.empty() ? 0 : 1;
    }
    CHECK(covered > 50);
  }
}

TEST_CASE("a budget gives the mesh of the records that come first in its order") {
  for (const auto* list : {&samples(), &samples_with_extras()}) {
    for (const Sample& sample : *list) {
      INFO(sample.name);
      const auto dataset = sample.open();
      const std::size_t records = sample.stream.size();
      std::size_t compared = 0;
      std::vector<std::size_t> at_place(records);
      for (std::size_t r = 0; r < records; ++r)
        at_place[sample.place[r]] = r;
      for (std::size_t done = 0; done <= records; ++done) {
        const std::size_t split = records - done; // where codes are alike, generations count
        if (split > 0 && split < records &&
            order_code(sample, at_place[split]) == order_code(sample, at_place[split - 1]))
          continue;
        std::vector<char> is_split;
        for (const std::size_t place : sample.place)
          is_split.push_back(place < split ? 1 : 0);
        const std::vector<Tet> there = test::cut_mesh(sample.stream, is_split).tets;
        std::set<Tet> expected;
        for (const Tet& tet : there)
          expected.insert(test::sorted_keeping_orientation(tet));
        Request by_vertices, by_tets;
        by_vertices.max_vertices = sample.mesh.vertex_count() - done;
        by_tets.max_tets = there.size();
        for (const Request& request : {by_vertices, by_tets}) {
          // Half of them from a file of which nothing was read before.
          const Extraction extraction = (compared % 2 == 0 ? dataset : sample.open())->extract(request);
          CHECK(in_original_ids(sample, extraction) == expected);
          CHECK(applied_in(sample, extraction) == is_split);
        }
        ++compared;
      }
      CHECK(compared > 30);
    }
  }
}

TEST_CASE("a finer bound gives a finer mesh, and every number of vertices can be had") {
  for (const Sample& sample : samples()) {
    INFO(sample.name);
    const auto dataset = sample.open();
    std::size_t last = 0;
    for (double bound = 1; bound > 1e-4; bound /= 1.7) {
      Request request;
      request.field_error.push_back({"", {bound, true}});
      const Extraction extraction = dataset->extract(request);
      CHECK(extraction.mesh.tets.size() >= last);
      last = extraction.mesh.tets.size();
    }
    // Any number of vertices can be met exactly, and the tets that are then there are the budget for the same mesh.
    // The first dataset has read all there is, the second nothing.
    (void)dataset->extract({});
    for (std::uint64_t vertices = dataset->info().base_vertices; vertices <= dataset->info().vertices; vertices += 5) {
      Request request;
      request.max_vertices = vertices;
      const Extraction extraction = dataset->extract(request);
      CHECK(extraction.mesh.vertex_count() == vertices);
      CHECK(same(extraction, sample.open()->extract(request)));
      request.max_vertices.reset();
      request.max_tets = extraction.mesh.tets.size();
      CHECK(dataset->extract(request).mesh.tets.size() == extraction.mesh.tets.size());
    }
  }
}

TEST_CASE("errors given out are not below the field at vertices that were removed") {
  for (const Sample& sample : samples()) {
    INFO(sample.name);
    const auto dataset = sample.open();
    for (const double bound : {0.4, 0.1, 0.02}) {
      Request request;
      request.field_error.push_back({"pressure", {bound, true}});
      const Extraction cut = dataset->extract(request);
      const PointArray& original = sample.mesh.point_arrays[0];
      std::set<VertexId> there;
      for (const VertexId v : cut.vertex_in_file)
        there.insert(sample.to_original[v.index()]);
      double worst = 0;
      for (std::uint32_t v = 0; v < sample.mesh.vertex_count(); ++v) {
        if (there.count(VertexId{v}) != 0) continue;
        const Point p = sample.mesh.position(VertexId{v});
        // Overlaps of nothing but the boundary are left out: inside by a margin, in exactly one tet.
        for (const Tet& tet : cut.mesh.tets) {
          std::array<Point, 4> corners;
          for (std::size_t i = 0; i < 4; ++i)
            corners[i] = cut.mesh.position(tet[i]);
          double value = 0, whole = 0;
          bool inside = true;
          for (std::size_t i = 0; i < 4; ++i) {
            auto replaced = corners;
            replaced[i] = p;
            const TetMesh one = test::make_mesh({replaced[0], replaced[1], replaced[2], replaced[3]}, {{0, 1, 2, 3}},
                                                ScalarType::kFloat64);
            const double weight = test::examine(one).volume;
            inside = inside && weight > 0;
            value += weight * cut.mesh.point_arrays[0].value(tet[i].index(), 0);
            whole += weight;
          }
          if (inside) worst = std::max(worst, std::fabs(value / whole - original.value(v, 0)));
        }
      }
      CHECK(worst <= cut.field_error[0] + 1e-12);
    }
  }
}

TEST_CASE("many threads get what one gets") {
  const Sample& sample = samples().front();
  const auto reference = sample.open();
  std::vector<Request> requests;
  std::vector<Extraction> expected;
  RandomRequests random(reference->info(), 5);
  for (int i = 0; i < 24; ++i) {
    requests.push_back(random.request());
    expected.push_back(reference->extract(requests.back()));
  }
  for (int round = 0; round < 5; ++round) {
    const auto shared = sample.open();
    std::vector<char> right(requests.size(), 0);
    std::vector<std::thread> threads;
    for (std::size_t first = 0; first < 4; ++first)
      threads.emplace_back([&, first] {
        for (std::size_t i = first; i < requests.size(); i += 4)
          right[i] = same(shared->extract(requests[i]), expected[i]) ? 1 : 0;
      });
    for (std::thread& thread : threads)
      thread.join();
    CHECK(std::count(right.begin(), right.end(), 1) == static_cast<std::ptrdiff_t>(requests.size()));
  }
}

TEST_CASE("an extraction can be cancelled and then done") {
  const auto dataset = samples().front().open();
  CHECK_THROWS_AS(dataset->extract({}, [](const Progress&) { return false; }), Error);
  CHECK(dataset->extract({}).mesh.tets.size() == dataset->info().tets);
}
