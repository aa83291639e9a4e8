#include "build/accumulating_predictor.hpp"

#include "build/collapse_geometry.hpp"

#include <algorithm>

namespace ptet::build {
using namespace vec;

AccumulatingPredictor::AccumulatingPredictor(const WorkingComplex& complex, const std::vector<Point>& positions,
                                             const NormalizedFields& fields, double diagonal,
                                             std::vector<double> field_weight, double domain_weight)
    : complex_(complex), positions_(positions), fields_(fields), inverse_diagonal_(1 / diagonal),
      field_weight_(std::move(field_weight)), domain_weight_(domain_weight),
      field_error_(complex.vertex_count() * fields.field_count()), domain_error_(complex.vertex_count()) {}

void AccumulatingPredictor::costs(Vertex vs, std::span<const Vertex> targets, std::span<float> costs) const {
  thread_local std::vector<double> errors;
  errors.resize(fields_.field_count());
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const Vertex vd = targets[i];
    field_errors(vs, vd, errors);
    double cost = domain_weight_ * domain_error(vs, vd);
    for (std::size_t f = 0; f < errors.size(); ++f)
      cost = std::max(cost, field_weight_[f] * errors[f]);
    costs[i] = static_cast<float>(cost + kEdgeLengthWeight * inverse_diagonal_ * norm(positions_[vd] - positions_[vs]));
  }
}

void AccumulatingPredictor::field_errors(Vertex vs, Vertex vd, std::span<double> errors) const {
  added_field_errors(vs, vd, errors);
  for (std::size_t f = 0; f < errors.size(); ++f)
    errors[f] += field_error_[vs * errors.size() + f];
}

double AccumulatingPredictor::domain_error(Vertex vs, Vertex vd) const {
  if (!is_on_boundary(complex_, vs)) return 0;
  return domain_error_[vs] + inverse_diagonal_ * distance_to_modified_faces(complex_, positions_, vs, vd);
}

void AccumulatingPredictor::collapse(Vertex vs, Vertex vd, std::span<const SlotId> /*deleted*/,
                                     std::span<const SlotId> /*modified*/) {
  std::vector<double> errors(fields_.field_count());
  field_errors(vs, vd, errors);
  for_each_modified_tet(complex_, vs, vd, [&](SlotId, const std::array<Vertex, 4>& corners) {
    for (const Vertex x : corners)
      for (std::size_t f = 0; f < errors.size(); ++f) {
        double& error = field_error_[x * errors.size() + f];
        error = std::max(error, errors[f]);
      }
  });
  const double of_domain = domain_error(vs, vd);
  for_each_modified_face(complex_, vs, vd, [&](SlotId, const std::array<Vertex, 3>& corners) {
    for (const Vertex x : corners)
      domain_error_[x] = std::max(domain_error_[x], of_domain);
  });
}

} // namespace ptet::build
