#include "build/local_predictor.hpp"

#include "build/collapse_geometry.hpp"

namespace ptet::build {

LocalPredictor::LocalPredictor(const WorkingComplex& complex, const std::vector<Point>& positions,
                               const NormalizedFields& fields, double diagonal, std::vector<double> field_weight,
                               double domain_weight)
    : AccumulatingPredictor(complex, positions, fields, diagonal, std::move(field_weight), domain_weight) {}

void LocalPredictor::added_field_errors(Vertex vs, Vertex vd, std::span<double> errors) const {
  const Place place = place_after_collapse(complex(), positions(), vs, vd);
  for_each_field_difference(fields(), vs, place.corners, place.weight,
                            [&](std::size_t f, double difference) { errors[f] = difference; });
}

} // namespace ptet::build
