// Options of a build that are out of their ranges are refused by name, before anything is done.
#include "ptet/build.hpp"
#include "ptet/error.hpp"
#include "support/meshes.hpp"

#include <functional>
#include <limits>
#include <string>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

/// What is said of the default options with a change; empty where they are taken.
std::string refusal(const std::function<void(BuildOptions&)>& change) {
  BuildOptions options;
  options.target_vertices = 0.5;
  options.threads = 1;
  change(options);
  try {
    (void)build_memory(test::grid({}), options);
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::kBadArgument);
    return error.what();
  }
  return {};
}

} // namespace

TEST_CASE("options: those out of range are refused, their limits are not", "[build]") {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInfinity = std::numeric_limits<double>::infinity();
  using Catch::Contains;
  CHECK(refusal([](BuildOptions&) {}).empty());

  for (const int beyond : {-1, 7, 1 << 20}) {
    INFO(beyond);
    CHECK_THAT(refusal([&](BuildOptions& o) { o.prediction = static_cast<Prediction>(beyond); }),
               Contains("no such prediction"));
    CHECK_THAT(refusal([&](BuildOptions& o) { o.evaluation = static_cast<Evaluation>(beyond); }),
               Contains("no such evaluation"));
    CHECK_THAT(refusal([&](BuildOptions& o) { o.objective = static_cast<Objective>(beyond); }),
               Contains("no such objective"));
  }
  CHECK_THAT(refusal([](BuildOptions& o) { o.evaluation = static_cast<Evaluation>(4); }),
             Contains("no such evaluation"));
  CHECK_THAT(refusal([](BuildOptions& o) { o.objective = static_cast<Objective>(3); }), Contains("no such objective"));
  CHECK_THAT(refusal([](BuildOptions& o) { o.evaluation = Evaluation::kSamples; }), Contains("measures everywhere"));
  CHECK_THAT(refusal([](BuildOptions& o) {
               o.prediction = Prediction::kSimulate;
               o.evaluation = Evaluation::kNone;
             }),
             Contains("an evaluation is needed"));

  for (const double target : {-1.0, kNan, kInfinity})
    CHECK_THAT(refusal([&](BuildOptions& o) { o.target_vertices = target; }), Contains("target number of vertices"));
  for (const double quality : {-0.1, 1.0, kNan})
    CHECK_THAT(refusal([&](BuildOptions& o) { o.min_quality = quality; }), Contains("[0, 1)"));
  for (const std::uint32_t star : {0U, kLeastMaxStar - 1, kGreatestMaxStar + 1})
    CHECK_THAT(refusal([&](BuildOptions& o) { o.max_star = star; }), Contains("8 .. 4096"));
  for (const double part : {0.0, -0.5, 1.5, kNan})
    CHECK_THAT(refusal([&](BuildOptions& o) { o.round_fraction = part; }), Contains("(0, 1]"));
  for (const double limit : {-1.0, kNan}) {
    CHECK_THAT(refusal([&](BuildOptions& o) { o.max_domain_error = {limit, true}; }), Contains("domain error"));
    CHECK_THAT(refusal([&](BuildOptions& o) { o.max_field_error = {{"", {limit, true}}}; }), Contains("field error"));
  }
  for (const std::uint32_t pieces : {0U, kMostPieces + 1})
    CHECK_THAT(refusal([&](BuildOptions& o) { o.pieces = pieces; }), Contains("1 .. 65536"));

  CHECK(refusal([](BuildOptions& o) { o.max_star = kLeastMaxStar; }).empty());
  CHECK(refusal([](BuildOptions& o) { o.max_star = kGreatestMaxStar; }).empty());
  CHECK(refusal([](BuildOptions& o) { o.round_fraction = 1; }).empty());
  CHECK(refusal([](BuildOptions& o) { o.min_quality = 0; }).empty());
  CHECK(refusal([](BuildOptions& o) { o.max_domain_error = {kInfinity, false}; }).empty());
}
