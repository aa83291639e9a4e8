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

/// The planes that are tried along each axis: those with these shares of the records below them.
constexpr std::array kShares = {0.4, 0.5, 0.6};
/// What makes a plane bad: each record in the separator costs 1, each that one side has more than the other this.
constexpr double kImbalance = 0.1;

class Divider {
public:
  Divider(const TetMesh& mesh, const RecordStream& records, const std::vector<std::uint32_t>& consumers,
          const std::vector<std::uint32_t>& generation, std::size_t most_records)
      : mesh_(mesh), records_(records), consumers_(consumers), generation_(generation), most_records_(most_records),
        reach_(records.size()), in_set_(records.size(), 0) {}

  std::vector<Records> run() {
    Records all(records_.size());
    std::iota(all.begin(), all.end(), 0U);
    measure(all);
    divide(std::move(all));
    return std::move(cells_);
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
      for_each_parent(records_, consumers_, record, [&](std::uint32_t parent) {
        if (in_set_[parent] != stamp_) return;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          reach_[parent].least[axis] = std::min(reach_[parent].least[axis], reach_[record].least[axis]);
          reach_[parent].greatest[axis] = std::max(reach_[parent].greatest[axis], reach_[record].greatest[axis]);
        }
      });
    }
  }

  [[nodiscard]] std::optional<Plane> best_plane(const Records& set) const {
    std::optional<Plane> best;
    double least_cost = std::numeric_limits<double>::infinity();
    std::vector<double> middles(set.size());
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t i = 0; i < set.size(); ++i)
        middles[i] = (reach_[set[i]].least[axis] + reach_[set[i]].greatest[axis]) / 2;
      for (const double share : kShares) {
        const auto rank = static_cast<std::ptrdiff_t>(share * static_cast<double>(set.size()));
        std::nth_element(middles.begin(), middles.begin() + rank, middles.end());
        const double at = middles[static_cast<std::size_t>(rank)];
        std::size_t left = 0, right = 0;
        for (const std::uint32_t record : set) {
          left += reach_[record].greatest[axis] < at ? 1 : 0;
          right += reach_[record].least[axis] >= at ? 1 : 0;
        }
        if (left == set.size() || right == set.size() || left + right == 0) continue;
        const double cost = static_cast<double>(set.size() - left - right) +
                            kImbalance * std::fabs(static_cast<double>(left) - static_cast<double>(right));
        if (cost >= least_cost) continue;
        least_cost = cost;
        best = Plane{axis, at};
      }
    }
    return best;
  }

  // The reach of the records must have been measured: in `set`, or in one that has nothing more that depends on them.
  void divide(Records set) {
    const auto plane = set.size() > most_records_ ? best_plane(set) : std::nullopt;
    if (!plane) {
      if (set.empty()) return;
      std::sort(set.begin(), set.end());
      cells_.push_back(std::move(set));
      return;
    }
    Records left, right, separator;
    for (const std::uint32_t record : set) {
      const Reach& reach = reach_[record];
      (reach.greatest[plane->axis] < plane->at ? left
       : reach.least[plane->axis] >= plane->at ? right
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
  const std::vector<std::uint32_t>& consumers_;
  const std::vector<std::uint32_t>& generation_;
  const std::size_t most_records_;
  std::vector<Reach> reach_;
  std::vector<std::uint32_t> in_set_; ///< by record: stamp of the set it was last measured in
  std::uint32_t stamp_ = 0;
  std::vector<Records> cells_;
};

} // namespace

std::vector<std::vector<std::uint32_t>> divide_into_cells(const TetMesh& mesh, const RecordStream& records,
                                                          const std::vector<std::uint32_t>& consumers,
                                                          const std::vector<std::uint32_t>& generation,
                                                          std::size_t most_records) {
  return Divider(mesh, records, consumers, generation, most_records).run();
}

} // namespace ptet::file
