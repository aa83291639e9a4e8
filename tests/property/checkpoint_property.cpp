// A build that is interrupted and goes on makes the same file as one that is not: wherever it is interrupted, whatever
// the method, and on any number of threads. What is of another build, or damaged, is refused.
#include "ptet/build.hpp"
#include "ptet/error.hpp"
#include "support/meshes.hpp"
#include "support/methods.hpp"
#include "support/temp_folder.hpp"
#ifdef PTET_TEST_WITH_VTK
#include "formats/vtk/read.hpp"
#endif

#include <algorithm>
#include <filesystem>
#include <set>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

using Bytes = std::vector<std::byte>;

BuildOptions with(Prediction prediction, Evaluation evaluation) {
  BuildOptions options;
  options.prediction = prediction;
  options.evaluation = evaluation;
  options.target_vertices = 0.05;
  return options;
}

/// Cancels at call number `last`; never when it is 0. `stage` is that of the last call.
struct Interrupter {
  int last = 0;
  int calls = 0;
  std::string stage;
  ProgressCallback callback() {
    return [this](const Progress& progress) {
      stage = progress.stage;
      return ++calls != last;
    };
  }
};

/// The build with a checkpoint at `path`, interrupted at call number `last`, if it comes to that; then nothing.
Bytes build_until(const TetMesh& mesh, const BuildOptions& options, int last, std::string* stage = nullptr,
                  BuildReport* report = nullptr) {
  Interrupter interrupter{last, 0, {}};
  try {
    Bytes bytes = build_memory(mesh, options, report, "mesh", "hash", interrupter.callback());
    REQUIRE(last == 0);
    return bytes;
  } catch (const Error& error) {
    REQUIRE(error.code() == ErrorCode::kCancelled);
    REQUIRE(last != 0);
  }
  if (stage != nullptr) *stage = interrupter.stage;
  return {};
}

int calls_of(const TetMesh& mesh, const BuildOptions& options) {
  Interrupter interrupter;
  static_cast<void>(build_memory(mesh, options, nullptr, "mesh", "hash", interrupter.callback()));
  return interrupter.calls;
}

/// Interrupted at about `points` places spread over the whole build, and gone on with from each on 1, 2 and 3 threads;
/// then interrupted again and again in one build. Returns the stages in which a checkpoint was left.
std::set<std::string> check_goes_on(const TetMesh& mesh, BuildOptions options, int points) {
  BuildReport whole_report;
  const Bytes whole = build_memory(mesh, options, &whole_report, "mesh", "hash");
  const int calls = calls_of(mesh, options);
  const test::TempFolder folder;
  options.checkpoint.path = folder / "build.ckpt";
  std::set<std::string> stages;
  const int step = std::max(1, calls / points);
  for (int last = 1; last <= calls; last += step) {
    INFO("interrupted at call " << last << " of " << calls);
    options.checkpoint.resume = false;
    options.threads = 2;
    std::string stage;
    static_cast<void>(build_until(mesh, options, last, &stage));
    if (!std::filesystem::exists(options.checkpoint.path)) continue; // before the first round was over
    stages.insert(stage);
    options.checkpoint.resume = true;
    options.threads = 1 + static_cast<unsigned>(last / step) % 3;
    BuildReport report;
    const Bytes resumed = build_until(mesh, options, 0, nullptr, &report);
    CHECK(resumed == whole);
    CHECK(report.resumed_records <= whole_report.records);
    CHECK(report.collapses == whole_report.collapses);
    CHECK(report.rounds == whole_report.rounds);
    CHECK(report.stopped_by == whole_report.stopped_by);
    CHECK(report.simulations == whole_report.simulations);
    CHECK(report.exact_evaluations == whole_report.exact_evaluations);
    CHECK(report.depth == whole_report.depth);
    CHECK(report.walk.size() == whole_report.walk.size());
    std::filesystem::remove(options.checkpoint.path);
  }
  // Now a build that never gets far at once.
  options.checkpoint.resume = false;
  Bytes bytes;
  for (int run = 0; bytes.empty() && run <= calls; ++run) {
    options.threads = 1 + static_cast<unsigned>(run) % 2;
    Interrupter interrupter{2 + calls / 4 + run, 0, {}};
    try {
      bytes = build_memory(mesh, options, nullptr, "mesh", "hash", interrupter.callback());
    } catch (const Error& error) {
      REQUIRE(error.code() == ErrorCode::kCancelled);
    }
    options.checkpoint.resume = std::filesystem::exists(options.checkpoint.path); // not before the first round was over
  }
  CHECK(bytes == whole);
  return stages;
}

/// Stops the build as early as it leaves a checkpoint.
void leave_checkpoint(const TetMesh& mesh, const BuildOptions& options) {
  for (int calls = 1; !std::filesystem::exists(options.checkpoint.path); ++calls) {
    REQUIRE(calls < 1000);
    static_cast<void>(build_until(mesh, options, calls));
  }
}

/// What is thrown, and its message.
std::pair<ErrorCode, std::string> refusal(const TetMesh& mesh, const BuildOptions& options) {
  try {
    static_cast<void>(build_memory(mesh, options, nullptr, "mesh", "hash"));
  } catch (const Error& error) {
    return {error.code(), error.what()};
  }
  FAIL("nothing was thrown");
  return {};
}

} // namespace

TEST_CASE("checkpoints: every method goes on as if nothing had been", "[checkpoint]") {
  const TetMesh mesh = test::grid({{4, 4, 3}, {}, 3, 4});
  for (const auto& [prediction, evaluation] : test::kMethods) {
    INFO(name_of(prediction) << ", " << name_of(evaluation));
    const auto stages = check_goes_on(mesh, with(prediction, evaluation), 3);
    CHECK(stages.count("collapsing") == 1);
  }
}

TEST_CASE("checkpoints: shapes with moving boundaries, limits, and builds that get stuck", "[checkpoint]") {
  for (const auto& [name, mesh] : test::sample_meshes(7)) {
    INFO(name);
    BuildOptions options = with(Prediction::kExact, Evaluation::kExact);
    options.target_vertices = 0;
    options.max_domain_error = {0.2, true};
    options.max_field_error = {{"pressure", {0.5, true}}};
    check_goes_on(mesh, options, 2);
  }
}

// What was measured before is remembered where errors have no limits, and not kept in a checkpoint.
TEST_CASE("checkpoints: what is remembered of measurements decides nothing", "[checkpoint]") {
  const TetMesh mesh = test::grid({{8, 8, 7}, [](int x, int y, int) { return x != 4 || y != 3; }, 3, 4});
  BuildOptions options = with(Prediction::kExact, Evaluation::kExact);
  options.target_vertices = 0;
  options.max_domain_error = {0.2, true};
  check_goes_on(mesh, options, 12);
}

TEST_CASE("checkpoints: within an evaluation after the collapses, and of records done before", "[checkpoint]") {
  // More records than one batch of the evaluation has.
  const TetMesh mesh = test::grid({{18, 18, 18}, {}, 2, 4});
  BuildOptions options = with(Prediction::kQuadric, Evaluation::kExact);
  options.fields = {"pressure"};
  options.target_vertices = 0.3;
  const Bytes whole = build_memory(mesh, options, nullptr, "mesh", "hash");
  const test::TempFolder folder;
  options.checkpoint.path = folder / "build.ckpt";
  int batches = 0;
  const auto second_batch = [&](const Progress& progress) {
    return progress.stage != "certifying errors" || ++batches != 2;
  };
  CHECK_THROWS_AS(build_memory(mesh, options, nullptr, "mesh", "hash", second_batch), Error);
  REQUIRE(batches == 2);
  options.checkpoint.resume = true;
  std::uint64_t first_done = 0;
  bool collapses = false;
  const auto watch = [&](const Progress& progress) {
    if (progress.stage == "certifying errors" && first_done == 0) first_done = progress.done;
    collapses |= progress.stage == "collapsing";
    return true;
  };
  CHECK(build_memory(mesh, options, nullptr, "mesh", "hash", watch) == whole);
  CHECK(first_done > 0);
  CHECK_FALSE(collapses);
}

TEST_CASE("checkpoints: written when it is time, and gone when the file is there", "[checkpoint]") {
  const TetMesh mesh = test::grid({{5, 5, 5}, {}, 3, 4});
  BuildOptions options = with(Prediction::kQuadric, Evaluation::kVertices);
  const test::TempFolder folder;
  const BuildReport plain = build_file(mesh, folder / "mesh.ptet", options);
  CHECK(plain.checkpoints == 0);
  const std::string expected = test::read_bytes(folder / "mesh.ptet");
  options.checkpoint.path = folder / "build.ckpt";
  options.checkpoint.every_seconds = 0;
  const BuildReport often = build_file(mesh, folder / "mesh.ptet", options);
  CHECK(often.checkpoints > often.rounds); // there are rounds that accept nothing
  CHECK(often.checkpoint_bytes > 100);
  options.checkpoint.every_seconds = 3600;
  const BuildReport seldom = build_file(mesh, folder / "mesh.ptet", options);
  CHECK(seldom.checkpoints == 1);
  CHECK(test::read_bytes(folder / "mesh.ptet") == expected);
  CHECK(folder.names() == std::vector<std::string>{"mesh.ptet"});
}

TEST_CASE("checkpoints: one that cannot be written does not end a build", "[checkpoint]") {
  const TetMesh mesh = test::grid({{5, 5, 5}, {}, 3, 4});
  BuildOptions options = with(Prediction::kQuadric, Evaluation::kVertices);
  const test::TempFolder folder;
  (void)build_file(mesh, folder / "mesh.ptet", options);
  const std::string expected = test::read_bytes(folder / "mesh.ptet");
  const std::filesystem::path place = folder / "place";
  options.checkpoint.path = (place / "build.ckpt").string();
  options.checkpoint.every_seconds = 0;
  CHECK(refusal(mesh, options).first == ErrorCode::kIo); // nor can any be: said at once
  for (const int gone_at : {1, 4}) {
    std::filesystem::create_directory(place);
    int calls = 0;
    const BuildReport report = build_file(mesh, folder / "mesh.ptet", options, {}, {}, [&](const Progress& progress) {
      if (progress.stage == std::string_view("collapsing") && ++calls == gone_at) std::filesystem::remove_all(place);
      return true;
    });
    CHECK(report.checkpoints_failed > 10);
    CHECK_THAT(report.checkpoint_failure, Catch::Contains("build.ckpt"));
    CHECK(report.notes.size() == 0);
    CHECK(test::read_bytes(folder / "mesh.ptet") == expected);
    CHECK(folder.names() == std::vector<std::string>{"mesh.ptet"});
  }
  // One that is stopped depends on it.
  std::filesystem::create_directory(place);
  const auto stop = [&](const Progress& progress) {
    if (progress.stage != std::string_view("collapsing")) return true;
    std::filesystem::remove_all(place);
    return false;
  };
  try {
    (void)build_file(mesh, folder / "mesh.ptet", options, {}, {}, stop);
    FAIL("nothing was thrown");
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::kIo);
  }
}

TEST_CASE("checkpoints: of another build they are refused, and say why", "[checkpoint]") {
  const TetMesh mesh = test::grid({{5, 5, 5}, {}, 3, 4});
  BuildOptions options = with(Prediction::kQuadric, Evaluation::kVertices);
  const test::TempFolder folder;
  options.checkpoint.path = folder / "build.ckpt";
  options.checkpoint.resume = true;
  CHECK(refusal(mesh, options).first == ErrorCode::kIo); // there is none
  options.checkpoint.resume = false;
  leave_checkpoint(mesh, options);
  CHECK(refusal(mesh, options).first == ErrorCode::kBadArgument); // there is one already
  options.checkpoint.resume = true;

  const auto refused = [&](const TetMesh& other, const std::function<void(BuildOptions&)>& change, const char* why) {
    BuildOptions changed = options;
    change(changed);
    const auto [code, message] = refusal(other, changed);
    INFO(message);
    return code == ErrorCode::kBadArgument && message.find(why) != std::string::npos;
  };
  CHECK(refused(
      mesh, [](BuildOptions& o) { o.max_star = 32; }, "max-star 64; here it is 32"));
  CHECK(refused(
      mesh, [](BuildOptions& o) { o.fields = {"flow"}; }, "field pressure, flow; here it is flow"));
  CHECK(refused(
      mesh, [](BuildOptions& o) { o.prediction = Prediction::kLocal; }, "predict"));
  CHECK(refused(
      mesh, [](BuildOptions& o) { o.round_fraction = 0.2; }, "round-fraction"));
  CHECK(refused(
      mesh,
      [](BuildOptions& o) {
        o.max_field_error = {{"", {0.5, true}}};
      },
      "max-field-error none"));
  TetMesh moved = mesh;
  moved.positions.bytes[5] ^= std::byte{1};
  CHECK(refused(
      moved, [](BuildOptions&) {}, "another mesh"));
  TetMesh renamed = mesh;
  renamed.point_arrays[2].name += "2";
  CHECK(refused(
      renamed, [](BuildOptions&) {}, "another mesh"));
  TetMesh fewer = mesh;
  fewer.tets.pop_back();
  CHECK(refused(
      fewer, [](BuildOptions&) {}, "another mesh"));
  // Threads, and how often checkpoints are written, are nobody's business.
  options.threads = 3;
  options.checkpoint.every_seconds = 1;
  CHECK_FALSE(build_memory(mesh, options, nullptr, "mesh", "hash").empty());
}

TEST_CASE("checkpoints: cut short or damaged anywhere they are refused", "[checkpoint]") {
  const TetMesh mesh = test::two_tets_sharing_a_face();
  const TetMesh larger = test::grid({{3, 3, 3}, {}, 2, 1});
  BuildOptions options = with(Prediction::kExact, Evaluation::kExact);
  const test::TempFolder folder;
  options.checkpoint.path = folder / "build.ckpt";
  leave_checkpoint(larger, options);
  const std::string good = test::read_bytes(options.checkpoint.path);
  REQUIRE(good.size() > 1000);
  options.checkpoint.resume = true;
  CHECK(refusal(mesh, options).first == ErrorCode::kBadArgument);
  const auto code_with = [&](const std::string& bytes) {
    test::write_bytes(options.checkpoint.path, bytes);
    return refusal(larger, options).first;
  };
  for (std::size_t length = 0; length < good.size(); length += 1 + length / 16)
    if (code_with(good.substr(0, length)) != ErrorCode::kCorruptFile) FAIL("length " << length);
  CHECK(code_with(good + "x") == ErrorCode::kCorruptFile);
  for (std::size_t at = 0; at < good.size(); at += 1 + at / 16) {
    std::string damaged = good;
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << (at % 8)));
    if (code_with(damaged) != ErrorCode::kCorruptFile) FAIL("byte " << at);
  }
  CHECK(code_with("what somebody wrote by hand, long enough for a header") == ErrorCode::kCorruptFile);
}

#ifdef PTET_TEST_WITH_VTK
TEST_CASE("checkpoints: a real mesh goes on as if nothing had been", "[checkpoint][data]") {
  const auto path = test::data_file("fea_bracket.vtu");
  if (!path) {
    WARN("skipped: no fea_bracket.vtu in " << test::data_dir() << " (set PTET_DATA)");
    return;
  }
  BuildOptions options = with(Prediction::kQuadric, Evaluation::kVertices);
  options.target_vertices = 0.6; // the rest is the same again
  check_goes_on(read_mesh(*path), options, 1);
}
#endif
