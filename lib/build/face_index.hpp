// A dynamic index of boundary faces by bounding box: which faces may a triangle meet?
#pragma once

#include "build/working_complex.hpp"

#include <algorithm>
#include <vector>

#include <boost/geometry.hpp>
#include <boost/geometry/geometries/box.hpp>
#include <boost/geometry/geometries/point.hpp>
#include <boost/geometry/index/rtree.hpp>

namespace ptet::build {

class FaceIndex {
public:
  using Corners = std::array<Point, 3>;

  void build(const WorkingComplex& complex, const std::vector<Point>& positions, std::span<const SlotId> ghosts) {
    std::vector<Entry> entries;
    entries.reserve(ghosts.size());
    box_of_.resize(complex.slot_count());
    for (const SlotId s : ghosts) {
      Corners corners;
      std::size_t i = 0;
      for (const Vertex v : complex.slot(s).v)
        if (v != complex.dummy()) corners[i++] = positions[v];
      box_of_[s] = box(corners);
      entries.emplace_back(box_of_[s], s);
    }
    tree_ = Tree(entries.begin(), entries.end());
  }
  /// Appends the faces whose box meets that of the triangle.
  void query(const Corners& corners, std::vector<SlotId>& hits) const {
    for (auto it = tree_.qbegin(boost::geometry::index::intersects(box(corners))); it != tree_.qend(); ++it)
      hits.push_back(it->second);
  }
  void erase(SlotId s) { tree_.remove(Entry(box_of_[s], s)); }
  void replace(SlotId s, const Corners& corners) {
    erase(s);
    box_of_[s] = box(corners);
    tree_.insert(Entry(box_of_[s], s));
  }

private:
  using BoxPoint = boost::geometry::model::point<double, 3, boost::geometry::cs::cartesian>;
  using Box = boost::geometry::model::box<BoxPoint>;
  using Entry = std::pair<Box, SlotId>;
  using Tree = boost::geometry::index::rtree<Entry, boost::geometry::index::linear<16>>;

  static Box box(const Corners& c) {
    const auto [x0, x1] = std::minmax({c[0][0], c[1][0], c[2][0]});
    const auto [y0, y1] = std::minmax({c[0][1], c[1][1], c[2][1]});
    const auto [z0, z1] = std::minmax({c[0][2], c[1][2], c[2][2]});
    return {BoxPoint(x0, y0, z0), BoxPoint(x1, y1, z1)};
  }

  std::vector<Box> box_of_; ///< by slot; ghosts only
  Tree tree_;
};

} // namespace ptet::build
