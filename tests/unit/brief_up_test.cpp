// Bounds in few digits: not below the bound, and no more above it than the last digit counts.
#include "tools/brief_up.hpp"

#include <cmath>
#include <limits>
#include <random>

#include <catch2/catch.hpp>

using ptet::brief_up;

TEST_CASE("a bound is shown rounded up") {
  CHECK(brief_up(0) == "0");
  CHECK(brief_up(1.0124, 3) == "1.02");
  CHECK(brief_up(1.02, 3) == "1.02");
  CHECK(brief_up(0.0302149) == "0.03022");
  CHECK(brief_up(9.9991, 3) == "10");
  CHECK(brief_up(999.2, 3) == "1e+03");
  CHECK(brief_up(129.71) == "129.8");
  CHECK(brief_up(123456) == "1.235e+05");
  CHECK(brief_up(3.1e-7, 1) == "4e-07");
  CHECK(brief_up(2.0000000000000004, 3) == "2"); // rounding of a quotient
  CHECK(brief_up(std::numeric_limits<double>::infinity()) == "inf");
}

TEST_CASE("shown bounds are bounds, and close") {
  std::mt19937 random(1);
  for (int i = 0; i < 20000; ++i) {
    const double bound =
        static_cast<double>(1 + random() % 1000000) * std::pow(10.0, static_cast<int>(random() % 40) - 25);
    const double shown = std::stod(brief_up(bound, 3));
    if (!(shown >= bound * (1 - 1e-12) && shown <= bound * 1.0101)) FAIL(bound << " is shown as " << shown);
  }
}
