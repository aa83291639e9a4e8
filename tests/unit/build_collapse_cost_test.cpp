// The growing square over measured errors, and its round corner, by hand.
#include "build/collapse_cost.hpp"

#include <limits>
#include <vector>

#include <catch2/catch.hpp>

using namespace ptet;
using build::CollapseCost;

namespace {

const std::vector<double> kDeviations{0.25, 0.04};

} // namespace

TEST_CASE("collapse cost: the greatest of the weighted maxima counts", "[build][cost]") {
  const CollapseCost cost(Objective::kMaximum, {2, 0.5}, kDeviations, 4);
  CHECK(cost.of_maximum(std::vector<double>{0.1, 0.3}) == 0.2);
  CHECK(cost.of_maximum(std::vector<double>{0.1, 0.8}) == 0.4);
  CHECK(cost.of_maximum(std::vector<double>{0, 0}) == 0);
  CHECK(cost.of_mean(std::vector<double>{0.25, 4}) == 0);
}

TEST_CASE("collapse cost: the root of the mean square's growth is an error, and what falls costs nothing",
          "[build][cost]") {
  const CollapseCost cost(Objective::kRootMeanSquare, {2, 0.5}, kDeviations, 4);
  CHECK(cost.of_mean(std::vector<double>{0.25, 0}) == 16);
  CHECK(cost.of_mean(std::vector<double>{0.25, 16}) == 32);
  CHECK(cost.of_mean(std::vector<double>{-9, 0}) == 0);
  CHECK(cost.of_mean(std::vector<double>{-9, 4}) == 16);
  CHECK(cost.of_maximum(std::vector<double>{0.1, 0.3}) == 0);
}

TEST_CASE("collapse cost: both axes grow with either kind of error", "[build][cost]") {
  const CollapseCost cost(Objective::kBoth, {3}, kDeviations, 4);
  CHECK(cost.of_maximum(std::vector<double>{0.5}) == 1.5);
  const double once = cost.of_mean(std::vector<double>{0.25});
  CHECK(once > 0);
  // With the power 3/4 of the error, which is the root of what is given.
  CHECK(cost.of_mean(std::vector<double>{0.25 * 256}) == Approx(8 * once));
  CHECK(CollapseCost(Objective::kBoth, {6}, kDeviations, 4).of_mean(std::vector<double>{0.25}) == Approx(2 * once));
}

TEST_CASE("collapse cost: beside the maximum the mean square counts as a fraction of the standard deviation",
          "[build][cost]") {
  const std::vector<double> even{0.25}, uneven{0.25 / 16};
  const std::vector<double> growth{0.01};
  const double once = CollapseCost(Objective::kBoth, {1}, even, 0).of_mean(growth);
  CHECK(CollapseCost(Objective::kBoth, {1}, uneven, 0).of_mean(growth) == Approx(8 * once));
  for (const Objective alone : {Objective::kRootMeanSquare, Objective::kMaximum})
    CHECK(CollapseCost(alone, {1}, even, 0).of_mean(growth) == CollapseCost(alone, {1}, uneven, 0).of_mean(growth));
  CHECK(CollapseCost(Objective::kBoth, {1}, uneven, 0).of_maximum(growth) == 0.01);
}

TEST_CASE("collapse cost: the maximum and the mean square together are the root of the sum of their squares",
          "[build][cost]") {
  CHECK(CollapseCost::of_field(3, 4) == 5);
  CHECK(CollapseCost::of_field(0.1, 0) == 0.1);
  CHECK(CollapseCost::of_field(0, 0.1) == 0.1);
  const double infinite = std::numeric_limits<double>::infinity();
  CHECK(CollapseCost::of_field(infinite, 4) == infinite);
}

TEST_CASE("collapse cost: without fields there is none", "[build][cost]") {
  const CollapseCost cost(Objective::kBoth, {}, {}, 0);
  CHECK(cost.of_maximum({}) == 0);
  CHECK(cost.of_mean({}) == 0);
}

TEST_CASE("collapse cost: a domain error costs what it weighs, less beside the mean square alone", "[build][cost]") {
  for (const Objective objective : {Objective::kMaximum, Objective::kBoth}) {
    const CollapseCost cost(objective, {1}, kDeviations, 4);
    CHECK(cost.of_domain(0.5) == 2);
    CHECK(cost.domain_error_at(2) == 0.5);
  }
  const CollapseCost alone(Objective::kRootMeanSquare, {1}, kDeviations, 4);
  CHECK(alone.of_domain(0.5) == Approx(2.0 / 3));
  CHECK(alone.domain_error_at(alone.of_domain(0.5)) == Approx(0.5));
  const CollapseCost none(Objective::kBoth, {1}, kDeviations, 0);
  CHECK(none.of_domain(0.5) == 0);
  CHECK(none.domain_error_at(2) == std::numeric_limits<double>::infinity());
}
