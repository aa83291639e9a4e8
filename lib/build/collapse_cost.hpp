// What a simulated or measured collapse costs: the growing square of the error space.
//
// Every kind of error is divided by its threshold, and the greatest counts: collapses are taken as if a square (a box,
// with k fields) grew from the origin of the error space, until one of its faces stands at its threshold.
//
//      field error ^          . corner: the thresholds
//                  |   ______.
//                  |  |      |      cost = max(w_f e_f, w_d e_d)
//                  |__|______|___> domain error
//
// Source: Cignoni et al. 2000, section 4.3. The mean square joins the field's axis: where both count, that axis is the
// root of the sum of their squares, and the corner between them is round. Of two collapses with the same maximum the
// one that harms fewer points goes first, which a corner does not see.
#pragma once

#include "ptet/build.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

namespace ptet::build {

class CollapseCost {
public:
  /// `field_weight`: one a field, of errors as fractions of its range. `deviation`: one a field, its standard deviation
  /// as a fraction of its range; > 0. `domain_weight`: of errors in mesh units.
  CollapseCost(Objective objective, std::vector<double> field_weight, std::span<const double> deviation,
               double domain_weight)
      : maximum_(objective == Objective::kRootMeanSquare ? 0.0 : 1.0),
        domain_((objective == Objective::kRootMeanSquare ? kDomainBesideMean : 1.0) * domain_weight),
        bent_(objective == Objective::kBoth), field_weight_(std::move(field_weight)) {
    for (std::size_t f = 0; f < field_weight_.size(); ++f) {
      const double mean = objective == Objective::kMaximum ? 0.0
                          : bent_                          ? kMeanInBoth / of_root(deviation[f])
                                                           : kMeanAlone;
      mean_weight_.push_back(mean * field_weight_[f]);
    }
  }

  [[nodiscard]] const std::vector<double>& field_weight() const { return field_weight_; }

  /// The part of the greatest errors, one a field.
  [[nodiscard]] double of_maximum(std::span<const double> errors) const {
    if (maximum_ == 0) return 0; // errors may be infinite
    double worst = 0;
    for (std::size_t f = 0; f < errors.size(); ++f)
      worst = std::max(worst, field_weight_[f] * errors[f]);
    return maximum_ * worst;
  }
  /// The error of field `f` at which it alone costs `cost`.
  [[nodiscard]] double error_at(double cost, std::size_t f) const {
    const double weight = maximum_ * field_weight_[f];
    return weight > 0 ? cost / weight : std::numeric_limits<double>::infinity();
  }
  /// The part of the mean square: `growth` is that of the integral of the squared error, in volumes of an average
  /// vertex, so that its root is an error again.
  [[nodiscard]] double of_mean(std::span<const double> growth) const {
    double worst = 0;
    for (std::size_t f = 0; f < growth.size(); ++f)
      worst = std::max(worst, mean_weight_[f] * of_root(std::sqrt(std::max(0.0, growth[f]))));
    return worst;
  }
  /// What both parts cost together; not less than either.
  [[nodiscard]] static double of_field(double maximum, double mean) {
    return mean == 0 ? maximum : std::sqrt(maximum * maximum + mean * mean);
  }
  /// The part of the domain error, mesh units.
  [[nodiscard]] double of_domain(double error) const { return domain_ * error; }
  /// The domain error that alone costs `cost`.
  [[nodiscard]] double domain_error_at(double cost) const {
    return domain_ > 0 ? cost / domain_ : std::numeric_limits<double>::infinity();
  }

private:
  /// Beside the maximum the mean square counts with the power 3/4 of its root: while errors are small there is room for
  /// the maximum, and where they are large none is left. A straight line with the same maximum leaves a mean square
  /// that is 6% larger.
  [[nodiscard]] double of_root(double root) const { return bent_ ? std::sqrt(root * std::sqrt(root)) : root; }

  /// Less holds the maximum down and lets the mean square go. Beside the maximum, which is a fraction of the range,
  /// the mean square counts as one of the standard deviation: a field that is even nearly everywhere, with its range in
  /// a few small places, has small mean squares as fractions of the range, and they would go unseen.
  static constexpr double kMeanInBoth = 0.155;
  /// Only what the mean square weighs against the domain error.
  static constexpr double kMeanAlone = 16;
  /// At 1 the mean square is 2% more, and the domain error .6 times as large.
  static constexpr double kDomainBesideMean = 1.0 / 3;

  double maximum_;
  double domain_;
  bool bent_;
  std::vector<double> field_weight_;
  std::vector<double> mean_weight_;
};

} // namespace ptet::build
