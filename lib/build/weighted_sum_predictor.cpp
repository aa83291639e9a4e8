#include "build/weighted_sum_predictor.hpp"

#include "build/collapse_geometry.hpp"

#include <algorithm>
#include <cmath>

namespace ptet::build {
using namespace vec;
namespace {

/// The mean volume of the tets to the power 2/3; 1 if they have none.
double mean_face_area(const WorkingComplex& complex, const std::vector<Point>& positions, const MeshScales* whole) {
  if (whole != nullptr) return whole->volume > 0 ? std::pow(whole->volume / whole->tet_count, 2.0 / 3) : 1;
  double volume = 0;
  std::size_t tets = 0;
  for (SlotId s = 0; s < complex.slot_count(); ++s)
    if (!complex.is_ghost(complex.slot(s))) {
      volume += tet_volume(corner_points(complex.slot(s).v, positions));
      ++tets;
    }
  return volume > 0 ? std::pow(volume / static_cast<double>(tets), 2.0 / 3) : 1;
}

} // namespace

WeightedSumPredictor::WeightedSumPredictor(const WorkingComplex& complex, const std::vector<Point>& positions,
                                           const NormalizedFields& fields, double diagonal,
                                           std::vector<double> field_weight, double domain_weight,
                                           const Weights& weights, const MeshScales* whole)
    : complex_(complex), positions_(positions), fields_(fields), inverse_diagonal_(1 / diagonal),
      field_weight_(std::move(field_weight)), domain_weight_(domain_weight), weights_(weights),
      face_area_(mean_face_area(complex, positions, whole)) {}

void WeightedSumPredictor::field_errors(Vertex vs, Vertex vd, std::span<double> errors) const {
  for_each_field_difference(fields_, vs, {vd, vd, vd, vd}, {1, 0, 0, 0},
                            [&](std::size_t f, double difference) { errors[f] = difference; });
}

double WeightedSumPredictor::domain_error(Vertex vs, Vertex vd) const {
  if (!is_on_boundary(complex_, vs)) return 0;
  return inverse_diagonal_ * distance_to_modified_faces(complex_, positions_, vs, vd);
}

double WeightedSumPredictor::volume_term(Vertex vs, Vertex vd) const {
  if (!is_on_boundary(complex_, vs)) return 0;
  return inverse_diagonal_ * std::abs(volume_added(complex_, positions_, vs, vd)) / face_area_;
}

double WeightedSumPredictor::edge_length_term(Vertex vs, Vertex vd) const {
  // An edge counts once for each tet that it belongs to.
  thread_local std::vector<double> lengths;
  lengths.clear();
  double sum = 0;
  for_each_modified_tet(complex_, vs, vd, [&](SlotId, const std::array<Vertex, 4>& corners) {
    for (const Vertex x : corners)
      if (x != vd) {
        lengths.push_back(norm(positions_[x] - positions_[vd]));
        sum += lengths.back();
      }
  });
  if (lengths.empty()) return 0;
  const double mean = sum / static_cast<double>(lengths.size());
  double deviation = 0;
  for (const double length : lengths)
    deviation += std::abs(length - mean);
  return inverse_diagonal_ * deviation / static_cast<double>(lengths.size());
}

void WeightedSumPredictor::costs(Vertex vs, std::span<const Vertex> targets, std::span<float> costs) const {
  thread_local std::vector<double> errors;
  errors.resize(fields_.field_count());
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const Vertex vd = targets[i];
    field_errors(vs, vd, errors);
    double gradient = 0;
    for (std::size_t f = 0; f < errors.size(); ++f)
      gradient = std::max(gradient, field_weight_[f] * errors[f]);
    costs[i] =
        static_cast<float>(weights_.gradient * gradient + weights_.volume * domain_weight_ * volume_term(vs, vd) +
                           weights_.edge_length * edge_length_term(vs, vd));
  }
}

void WeightedSumPredictor::collapse(Vertex /*vs*/, Vertex /*vd*/, std::span<const SlotId> /*deleted*/,
                                    std::span<const SlotId> /*modified*/) {}

} // namespace ptet::build
