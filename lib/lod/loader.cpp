#include "lod/loader.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ptet {
namespace {

std::vector<std::uint32_t> members(const BlockSet& set) {
  std::vector<std::uint32_t> blocks;
  for (std::uint32_t b = 0; b < set.size(); ++b)
    if (set[b] != 0) blocks.push_back(b);
  return blocks;
}

bool is_subset(const BlockSet& part, const BlockSet& whole) {
  for (std::size_t b = 0; b < part.size(); ++b)
    if (part[b] != 0 && whole[b] == 0) return false;
  return true;
}

void unite(BlockSet& set, const BlockSet& more) {
  for (std::size_t b = 0; b < set.size(); ++b)
    set[b] = static_cast<char>(set[b] | more[b]);
}

void intersect(BlockSet& set, const BlockSet& other) {
  for (std::size_t b = 0; b < set.size(); ++b)
    set[b] = static_cast<char>(set[b] & other[b]);
}

/// Thrown out of a decoding that nobody wants any more.
struct Stopped {};

} // namespace

Loader::Loader(file::Reader& reader, file::Content& content, const OpenOptions& options,
               file::Reader::Batch::StarMeasured measured)
    : reader_(reader), content_(content), measured_(std::move(measured)), in_background_(options.background),
      needed_by_(reader.blocks().size()), in_use_(reader.blocks().size(), 0), no_room_(reader.blocks().size(), 0),
      pins_(reader.blocks().size(), 0) {
  for (std::uint32_t b = 0; b < needed_by_.size(); ++b)
    for (const std::uint32_t needed : reader.blocks()[b].needs)
      needed_by_[needed].push_back(b);
  room_ = options.limits.max_bytes - std::min(options.limits.max_bytes, reader.fixed_bytes());
  if (options.memory_limit > 0) room_ = std::min(room_, options.memory_limit);
  is_limited_ = bytes_of(BlockSet(needed_by_.size(), 1)) > room_;
  takes_turns_ = is_limited_ && !in_background_;
  if (in_background_) queue_.emplace([this](const BlockSet& asked) { return load_part(asked); });
}

Loader::~Loader() {
  if (queue_) queue_->stop();
}

// ---- locks ----

std::shared_lock<std::shared_mutex> Loader::lock() const {
  const std::lock_guard through(gate_);
  return std::shared_lock(content_mutex_);
}

// What goes wrong while the content changes is found by nobody half done.
template <class F>
decltype(auto) Loader::alone(F&& f) {
  std::unique_lock gate(gate_);
  const std::unique_lock guard(content_mutex_);
  gate.unlock();
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
  const std::lock_guard guard(state_);
  for (const std::uint32_t b : members(set))
    ++pins_[b];
}

void Loader::unpin(const BlockSet& set) {
  const std::lock_guard guard(state_);
  for (const std::uint32_t b : members(set))
    --pins_[b];
}

// ---- sets of blocks ----

void Loader::close(BlockSet& set) const {
  std::vector<std::uint32_t> open;
  close(set, open);
}

void Loader::close(BlockSet& set, std::vector<std::uint32_t>& open) const {
  open.clear();
  for (std::uint32_t b = 0; b < set.size(); ++b)
    if (set[b] != 0) open.push_back(b);
  while (!open.empty()) {
    const std::uint32_t b = open.back();
    open.pop_back();
    for (const std::uint32_t needed : reader_.blocks()[b].needs)
      if (std::exchange(set[needed], 1) == 0) open.push_back(needed);
  }
}

// With a block goes what needs it and is not there yet.
void Loader::leave_out(BlockSet& set, std::vector<std::uint32_t> out, const BlockSet& loaded) const {
  while (!out.empty()) {
    const std::uint32_t b = out.back();
    out.pop_back();
    if (loaded[b] != 0 || std::exchange(set[b], 0) == 0) continue;
    out.insert(out.end(), needed_by_[b].begin(), needed_by_[b].end());
  }
}

// Blocks with wrong bytes stay wrong. Where reading failed it may not do so the next time.
void Loader::leave_out_hopeless(BlockSet& set) const {
  std::vector<std::uint32_t> out;
  {
    const std::lock_guard guard(state_);
    for (const auto& [block, failed] : failed_)
      if (failed.failure.code != ErrorCode::kIo || (in_background_ && Clock::now() - failed.when < kRetryAfter))
        out.push_back(block);
  }
  leave_out(set, std::move(out), content_.block_loaded);
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

void Loader::load(BlockSet& closed) {
  repair();
  bool is_there = false;
  {
    const auto guard = lock();
    is_there = holds(closed);
  }
  if (!is_there) {
    if (in_background_) {
      queue_->ask_for(closed);
    } else {
      const std::lock_guard one(loading_);
      load_now(closed);
    }
    keep_loaded(closed);
  }
  if (takes_turns_) unite(in_use_, closed);
}

// What cannot be had is not asked for again with each of the others that need it.
bool Loader::load(BlockSet& closed, Clock::time_point until) {
  if (in_background_ || is_limited_) {
    load(closed);
    return true;
  }
  BlockSet loaded = closed, lost(closed.size(), 0);
  keep_loaded(loaded);
  std::deque<std::uint32_t> left;
  for (const std::uint32_t b : members(closed))
    if (loaded[b] == 0) left.push_back(b);
  for (double at_once = 1; !left.empty();) {
    const auto begin = Clock::now();
    BlockSet part = loaded;
    double count = 0;
    for (; count < at_once && !left.empty(); left.pop_front()) {
      BlockSet with = part;
      with[left.front()] = 1;
      close(with);
      if (std::equal(with.begin(), with.end(), lost.begin(), [](char a, char b) { return a == 0 || b == 0; })) {
        part = std::move(with);
        ++count;
      }
    }
    BlockSet wanted = part;
    load(part);
    for (std::size_t b = 0; b < part.size(); ++b)
      if (wanted[b] != part[b]) lost[b] = 1;
    loaded = std::move(part);
    const auto now = Clock::now();
    at_once = std::floor(
        std::min(2.0, std::chrono::duration<double>(until - now) / std::chrono::duration<double>(now - begin)) * count);
    if (!left.empty() && at_once < 1 && count > 0) {
      closed = std::move(loaded);
      return false;
    }
    at_once = std::max(at_once, 1.0);
  }
  closed = std::move(loaded);
  return true;
}

void Loader::load_now(BlockSet& set) {
  const BlockSet none(set.size(), 0);
  if (is_spoilt_) rebuild(none, none, true);
  leave_out_hopeless(set);
  if (is_limited_ && !make_room(set)) return;
  decode(fetch(set, content_.block_loaded));
}

// Returns whether the set is to be loaded on top of what is there; else all has been done.
bool Loader::make_room(BlockSet& set) {
  const BlockSet& loaded = content_.block_loaded;
  BlockSet all = loaded;
  unite(all, set);
  if (bytes_of(all) <= room_) return true;
  const BlockSet keep = what_fits(set);
  {
    const std::lock_guard guard(state_);
    for (const std::uint32_t b : members(set))
      no_room_[b] = keep[b] == 0 ? 1 : 0;
  }
  intersect(set, keep);
  if (is_subset(set, loaded)) return false;
  all = loaded;
  unite(all, set);
  if (bytes_of(all) <= room_) return true;
  if (!rebuild(keep, BlockSet(loaded), false)) {
    const std::lock_guard guard(state_);
    for (const std::uint32_t b : members(set))
      if (loaded[b] == 0) no_room_[b] = 1;
  }
  return false;
}

// What must stay, then of the set what there is room for, coarse blocks first.
BlockSet Loader::what_fits(const BlockSet& set) const {
  BlockSet keep = takes_turns_ ? in_use_ : BlockSet(set.size(), 0);
  {
    const std::lock_guard guard(state_);
    for (std::size_t b = 0; b < keep.size(); ++b)
      if (pins_[b] > 0) keep[b] = 1;
  }
  close(keep);
  intersect(keep, content_.block_loaded);
  for (const std::uint32_t b : members(set)) {
    if (keep[b] != 0) continue;
    BlockSet with = keep;
    with[b] = 1;
    close(with);
    if (bytes_of(with) <= room_) keep = std::move(with);
  }
  return keep;
}

void Loader::note(const BlockFailure& failure) {
  const std::lock_guard guard(state_);
  failed_.insert_or_assign(failure.block, Failed{failure, Clock::now()});
}

// What cannot be had goes out of the set, with what needs it.
std::vector<file::FetchedBlock> Loader::fetch(BlockSet& set, const BlockSet& loaded) {
  std::vector<std::uint32_t> wanted = members(set);
  std::erase_if(wanted, [&](std::uint32_t b) { return loaded[b] != 0; });
  std::vector<std::uint32_t> out;
  auto fetched = reader_.fetch(
      wanted,
      [&](std::uint32_t b, const Error& error) {
        out.push_back(b);
        if (!is_stopped()) note({b, reader_.blocks()[b].offset, error.code(), error.what()});
      },
      [this] { return is_stopped(); });
  if (is_stopped()) throw Stopped{};
  leave_out(set, std::move(out), loaded);
  std::erase_if(fetched, [&](const file::FetchedBlock& block) { return set[block.block] == 0; });
  return fetched;
}

void Loader::decode(std::vector<file::FetchedBlock> fetched) {
  if (fetched.empty()) return;
  const BlockSet was_loaded = content_.block_loaded;
  BlockSet target = was_loaded;
  std::vector<std::uint32_t> blocks;
  for (const file::FetchedBlock& block : fetched) {
    blocks.push_back(block.block);
    target[block.block] = 1;
  }
  try {
    file::Reader::Batch batch = alone([&] { return reader_.begin(std::move(fetched), content_); });
    while (alone([&] { return batch.step(content_, kRecordsAtOnce, measured_); }))
      if (is_stopped()) throw Stopped{};
    alone([&] {
      batch.check(content_);
      for (const std::uint32_t b : blocks)
        content_.block_loaded[b] = 1;
      content_.refinement.settle(); // once all is read
    });
  } catch (const file::BlockError& error) {
    note({error.block, error.block_offset, error.code(), error.what()});
    leave_out(target, {error.block}, BlockSet(target.size(), 0));
    rebuild(std::move(target), was_loaded, true);
    return;
  }
  const std::lock_guard guard(state_);
  for (const std::uint32_t b : blocks) {
    failed_.erase(b);
    no_room_[b] = 0;
  }
}

// ---- making the content anew ----

// `must`: even when what was loaded and is to be kept cannot all be read again; else nothing is done then, and false
// returned.
bool Loader::rebuild(BlockSet keep, const BlockSet& was_loaded, bool must) {
  const BlockSet none(keep.size(), 0);
  for (int attempt = 0;; ++attempt) {
    // A file with so many wrong blocks under right hashes is no accident.
    if (attempt == kMaxRebuilds) intersect(keep, was_loaded);
    if (attempt > kMaxRebuilds) keep = none;
    BlockSet readable = keep;
    auto fetched = fetch(readable, none);
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
    note({error.block, error.block_offset, error.code(), error.what()});
    leave_out(keep, {error.block}, BlockSet(keep.size(), 0));
    return false;
  }
  const std::lock_guard guard(state_);
  for (const std::uint32_t b : members(keep)) {
    failed_.erase(b);
    no_room_[b] = 0;
  }
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

Loader::Shortfall Loader::explain(const BlockSet& missing) const {
  Shortfall shortfall;
  BlockSet rest = missing;
  const std::lock_guard guard(state_);
  std::vector<std::uint32_t> out;
  for (const auto& [block, failed] : failed_) {
    if (missing[block] == 0) continue;
    shortfall.failures.push_back(failed.failure);
    out.push_back(block);
  }
  leave_out(rest, std::move(out), BlockSet(rest.size(), 0));
  bool is_loading = false, lacks_room = false;
  for (const std::uint32_t b : members(rest))
    (no_room_[b] != 0 ? lacks_room : is_loading) = true;
  if (is_loading && in_background_) {
    shortfall.limited_by = LimitedBy::kLoading;
  } else if (lacks_room) {
    shortfall.limited_by = LimitedBy::kMemory;
  }
  return shortfall;
}

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
  leave_out_hopeless(possible);
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
  load_now(part);
  return has_more;
}

void Loader::wait_until_loaded(const ProgressCallback& progress) {
  if (queue_) queue_->wait_until_done(progress);
}

} // namespace ptet
