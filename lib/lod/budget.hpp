// What fits a budget, and the order in which it is spent.
#pragma once

#include "lod/hierarchy.hpp"
#include "lod/request.hpp"

#include <tuple>
#include <utility>
#include <vector>

namespace ptet {

/// A record's rank in the order in which a budget is spent, as far as order codes, which are rounded, tell. A record's
/// parents always rank before it: their order codes are no less than its own, and where they are equal their
/// generations are less.
///
/// A budget ends at the first wished record in this order that does not fit, with all that it needs, on top of what is
/// promised and of the wished ones before it. All who spend one come to the same end: find_cut(), which looks at
/// records as it reads them, and RunningCut, which goes by histograms or from where the last one ended.
struct BudgetRank {
  OrderCode key = 0;
  std::uint32_t generation = 0;
  std::uint32_t record = 0;

  friend bool operator<(const BudgetRank& a, const BudgetRank& b) {
    return std::tie(b.key, a.generation, a.record) < std::tie(a.key, b.generation, b.record);
  }
};

/// What splits add to the base.
struct AddedSize {
  std::uint64_t records = 0;
  std::uint64_t tets = 0;
  std::uint64_t faces = 0; ///< of the boundary

  AddedSize& operator+=(const AddedSize& other) {
    records += other.records;
    tets += other.tets;
    faces += other.faces;
    return *this;
  }
  AddedSize& operator-=(const AddedSize& other) {
    records -= other.records;
    tets -= other.tets;
    faces -= other.faces;
    return *this;
  }
};

/// What the split of a loaded record adds. The lock must be held.
[[nodiscard]] AddedSize added_by(const Refinement& refinement, RecordId r);

/// Blocks with the largest order codes of their records, largest first.
using BlocksByOrder = std::vector<std::pair<OrderCode, std::uint32_t>>;

/// The budgets for size.
class Budget {
public:
  /// Both must outlive it.
  Budget(const Hierarchy& hierarchy, const Budgets& budgets);

  [[nodiscard]] bool fits(const AddedSize& size) const;
  /// A first guess at the number of records that fit on top of `spent`, to read about the right number of blocks at
  /// once.
  [[nodiscard]] std::uint64_t expected_records(const AddedSize& spent) const;
  /// The order code down to which blocks must be read to have `rank` records; 0 when there are not so many.
  [[nodiscard]] OrderCode key_of_rank(const BlocksByOrder& blocks, std::uint64_t rank) const;

private:
  [[nodiscard]] std::uint64_t tets(const AddedSize& size) const;

  const Hierarchy& hierarchy_;
  const Budgets& budgets_;
  std::uint64_t vertex_bytes_;
};

} // namespace ptet
