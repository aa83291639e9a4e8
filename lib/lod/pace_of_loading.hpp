// How many blocks to load at once where there is little time: few enough that the time is kept, as many as there is
// time for, as loading many together costs less than loading them one by one.
#pragma once

#include "lod/block_needs.hpp"

#include <limits>
#include <mutex>
#include <optional>

namespace ptet {

/// How much may be loaded at once. Work is in whatever unit takes about the same time.
struct LoadingLimit {
  double alone = std::numeric_limits<double>::infinity(); ///< of one thing
  double together = 0;                                    ///< of several

  /// Whether `more` may be done, too, where `work` is to be done.
  [[nodiscard]] bool allows(double work, double more) const {
    return work == 0 ? more <= alone : work + more <= together;
  }
};

/// Learns from each loading how much the next ones may be. Thread rule: any.
class PaceOfLoading {
public:
  void note(double work, double seconds);
  /// For whoever has so many seconds left: what that is enough for at the pace of the last loading, and at most four
  /// times as much as was ever loaded at once. The first time at least one thing, whatever it is. Where that takes more
  /// time than there is, as where a server answers late however little is asked, twice as much as the last time, as
  /// long as that is much the quicker way; where it is not, it is tried again later, and later each time.
  [[nodiscard]] LoadingLimit limit(double seconds_left, bool is_first) const;

private:
  static constexpr unsigned kWaits = 2;

  mutable std::mutex mutex_;
  double most_ = 0, last_work_ = 0, last_seconds_ = 0;
  double first_work_ = 0;                  ///< whatever the time is
  unsigned wait_ = 0, next_wait_ = kWaits; ///< loadings until more is tried
};

/// A closed set of blocks to be loaded together, as it is gathered.
class PartToLoad {
public:
  /// `start` is closed; `loaded` are those that take no work. Both `needs` and `loaded` must outlive it.
  PartToLoad(const BlockNeeds& needs, const BlockSet& loaded, BlockSet start)
      : needs_(needs), loaded_(loaded), start_(start), blocks_(std::move(start)) {}

  /// Adds a block and what it needs, and returns all that was added: nothing where the block is there already, or where
  /// it needs what is in `lost`. Adds nothing and returns nullopt where `limit` does not allow it; null: there is none.
  [[nodiscard]] std::optional<std::vector<std::uint32_t>> add(std::uint32_t block, const BlockSet& lost,
                                                              const LoadingLimit* limit);
  /// Takes out again what was added and is not loaded: no work is left.
  void keep_loaded();

  [[nodiscard]] const BlockSet& blocks() const { return blocks_; }
  /// What it takes to load those that are not loaded. See LoadingLimit.
  [[nodiscard]] double work() const { return work_; }

private:
  const BlockNeeds& needs_;
  const BlockSet& loaded_;
  BlockSet start_, blocks_;
  double work_ = 0;
};

} // namespace ptet
