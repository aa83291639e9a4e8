// How many blocks to load at once where there is little time: few enough that the time is kept, as many as there is
// time for, as loading many together costs less than loading them one by one.
#pragma once

#include "lod/block_needs.hpp"

#include <algorithm>
#include <limits>
#include <optional>

namespace ptet {

/// Learns from each loading how much the next one may be: one thing first, then at most four times as much as before,
/// and what it seems there is time for. Work is in whatever unit takes about the same time.
class PaceOfLoading {
public:
  /// Whether `more` may be done, too, where `work` is to be done.
  [[nodiscard]] bool has_time_for(double work, double more) const {
    return work == 0 ? more <= affordable_ : work + more <= std::min(kMostMore * most_, affordable_);
  }
  void note(double work, double seconds, double seconds_left) {
    most_ = std::max(most_, work);
    affordable_ = std::max(seconds_left, 0.0) / std::max(seconds, 1e-9) * work;
  }

private:
  static constexpr double kMostMore = 4;
  double most_ = 0, affordable_ = std::numeric_limits<double>::infinity();
};

/// A closed set of blocks to be loaded together, as it is gathered.
class PartToLoad {
public:
  /// `start` is closed; `loaded` are those that take no work. Both `needs` and `loaded` must outlive it.
  PartToLoad(const BlockNeeds& needs, const BlockSet& loaded, BlockSet start)
      : needs_(needs), loaded_(loaded), start_(start), blocks_(std::move(start)) {}

  /// Adds a block and what it needs, and returns all that was added: nothing where the block is there already, or where
  /// it needs what is in `lost`. Adds nothing and returns nullopt where `pace` has no time for them; null: there is.
  [[nodiscard]] std::optional<std::vector<std::uint32_t>> add(std::uint32_t block, const BlockSet& lost,
                                                              const PaceOfLoading* pace);
  /// Takes out again what was added and is not loaded: no work is left.
  void keep_loaded();

  [[nodiscard]] const BlockSet& blocks() const { return blocks_; }
  /// What it takes to load those that are not loaded. See PaceOfLoading.
  [[nodiscard]] double work() const { return work_; }

private:
  const BlockNeeds& needs_;
  const BlockSet& loaded_;
  BlockSet start_, blocks_;
  double work_ = 0;
};

} // namespace ptet
