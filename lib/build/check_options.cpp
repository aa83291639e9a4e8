#include "build/builder.hpp"
#include "build/describe_options.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <cmath>

namespace ptet::build {
namespace {

/// Of an enumeration that counts from 0: a cast can make any value.
template <class Enum>
bool is_one_of(Enum value, Enum last) {
  return static_cast<int>(value) >= 0 && value <= last;
}

} // namespace

void check_options(const BuildOptions& options) {
  const auto require = [](bool good, const char* what) {
    if (!good) throw Error(ErrorCode::kBadArgument, what);
  };
  require(is_one_of(options.prediction, Prediction::kExact), "there is no such prediction");
  require(is_one_of(options.evaluation, Evaluation::kExact), "there is no such evaluation");
  require(is_one_of(options.objective, Objective::kBoth), "there is no such objective");
  require(options.target_vertices >= 0 && std::isfinite(options.target_vertices),
          "the target number of vertices must be a number >= 0");
  const double min_quality = options.min_quality.value_or(0);
  require(min_quality >= 0 && min_quality < 1, "the least quality must be in [0, 1)");
  require(options.max_star >= kLeastMaxStar && options.max_star <= kGreatestMaxStar,
          "the cap on the star must be in 8 .. 4096");
  require(options.round_fraction > 0 && options.round_fraction <= 1, "the part taken in a round must be in (0, 1]");
  require(options.prediction != Prediction::kExact || options.evaluation == Evaluation::kExact,
          "a prediction that measures everywhere goes with an evaluation that does");
  require(options.prediction != Prediction::kSimulate || options.evaluation != Evaluation::kNone,
          "what is simulated is seen at removed vertices at least: an evaluation is needed");
  require(options.checkpoint.every_seconds >= 0, "the seconds between checkpoints must be a number >= 0");
  require(options.max_domain_error.value >= 0, "the limit on domain error must be a number >= 0");
  require(std::all_of(options.max_field_error.begin(), options.max_field_error.end(),
                      [](const FieldBound& bound) { return bound.bound.value >= 0; }),
          "a field error limit must be a number >= 0");
  require(!options.weld || (options.weld->value >= 0 && std::isfinite(options.weld->value)),
          "the distance within which points are welded must be a number >= 0");
  require(options.pieces >= 1 && options.pieces <= kMostPieces, "the number of pieces must be in 1 .. 65536");
  require(options.pieces == 1 || options.checkpoint.path.empty(), "a build over pieces keeps no checkpoints");
}

} // namespace ptet::build
