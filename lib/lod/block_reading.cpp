#include "lod/block_reading.hpp"

#include "lod/pace_of_loading.hpp"

#include <algorithm>
#include <limits>

namespace ptet {
namespace {

/// Of the time that a request has, so much is there when all is read, whenever that is.
constexpr double kPartAfterReading = 0.25;

} // namespace

BlockReading::BlockReading(Hierarchy& hierarchy, const ResolvedRequest& request, const ProgressCallback& progress)
    : hierarchy_(hierarchy), request_(request), progress_(progress), cancellation_(progress),
      begin_(begin(cancellation_)), turn_(hierarchy.loader(), until(), cancellation()) {}

/// Nobody waits for the turn of what is cancelled already.
BlockReading::Clock::time_point BlockReading::begin(Cancellation& cancellation) {
  cancellation.check();
  return Clock::now();
}

void BlockReading::read(BlockSet& set, BlockSet& missing) {
  cancellation_.check();
  if (!may_load()) {
    hierarchy_.loader().keep_loaded(set);
    is_time_up_ = true;
    return;
  }
  hierarchy_.close(set);
  const BlockSet wanted = set;
  if (!request_.budgets.max_seconds) hierarchy_.loader().leave_out_failed(set, missing); // else see read_in_time
  if (!hierarchy_.loader().load_when_free(set, until(), cancellation())) {
    is_time_up_ = true;
    return;
  }
  for (std::size_t b = 0; b < set.size(); ++b) // both ways: what was missing before may be there now
    if (wanted[b] != 0) missing[b] = set[b] == 0 ? 1 : 0;
}

void BlockReading::read_in_time(BlockSet& set, BlockSet& missing, const BlocksByOrder& by_key, std::uint32_t reach,
                                std::uint64_t tets_per_record) {
  const bool has_lost = try_to_read_in_time(set, missing, by_key, reach, tets_per_record);
  if (has_lost && !is_time_up_ && !hierarchy_.loader().is_in_background())
    static_cast<void>(try_to_read_in_time(set, missing, by_key, reach, tets_per_record));
}

/// Returns whether there are blocks that could not be had.
bool BlockReading::try_to_read_in_time(BlockSet& set, BlockSet& missing, const BlocksByOrder& by_key,
                                       std::uint32_t reach, std::uint64_t tets_per_record) {
  const bool waits = !hierarchy_.loader().is_in_background();
  const std::vector<std::uint32_t> order = needs_first(by_key, reach, set);
  BlockSet loaded(set.size(), 1), lost(set.size(), 0);
  hierarchy_.loader().keep_loaded(loaded);
  if (!may_load()) { // no time is left, but what is there is there
    for (const std::uint32_t b : order)
      if (loaded[b] != 0) set[b] = 1;
    is_time_up_ = true;
    return false;
  }
  std::uint64_t tets = hierarchy_.header().base_tet_count;
  PaceOfLoading& pace = hierarchy_.loader().pace();
  for (std::size_t next = 0; next < order.size() && !is_time_up_;) {
    const auto begin = Clock::now();
    const LoadingLimit limit = pace.limit(seconds_left(tets), !has_loaded_);
    PartToLoad part(hierarchy_.loader().needs(), loaded, set);
    for (; next < order.size(); ++next) {
      if (seconds_left(tets) <= 0) {
        is_time_up_ = true;
        if (waits) part.keep_loaded();
        break;
      }
      if (part.blocks()[order[next]] != 0) continue;
      const auto added = part.add(order[next], lost, waits ? &limit : nullptr);
      if (!added) {
        is_time_up_ = part.work() == 0;
        break;
      }
      if (added->empty()) missing[order[next]] = 1;
      for (const std::uint32_t b : *added)
        if (waits || loaded[b] != 0) tets += tets_per_record * hierarchy_.blocks()[b].record_count;
    }
    set = part.blocks();
    read(set, missing);
    for (std::size_t b = 0; b < lost.size(); ++b)
      if (part.blocks()[b] != set[b]) lost[b] = 1;
    if (part.work() == 0) continue;
    has_loaded_ = true;
    if (waits && part.blocks() == set)
      pace.note(part.work(), std::chrono::duration<double>(Clock::now() - begin).count());
  }
  if (has_loaded_ || is_time_up_)
    grace_ = std::max(grace_, kPartAfterReading * *request_.budgets.max_seconds - seconds_left(tets));
  return std::find(lost.begin(), lost.end(), 1) != lost.end();
}

/// The blocks with a key of at least `reach`, but for those in `set`: those that others need before these.
std::vector<std::uint32_t> BlockReading::needs_first(const BlocksByOrder& by_key, std::uint32_t reach,
                                                     BlockSet set) const {
  const BlockSet none(set.size(), 0);
  std::vector<std::uint32_t> order;
  for (const auto& [key, b] : by_key) {
    if (key < reach) break;
    if (set[b] != 0) continue;
    std::vector<std::uint32_t> added = hierarchy_.loader().needs().add(set, b, none);
    std::sort(added.begin(), added.end());
    order.insert(order.end(), added.begin(), added.end());
  }
  return order;
}

void BlockReading::keep_loaded(BlockSet& set, BlockSet& missing) const {
  for (std::size_t b = 0; b < set.size(); ++b)
    if (set[b] != 0 && hierarchy_.content().block_loaded[b] == 0) {
      set[b] = 0;
      missing[b] = 1;
    }
}

// ---- time ----

/// Until when to wait for another thread that loads. None: as long as it takes, as with origins, for which all of the
/// file is read whatever the time.
std::optional<BlockReading::Clock::time_point> BlockReading::until() const {
  constexpr double kMost = 1e6;
  if (!request_.budgets.max_seconds || request_.origins) return std::nullopt;
  return begin_ + std::chrono::duration_cast<Clock::duration>(
                      std::chrono::duration<double>(std::min(*request_.budgets.max_seconds, kMost)));
}

bool BlockReading::is_late(std::uint64_t tets) const {
  return request_.budgets.max_seconds && seconds_left(tets) + grace() <= 0;
}

/// The seconds left for reading, when a mesh of so many tets is to be put out afterwards.
double BlockReading::seconds_left(std::uint64_t tets) const {
  constexpr double kSecondsPerTet = 40e-9; // from the cut to the mesh, as a rule
  const double passed = std::chrono::duration<double>(Clock::now() - begin_).count();
  return *request_.budgets.max_seconds - passed - kSecondsPerTet * static_cast<double>(tets);
}

/// Seconds more than there are for making something of what was read, where reading took nearly all of them, or more;
/// without limit where others read all the time: what is there is there.
double BlockReading::grace() const {
  return may_load() ? grace_ : std::numeric_limits<double>::infinity();
}

} // namespace ptet
