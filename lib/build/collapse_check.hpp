// Is a half-edge collapse allowed? Combinatorics, orientation and shape, in one pass over the two stars.
//
//   D(e)  deleted    the slots that hold both vs and vd
//   M(e)  modified   the slots that hold vs but not vd; the collapse puts vd in its place
//
// Source: Cignoni et al. 2000, section 3.2; Dey, Edelsbrunner, Guha, Nekhayev, Topology preserving edge contraction,
// 1999 (link condition for 3-complexes, boundary closed by a dummy vertex).
#pragma once

#include "build/working_complex.hpp"
#include "ptet/build.hpp"

#include <span>
#include <utility>
#include <vector>

namespace ptet::build {

/// A vertex of Lk(vs), and whether the collapse vs -> vd makes it a new neighbour of vd.
struct LinkVertex {
  Vertex vertex;
  bool joins;             ///< by an edge
  bool joins_on_boundary; ///< by an edge of the boundary
};

/// All that doing a collapse needs to know of it.
struct CollapsePlan {
  Vertex vs = kNone;
  Vertex vd = kNone;
  bool moves_boundary = false; ///< vs is a vertex of the boundary
  std::uint32_t height = 0;    ///< of the record: one more than those below the star of vs
  std::vector<SlotId> deleted;
  std::vector<SlotId> modified;
  std::vector<float> new_quality; ///< of each modified slot after the collapse
  std::vector<LinkVertex> link;   ///< of vs; without the dummy
};

class CollapseCheck {
public:
  /// A larger star is not taken apart in one record: its vertex stays.
  static constexpr std::size_t kMaxRemovedStar = 1024;

  CollapseCheck(const WorkingComplex& complex, const std::vector<Point>& positions, double min_quality,
                std::uint32_t max_star);

  /// kAccepted, or the first reason against vs -> vd. What depends on fields or on the geometry of the boundary is not
  /// looked at here. Leaves the plan below, complete when accepted.
  [[nodiscard]] CollapseStatus examine(Vertex vs, Vertex vd);

  [[nodiscard]] const CollapsePlan& plan() const { return plan_; }
  /// Exchanges what the last examination left for what an earlier one did.
  void swap(CollapsePlan& plan) { std::swap(plan_, plan); }
  [[nodiscard]] std::span<const SlotId> deleted() const { return plan_.deleted; }
  [[nodiscard]] std::span<const SlotId> modified() const { return plan_.modified; }
  [[nodiscard]] bool moves_boundary() const { return plan_.moves_boundary; }

private:
  using Edge = std::array<Vertex, 2>;

  [[nodiscard]] bool classify();
  void mark_links();
  [[nodiscard]] bool link_condition();
  void common_edges(const Slot& slot, Vertex apex, std::vector<Edge>& into) const;
  [[nodiscard]] bool inverts(const Slot& slot) const;
  [[nodiscard]] bool spoils_shapes();
  void find_joining();

  const WorkingComplex& complex_;
  const std::vector<Point>& positions_;
  float min_quality_;
  std::uint32_t max_star_;

  CollapsePlan plan_;
  float worst_old_ = 1;               ///< quality in the star
  bool moves_along_boundary_ = false; ///< vs vd is an edge of the boundary

  // Marks by vertex, dummy included, in one word: the stamp of this examination plus what the vertex is.
  static constexpr std::uint32_t kInLinkOfEdge = 1;
  static constexpr std::uint32_t kOnBoundary = 2;       ///< joined to vs by an edge of the boundary
  static constexpr std::uint32_t kOnBoundaryOfEdge = 4; ///< by a face of the boundary to vs and vd
  static constexpr std::uint32_t kMarkStep = 8;
  [[nodiscard]] bool in_link_of_vs(Vertex x) const { return mark_[x] >= stamp_; }
  [[nodiscard]] bool in_link_of_edge(Vertex x) const { return in_link_of_vs(x) && (mark_[x] & kInLinkOfEdge) != 0; }

  std::uint32_t stamp_ = 0;
  std::vector<std::uint32_t> mark_;
  std::vector<Edge> link_edges_; ///< of e
  std::vector<Edge> chords_;     ///< edges of Lk(vs) between vertices of Lk(e) that are not in Lk(e)
  std::vector<Edge> scratch_;
};

} // namespace ptet::build
