#include "build/per_tet_predictor.hpp"

#include "build/collapse_geometry.hpp"

#include <algorithm>

namespace ptet::build {
using namespace vec;

PerTetPredictor::PerTetPredictor(const WorkingComplex& complex, const std::vector<Point>& positions,
                                 const NormalizedFields& fields, double diagonal, std::vector<double> field_weight,
                                 double domain_weight)
    : complex_(complex), positions_(positions), fields_(fields), inverse_diagonal_(1 / diagonal),
      field_weight_(std::move(field_weight)), domain_weight_(domain_weight),
      field_error_(complex.slot_count() * fields.field_count()), domain_error_(complex.slot_count()) {}

/// Largest errors of the tets that vs -> vd deletes.
void PerTetPredictor::deleted_errors(Vertex vs, Vertex vd, std::span<double> errors) const {
  std::fill(errors.begin(), errors.end(), 0.0);
  for (const SlotId s : complex_.star(vs)) {
    if (!has_corner(complex_.slot(s).v, vd)) continue;
    const auto of_tet = tet_errors(s);
    for (std::size_t f = 0; f < errors.size(); ++f)
      errors[f] = std::max(errors[f], of_tet[f]);
  }
}

/// Calls `visit(slot, field, error)` with what every modified tet would carry, given the errors of the deleted ones.
template <class Visit>
void PerTetPredictor::for_each_tet_error(Vertex vs, Vertex vd, std::span<const double> deleted, Visit&& visit) const {
  for_each_modified_tet(complex_, vs, vd, [&](SlotId s, const std::array<Vertex, 4>& corners) {
    const std::array<Point, 4> after = corner_points(corners, positions_);
    std::array<double, 4> weight{};
    if (!barycentrics(positions_[vs], after, weight)) {
      for (std::size_t f = 0; f < deleted.size(); ++f)
        visit(s, f, std::max(deleted[f], tet_errors(s)[f]));
      return;
    }
    // The coordinate of vs that belongs to vd is the ratio of the heights of vs and vd.
    const std::size_t at_vd = static_cast<std::size_t>(std::find(corners.begin(), corners.end(), vd) - corners.begin());
    const double share = 1 / std::max(1.0, std::abs(weight[at_vd]));
    for_each_field_difference(fields_, vs, corners, weight, [&](std::size_t f, double at_vs) {
      visit(s, f, std::max(deleted[f], tet_errors(s)[f]) + share * at_vs);
    });
  });
}

/// Calls `visit(ghost, error)` with what every modified boundary face would carry.
template <class Visit>
void PerTetPredictor::for_each_face_error(Vertex vs, Vertex vd, Visit&& visit) const {
  double worst = 0;
  bool on_boundary = false;
  for (const SlotId s : complex_.star(vs)) {
    const Slot& slot = complex_.slot(s);
    if (!complex_.is_ghost(slot)) continue;
    on_boundary = true;
    if (has_corner(slot.v, vd)) worst = std::max(worst, domain_error_[s]);
  }
  if (!on_boundary) return;
  const double added = inverse_diagonal_ * distance_to_modified_faces(complex_, positions_, vs, vd);
  for_each_modified_face(complex_, vs, vd, [&](SlotId s, const std::array<Vertex, 3>&) {
    visit(s, std::max(worst, domain_error_[s]) + added);
  });
}

void PerTetPredictor::field_errors(Vertex vs, Vertex vd, std::span<double> errors) const {
  thread_local std::vector<double> deleted;
  deleted.resize(errors.size());
  deleted_errors(vs, vd, deleted);
  std::copy(deleted.begin(), deleted.end(), errors.begin());
  for_each_tet_error(vs, vd, deleted,
                     [&](SlotId, std::size_t f, double error) { errors[f] = std::max(errors[f], error); });
}

double PerTetPredictor::domain_error(Vertex vs, Vertex vd) const {
  double worst = 0;
  for_each_face_error(vs, vd, [&](SlotId, double error) { worst = std::max(worst, error); });
  return worst;
}

void PerTetPredictor::costs(Vertex vs, std::span<const Vertex> targets, std::span<float> costs) const {
  thread_local std::vector<double> errors;
  errors.resize(fields_.field_count());
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const Vertex vd = targets[i];
    field_errors(vs, vd, errors);
    double cost = 0;
    for (std::size_t f = 0; f < errors.size(); ++f)
      cost = std::max(cost, field_weight_[f] * errors[f]);
    cost = std::max(cost, domain_weight_ * domain_error(vs, vd));
    costs[i] = static_cast<float>(cost + kEdgeLengthWeight * inverse_diagonal_ * norm(positions_[vd] - positions_[vs]));
  }
}

void PerTetPredictor::collapse(Vertex vs, Vertex vd, std::span<const SlotId> /*deleted*/,
                               std::span<const SlotId> /*modified*/) {
  // What a slot gets depends on its own error and on those of deleted slots: none is changed too early.
  std::vector<double> of_deleted(fields_.field_count());
  deleted_errors(vs, vd, of_deleted);
  for_each_tet_error(vs, vd, of_deleted,
                     [&](SlotId s, std::size_t f, double error) { field_error_[s * of_deleted.size() + f] = error; });
  for_each_face_error(vs, vd, [&](SlotId s, double error) { domain_error_[s] = error; });
}

} // namespace ptet::build
