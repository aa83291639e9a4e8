// Predicted cost of a half-edge collapse by the difference of gradients (the paper's GN): where the field changes in
// the same way at both ends of an edge, vs can be told from its surroundings.
//
//     error added by vs -> vd  =  |(gradient(vs) - gradient(vd)) . (vd - vs)|
//
// The gradients are those of the original mesh, at a vertex the mean over its tets weighted by the solid angle at the
// vertex. Of a vector the Euclidean norm over the components. The domain is as in local_predictor.hpp.
//
// With the norm of the difference times the length of the edge in the place of the product, the largest sampled error
// at 10% of the vertices, in % of the range, was 25 / 21 / 17 / 1.6 on four meshes, against 27 / 12 / 21 / .99; the
// second and the last mesh are anisotropic.
//
// Source: Cignoni et al. 2000, section 5.2. Solid angle: Van Oosterom and Strackee, The Solid Angle of a Plane
// Triangle, 1983.
#pragma once

#include "build/accumulating_predictor.hpp"
#include "mesh/vec3.hpp"

namespace ptet::build {

/// The solid angle that the triangle a b c is seen under from `apex`, in [0, 2 pi].
[[nodiscard]] double solid_angle(const Point& apex, const Point& a, const Point& b, const Point& c);

/// Gradients at the vertices of the complex as it is: vertex x channel, change in fractions of the range over the
/// length of the diagonal. Flat tets have no say; 0 at a vertex of nothing else.
[[nodiscard]] std::vector<Vec3> vertex_gradients(const WorkingComplex& complex, const std::vector<Point>& positions,
                                                 const NormalizedFields& fields, double diagonal);

/// Of every field |(gradient(vs) - gradient(vd)) . edge|, as a fraction of the range; `edge` in diagonals.
void gradient_differences(const NormalizedFields& fields, const std::vector<Vec3>& gradients, Vertex vs, Vertex vd,
                          const Vec3& edge, std::span<double> differences);

class GradientPredictor final : public AccumulatingPredictor {
public:
  /// Arguments as for the base. The complex must still be the original one.
  GradientPredictor(const WorkingComplex& complex, const std::vector<Point>& positions, const NormalizedFields& fields,
                    double diagonal, std::vector<double> field_weight, double domain_weight);

private:
  void added_field_errors(Vertex vs, Vertex vd, std::span<double> errors) const override;

  std::vector<Vec3> gradients_; ///< vertex x channel
};

} // namespace ptet::build
