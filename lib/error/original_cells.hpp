// The original mesh, as measurements of versions walk over it: tets with their neighbours, those around each vertex,
// and a tree of the faces at which a walk ends.
#pragma once

#include "error/channel_view.hpp"
#include "error/star_cones.hpp"
#include "mesh/box_tree.hpp"
#include "mesh/large_pages.hpp"
#include "mesh/prepare.hpp"
#include "mesh/topology.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace ptet {

struct OriginalCells {
  static constexpr std::uint32_t kOutside = 0xffffffffU;
  /// Of the tets around a vertex all are looked at up to so many; beyond, those that a tree finds.
  static constexpr std::uint32_t kLargeStar = 256;
  /// Flatter tets, by the determinant of their edges against the product of the lengths, are measured in numbers of
  /// twice the digits.
  static constexpr double kFlatShape = 1e-6;

  struct Cell {
    std::array<std::uint32_t, 4> v;
    std::array<std::uint32_t, 4> neighbor; ///< across the face opposite each corner; kOutside at the boundary
    double volume;                         ///< 0 for a tet that is flat, exactly, and for no other
    [[nodiscard]] bool is_flat() const { return !(volume > 0); }
  };

  /// Both must outlive the object. Throws Error(kLimit) where very many thin tets lie on one another.
  OriginalCells(const PreparedMesh& mesh, ChannelView fields);

  [[nodiscard]] const Point& point(std::uint32_t v) const { return prepared.points[v]; }
  /// Whether the tet is flat or so thin that all of it may seem to lie on a plane of a version: a walk passes through
  /// it, or stops at it, without having seen what is behind.
  [[nodiscard]] bool is_thin(std::uint32_t t) const { return cells[t].is_flat() || (!thin.empty() && thin[t] != 0); }
  /// The tets that touch the place of a vertex of a thin tet, or nearly: where its own are thin it may be others that
  /// fill the space around it. Flat ones are not among them, and others may be. None for other vertices.
  [[nodiscard]] std::span<const std::uint32_t> behind_thin(std::uint32_t v) const;
  /// The face of a tet opposite its corner v.
  [[nodiscard]] StarCones::Triangle opposite(const std::array<std::uint32_t, 4>& tet, std::uint32_t v) const;

  const PreparedMesh& prepared;
  ChannelView channels;
  std::vector<char> ends_field;           ///< by channel: whether it is the last of its field
  bool scalars = true;                    ///< whether each is a field
  std::vector<double> scale_sq;           ///< by field: the square of the scale of errors
  LargeVector<Cell> cells;                ///< the original tets
  std::vector<char> thin;                 ///< by tet, where any is that is not flat
  std::vector<std::uint32_t> star_begin;  ///< by vertex, into `star`
  LargeVector<std::uint32_t> star;        ///< tets around each vertex, ascending
  std::vector<std::uint32_t> large_stars; ///< vertices, ascending
  std::vector<StarCones> cones;           ///< of each of these, by place in its star
  std::vector<char> on_boundary;          ///< by vertex: of a boundary face or a thin tet
  std::vector<HalfFace> boundary_faces;   ///< and those between thin tets and others
  std::optional<BoxTree> boundary_tree;   ///< of these

private:
  void describe_fields();
  void make_cells();
  void find_thin();
  void find_boundary();
  void find_behind_thin();
  void make_stars();
  [[nodiscard]] bool is_near(std::uint32_t t, const Point& place) const;
  [[nodiscard]] std::size_t place_among_thin(std::uint32_t v) const;
  [[nodiscard]] double volume_of(const std::array<std::uint32_t, 4>& tet) const;
  [[nodiscard]] StarCones cones_of(std::uint32_t v) const;

  [[nodiscard]] double thin_height(std::uint32_t t) const { return thin_height_[body_of_[cells[t].v[0]]]; }

  std::vector<std::uint32_t> body_of_;       ///< by vertex, while the object is made: what hangs together by vertices
  std::vector<double> thin_height_;          ///< by body, up to which a tet is thin
  std::vector<std::uint32_t> thin_vertices_; ///< of thin tets, ascending
  std::vector<std::uint32_t> list_of_;       ///< by place in these
  std::vector<std::size_t> behind_begin_{0}; ///< by list, into behind_
  std::vector<std::uint32_t> behind_;        ///< tets
};

} // namespace ptet
