#include "record/budget_rank.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace ptet {
namespace {

/// What a place counts: by collapse, by one kind of error beside another, by one alone.
constexpr std::uint64_t kStep = 10, kStepOfTwo = 11, kStepAlone = 5;

/// 0 where there is no error, however much it weighs, or no weight, however large it is.
double weighed(double weight, double error) {
  return error == 0 || weight == 0 ? 0 : weight * error;
}

/// Places by `key` of the record or of any that depends on it, largest first; of two alike the later collapse first.
/// What was there before stays where it is less.
void lower(std::vector<std::uint64_t>& place, std::uint64_t step, std::vector<double> key, const RecordStream& records,
           const StreamParents& parents) {
  for (std::size_t r = 0; r < key.size(); ++r)
    for_each_parent(records, parents, r, [&](std::uint32_t parent) { key[parent] = std::max(key[parent], key[r]); });
  std::vector<std::uint32_t> order(key.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return std::pair(key[b], b) < std::pair(key[a], a); });
  for (std::size_t i = 0; i < order.size(); ++i)
    place[order[i]] = std::min(place[order[i]], step * i);
}

} // namespace

std::vector<std::uint32_t> budget_rank(const RecordStream& records, const StreamParents& parents) {
  const std::size_t count = records.size(), fields = records.fields.size();
  const BudgetWeights& weights = records.budget;
  std::vector<std::uint64_t> place(count);
  for (std::size_t r = 0; r < count; ++r)
    place[r] = kStep * (count - 1 - r);
  const bool by_maximum = !weights.maximum.empty(), by_mean = weights.mean && records.has_squared_errors();
  const std::uint64_t step = by_maximum && by_mean ? kStepOfTwo : kStepAlone;
  std::vector<double> key(count);
  if (by_maximum) {
    for (std::size_t r = 0; r < count; ++r) {
      key[r] = weighed(weights.domain, records.domain_error[r]);
      for (std::size_t f = 0; f < fields; ++f)
        key[r] = std::max(key[r], weighed(weights.maximum[f], records.largest_error(r, f)));
    }
    lower(place, step, key, records, parents);
  }
  if (by_mean) {
    // Each field by its part of what all collapses changed: so fields of all kinds have their say.
    std::vector<double> all(fields);
    for (std::size_t i = 0; i < records.squared_error.size(); ++i)
      all[i % fields] += std::abs(records.squared_error[i]);
    for (std::size_t r = 0; r < count; ++r) {
      key[r] = 0;
      for (std::size_t f = 0; f < fields; ++f)
        if (all[f] > 0) key[r] = std::max(key[r], records.squared_error[r * fields + f] / all[f]);
    }
    lower(place, step, std::move(key), records, parents);
  }
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return std::pair(place[a], b) < std::pair(place[b], a); });
  std::vector<std::uint32_t> rank(count);
  for (std::uint32_t i = 0; i < count; ++i)
    rank[order[i]] = i;
  return rank;
}

} // namespace ptet
