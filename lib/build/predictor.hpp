// What a half-edge collapse is expected to cost, told without looking at what it would do to the rest of the data.
#pragma once

#include "build/working_complex.hpp"

#include <span>

namespace ptet::build {

class Predictor {
public:
  Predictor() = default;
  virtual ~Predictor() = default;
  Predictor(const Predictor&) = delete;
  Predictor& operator=(const Predictor&) = delete;

  /// Costs of vs -> targets[i], one each; comparable with one another only. `targets` are neighbours of `vs`.
  /// Thread rule: called from several threads at once between collapses; keeps no state between calls.
  virtual void costs(Vertex vs, std::span<const Vertex> targets, std::span<float> costs) const = 0;

  /// vs -> vd is about to happen; `deleted` and `modified` are the slots around vs, ghosts included. Called before the
  /// complex changes, one collapse at a time.
  virtual void collapse(Vertex vs, Vertex vd, std::span<const SlotId> deleted, std::span<const SlotId> modified) = 0;

  /// The errors that the predictor believes vs -> vd to have: one a field as fractions of its range. What is recorded
  /// where no error is measured. Called before collapse(). Thread rule: as costs().
  virtual void field_errors(Vertex vs, Vertex vd, std::span<double> errors) const = 0;
  /// Likewise of the domain, as a fraction of the diagonal; 0 inside it. Thread rule: as costs().
  [[nodiscard]] virtual double domain_error(Vertex vs, Vertex vd) const = 0;
};

} // namespace ptet::build
