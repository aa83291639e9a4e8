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
#include <vector>

namespace ptet::build {

class CollapseCheck {
public:
  CollapseCheck(const WorkingComplex& complex, const std::vector<Point>& positions, double min_quality,
                std::uint32_t max_star);

  /// kAccepted, or the first reason against vs -> vd. What depends on fields or on the geometry of the boundary is not
  /// looked at here. Leaves D(e), M(e) and the new qualities below, complete when accepted.
  [[nodiscard]] CollapseStatus examine(Vertex vs, Vertex vd);

  [[nodiscard]] std::span<const SlotId> deleted() const { return deleted_; }
  [[nodiscard]] std::span<const SlotId> modified() const { return modified_; }
  /// For each modified slot its quality after the collapse.
  [[nodiscard]] std::span<const float> new_quality() const { return new_quality_; }
  /// vs is a vertex of the boundary.
  [[nodiscard]] bool moves_boundary() const { return moves_boundary_; }

private:
  using Edge = std::array<Vertex, 2>;

  void classify(Vertex vs, Vertex vd);
  [[nodiscard]] bool link_condition(Vertex vs, Vertex vd);
  void common_edges(const Slot& slot, Vertex apex, std::vector<Edge>& into) const;
  [[nodiscard]] bool inverts(Vertex vs, Vertex vd) const;
  [[nodiscard]] bool spoils_shapes(Vertex vs, Vertex vd);

  const WorkingComplex& complex_;
  const std::vector<Point>& positions_;
  float min_quality_;
  std::uint32_t max_star_;

  std::vector<SlotId> deleted_;
  std::vector<SlotId> modified_;
  std::vector<float> new_quality_;
  bool moves_boundary_ = false;

  // Marks by vertex, dummy included, in one word: the stamp of this examination plus what the vertex is.
  static constexpr std::uint32_t kInLinkOfVs = 1;
  static constexpr std::uint32_t kInLinkOfEdge = 2;
  static constexpr std::uint32_t kMarkStep = 4;
  [[nodiscard]] bool in_link_of_vs(Vertex x) const { return mark_[x] > stamp_; }
  [[nodiscard]] bool in_link_of_edge(Vertex x) const { return mark_[x] > stamp_ + kInLinkOfVs; }

  std::uint32_t stamp_ = 0;
  std::vector<std::uint32_t> mark_;
  std::vector<Edge> link_edges_; ///< of e
  std::vector<Edge> chords_;     ///< edges of Lk(vs) between vertices of Lk(e) that are not in Lk(e)
  std::vector<Edge> scratch_;
};

} // namespace ptet::build
