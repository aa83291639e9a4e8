// What fits a budget, and the order in which it is spent.
#pragma once

#include "lod/hierarchy.hpp"
#include "lod/request.hpp"

#include <tuple>
#include <utility>
#include <vector>

namespace ptet {

/// A record's rank in the order in which a budget is spent: the last collapse is undone first, as far as order codes
/// tell.
///
/// Every prefix of the order is closed: the order code of a parent is no less than that of its child, and where they
/// are equal the parent's generation is less.
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

  AddedSize& operator+=(const AddedSize& other) {
    records += other.records;
    tets += other.tets;
    return *this;
  }
  AddedSize& operator-=(const AddedSize& other) {
    records -= other.records;
    tets -= other.tets;
    return *this;
  }
};

/// Blocks with the largest order codes of their records, largest first.
using BlocksByOrder = std::vector<std::pair<OrderCode, std::uint32_t>>;

class Budget {
public:
  /// Both must outlive it.
  Budget(const Hierarchy& hierarchy, const ResolvedRequest& request) : hierarchy_(hierarchy), request_(request) {}

  [[nodiscard]] bool fits(const AddedSize& size) const;
  /// A first guess at the number of records that fit, to read about the right number of blocks at once.
  [[nodiscard]] std::uint64_t expected_records() const;
  /// The order code down to which blocks must be read to have `rank` records; 0 when there are not so many.
  [[nodiscard]] OrderCode key_of_rank(const BlocksByOrder& blocks, std::uint64_t rank) const;

private:
  const Hierarchy& hierarchy_;
  const ResolvedRequest& request_;
};

} // namespace ptet
