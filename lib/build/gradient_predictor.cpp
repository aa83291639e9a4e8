#include "build/gradient_predictor.hpp"

#include "build/collapse_geometry.hpp"
#include "mesh/shape.hpp"

#include <cmath>

namespace ptet::build {
using namespace vec;

double solid_angle(const Point& apex, const Point& a, const Point& b, const Point& c) {
  const Vec3 u = a - apex;
  const Vec3 v = b - apex;
  const Vec3 w = c - apex;
  const double nu = norm(u);
  const double nv = norm(v);
  const double nw = norm(w);
  const double volume = std::abs(dot(u, cross(v, w)));
  return 2 * std::atan2(volume, nu * nv * nw + dot(u, v) * nw + dot(v, w) * nu + dot(w, u) * nv);
}

std::vector<Vec3> vertex_gradients(const WorkingComplex& complex, const std::vector<Point>& positions,
                                   const NormalizedFields& fields, double diagonal) {
  const std::size_t channels = fields.channel_count();
  std::vector<Vec3> gradients(complex.vertex_count() * channels);
  std::vector<double> angles(complex.vertex_count());
  for (SlotId s = 0; s < complex.slot_count(); ++s) {
    const Slot& slot = complex.slot(s);
    if (complex.is_ghost(slot)) continue;
    const std::array<Point, 4> tet = corner_points(slot.v, positions);
    std::array<Vec3, 3> basis{};
    const double scale = 1 / diagonal;
    if (!has_gradient(scale * (tet[1] - tet[0]), scale * (tet[2] - tet[0]), scale * (tet[3] - tet[0])) ||
        !barycentric_gradients(tet, basis))
      continue;
    std::array<double, 4> angle{};
    for (std::size_t i = 0; i < 4; ++i) {
      angle[i] = solid_angle(tet[i], tet[(i + 1) % 4], tet[(i + 2) % 4], tet[(i + 3) % 4]);
      angles[slot.v[i]] += angle[i];
    }
    const double* const f = fields.at(slot.v[0]);
    for (std::size_t c = 0; c < channels; ++c) {
      Vec3 gradient{};
      for (std::size_t i = 0; i < 3; ++i)
        gradient = gradient + diagonal * (fields.at(slot.v[i + 1])[c] - f[c]) * basis[i];
      for (std::size_t i = 0; i < 4; ++i) {
        Vec3& sum = gradients[slot.v[i] * channels + c];
        sum = sum + angle[i] * gradient;
      }
    }
  }
  for (Vertex v = 0; v < complex.vertex_count(); ++v)
    for (std::size_t c = 0; c < channels && angles[v] > 0; ++c)
      gradients[v * channels + c] = (1 / angles[v]) * gradients[v * channels + c];
  return gradients;
}

void gradient_differences(const NormalizedFields& fields, const std::vector<Vec3>& gradients, Vertex vs, Vertex vd,
                          const Vec3& edge, std::span<double> differences) {
  const std::size_t channels = fields.channel_count();
  double sum_sq = 0;
  for (std::size_t c = 0; c < channels; ++c) {
    const double difference = dot(edge, gradients[vs * channels + c] - gradients[vd * channels + c]);
    sum_sq += difference * difference;
    if (!fields.ends_field(c)) continue;
    differences[fields.field_of(c)] = std::sqrt(sum_sq);
    sum_sq = 0;
  }
}

GradientPredictor::GradientPredictor(const WorkingComplex& complex, const std::vector<Point>& positions,
                                     const NormalizedFields& fields, double diagonal, std::vector<double> field_weight,
                                     double domain_weight)
    : AccumulatingPredictor(complex, positions, fields, diagonal, std::move(field_weight), domain_weight),
      gradients_(vertex_gradients(complex, positions, fields, diagonal)) {}

void GradientPredictor::added_field_errors(Vertex vs, Vertex vd, std::span<double> errors) const {
  gradient_differences(fields(), gradients_, vs, vd, inverse_diagonal() * (positions()[vd] - positions()[vs]), errors);
}

} // namespace ptet::build
