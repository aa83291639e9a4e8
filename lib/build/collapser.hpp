// The mesh while it is being collapsed: all that follows it, half-edge collapse by half-edge collapse, and the records
// of what was done.
//
//   trial    (one a thread) has accepted vs -> vd by combinatorics, orientation and shape
//   accept   boundary, field errors, domain error: refused, or put down. The removed vertices are told
//   make     all that were accepted: candidates, quadrics, complex, boundary surface and its faces are told, and there
//            are records. None looks at what another changes, so they are told at the same time, each of one collapse
//            after the other
//
// Source: Cignoni et al. 2000, sections 3.2 and 4.
#pragma once

#include "build/boundary_check.hpp"
#include "build/candidates.hpp"
#include "build/choose_predictor.hpp"
#include "build/collapse_cost.hpp"
#include "build/error_limits.hpp"
#include "build/field_samples.hpp"
#include "build/mesh_scales.hpp"
#include "build/normalized_fields.hpp"
#include "build/removed_vertices.hpp"
#include "build/trial.hpp"
#include "build/working_complex.hpp"
#include "build/working_surface.hpp"
#include "error/exact_field_error.hpp"
#include "mesh/prepare.hpp"
#include "ptet/build.hpp"
#include "record/stream.hpp"

#include <memory>
#include <vector>

namespace ptet::build {

class Collapser {
public:
  /// The mesh as it was given. `whole`: the mesh that `prepared` is a part of, with `samples` in the part where the
  /// evaluation looks at samples; null: it is all of it. `records`, empty so far, gets what is known before the first
  /// collapse, then every collapse. All must outlive the object, but for the samples.
  /// Throws Error(kBadArgument) as ErrorLimits does.
  Collapser(const PreparedMesh& prepared, const NormalizedFields& fields, const MeshScales* whole,
            std::span<const Sample> samples, const BuildOptions& options, RecordStream& records);
  Collapser(const Collapser&) = delete;
  Collapser& operator=(const Collapser&) = delete;

  [[nodiscard]] const std::vector<Point>& positions() const { return prepared_.points; } ///< by vertex
  [[nodiscard]] const NormalizedFields& fields() const { return fields_; }
  [[nodiscard]] const MeshScales& scales() const { return scales_; }
  [[nodiscard]] const ErrorLimits& limits() const { return limits_; }
  [[nodiscard]] const CollapseCost& cost() const { return cost_; }
  [[nodiscard]] const WorkingComplex& complex() const { return complex_; }
  [[nodiscard]] const BoundaryCheck& boundary() const { return boundary_; }
  /// Null unless errors are measured, or limits hold, everywhere.
  [[nodiscard]] const ExactFieldError* exact() const { return exact_.get(); }
  [[nodiscard]] Candidates& candidates() { return candidates_; }
  [[nodiscard]] RecordStream& records() { return records_; }

  /// Vertices of the complex that are left.
  [[nodiscard]] std::uint32_t alive_count() const {
    return complex_.vertex_count() - static_cast<std::uint32_t>(records_.size() + accepted_count_);
  }
  /// Once what was accepted is recorded; points in no tet do not count.
  [[nodiscard]] std::uint64_t vertices_left() const { return prepared_.used_vertex_count - records_.size(); }
  /// So many are to be left of the complex, by the options.
  [[nodiscard]] std::uint32_t target_count() const { return target_count_; }
  [[nodiscard]] bool at_target() const { return alive_count() <= target_count_; }
  /// Longest chain of records that depend on one another.
  [[nodiscard]] std::uint32_t depth() const { return depth_; }

  /// Accepts the collapse that this thread's trial has, unless the boundary or an error stands against it. It is to be
  /// made after those that were accepted and are not made: neither of its ends is in the star of a vertex that one of
  /// these removes, nor does it meet them.
  /// `known`: its field errors, one a field, fractions of the ranges, as measured exactly or by predicted_errors();
  /// null: they are those at the removed vertices, or as predicted. `move`: what has been found of it since
  /// begin_changes(), where it moves the boundary. What is accepted is taken out of the trial and of `move`.
  [[nodiscard]] CollapseStatus accept(std::uint32_t round, const std::vector<double>* known, BoundaryMove& move);
  /// Whether the boundary may meet itself where this is made after those.
  [[nodiscard]] bool may_meet_accepted(const BoundaryMove& move) const;
  /// Makes what was accepted, in that order.
  void make_accepted();
  /// Makes the collapse that this thread's trial has accepted, as accept() says. The trial keeps it.
  [[nodiscard]] CollapseStatus collapse(std::uint32_t round, const std::vector<double>& measured, BoundaryMove& move);
  /// What is to be recorded of the fields where nothing is measured. Thread rule: const.
  void predicted_errors(const CollapsePlan& plan, std::vector<double>& errors) const;
  [[nodiscard]] bool measures_nothing() const { return options_.evaluation == Evaluation::kNone; }
  /// What boundary() says from now on is compared with what changes from now on.
  void begin_changes() { surface_.begin_changes(); }
  /// Makes a collapse that was accepted before: nothing is asked that only refuses, and its field errors are left for
  /// the caller to record. False when it cannot be.
  [[nodiscard]] bool collapse_again(Vertex vs, Vertex vd, std::uint32_t round);
  /// Puts down what only the last of the collapses leaves known, RecordStream::slots. Nothing may follow.
  void end_records();

private:
  /// A collapse that is to be made.
  struct Accepted {
    CollapsePlan plan;
    BoundaryMove move;
    std::uint32_t round = 0;
    std::uint32_t first_version = 0;                  ///< that it makes
    std::vector<double> field_errors, outside_errors; ///< one a field, or none that are to be recorded
  };

  [[nodiscard]] BudgetWeights budget_weights() const;
  void begin_records();
  void find_field_errors(Trial& trial, const std::vector<double>* known);
  void put_down(Trial& trial, BoundaryMove& move, std::uint32_t round);
  [[nodiscard]] std::span<const Accepted> accepted() const { return {accepted_.data(), accepted_count_}; }
  void tell_candidates();
  void tell_quadrics();
  void tell_complex();
  void tell_surface();
  void tell_faces();
  void record();

  const PreparedMesh& prepared_;
  const NormalizedFields& fields_;
  const BuildOptions& options_;
  RecordStream& records_;
  MeshScales scales_;
  ErrorLimits limits_;
  CollapseCost cost_;
  std::uint32_t target_count_;
  std::uint32_t depth_ = 0;         ///< of the accepted, too
  std::uint32_t version_count_ = 0; ///< so far, with the accepted

  std::vector<char> frozen_; ///< by vertex
  WorkingComplex complex_;
  WorkingSurface surface_;
  RemovedVertices removed_;
  std::unique_ptr<ExactFieldError> exact_;
  ChosenPredictor predictor_;
  BoundaryCheck boundary_;
  Candidates candidates_;

  // Of the collapse in hand.
  std::vector<double> field_errors_, outside_errors_; ///< one a field, or none that are to be recorded

  std::vector<Accepted> accepted_; ///< room for those that are made at the same time
  std::size_t accepted_count_ = 0; ///< so many of these are in use
};

} // namespace ptet::build
