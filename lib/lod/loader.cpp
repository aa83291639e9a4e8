#include "lod/loader.hpp"

#include <algorithm>
#include <thread>
#include <utility>

namespace ptet {
namespace {

/// Thrown out of a decoding that nobody wants any more.
struct Stopped {};

} // namespace

Loader::Loader(file::Reader& reader, file::Content& content, const OpenOptions& options,
               file::Reader::Batch::StarMeasured measured)
    : reader_(reader), content_(content), measured_(std::move(measured)), in_background_(options.background),
      needs_(reader.blocks()), losses_(needs_, options.background), in_use_(reader.blocks().size(), 0),
      pins_(reader.blocks().size(), 0) {
  room_ = options.limits.max_bytes - std::min(options.limits.max_bytes, reader.fixed_bytes());
  if (options.memory_limit > 0) room_ = std::min(room_, options.memory_limit);
  is_limited_ = bytes_of(BlockSet(reader.blocks().size(), 1)) > room_;
  if (is_limited_) {
    stored_.emplace(reader.blocks().size(), room_ / kShareOfStored);
    room_ -= room_ / kShareOfStored;
  }
  takes_turns_ = is_limited_ && !in_background_;
  if (in_background_) queue_ = std::make_unique<LoadQueue>([this](const BlockSet& asked) { return load_part(asked); });
}

Loader::~Loader() {
  if (!queue_) return;
  if (queue_->is_orphaned())
    (void)queue_.release(); // NOLINT(bugprone-unused-return-value): for good, see LoadQueue
  else
    queue_->finish(); // its thread looks at queue_ while it serves, so it must be there until then
}

// ---- locks ----

std::shared_lock<std::shared_mutex> Loader::lock() const {
  return lock_.shared();
}

// What goes wrong while the content changes is found by nobody half done.
template <class F>
decltype(auto) Loader::alone(F&& f) {
  const std::unique_lock guard = lock_.alone();
  try {
    return f();
  } catch (...) {
    spoil();
    throw;
  }
}

void Loader::spoil() {
  is_spoilt_ = true;
  std::fill(content_.block_loaded.begin(), content_.block_loaded.end(), char{0});
}

bool Loader::holds(const BlockSet& set) const {
  return !is_spoilt_ && is_subset(set, content_.block_loaded);
}

void Loader::keep_loaded(BlockSet& set) const {
  const auto guard = lock();
  intersect(set, content_.block_loaded);
}

Loader::Turn::Turn(Loader& loader) : loader_(loader) {
  if (loader.takes_turns_) lock_ = std::unique_lock(loader.turn_);
}

Loader::Turn::~Turn() {
  if (lock_) std::fill(loader_.in_use_.begin(), loader_.in_use_.end(), char{0});
}

void Loader::pin(const BlockSet& set) {
  const std::lock_guard guard(pins_mutex_);
  for (const std::uint32_t b : members(set))
    ++pins_[b];
}

void Loader::unpin(const BlockSet& set) {
  const std::lock_guard guard(pins_mutex_);
  for (const std::uint32_t b : members(set))
    --pins_[b];
}

// ---- sets of blocks ----

void Loader::close(BlockSet& set) const {
  std::vector<std::uint32_t> open;
  close(set, open);
}

std::uint64_t Loader::bytes_of(const BlockSet& set) const {
  std::uint64_t bytes = 0;
  for (const std::uint32_t b : members(set))
    bytes += reader_.decoded_bytes(b);
  return bytes;
}

// ---- loading ----

// Memory ran out while blocks were put in their places.
void Loader::repair() {
  if (!is_spoilt_) return;
  const std::lock_guard one(loading_);
  const BlockSet none(reader_.blocks().size(), 0);
  if (is_spoilt_) rebuild(none, none, true);
}

void Loader::load(BlockSet& closed, Cancellation* cancellation, const void* asker) {
  static_cast<void>(load_when_free(closed, std::nullopt, cancellation, asker));
}

bool Loader::load_when_free(BlockSet& closed, std::optional<Clock::time_point> until, Cancellation* cancellation,
                            const void* asker) {
  repair();
  bool is_there = false, is_free = true;
  {
    const auto guard = lock();
    is_there = holds(closed);
  }
  if (!is_there) {
    if (queue_) {
      queue_->ask_for(closed, asker);
    } else {
      const auto one = wait_for_others(until, cancellation);
      is_free = one.owns_lock();
      if (is_free) load_now(closed, cancellation);
    }
    keep_loaded(closed);
  } else if (asker != nullptr) {
    forget_asker(asker);
  }
  if (takes_turns_) unite(in_use_, closed);
  return is_free;
}

/// Does not own the lock where it waited in vain.
std::unique_lock<std::timed_mutex> Loader::wait_for_others(std::optional<Clock::time_point> until,
                                                           Cancellation* cancellation) {
  constexpr std::chrono::milliseconds kBetweenLooks{20};
  std::unique_lock one(loading_, std::defer_lock);
  while (!one.try_lock_until(std::min(until.value_or(Clock::time_point::max()), Clock::now() + kBetweenLooks))) {
    if (until && Clock::now() >= *until) break;
    if (cancellation != nullptr) cancellation->check();
  }
  return one;
}

// What failed before is tried again when there is nothing else to read: no source that fails for some blocks keeps the
// others, and the answer is whole but for these then, whatever time is left.
bool Loader::load(BlockSet& closed, Clock::time_point until, Cancellation* cancellation, const void* asker) {
  if (in_background_ || is_limited_) {
    load(closed, cancellation, asker);
    return true;
  }
  TimedLoad load{closed, BlockSet(closed.size(), 0), until, cancellation};
  keep_loaded(load.loaded);
  std::vector<std::uint32_t> again;
  for (const std::uint32_t b : losses_.failed())
    if (closed[b] != 0 && load.loaded[b] == 0) {
      load.lost[b] = 1;
      again.push_back(b);
    }
  bool is_all = load_some(load, closed);
  for (const std::uint32_t b : again) {
    if (!is_all || (load.has_tried && Clock::now() >= until)) break;
    load.lost[b] = 0;
    is_all = load_some(load, closed);
  }
  closed = std::move(load.loaded);
  return is_all;
}

/// Of the set what is neither loaded nor lost, nor needs what is lost. Returns false when it left some for later.
bool Loader::load_some(TimedLoad& load, const BlockSet& closed) {
  std::deque<std::uint32_t> left;
  for (const std::uint32_t b : members(closed))
    if (load.loaded[b] == 0) left.push_back(b);
  PaceOfLoading pace;
  while (true) {
    const auto begin = Clock::now();
    BlockSet part = load.loaded;
    double work = 0;
    for (; !left.empty(); left.pop_front()) {
      if (part[left.front()] != 0) continue;
      const std::vector<std::uint32_t> added = needs_.add(part, left.front(), load.lost);
      double more = 0;
      for (const std::uint32_t b : added)
        more += work_of(b);
      if (added.empty() || pace.has_time_for(work, more)) {
        work += more;
        continue;
      }
      if (work == 0) return false;
      for (const std::uint32_t b : added)
        part[b] = 0;
      break;
    }
    if (work == 0) return true;
    const BlockSet wanted = part;
    load.has_tried = true;
    const bool is_free = load_when_free(part, load.until, load.cancellation);
    if (is_free)
      for (std::size_t b = 0; b < part.size(); ++b)
        if (wanted[b] != part[b]) load.lost[b] = 1;
    load.loaded = std::move(part);
    if (!is_free) return false;
    const auto now = Clock::now();
    pace.note(work, std::chrono::duration<double>(now - begin).count(),
              std::chrono::duration<double>(load.until - now).count());
  }
}

void Loader::load_now(BlockSet& set, Cancellation* cancellation) {
  const BlockSet none(set.size(), 0);
  if (is_spoilt_) rebuild(none, none, true);
  needs_.leave_out(set, losses_.hopeless(), content_.block_loaded);
  if (is_limited_ && !make_room(set, cancellation)) return;
  decode(fetch(set, content_.block_loaded, cancellation), cancellation);
}

// Returns whether the set is to be loaded on top of what is there; else all has been done.
bool Loader::make_room(BlockSet& set, Cancellation* cancellation) {
  const BlockSet& loaded = content_.block_loaded;
  BlockSet all = loaded;
  unite(all, set);
  if (bytes_of(all) <= room_) return true;
  const BlockSet keep = what_fits(set);
  for (const std::uint32_t b : members(set))
    if (keep[b] == 0) losses_.note_no_room(b);
  intersect(set, keep);
  if (is_subset(set, loaded)) return false;
  all = loaded;
  unite(all, set);
  if (bytes_of(all) <= room_) return true;
  if (!rebuild(keep, BlockSet(loaded), false, cancellation)) {
    for (const std::uint32_t b : members(set))
      if (loaded[b] == 0) losses_.note_no_room(b);
  }
  return false;
}

// What must stay, then of the set what there is room for, coarse blocks first.
BlockSet Loader::what_fits(const BlockSet& set) const {
  BlockSet keep = takes_turns_ ? in_use_ : BlockSet(set.size(), 0);
  {
    const std::lock_guard guard(pins_mutex_);
    for (std::size_t b = 0; b < keep.size(); ++b)
      if (pins_[b] > 0) keep[b] = 1;
  }
  close(keep);
  intersect(keep, content_.block_loaded);
  // What does not fit once never does: the more is kept the less room there is.
  std::uint64_t bytes = bytes_of(keep);
  BlockSet unfit(set.size(), 0);
  for (const std::uint32_t b : members(set)) {
    if (keep[b] != 0) continue;
    const std::vector<std::uint32_t> added = needs_.add(keep, b, unfit);
    std::uint64_t with = bytes;
    for (const std::uint32_t a : added)
      with += reader_.decoded_bytes(a);
    if (!added.empty() && with <= room_) {
      bytes = with;
      continue;
    }
    unfit[b] = 1;
    for (const std::uint32_t a : added)
      keep[a] = 0;
  }
  return keep;
}

// What cannot be had goes out of the set, with what needs it.
std::vector<file::FetchedBlock> Loader::fetch(BlockSet& set, const BlockSet& loaded, Cancellation* cancellation) {
  std::vector<std::uint32_t> wanted, out;
  std::vector<file::FetchedBlock> fetched;
  for (const std::uint32_t b : members(set)) {
    if (loaded[b] != 0) continue;
    file::FetchedBlock stored = stored_ ? stored_->use(b) : file::FetchedBlock{};
    if (stored.bytes.empty())
      wanted.push_back(b);
    else
      fetched.push_back(std::move(stored));
  }
  auto read = reader_.fetch(
      wanted,
      [&](std::uint32_t b, const Error& error) {
        out.push_back(b);
        if (error.code() != ErrorCode::kCancelled)
          losses_.note({b, reader_.blocks()[b].offset, error.code(), error.what()});
      },
      [&] { return is_stopped() || (cancellation != nullptr && cancellation->is_wanted()); });
  if (is_stopped()) throw Stopped{};
  if (cancellation != nullptr) cancellation->check();
  for (file::FetchedBlock& block : read) {
    if (stored_) stored_->keep(block);
    fetched.push_back(std::move(block));
  }
  needs_.leave_out(set, std::move(out), loaded);
  std::erase_if(fetched, [&](const file::FetchedBlock& block) { return set[block.block] == 0; });
  std::sort(fetched.begin(), fetched.end(), [](const auto& a, const auto& b) { return a.block < b.block; });
  return fetched;
}

// All together, or, where it may be cancelled, a closed part at a time.
void Loader::decode(std::vector<file::FetchedBlock> fetched, Cancellation* cancellation) {
  const BlockSet none(needs_.size(), 0);
  BlockSet loaded = content_.block_loaded, target = loaded;
  std::vector<std::size_t> place(needs_.size(), 0);
  for (std::size_t i = 0; i < fetched.size(); ++i) {
    target[fetched[i].block] = 1;
    place[fetched[i].block] = i;
  }
  if (cancellation != nullptr) alone([&] { reader_.expect(fetched, content_); });
  for (std::size_t begin = 0; begin < fetched.size();) {
    BlockSet with = loaded;
    std::vector<file::FetchedBlock> part;
    for (; begin < fetched.size() && (cancellation == nullptr || part.size() < kBlocksBetweenLooks); ++begin)
      for (const std::uint32_t b : needs_.add(with, fetched[begin].block, none))
        part.push_back(std::move(fetched[place[b]]));
    try {
      decode_together(std::move(part));
    } catch (const file::BlockError& error) {
      losses_.note({error.block, error.block_offset, error.code(), error.what()});
      needs_.leave_out(target, {error.block}, none);
      rebuild(std::move(target), loaded, true);
      return;
    }
    loaded = std::move(with);
    if (cancellation != nullptr && begin < fetched.size()) cancellation->check();
  }
}

void Loader::decode_together(std::vector<file::FetchedBlock> fetched) {
  if (fetched.empty()) return;
  std::vector<std::uint32_t> blocks;
  blocks.reserve(fetched.size());
  for (const file::FetchedBlock& block : fetched)
    blocks.push_back(block.block);
  file::Reader::Batch batch = alone([&] { return reader_.begin(std::move(fetched), content_); });
  while (alone([&] { return batch.step(content_, kRecordsAtOnce, measured_); }))
    if (is_stopped()) throw Stopped{};
  alone([&] {
    batch.check(content_);
    for (const std::uint32_t b : blocks)
      content_.block_loaded[b] = 1;
    content_.refinement.settle(); // once all is read
  });
  losses_.forget(blocks);
}

// ---- making the content anew ----

// `must`: even when what was loaded and is to be kept cannot all be read again; else nothing is done then, and false
// returned.
bool Loader::rebuild(BlockSet keep, const BlockSet& was_loaded, bool must, Cancellation* cancellation) {
  const BlockSet none(keep.size(), 0);
  for (int attempt = 0;; ++attempt) {
    // A file with so many wrong blocks under right hashes is no accident.
    if (attempt == kMaxRebuilds) intersect(keep, was_loaded);
    if (attempt > kMaxRebuilds) keep = none;
    BlockSet readable = keep;
    auto fetched = fetch(readable, none, must ? nullptr : cancellation);
    if (!must) {
      BlockSet lost = keep;
      intersect(lost, was_loaded);
      if (!is_subset(lost, readable)) return false;
    }
    keep = std::move(readable);
    if (try_to_rebuild(keep, std::move(fetched))) return true;
    must = true;
  }
}

bool Loader::try_to_rebuild(BlockSet& keep, std::vector<file::FetchedBlock> fetched) {
  try {
    alone([&] { apply_alone(std::move(fetched)); });
  } catch (const file::BlockError& error) {
    losses_.note({error.block, error.block_offset, error.code(), error.what()});
    needs_.leave_out(keep, {error.block}, BlockSet(keep.size(), 0));
    return false;
  }
  losses_.forget(members(keep));
  return true;
}

// The old content goes first: there may be no room for both.
void Loader::apply_alone(std::vector<file::FetchedBlock> fetched) {
  ++revision_;
  spoil();
  content_.refinement = Refinement({}, 0, 0);
  content_.positions.bytes = {};
  content_.arrays = {};
  content_ = reader_.read_base();
  std::vector<std::uint32_t> blocks;
  blocks.reserve(fetched.size());
  for (const file::FetchedBlock& block : fetched)
    blocks.push_back(block.block);
  if (!fetched.empty()) {
    file::Reader::Batch batch = reader_.begin(std::move(fetched), content_);
    while (batch.step(content_, content_.generation.size(), measured_)) {
    }
    batch.check(content_);
  }
  for (const std::uint32_t b : blocks)
    content_.block_loaded[b] = 1;
  is_spoilt_ = false;
}

// ---- why not ----

bool Loader::waits_for(const BlockSet& missing) const {
  if (std::find(missing.begin(), missing.end(), 1) == missing.end()) return false;
  const LimitedBy limit = explain(missing).limited_by;
  return limit == LimitedBy::kLoading || limit == LimitedBy::kMemory;
}

// ---- the thread ----

// Coarse blocks first, some at a time. What a limit of memory keeps is decided over all that is asked.
bool Loader::load_part(const BlockSet& asked) {
  const std::lock_guard one(loading_);
  BlockSet possible = asked, part(asked.size(), 0);
  needs_.leave_out(possible, losses_.hopeless(), content_.block_loaded);
  std::size_t count = 0;
  bool has_more = false;
  for (const std::uint32_t b : members(possible)) {
    if (content_.block_loaded[b] != 0 && !is_limited_) continue;
    if (!is_limited_ && count++ == kBlocksAtOnce) {
      has_more = true;
      break;
    }
    part[b] = 1;
  }
  close(part);
  load_now(part, nullptr);
  return has_more;
}

void Loader::wait_until_loaded(const ProgressCallback& progress) {
  if (queue_) queue_->wait_until_done(progress);
}

} // namespace ptet
