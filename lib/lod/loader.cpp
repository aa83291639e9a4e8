#include "lod/loader.hpp"

#include <algorithm>
#include <thread>
#include <utility>

namespace ptet {
namespace {

/// Thrown out of a decoding that nobody wants any more.
struct Stopped {};

/// The returned lock is owned unless the time was up first.
std::unique_lock<file::OwnedMutex> wait_for_others(file::OwnedMutex& mutex,
                                                   std::optional<std::chrono::steady_clock::time_point> until,
                                                   Cancellation* cancellation) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds kBetweenLooks{20};
  std::unique_lock one(mutex, std::defer_lock);
  while (!one.try_lock_until(std::min(until.value_or(Clock::time_point::max()), Clock::now() + kBetweenLooks))) {
    if (until && Clock::now() >= *until) break;
    if (cancellation != nullptr) cancellation->check();
  }
  return one;
}

} // namespace

Loader::Loader(file::Reader& reader, file::Content& content, const OpenOptions& options,
               file::Reader::Batch::StarMeasured measured)
    : reader_(reader), content_(content), measured_(std::move(measured)), in_background_(options.background),
      needs_(reader.blocks()), memory_(reader, needs_, options), losses_(needs_, options.background),
      takes_turns_(memory_.is_limited() && !options.background), in_use_(needs_.size(), 0), pins_(needs_.size(), 0) {
  if (memory_.is_limited()) stored_.emplace(needs_.size(), memory_.bytes_for_stored());
  if (in_background_) queue_ = std::make_unique<LoadQueue>([this](const BlockSet& asked) { return load_part(asked); });
}

Loader::~Loader() {
  if (!queue_) return;
  if (is_orphaned())
    (void)queue_.release(); // NOLINT(bugprone-unused-return-value): for good, see LoadQueue
  else
    queue_->finish(); // its thread looks at queue_ while it serves, so it must be there until then
}

// ---- locks ----

std::shared_lock<std::shared_mutex> Loader::lock() {
  refuse_orphaned();
  while (true) {
    repair();
    auto guard = lock_.shared();
    if (!is_spoilt_) return guard;
  }
}

// When something is thrown amid a change the content is marked spoilt, so that nobody finds it half done.
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
  return is_subset(set, content_.block_loaded);
}

void Loader::keep_loaded(BlockSet& set) {
  const auto guard = lock();
  intersect(set, content_.block_loaded);
}

Loader::Turn::Turn(Loader& loader, std::optional<Clock::time_point> until, Cancellation* cancellation)
    : loader_(loader) {
  if (loader.takes_turns_) lock_ = wait_for_others(loader.turn_, until, cancellation);
}

Loader::Turn::~Turn() {
  if (lock_) std::fill(loader_.in_use_.begin(), loader_.in_use_.end(), char{0});
}

void Loader::count_pins(const BlockSet& set, std::uint32_t change) {
  if (is_orphaned()) return;
  const std::lock_guard guard(pins_mutex_);
  for (std::size_t b = 0; b < set.size(); ++b)
    if (set[b] != 0) pins_[b] += change;
}

void Loader::close(BlockSet& set) const {
  std::vector<std::uint32_t> open;
  close(set, open);
}

// ---- loading ----

// For when memory ran out while blocks were put in their places.
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
  bool is_there = false, is_free = true;
  {
    const auto guard = lock();
    is_there = holds(closed);
  }
  if (!is_there) {
    if (queue_) {
      queue_->ask_for(closed, asker);
    } else {
      const auto one = wait_for_others(loading_, until, cancellation);
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

// Blocks that failed before are tried again last, so that a source that fails for some blocks does not keep the others
// waiting. When only these are left the answer is not called incomplete for want of time.
bool Loader::load(BlockSet& closed, Clock::time_point until, Cancellation* cancellation, const void* asker) {
  if (in_background_ || is_limited()) {
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

/// Loads those of the set that are not loaded, not lost, and need nothing lost. Returns false when some are left for
/// later.
bool Loader::load_some(TimedLoad& load, const BlockSet& closed) {
  const std::vector<std::uint32_t> wanted = members(closed);
  for (auto next = wanted.begin();;) {
    const auto begin = Clock::now();
    const BlockSet before = load.loaded;
    const LoadingLimit limit = pace_.limit(std::chrono::duration<double>(load.until - begin).count(), !load.has_tried);
    PartToLoad part(needs_, before, before);
    while (next != wanted.end() && part.add(*next, load.lost, &limit))
      ++next;
    if (part.work() == 0) return next == wanted.end();
    load.has_tried = true;
    load.loaded = part.blocks();
    if (!load_when_free(load.loaded, load.until, load.cancellation)) return false;
    for (std::size_t b = 0; b < load.lost.size(); ++b)
      if (part.blocks()[b] != load.loaded[b]) load.lost[b] = 1;
    if (part.blocks() == load.loaded)
      pace_.note(part.work(), std::chrono::duration<double>(Clock::now() - begin).count());
  }
}

void Loader::load_now(BlockSet& set, Cancellation* cancellation) {
  const BlockSet none(set.size(), 0);
  if (is_spoilt_) rebuild(none, none, true);
  needs_.leave_out(set, losses_.hopeless(), content_.block_loaded);
  if (is_limited() && !make_room(set, cancellation)) return;
  decode(fetch(set, content_.block_loaded, cancellation), cancellation);
}

// Returns true when the set fits on top of what is there and is still to be loaded; false when all has been done.
bool Loader::make_room(BlockSet& set, Cancellation* cancellation) {
  const BlockSet& loaded = content_.block_loaded;
  BlockSet all = loaded;
  unite(all, set);
  if (memory_.fits(all)) return true;
  const BlockSet keep = memory_.what_fits(what_must_stay(), set);
  for (const std::uint32_t b : members(set))
    if (keep[b] == 0) losses_.note_no_room(b);
  intersect(set, keep);
  if (is_subset(set, loaded)) return false;
  all = loaded;
  unite(all, set);
  if (memory_.fits(all)) return true;
  if (!rebuild(keep, BlockSet(loaded), false, cancellation)) {
    for (const std::uint32_t b : members(set))
      if (loaded[b] == 0) losses_.note_no_room(b);
  }
  return false;
}

BlockSet Loader::what_must_stay() const {
  BlockSet keep = takes_turns_ ? in_use_ : BlockSet(needs_.size(), 0);
  {
    const std::lock_guard guard(pins_mutex_);
    for (std::size_t b = 0; b < keep.size(); ++b)
      if (pins_[b] > 0) keep[b] = 1;
  }
  close(keep);
  intersect(keep, content_.block_loaded);
  return keep;
}

// Reads the bytes of the blocks of the set that are not in `loaded`. Takes out of the set those that cannot be had and
// those that need them: these are not read any more.
std::vector<file::FetchedBlock> Loader::fetch(BlockSet& set, const BlockSet& loaded, Cancellation* cancellation) {
  std::vector<std::uint32_t> wanted;
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
        losses_.note({b, reader_.blocks()[b].offset, error.code(), error.what()});
        needs_.leave_out(set, {b}, loaded);
      },
      [&](std::uint32_t b) { return set[b] != 0; },
      [&] { return is_stopped() || (cancellation != nullptr && cancellation->is_wanted()); });
  if (is_stopped()) throw Stopped{};
  if (cancellation != nullptr) cancellation->check();
  for (file::FetchedBlock& block : read) {
    if (stored_) stored_->keep(block);
    fetched.push_back(std::move(block));
  }
  std::erase_if(fetched, [&](const file::FetchedBlock& block) { return set[block.block] == 0; });
  std::sort(fetched.begin(), fetched.end(), [](const auto& a, const auto& b) { return a.block < b.block; });
  return fetched;
}

// Decodes all together, as far as there is room for that, or, with a cancellation, a few at a time. What is loaded is
// closed in between.
void Loader::decode(std::vector<file::FetchedBlock> fetched, Cancellation* cancellation) {
  const BlockSet none(needs_.size(), 0);
  BlockSet target = content_.block_loaded;
  for (const file::FetchedBlock& block : fetched)
    target[block.block] = 1;
  alone([&] { reader_.expect(fetched, content_); });
  auto parts = memory_.parts_of(std::move(fetched), content_.block_loaded,
                                cancellation != nullptr ? kBlocksBetweenLooks : needs_.size());
  for (std::vector<file::FetchedBlock>& part : parts) {
    if (cancellation != nullptr && &part != &parts.front()) cancellation->check();
    const BlockSet loaded = content_.block_loaded;
    try {
      decode_together(std::move(part));
    } catch (const file::BlockError& error) {
      losses_.note({error.block, error.block_offset, error.code(), error.what()});
      needs_.leave_out(target, {error.block}, none);
      rebuild(std::move(target), loaded, true);
      return;
    }
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

// Makes the content anew from `keep`. Should some of it that was loaded not be had again: with `must` it is made
// without these, else nothing is done and false is returned.
bool Loader::rebuild(BlockSet keep, const BlockSet& was_loaded, bool must, Cancellation* cancellation) {
  const BlockSet none(keep.size(), 0);
  for (int attempt = 0;; ++attempt) {
    // So many blocks with wrong contents under right hashes are no accident: stop looking for a set that works.
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
  content_.positions.bytes = std::vector<std::byte>(); // {} would keep its memory
  content_.arrays = {};
  content_ = reader_.read_base();
  reader_.expect(fetched, content_);
  BlockSet loaded(needs_.size(), 0);
  for (std::vector<file::FetchedBlock>& part : memory_.parts_of(std::move(fetched), loaded, needs_.size())) {
    for (const file::FetchedBlock& block : part)
      loaded[block.block] = 1;
    file::Reader::Batch batch = reader_.begin(std::move(part), content_);
    while (batch.step(content_, content_.generation.size(), measured_)) {
    }
    batch.check(content_);
  }
  content_.block_loaded = std::move(loaded);
  is_spoilt_ = false;
}

// ---- why not ----

void Loader::leave_out_failed(BlockSet& set, const BlockSet& missing) {
  if (in_background_ || std::find(missing.begin(), missing.end(), 1) == missing.end()) return;
  std::vector<std::uint32_t> failed = losses_.failed();
  std::erase_if(failed, [&](std::uint32_t b) { return missing[b] == 0; });
  const auto guard = lock();
  needs_.leave_out(set, std::move(failed), content_.block_loaded);
}

bool Loader::waits_for(const BlockSet& missing) const {
  if (std::find(missing.begin(), missing.end(), 1) == missing.end()) return false;
  const LimitedBy limit = explain(missing).limited_by;
  return limit == LimitedBy::kLoading || limit == LimitedBy::kMemory;
}

// ---- the thread ----

// Loads coarse blocks first, some at a time, unless memory is limited: what is to be kept is then decided over all that
// is asked.
bool Loader::load_part(const BlockSet& asked) {
  const std::lock_guard one(loading_);
  BlockSet possible = asked, part(asked.size(), 0);
  needs_.leave_out(possible, losses_.hopeless(), content_.block_loaded);
  std::size_t count = 0;
  bool has_more = false;
  for (const std::uint32_t b : members(possible)) {
    if (content_.block_loaded[b] != 0 && !is_limited()) continue;
    if (!is_limited() && count++ == kBlocksAtOnce) {
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
