// Reads the blocks that one request depends on: in the time that it has, for as long as its caller goes on wanting
// them, and around those that cannot be had.
#pragma once

#include "lod/budget.hpp"
#include "lod/cancellation.hpp"
#include "lod/hierarchy.hpp"
#include "lod/request.hpp"

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

namespace ptet {

/// The request's time runs from when it is made, and as long as it exists it is the request's turn to load. What is
/// read into a closed set leaves it closed; `missing`: of what was asked for, what could not be had. What was left
/// unread for want of time does not count as missing.
class BlockReading {
public:
  /// All must outlive it. Throws Error(kCancelled), as do those that read.
  BlockReading(Hierarchy& hierarchy, const ResolvedRequest& request, const ProgressCallback& progress);

  /// Reads a set and what it needs, and takes out of it what could not be had.
  void read(BlockSet& set, BlockSet& missing);
  /// Adds to a closed set the blocks with a key of at least `reach`, largest first, until the time is up. As many are
  /// read at once as it seems there is time for. `tets_per_record`: how much a record adds to the mesh that is to be
  /// put out afterwards. What could not be had is tried once more.
  void read_in_time(BlockSet& set, BlockSet& missing, const BlocksByOrder& by_key, std::uint32_t reach,
                    std::uint64_t tets_per_record);
  /// Of a set that was read, what is loaded now; the rest is missing. The hierarchy's lock must be held.
  void keep_loaded(BlockSet& set, BlockSet& missing) const;

  /// Whether blocks may be loaded. Not where others loaded all the time: then what is in memory already is all.
  [[nodiscard]] bool may_load() const { return turn_.has_come(); }
  /// Whether it is too late to make more of what was read: a mesh of so many tets can only just be put out in what time
  /// is left. Where reading took nearly all of the time, or more, there is some left.
  [[nodiscard]] bool is_late(std::uint64_t tets) const;
  /// Whether something was left out for want of time.
  [[nodiscard]] bool is_time_up() const { return is_time_up_; }
  void note_time_is_up() { is_time_up_ = true; }

private:
  using Clock = std::chrono::steady_clock;

  [[nodiscard]] static Clock::time_point begin(Cancellation& cancellation);
  [[nodiscard]] std::optional<Clock::time_point> until() const;
  [[nodiscard]] Cancellation* cancellation() { return progress_ ? &cancellation_ : nullptr; }
  [[nodiscard]] double seconds_left(std::uint64_t tets) const;
  [[nodiscard]] double grace() const;
  [[nodiscard]] std::vector<std::uint32_t> needs_first(const BlocksByOrder& by_key, std::uint32_t reach,
                                                       BlockSet set) const;
  [[nodiscard]] bool try_to_read_in_time(BlockSet& set, BlockSet& missing, const BlocksByOrder& by_key,
                                         std::uint32_t reach, std::uint64_t tets_per_record);

  Hierarchy& hierarchy_;
  const ResolvedRequest& request_;
  const ProgressCallback& progress_;
  Cancellation cancellation_;
  const Clock::time_point begin_;
  const Loader::Turn turn_;
  bool is_time_up_ = false;
  double grace_ = 0;        ///< seconds for what comes after reading, in spite of the time
  bool has_loaded_ = false; ///< or tried to, what was not there
};

} // namespace ptet
