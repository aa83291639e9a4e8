// Which blocks are decoded, and getting more: at once or by a thread of its own, within a limit of memory, around
// blocks that cannot be had.
//
//   wanted blocks, closed -> less the hopeless and what needs them -> less what does not fit the memory
//     -> fetch -> less what failed and what needs it -> decode -> loaded, closed
//
// Loaded blocks are always closed under BlockInfo::needs, so whatever is left out, a closed cut less the records that
// are not loaded is a closed cut. A block whose records turn out wrong while they are applied spoils the content: it is
// made anew from the base mesh with what is good. Ids of records and vertices stay; versions are numbered anew.
//
// Locks, in the order in which they are taken: turn, loading, content, and one of those of the queue, the losses and
// the pins. Decoding takes the content's for some dozen records at a time, see ContentLock.
#pragma once

#include "formats/ptet/owned_mutex.hpp"
#include "formats/ptet/reader.hpp"
#include "lod/block_losses.hpp"
#include "lod/block_needs.hpp"
#include "lod/cancellation.hpp"
#include "lod/content_lock.hpp"
#include "lod/load_queue.hpp"
#include "lod/loading_memory.hpp"
#include "lod/pace_of_loading.hpp"
#include "lod/stored_blocks.hpp"
#include "ptet/dataset.hpp"
#include "ptet/source.hpp"

#include <atomic>
#include <chrono>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <vector>

namespace ptet {

class Loader {
public:
  /// `measured` is called for each record that is decoded, the content's lock held alone. `reader` and `content` must
  /// outlive the loader; nobody else may load.
  Loader(file::Reader& reader, file::Content& content, const OpenOptions& options,
         file::Reader::Batch::StarMeasured measured);
  /// Waits for a read of the source that is under way.
  ~Loader();
  Loader(const Loader&) = delete;
  Loader& operator=(const Loader&) = delete;

  /// Hold it to look at the content. A thread must not take it twice. What a load that ran out of memory left behind is
  /// put right first, which may take as long as reading the base mesh, or what another thread makes anew where it met
  /// damage. Throws Error(kIo) in a process that was forked from the one whose thread loads in the background,
  /// as do the others that take locks; std::bad_alloc, and then there is nothing to look at.
  [[nodiscard]] std::shared_lock<std::shared_mutex> lock();
  /// Throws that Error there. Of what never changes, too, only what asks the source has to be refused.
  void refuse_orphaned() const {
    if (queue_) queue_->refuse_orphaned();
  }
  /// Are all of the set loaded? The lock must be held.
  [[nodiscard]] bool holds(const BlockSet& set) const;

  /// See BlockNeeds.
  void close(BlockSet& set) const;
  void close(BlockSet& set, std::vector<std::uint32_t>& open) const { needs_.close(set, open); }
  [[nodiscard]] const BlockNeeds& needs() const { return needs_; }
  /// Loads a closed set and takes out of it what is not loaded then; it stays closed. With OpenOptions::background only
  /// asks for the loading. Takes the lock itself. Where memory is limited, to be called under a Turn. Throws
  /// std::bad_alloc, and in the background what the thread met; nothing of the file or its source. Throws
  /// Error(kCancelled) between blocks, not while the content is made anew; what was decoded until then stays.
  /// Throws Error(kBadArgument) in a thread that loads already, when blocks are lacking.
  /// `asker`: see LoadQueue.
  void load(BlockSet& closed, Cancellation* cancellation = nullptr, const void* asker = nullptr);
  /// The same, but waits for another thread that loads no longer than `until`; then loads nothing and returns false.
  [[nodiscard]] bool load_when_free(BlockSet& closed, std::optional<std::chrono::steady_clock::time_point> until,
                                    Cancellation* cancellation = nullptr, const void* asker = nullptr);
  /// The same some blocks at a time, coarse ones first and those last that failed before, and as it seems by `until`:
  /// at least one that is not there yet, but none while another thread loads until then. Returns false when it left
  /// blocks for later that have not failed. Where memory is limited all are loaded at once.
  [[nodiscard]] bool load(BlockSet& closed, std::chrono::steady_clock::time_point until,
                          Cancellation* cancellation = nullptr, const void* asker = nullptr);
  /// In the background: what the asker has asked for is wanted no more.
  void forget_asker(const void* asker) {
    if (queue_) queue_->forget_asker(asker);
  }
  /// Takes out of the set what is not loaded. Takes the lock itself.
  void keep_loaded(BlockSet& set);

  using Shortfall = ptet::Shortfall;
  /// See BlockLosses.
  [[nodiscard]] Shortfall explain(const BlockSet& missing) const { return losses_.explain(missing); }
  /// Whether who lacks these blocks had better not go on to further ones: they are still to be read, or memory is
  /// short.
  [[nodiscard]] bool waits_for(const BlockSet& missing) const;
  /// Takes out of the set those that are missing because they could not be read, and what needs them: not to be tried
  /// twice for one request. Where a thread loads in the background it is the one to know.
  void leave_out_failed(BlockSet& set, const BlockSet& missing);

  /// Returns once nothing asked for is left to do. Throws Error(kCancelled) when `progress` says so, and what the
  /// thread met besides block failures.
  void wait_until_loaded(const ProgressCallback& progress);

  /// While one exists, blocks loaded by its owner are not dropped. Where memory is limited there is one at a time; a
  /// thread that loads in the background takes no heed of them. Throws Error(kBadArgument) in its owner's thread.
  class Turn {
  public:
    /// Waits no longer than `until`. Throws Error(kCancelled).
    explicit Turn(Loader& loader, std::optional<std::chrono::steady_clock::time_point> until = std::nullopt,
                  Cancellation* cancellation = nullptr);
    ~Turn();
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

    /// False when the time was up before those of others: then nothing may be loaded.
    [[nodiscard]] bool has_come() const { return !loader_.takes_turns_ || lock_.owns_lock(); }

  private:
    Loader& loader_;
    std::unique_lock<file::OwnedMutex> lock_;
  };

  /// Whether this is the thread that loads in the background, as within a read of the source.
  [[nodiscard]] bool is_own_thread() const { return queue_ && queue_->is_own_thread(); }
  /// Has that thread let its owner go, see LoadQueue.
  void end_with(LoadQueue::Owner owner) { queue_->end_with(std::move(owner)); }

  [[nodiscard]] PaceOfLoading& pace() { return pace_; }
  /// Whether a thread of its own loads: nobody waits then, what is there is used.
  [[nodiscard]] bool is_in_background() const { return in_background_; }
  /// Whether blocks may be dropped: not all fit the memory.
  [[nodiscard]] bool is_limited() const { return memory_.is_limited(); }
  /// Limits::max_bytes with which all fit, an estimate.
  [[nodiscard]] std::uint64_t bytes_for_all() const { return memory_.bytes_for_all(); }
  /// Pinned blocks are not dropped while they are loaded; pins count. Pin first, then load. Neither takes memory.
  void pin(const BlockSet& set) { count_pins(set, 1); }
  void unpin(const BlockSet& set) { count_pins(set, ~0U); }
  /// Grows whenever the content was made anew: versions have other ids then, and, if its bytes could not be read again,
  /// even a pinned block may be gone. The lock must be held.
  [[nodiscard]] std::uint64_t revision() const { return revision_; }

private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kRecordsAtOnce = 64; ///< decoded between two chances for readers
  static constexpr std::size_t kBlocksAtOnce = 32;  ///< decoded by the thread before it looks what is asked for last
  static constexpr std::size_t kBlocksBetweenLooks = 8; ///< decoded by others before they can be cancelled
  static constexpr int kMaxRebuilds = 16;

  template <class F>
  decltype(auto) alone(F&& f);
  void spoil();

  void count_pins(const BlockSet& set, std::uint32_t change);
  /// A load() that is to be done by some time.
  struct TimedLoad {
    BlockSet loaded, lost; ///< what it has so far, and what could not be had
    Clock::time_point until;
    Cancellation* cancellation = nullptr;
    bool has_tried = false; ///< whether it has begun to read or decode anything
  };
  [[nodiscard]] bool load_some(TimedLoad& load, const BlockSet& closed);
  void load_now(BlockSet& set, Cancellation* cancellation);
  [[nodiscard]] bool make_room(BlockSet& set, Cancellation* cancellation);
  [[nodiscard]] BlockSet what_must_stay() const;
  [[nodiscard]] std::vector<file::FetchedBlock> fetch(BlockSet& set, const BlockSet& loaded,
                                                      Cancellation* cancellation = nullptr);
  void decode(std::vector<file::FetchedBlock> fetched, Cancellation* cancellation);
  void decode_together(std::vector<file::FetchedBlock> fetched);
  void repair();
  bool rebuild(BlockSet keep, const BlockSet& was_loaded, bool must, Cancellation* cancellation = nullptr);
  bool try_to_rebuild(BlockSet& keep, std::vector<file::FetchedBlock> fetched);
  void apply_alone(std::vector<file::FetchedBlock> fetched);

  [[nodiscard]] bool load_part(const BlockSet& asked);
  [[nodiscard]] bool is_stopped() const { return queue_ && queue_->is_stopped(); }
  [[nodiscard]] bool is_orphaned() const { return queue_ && queue_->is_orphaned(); }

  file::Reader& reader_;
  file::Content& content_;
  const file::Reader::Batch::StarMeasured measured_;
  const bool in_background_;
  const BlockNeeds needs_;
  const LoadingMemory memory_;
  BlockLosses losses_;
  const bool takes_turns_;

  ContentLock lock_;
  std::uint64_t revision_ = 0;         ///< under the content's lock
  std::atomic<bool> is_spoilt_{false}; ///< the content must be made anew; changes under the content's lock

  PaceOfLoading pace_; ///< of whoever has little time
  file::OwnedMutex turn_;
  BlockSet in_use_; ///< by the owner of the turn
  file::OwnedMutex loading_;
  std::optional<StoredBlocks> stored_; ///< of who loads; where not all blocks fit

  mutable std::mutex pins_mutex_;
  std::vector<std::uint32_t> pins_;
  std::unique_ptr<LoadQueue> queue_; ///< in the background; last: its thread works on what is above
};

} // namespace ptet
