#include "formats/ptet/cells.hpp"

#include "formats/ptet/ordering.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

namespace ptet::file {
namespace {

using Records = std::vector<std::uint32_t>;

/// Planes that are tried along each axis: they part the records in so many shares, less one.
constexpr std::size_t kShares = 20;
/// Where these planes lie is found from so many of the records at most.
constexpr std::size_t kSample = 4096;

class Divider {
public:
  Divider(const TetMesh& mesh, const RecordStream& records, const StreamParents& parents,
          const std::vector<std::uint32_t>& generation, std::size_t most_records)
      : mesh_(mesh), records_(records), parents_(parents), generation_(generation), most_records_(most_records),
        reach_(records.size()), in_set_(records.size(), 0) {}

  CellTree run() {
    Records all(records_.size());
    std::iota(all.begin(), all.end(), 0U);
    measure(all);
    divide(std::move(all));
    return std::move(tree_);
  }

private:
  /// The box around the vertices of a record and of all records of the set that depend on it.
  struct Reach {
    Point least, greatest;
  };
  struct Plane {
    std::size_t axis;
    double at; ///< coordinate along the axis; what lies below it is left
  };

  void measure(const Records& set) {
    ++stamp_;
    for (const std::uint32_t record : set) {
      in_set_[record] = stamp_;
      reach_[record].least = reach_[record].greatest = mesh_.position(records_.removed[record]);
    }
    Records fine_to_coarse = set;
    std::sort(fine_to_coarse.begin(), fine_to_coarse.end(), [&](std::uint32_t a, std::uint32_t b) {
      return std::pair(generation_[b], a) < std::pair(generation_[a], b);
    });
    for (const std::uint32_t record : fine_to_coarse) {
      for_each_parent(records_, parents_, record, [&](std::uint32_t parent) {
        if (in_set_[parent] != stamp_) return;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          reach_[parent].least[axis] = std::min(reach_[parent].least[axis], reach_[record].least[axis]);
          reach_[parent].greatest[axis] = std::max(reach_[parent].greatest[axis], reach_[record].greatest[axis]);
        }
      });
    }
  }

  /// Coordinates along the axis that part the middles of the records' reaches in shares; ascending.
  [[nodiscard]] std::vector<double> places(const Records& set, std::size_t axis) const {
    std::vector<double> middles;
    const std::size_t step = (set.size() + kSample - 1) / kSample;
    for (std::size_t i = 0; i < set.size(); i += step)
      middles.push_back((reach_[set[i]].least[axis] + reach_[set[i]].greatest[axis]) / 2);
    std::sort(middles.begin(), middles.end());
    std::vector<double> places;
    for (std::size_t share = 1; share < kShares; ++share)
      places.push_back(middles[share * middles.size() / kShares]);
    return places;
  }

  /// The plane with the fewest records in the separator, as a part of the geometric mean of what lies on both sides: a
  /// reader of one place needs the separator and one side. Dense places would have the most in the middle.
  [[nodiscard]] std::optional<Plane> best_plane(const Records& set) const {
    std::optional<Plane> best;
    double least_cost = std::numeric_limits<double>::infinity();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::vector<double> at = places(set, axis);
      // Of each record the planes that it lies left of are the last ones, those that it lies right of the first ones.
      std::vector<std::size_t> left(at.size() + 1), right(at.size() + 1);
      for (const std::uint32_t record : set) {
        ++left[static_cast<std::size_t>(std::upper_bound(at.begin(), at.end(), reach_[record].greatest[axis]) -
                                        at.begin())];
        ++right[static_cast<std::size_t>(std::upper_bound(at.begin(), at.end(), reach_[record].least[axis]) -
                                         at.begin())];
      }
      std::size_t left_count = 0, right_count = set.size();
      for (std::size_t plane = 0; plane < at.size(); ++plane) {
        left_count += left[plane];
        right_count -= right[plane];
        if (left_count == 0 || right_count == 0) continue;
        // One more, so that of planes that separate nothing the one in the middle is taken.
        const double cost = static_cast<double>(set.size() - left_count - right_count + 1) /
                            std::sqrt(static_cast<double>(left_count) * static_cast<double>(right_count));
        if (cost >= least_cost) continue;
        least_cost = cost;
        best = Plane{axis, at[plane]};
      }
    }
    return best;
  }

  // The reach of the records must have been measured: in `set`, or in one that has nothing more that depends on them.
  void divide(Records set) {
    if (set.empty()) return;
    const std::size_t node = tree_.nodes.size();
    tree_.nodes.push_back({static_cast<std::uint32_t>(tree_.cells.size()), 0, 0});
    if (const auto plane = set.size() > most_records_ ? best_plane(set) : std::nullopt) {
      divide(std::move(set), *plane);
    } else {
      std::sort(set.begin(), set.end());
      tree_.cells.push_back(std::move(set));
    }
    tree_.nodes[node].end = static_cast<std::uint32_t>(tree_.cells.size());
    tree_.nodes[node].after = static_cast<std::uint32_t>(tree_.nodes.size());
  }
  void divide(Records set, const Plane& plane) {
    Records left, right, separator;
    for (const std::uint32_t record : set) {
      const Reach& reach = reach_[record];
      (reach.greatest[plane.axis] < plane.at ? left
       : reach.least[plane.axis] >= plane.at ? right
                                             : separator)
          .push_back(record);
    }
    set = Records(); // {} would keep its memory
    if (separator.size() > most_records_) measure(separator);
    divide(std::move(separator));
    divide(std::move(left));
    divide(std::move(right));
  }

  const TetMesh& mesh_;
  const RecordStream& records_;
  const StreamParents& parents_;
  const std::vector<std::uint32_t>& generation_;
  const std::size_t most_records_;
  std::vector<Reach> reach_;
  std::vector<std::uint32_t> in_set_; ///< by record: stamp of the set it was last measured in
  std::uint32_t stamp_ = 0;
  CellTree tree_;
};

} // namespace

std::vector<CellTree::Node> CellTree::parts(const std::vector<std::size_t>& count, std::size_t most) const {
  std::vector<std::size_t> before(cells.size() + 1);
  std::partial_sum(count.begin(), count.end(), before.begin() + 1);
  std::vector<Node> parts;
  for (std::uint32_t i = 0; i < nodes.size();) {
    const Node& node = nodes[i];
    const bool is_cell = node.after == i + 1;
    if (!is_cell && before[node.end] - before[node.begin] > most) {
      ++i;
      continue;
    }
    parts.push_back(node);
    i = node.after;
  }
  return parts;
}

CellTree divide_into_cells(const TetMesh& mesh, const RecordStream& records, const StreamParents& parents,
                           const std::vector<std::uint32_t>& generation, std::size_t most_records) {
  return Divider(mesh, records, parents, generation, most_records).run();
}

} // namespace ptet::file
