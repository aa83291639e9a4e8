// A mesh with fields as predictors see it, and collapses of it.
#pragma once

#include "build/normalized_fields.hpp"
#include "build/predictor.hpp"
#include "build_fixture.hpp"
#include "mesh/prepare.hpp"
#include "support/meshes.hpp"

#include <algorithm>
#include <functional>
#include <random>
#include <vector>

namespace ptet::build::test {

using FieldAt = std::function<std::vector<double>(const Point&)>;

/// Fields over points, ids as given: one row of components for each point. No tets.
inline PreparedMesh with_field(const std::vector<Point>& points, const std::vector<std::vector<double>>& values) {
  PreparedMesh prepared;
  prepared.mesh = ptet::test::make_mesh(points, {}, ScalarType::kFloat64);
  std::size_t row = 0;
  ptet::test::add_array(prepared.mesh, "f", ScalarType::kFloat64, static_cast<std::uint32_t>(values[0].size()),
                        [&](const Point&) { return values.at(row++); });
  prepared.used_vertex_count = static_cast<std::uint32_t>(points.size());
  for (std::uint32_t v = 0; v < points.size(); ++v)
    prepared.original_vertex.emplace_back(v);
  prepared.points = points;
  return prepared;
}

inline std::vector<std::vector<double>> scalars(const std::vector<double>& values) {
  std::vector<std::vector<double>> rows;
  for (const double value : values)
    rows.push_back({value});
  return rows;
}

/// Six corners and the centre, 6.
inline Fixture octahedron() {
  return {
      {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}, {0, 0, 0}},
      {{0, 2, 4, 6}, {0, 2, 5, 6}, {0, 3, 4, 6}, {0, 3, 5, 6}, {1, 2, 4, 6}, {1, 2, 5, 6}, {1, 3, 4, 6}, {1, 3, 5, 6}}};
}

/// A mesh with one field or more, the working complex over it, and its diagonal.
struct Scene {
  PreparedMesh prepared;
  NormalizedFields fields;
  WorkingComplex complex;
  double diagonal;

  Scene(const Fixture& fixture, const std::vector<std::vector<double>>& values, double length = 4)
      : prepared(with_field(fixture.points, values)), fields(prepared, {}), complex(fixture.complex), diagonal(length) {
  }
  explicit Scene(PreparedMesh mesh, double length = 100)
      : prepared(std::move(mesh)), fields(prepared, {}),
        complex(prepared.used_vertex_count, prepared.mesh.tets, prepared.boundary_faces), diagonal(length) {}
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;
  ~Scene() = default;

  [[nodiscard]] const std::vector<Point>& points() const { return prepared.points; }

  /// The predictor's words on vs -> vd for the only field.
  [[nodiscard]] double field_error(const Predictor& predictor, Vertex vs, Vertex vd) const {
    std::vector<double> errors(fields.field_count(), -1.0);
    predictor.field_errors(vs, vd, errors);
    return errors.at(0);
  }
  [[nodiscard]] static double cost(const Predictor& predictor, Vertex vs, Vertex vd) {
    float cost = -1;
    predictor.costs(vs, {&vd, 1}, {&cost, 1});
    return cost;
  }
  /// What every cost has for the length of its edge.
  [[nodiscard]] double length_part(Vertex vs, Vertex vd) const {
    using namespace vec;
    return 1e-4 * norm(points()[vd] - points()[vs]) / diagonal;
  }
  [[nodiscard]] bool is_inner(Vertex v) const {
    const auto star = complex.star(v);
    return std::none_of(star.begin(), star.end(), [&](SlotId s) { return complex.is_ghost(complex.slot(s)); });
  }
  [[nodiscard]] std::vector<Vertex> neighbours(Vertex v) const {
    std::set<Vertex> found;
    for (const SlotId s : complex.star(v))
      for (const Vertex x : complex.slot(s).v)
        if (x != v && x != complex.dummy()) found.insert(x);
    return {found.begin(), found.end()};
  }
  /// Collapses if that is allowed; all the predictors are told.
  bool collapse(Vertex vs, Vertex vd, const std::vector<Predictor*>& predictors) {
    CollapseCheck check(complex, points(), 0, 64);
    if (check.examine(vs, vd) != CollapseStatus::kAccepted) return false;
    for (Predictor* predictor : predictors)
      predictor->collapse(vs, vd, check.deleted(), check.modified());
    complex.collapse(vs, vd, check.deleted(), check.modified());
    return true;
  }
  /// Up to `count` accepted collapses, of inner vertices only if so asked; `before(vs, vd)` sees what is tried next,
  /// `after(vs, vd)` what was accepted.
  template <class Before, class After>
  int random_collapses(int count, bool inner_only, const std::vector<Predictor*>& predictors, Before&& before,
                       After&& after) {
    std::mt19937 random(11);
    int accepted = 0;
    for (int i = 0; i < 50 * count && accepted < count; ++i) {
      const Vertex vs = static_cast<Vertex>(random() % complex.vertex_count());
      if (!complex.alive(vs) || (inner_only && !is_inner(vs))) continue;
      const auto around = neighbours(vs);
      const Vertex vd = around[random() % around.size()];
      before(vs, vd);
      if (!collapse(vs, vd, predictors)) continue;
      ++accepted;
      after(vs, vd);
    }
    return accepted;
  }
};

/// A jittered grid with one field.
inline PreparedMesh prepared_grid(const FieldAt& field, std::uint32_t components = 1,
                                  std::array<int, 3> cells = {4, 4, 4}) {
  ptet::test::GridOptions options;
  options.cells = cells;
  TetMesh mesh = ptet::test::grid(options);
  mesh.point_arrays.clear();
  ptet::test::add_array(mesh, "f", ScalarType::kFloat64, components, field);
  return prepare(std::move(mesh));
}

/// Smooth, curved everywhere.
inline std::vector<double> curved(const Point& p) {
  return {std::sin(0.07 * p[0]) + 0.4 * std::cos(0.09 * p[1] + 0.02 * p[2]) + 0.001 * p[2] * p[2]};
}

} // namespace ptet::build::test
