// Takes the collapses of a round by exact measurement of what they would do.
//
//   apart      of those picked, the ones whose stars have no tet in common
//   measure    the exact errors of their best half-edges, in parallel; given up where they cost too much for the round,
//              which of the boundary is looked at first: least work, and on thin meshes most often what is too much
//   collapse   those that are still among the best, one by one; the others are put back, at the cost that they have
//              turned out to have
//
// Along with the mesh go the integral of the squared error over every tet of it and the volume of it outside of the
// domain: the changes of their sums are the squared error of a record and, with that of the mesh's volume, what it
// uncovers.
//
// Source: Cignoni et al. 2000, sections 4.3 and 4.4, with exact errors in the place of those at vertices.
#pragma once

#include "build/checkpoint.hpp"
#include "build/collapser.hpp"
#include "build/known_versions.hpp"
#include "mesh/large_pages.hpp"
#include "ptet/build.hpp"

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace ptet::build {

class MeasuredRounds {
public:
  /// Both must outlive the object; the mesh must be as it was given. `report` counts what becomes of half-edges.
  MeasuredRounds(Collapser& collapser, BuildReport& report);

  /// Collapses what may go of `picked`, by Candidates::pick(), until the target is reached.
  /// `look` is called now and then from this thread, and may throw.
  void take(const std::vector<Vertex>& picked, std::uint32_t round, const std::function<void()>& look);
  /// When collapses were made, and their squared errors recorded, by others.
  void measure_made();

  /// What a mesh with the same collapses made by others does not tell.
  template <class Archive>
  void serialize(Archive& archive, unsigned /*version*/) {
    serialize_sparse(archive, std::span(slot_sums_));
  }

private:
  struct Verdict;

  [[nodiscard]] std::vector<Vertex> apart(const std::vector<Vertex>& picked, std::uint32_t round);
  [[nodiscard]] Verdict measure(Vertex vs, Trial& trial);
  void measure_fields(Trial& trial, double enough, KnownVersions* known, Verdict& verdict) const;
  void look_at_boundary(const CollapsePlan& plan, double enough, Verdict& verdict) const;
  void measure_domain(Vertex vs, double enough, Verdict& verdict) const;
  [[nodiscard]] float not_now() const;
  [[nodiscard]] std::vector<double> squared_in_star(const CollapseCheck& check) const;
  [[nodiscard]] CollapseStatus collapse(Vertex vs, std::uint32_t round, Verdict& verdict);
  [[nodiscard]] double exchange_sums(const CollapseCheck& check, std::size_t i, const std::vector<double>& integrals);
  void record_squared_errors(const CollapseCheck& check, const std::vector<double>& integrals, double volume_added);

  Collapser& collapser_;
  const WorkingComplex& complex_;
  Candidates& candidates_;
  BuildReport& report_;
  std::size_t field_count_;
  std::size_t sum_count_;             ///< of a slot: one a field, and the volume
  std::vector<double> squared_scale_; ///< by field
  double vertex_volume_;              ///< of an average vertex
  /// Slot x (field, volume): integral of the squared error, and the volume outside of the domain.
  LargeVector<double> slot_sums_;
  KnownOfVertices known_;              ///< where a measured half-edge was put back
  std::vector<std::uint32_t> claimed_; ///< by vertex: the last round in which its star was to change
};

} // namespace ptet::build
