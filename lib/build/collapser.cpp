#include "build/collapser.hpp"

#include "build/describe_options.hpp"
#include "mesh/large_pages.hpp"
#include "mesh/shape.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include <oneapi/tbb/parallel_invoke.h>

namespace ptet::build {
namespace {

/// So many collapses are made by several threads: telling them of it takes as long as some collapses.
constexpr std::size_t kWorthSharing = 8;

/// So many vertices are to be left. Of a fraction that is a whole number but for rounding it is that number.
std::uint32_t count_of_target(double target, std::uint32_t vertices) {
  constexpr double kBelow = 1 - 0x1p-50;
  const double count = target < 1 ? kBelow * target * static_cast<double>(vertices) : target;
  return static_cast<std::uint32_t>(std::min<double>(std::ceil(count), vertices));
}

/// Whether errors are measured, or limits hold, everywhere.
bool wants_exact(const BuildOptions& options, const ErrorLimits& limits) {
  return options.prediction == Prediction::kExact ||
         (limits.bounds_fields() && options.evaluation == Evaluation::kExact);
}

DomainError domain_error_of(const BuildOptions& options) {
  switch (options.evaluation) {
  case Evaluation::kNone: return DomainError::kPredicted;
  case Evaluation::kExact: return DomainError::kBound;
  case Evaluation::kVertices:
  case Evaluation::kSamples: break;
  }
  return DomainError::kSampled;
}

} // namespace

Collapser::Collapser(const PreparedMesh& prepared, const NormalizedFields& fields, const MeshScales* whole,
                     std::span<const Sample> samples, const BuildOptions& options, RecordStream& records)
    : prepared_(prepared), fields_(fields), options_(options), records_(records),
      scales_(whole != nullptr ? *whole : scales_of(prepared, fields)),
      limits_(prepared, fields, options, scales_.diagonal),
      cost_(options.objective, limits_.field_weights(), scales_.field_deviation, limits_.measured_domain_weight()),
      target_count_(count_of_target(options.target_vertices, prepared.used_vertex_count)), frozen_(prepared.frozen),
      complex_(prepared.used_vertex_count, prepared.mesh.tets, prepared.boundary_faces),
      surface_(complex_, prepared.points, scales_.diagonal, frozen_, domain_error_of(options),
               prepared.crossing_curves),
      removed_(prepared.points, fields, scales_.diagonal,
               options.evaluation == Evaluation::kExact ? CoveredPoints::kStay : CoveredPoints::kMove),
      exact_(wants_exact(options, limits_) ? std::make_unique<ExactFieldError>(prepared, fields.view()) : nullptr),
      predictor_(choose_predictor(options.prediction, complex_, prepared.points, fields, scales_.diagonal,
                                  limits_.field_weights(), limits_.domain_weight(), whole)),
      boundary_(complex_, surface_, *predictor_.predictor, domain_error_of(options), scales_.diagonal,
                limits_.domain()),
      candidates_(
          complex_, surface_, *predictor_.predictor, predictor_.quadrics, cost_, options.prediction,
          options.round_fraction,
          [this, min_quality = min_quality_of(options, prepared)] {
            return Trial(complex_, prepared_.points, removed_, exact_.get(), min_quality, options_.max_star);
          },
          frozen_) {
  std::vector<Sample> own;
  if (options.evaluation == Evaluation::kSamples && whole == nullptr)
    samples = own = choose_samples(prepared.mesh.tets, fields);
  if (options.evaluation == Evaluation::kSamples) removed_.hold_samples(complex_, samples, prepared.mesh.tets);
  if (options.prediction == Prediction::kExact) removed_.weigh(vertex_volumes(prepared, scales_));
  begin_records();
}

/// Nothing where errors are not measured everywhere: what is believed, or seen at samples, is no guide to budgets.
BudgetWeights Collapser::budget_weights() const {
  BudgetWeights weights;
  if (options_.evaluation != Evaluation::kExact) return weights;
  weights.mean = options_.objective != Objective::kMaximum;
  if (options_.objective == Objective::kRootMeanSquare) return weights;
  const std::vector<double>& weight = cost_.field_weight();
  for (std::size_t f = 0; f < weight.size(); ++f)
    weights.maximum.push_back(weight[f] / fields_.fields()[f].scale());
  // A place on the boundary costs a budget more than one inside: with all of the weight the greatest field errors of
  // two meshes of five are no less than by collapses alone, for domain errors that are 6% less.
  constexpr double kDomainInBudgets = 0.25;
  weights.domain = kDomainInBudgets * limits_.measured_domain_weight();
  return weights;
}

void Collapser::begin_records() {
  records_.fields = fields_.fields();
  records_.budget = budget_weights();
  records_.diagonal = scales_.diagonal;
  records_.volume = scales_.volume;
  records_.overlaps_itself = prepared_.overlaps_itself;
  records_.original_tet_count = static_cast<std::uint32_t>(prepared_.mesh.tets.size());
  records_.original_ghost_count = static_cast<std::uint32_t>(prepared_.boundary_faces.size());
  version_count_ = complex_.slot_count();
  // Where there is room for all at first, lists are never there twice. What is not used takes no memory. A star has
  // some 22 slots.
  const std::size_t most = alive_count() - std::min(alive_count(), target_count_);
  reserve_large(records_.stars, 26 * most);
  reserve_large(records_.removed, most);
  reserve_large(records_.target, most);
  reserve_large(records_.round, most);
  reserve_large(records_.modified_count, most);
  reserve_large(records_.star_begin, most + 1);
  reserve_large(records_.also_needs_begin, most + 1);
  reserve_large(records_.domain_error, most);
  reserve_large(records_.field_error, most * fields_.field_count());
  for (SlotId s = 0; s < complex_.slot_count(); ++s)
    if (Slot& slot = complex_.slot(s); !complex_.is_ghost(slot))
      slot.quality =
          std::max(0.0F, static_cast<float>(shape_quality(prepared_.points[slot.v[0]], prepared_.points[slot.v[1]],
                                                          prepared_.points[slot.v[2]], prepared_.points[slot.v[3]])));
}

void Collapser::end_records() {
  complex_.forget_stars();
  reserve_large(records_.slots, complex_.slot_count());
  for (SlotId s = 0; s < complex_.slot_count(); ++s)
    records_.slots.push_back(complex_.tet_of(complex_.slot(s)));
}

CollapseStatus Collapser::collapse(std::uint32_t round, const std::vector<double>& measured, BoundaryMove& move) {
  const CollapseStatus status = accept(round, &measured, move);
  if (status != CollapseStatus::kAccepted) return status;
  make_accepted();
  candidates_.trial().swap(accepted_.front().plan);
  return status;
}

CollapseStatus Collapser::accept(std::uint32_t round, const std::vector<double>* known, BoundaryMove& move) {
  Trial& trial = candidates_.trial();
  const CollapsePlan& plan = trial.check().plan();
  if (plan.moves_boundary) {
    CollapseStatus status = CollapseStatus::kAccepted;
    if (!boundary_.stands(move)) status = boundary_.examine(plan, move);
    // Bounds, which take longer than the fields, come after them.
    if (status == CollapseStatus::kAccepted && boundary_.measures_quickly() && !move.error)
      status = boundary_.measure(plan.vs, plan.vd, move);
    if (status != CollapseStatus::kAccepted) return status;
  }
  find_field_errors(trial, known);
  if (limits_.passed_by(field_errors_) || limits_.passed_by(outside_errors_)) return CollapseStatus::kFieldError;
  if (known == nullptr && exact_) {
    std::vector<double> everywhere(field_errors_.size());
    if (!trial.measure(everywhere, nullptr, limits_.field(), [] { return false; })) return CollapseStatus::kFieldError;
  }
  if (plan.moves_boundary && !move.error) {
    const CollapseStatus status = boundary_.measure(plan.vs, plan.vd, move);
    if (status != CollapseStatus::kAccepted) return status;
  }
  put_down(trial, move, round);
  return CollapseStatus::kAccepted;
}

bool Collapser::may_meet_accepted(const BoundaryMove& move) const {
  return std::any_of(accepted().begin(), accepted().end(), [&](const Accepted& other) {
    return other.plan.moves_boundary && boundary_.may_meet(move, other.move);
  });
}

void Collapser::predicted_errors(const CollapsePlan& plan, std::vector<double>& errors) const {
  errors.resize(fields_.field_count());
  predictor_.predictor->field_errors(plan.vs, plan.vd, errors);
}

/// Of the half-edge that `trial` has accepted.
void Collapser::find_field_errors(Trial& trial, const std::vector<double>* known) {
  outside_errors_.clear();
  if (measures_nothing()) {
    if (known == nullptr) predicted_errors(trial.check().plan(), field_errors_);
  } else {
    const RemovedVertices::Simulation& seen = trial.simulate();
    const bool everywhere = options_.evaluation == Evaluation::kExact;
    const auto stated = everywhere ? seen.errors_inside() : seen.errors();
    field_errors_.assign(stated.begin(), stated.end());
    if (everywhere) outside_errors_.assign(seen.errors_outside().begin(), seen.errors_outside().end());
  }
  if (known != nullptr) field_errors_ = *known;
}

bool Collapser::collapse_again(Vertex vs, Vertex vd, std::uint32_t round) {
  const std::uint32_t vertices = complex_.vertex_count();
  if (vs >= vertices || vd >= vertices || vs == vd || !complex_.alive(vs) || !complex_.alive(vd)) return false;
  Trial& trial = candidates_.trial();
  const CollapseCheck& check = trial.check();
  if (trial.examine(vs, vd) != CollapseStatus::kAccepted || check.deleted().empty()) return false;
  BoundaryMove move;
  if (check.moves_boundary()) {
    boundary_.outline(check.plan(), move);
    if (!surface_.collapse_ok(vs, vd) || boundary_.measure(vs, vd, move) != CollapseStatus::kAccepted) return false;
  }
  if (!measures_nothing()) trial.simulate();
  field_errors_.clear();
  outside_errors_.clear();
  put_down(trial, move, round);
  make_accepted();
  return true;
}

/// Accepts what the trial has; what the removed vertices become is not put off.
void Collapser::put_down(Trial& trial, BoundaryMove& move, std::uint32_t round) {
  if (accepted_count_ == accepted_.size()) accepted_.emplace_back();
  Accepted& next = accepted_[accepted_count_];
  if (!measures_nothing()) removed_.commit(complex_, trial.check().deleted(), trial.last_simulation());
  trial.swap(next.plan);
  std::swap(next.move, move);
  std::swap(next.field_errors, field_errors_);
  std::swap(next.outside_errors, outside_errors_);
  next.round = round;
  next.first_version = version_count_;
  version_count_ += static_cast<std::uint32_t>(next.plan.modified.size());
  if (version_count_ >= kNone / 2) throw Error(ErrorCode::kLimit, "the build makes more tets than 31-bit ids can name");
  depth_ = std::max(depth_, next.plan.height);
  ++accepted_count_;
}

void Collapser::make_accepted() {
  if (accepted_count_ < kWorthSharing) {
    tell_candidates();
    tell_quadrics();
    tell_complex();
    tell_surface();
    tell_faces();
    record();
  } else {
    oneapi::tbb::parallel_invoke([&] { tell_complex(); }, [&] { tell_surface(); }, [&] { tell_faces(); },
                                 [&] {
                                   tell_candidates();
                                   record();
                                 },
                                 [&] { tell_quadrics(); });
  }
  accepted_count_ = 0;
}

void Collapser::tell_candidates() {
  for (const Accepted& made : accepted()) {
    const CollapsePlan& plan = made.plan;
    candidates_.forget(plan.vd); // its own cost has changed, not only its star
    for (const LinkVertex& x : plan.link)
      candidates_.change_star(x, plan.vd, plan.height);
  }
}

/// The predictor, where it looks at quadrics and not at the complex.
void Collapser::tell_quadrics() {
  if (predictor_.quadrics == nullptr) return;
  for (const Accepted& made : accepted())
    predictor_.predictor->collapse(made.plan.vs, made.plan.vd, made.plan.deleted, made.plan.modified);
}

/// And any other predictor, before each collapse.
void Collapser::tell_complex() {
  for (const Accepted& made : accepted()) {
    const CollapsePlan& plan = made.plan;
    if (predictor_.quadrics == nullptr) predictor_.predictor->collapse(plan.vs, plan.vd, plan.deleted, plan.modified);
    complex_.collapse(plan.vs, plan.vd, plan.deleted, plan.modified);
    for (std::size_t m = 0; m < plan.modified.size(); ++m) {
      Slot& slot = complex_.slot(plan.modified[m]);
      slot.version = made.first_version + static_cast<std::uint32_t>(m);
      slot.quality = plan.new_quality[m];
      slot.height = plan.height;
    }
  }
}

void Collapser::tell_surface() {
  for (const Accepted& made : accepted())
    if (made.plan.moves_boundary) surface_.collapse(made.plan.vs, made.plan.vd, made.move.handover);
}

void Collapser::tell_faces() {
  for (const Accepted& made : accepted())
    if (made.plan.moves_boundary) surface_.move_faces(made.move.changes);
}

void Collapser::record() {
  for (const Accepted& made : accepted()) {
    const CollapsePlan& plan = made.plan;
    for (const std::span<const SlotId> part : {plan.modified, plan.deleted})
      records_.stars.insert(records_.stars.end(), part.begin(), part.end());
    records_.removed.push_back(VertexId{plan.vs});
    records_.target.push_back(VertexId{plan.vd});
    records_.round.push_back(made.round);
    records_.star_begin.push_back(records_.stars.size());
    records_.modified_count.push_back(static_cast<std::uint16_t>(plan.modified.size()));
    for (std::size_t f = 0; f < made.field_errors.size(); ++f)
      records_.field_error.push_back(made.field_errors[f] * fields_.fields()[f].range);
    for (std::size_t f = 0; f < made.outside_errors.size(); ++f) // none where they are among the others
      records_.outside_error.push_back(made.outside_errors[f] * fields_.fields()[f].range);
    records_.also_needs_begin.push_back(records_.also_needs.size());
    records_.domain_error.push_back(plan.moves_boundary ? *made.move.error : 0);
  }
}

} // namespace ptet::build
