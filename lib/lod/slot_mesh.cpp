#include "lod/slot_mesh.hpp"

#include "lod/replace_corner.hpp"
#include "lod/star.hpp"
#include "mesh/large_pages.hpp"
#include "record/ghost.hpp"

#include <algorithm>
#include <cstring>
#include <numeric>

namespace ptet {
namespace {

constexpr SlotMesh::TetSlots kNoTet = {SlotMesh::kUnused, SlotMesh::kUnused, SlotMesh::kUnused, SlotMesh::kUnused};
constexpr SlotMesh::FaceSlots kNoFace = {SlotMesh::kUnused, SlotMesh::kUnused, SlotMesh::kUnused};

void copy_row(const PointArray& from, std::size_t row, PointArray& to, std::size_t slot) {
  const std::size_t bytes = from.row_bytes();
  if ((slot + 1) * bytes > to.bytes.size()) resize_large(to.bytes, (slot + 1) * bytes);
  std::memcpy(to.bytes.data() + slot * bytes, from.bytes.data() + row * bytes, bytes);
}

/// `moved`: by slot where it goes, see Slots::compact.
void move_slot(std::uint32_t& slot, const std::vector<std::uint32_t>& moved) {
  if (slot != SlotMesh::kUnused) slot = moved[slot];
}

/// Moves rows of `width` numbers each to their new slots. These are lower ones, in the same order: nothing is
/// overwritten that is still to be moved.
template <class Rows>
void keep_rows(Rows& rows, const std::vector<std::uint32_t>& moved, std::size_t used, std::size_t width) {
  for (std::size_t slot = 0; slot < moved.size(); ++slot)
    if (moved[slot] != SlotMesh::kUnused && moved[slot] != slot)
      std::copy_n(rows.begin() + static_cast<std::ptrdiff_t>(slot * width), width,
                  rows.begin() + static_cast<std::ptrdiff_t>(moved[slot] * width));
  rows.resize(used * width);
  rows.shrink_to_fit();
}

} // namespace

template <class Row>
std::uint32_t SlotMesh::Slots<Row>::take(const Row& row) {
  std::uint32_t slot = 0;
  if (free.empty()) {
    slot = static_cast<std::uint32_t>(rows.size());
    grow_large(rows, rows.size() + 1);
    rows.push_back(row);
    is_changed.push_back(false);
    // So that giving back and telling never allocate.
    reserve_large(free, rows.capacity());
    reserve_large(changed, rows.capacity());
  } else {
    slot = free.back();
    free.pop_back();
    rows[slot] = row;
  }
  tell(slot);
  return slot;
}

template <class Row>
void SlotMesh::Slots<Row>::release(std::uint32_t slot, const Row& unused) {
  rows[slot] = unused;
  free.push_back(slot);
  tell(slot);
}

template <class Row>
std::vector<std::uint32_t> SlotMesh::Slots<Row>::compact(const Row& unused) {
  std::vector<std::uint32_t> moved(rows.size(), kUnused);
  std::vector<Row> kept;
  kept.reserve(used());
  for (std::size_t slot = 0; slot < rows.size(); ++slot) {
    if (rows[slot] == unused) continue;
    moved[slot] = static_cast<std::uint32_t>(kept.size());
    kept.push_back(rows[slot]);
  }
  rows.swap(kept);
  std::vector<std::uint32_t> all(rows.size());
  std::iota(all.begin(), all.end(), 0U);
  changed.swap(all);
  is_changed = std::vector<bool>(rows.size(), true);
  free = std::vector<std::uint32_t>();
  free.reserve(rows.capacity());
  return moved;
}

SlotMesh::SlotMesh(const Hierarchy& hierarchy) : hierarchy_(hierarchy) {
  const file::Content& content = hierarchy_.content();
  const Refinement& refinement = content.refinement;
  positions_ = {content.positions.name, content.positions.type, content.positions.components, {}};
  for (const PointArray& array : content.arrays)
    arrays_.push_back({array.name, array.type, array.components, {}});
  slot_of_vertex_.assign(content.positions.size(), kUnused);
  rim_place_.assign(refinement.record_count(), kUnused);
  make_room();
  for (std::uint32_t t = 0; t < refinement.base_tet_count(); ++t)
    for (const VertexId v : refinement.base_tet(t))
      slot_of_vertex_[v.index()] = 0;
  for (std::uint32_t v = 0; v < refinement.base_vertex_count(); ++v)
    if (slot_of_vertex_[v] != kUnused)
      add_vertex(VertexId{v});
    else
      unused_.emplace_back(v);
  const auto slot = [&](VertexId v) { return v == kDummyVertex ? kUnused : slot_of_vertex_[v.index()]; };
  for (std::uint32_t t = 0; t < refinement.base_place_count(); ++t) {
    const Tet& tet = refinement.base_tet(t);
    const TetSlots slots = {slot(tet[0]), slot(tet[1]), slot(tet[2]), slot(tet[3])};
    if (t < refinement.base_tet_count())
      slot_of_place_[t] = tets_.take(slots);
    else
      add_ghost(t, slots, static_cast<std::size_t>(std::find(tet.begin(), tet.end(), kDummyVertex) - tet.begin()));
  }
}

void SlotMesh::make_room() {
  if (!is_settled_ && hierarchy_.content().refinement.is_settled()) settle();
  resize_large(slot_of_place_, hierarchy_.content().refinement.place_count(), kUnused);
}

bool SlotMesh::compact() {
  if (tets_.rows.size() <= std::max(kFewSlots, kSlotsATet * static_cast<std::size_t>(tets_.used()))) return false;
  const std::vector<std::uint32_t> tet = tets_.compact(kNoTet), face = faces_.compact(kNoFace),
                                   vertex = vertices_.compact(VertexId{});
  for (TetSlots& row : tets_.rows)
    for (std::uint32_t& slot : row)
      move_slot(slot, vertex);
  for (FaceSlots& row : faces_.rows)
    for (std::uint32_t& slot : row)
      move_slot(slot, vertex);
  for (std::uint32_t& slot : slot_of_vertex_)
    move_slot(slot, vertex);
  move_places(tet, face);
  keep_rows(positions_.bytes, vertex, vertices_.rows.size(), positions_.row_bytes());
  for (PointArray& array : arrays_)
    keep_rows(array.bytes, vertex, vertices_.rows.size(), array.row_bytes());
  if (creators_) keep_rows(made_by_, tet, tets_.rows.size(), 1);
  return true;
}

// A place that is not in the mesh now names a slot that is another's or nobody's; after the move it still does, and is
// given one of its own when it comes back.
void SlotMesh::move_places(const std::vector<std::uint32_t>& tet, const std::vector<std::uint32_t>& face) {
  const Refinement& refinement = hierarchy_.content().refinement;
  for (std::uint32_t p = 0; p < refinement.base_place_count(); ++p)
    move_slot(slot_of_place_[p], p < refinement.base_tet_count() ? tet : face);
  for (std::uint32_t r = 0; r < refinement.record_count(); ++r) {
    if (!refinement.applied(RecordId{r})) continue;
    const std::span<const VertexId> rim = refinement.rim(RecordId{r});
    for (std::size_t i = 0; i < rim.size(); ++i) {
      move_slot(slot_of_place_[refinement.rim_place(RecordId{r}) + i], rim_edge(rim, i).is_of_ghost() ? face : tet);
    }
  }
}

// Once all records are read places have other names; the slots stay.
void SlotMesh::settle() {
  const Refinement& refinement = hierarchy_.content().refinement;
  std::vector<std::uint32_t> slot(refinement.place_count(), kUnused);
  std::copy_n(slot_of_place_.begin(), std::min<std::size_t>(refinement.base_place_count(), slot_of_place_.size()),
              slot.begin());
  for (std::uint32_t r = 0; r < rim_place_.size(); ++r)
    if (rim_place_[r] != kUnused)
      std::copy_n(slot_of_place_.begin() + rim_place_[r], refinement.rim(RecordId{r}).size(),
                  slot.begin() + refinement.rim_place(RecordId{r}));
  slot_of_place_.swap(slot);
  std::vector<std::uint32_t>().swap(rim_place_);
  is_settled_ = true;
}

std::uint32_t SlotMesh::add_vertex(VertexId v) {
  const file::Content& content = hierarchy_.content();
  const std::uint32_t slot = vertices_.take(v);
  slot_of_vertex_[v.index()] = slot;
  copy_row(content.positions, v.index(), positions_, slot);
  for (std::size_t i = 0; i < arrays_.size(); ++i)
    copy_row(content.arrays[i], v.index(), arrays_[i], slot);
  return slot;
}

void SlotMesh::remove_vertex(VertexId v) {
  vertices_.release(std::exchange(slot_of_vertex_[v.index()], kUnused), VertexId{});
}

void SlotMesh::show_unused_vertices(bool shown) {
  if (std::exchange(shows_unused_, shown) == shown) return;
  for (const VertexId v : unused_)
    if (shown)
      add_vertex(v);
    else
      remove_vertex(v);
}

void SlotMesh::add_ghost(std::uint32_t place, const TetSlots& slots, std::size_t dummy_corner) {
  slot_of_place_[place] = faces_.take(face_of_ghost(slots, dummy_corner));
}

void SlotMesh::replace(Place place, std::uint32_t from, std::uint32_t to) {
  const std::uint32_t slot = slot_of_place_[place.index()];
  if (place.is_ghost()) {
    replace_corner(faces_.rows[slot], from, to);
    faces_.tell(slot);
  } else {
    replace_corner(tets_.rows[slot], from, to);
    tets_.tell(slot);
  }
}

void SlotMesh::fetch_places(RecordId r) const {
  const Refinement& refinement = hierarchy_.content().refinement;
  for (const Place place : refinement.modified(r))
    __builtin_prefetch(&slot_of_place_[place.index()]);
  const std::span<const VertexId> rim = refinement.rim(r);
  for (const VertexId w : rim)
    if (w != kDummyVertex) __builtin_prefetch(&slot_of_vertex_[w.index()]);
  __builtin_prefetch(&slot_of_vertex_[refinement.target(r).index()]);
  __builtin_prefetch(&slot_of_vertex_[refinement.vertex_of(r).index()]);
  __builtin_prefetch(&slot_of_place_[refinement.rim_place(r)]);
  __builtin_prefetch(&slot_of_place_[refinement.rim_place(r) + rim.size() - 1]);
}

void SlotMesh::fetch_slots(RecordId r) const {
  const Refinement& refinement = hierarchy_.content().refinement;
  for (const Place place : refinement.modified(r))
    if (!place.is_ghost()) fetch_tet(slot_of_place_[place.index()]);
  for (std::uint32_t i = 0; i < refinement.rim(r).size(); ++i)
    fetch_tet(slot_of_place_[refinement.rim_place(r) + i]);
}

void SlotMesh::fetch_tet(std::uint32_t slot) const {
  if (slot >= tets_.rows.size()) return; // of a split that is yet to come
  __builtin_prefetch(&tets_.rows[slot]);
  if (creators_) __builtin_prefetch(&made_by_[slot]);
}

void SlotMesh::split(RecordId r) {
  const Refinement& refinement = hierarchy_.content().refinement;
  const std::uint32_t u = slot_of_vertex_[refinement.target(r).index()];
  const std::uint32_t v = add_vertex(refinement.vertex_of(r));
  for (const Place place : refinement.modified(r))
    replace(place, u, v);
  const std::span<const VertexId> rim = refinement.rim(r);
  const auto slot = [&](VertexId w) { return w == kDummyVertex ? kUnused : slot_of_vertex_[w.index()]; };
  std::uint32_t place = refinement.rim_place(r);
  if (!is_settled_) rim_place_[r.index()] = place;
  std::uint32_t a = slot(rim.front());
  for (std::size_t i = 1; i <= rim.size(); ++i) {
    const std::uint32_t b = slot(rim[i < rim.size() ? i : 0]);
    if (a == kUnused || b == kUnused)
      add_ghost(place, {v, u, a, b}, a == kUnused ? 2 : 3);
    else
      slot_of_place_[place] = tets_.take({v, u, a, b});
    if (creators_ && a != kUnused && b != kUnused) set_creator(slot_of_place_[place], creators_->first(place));
    ++place;
    a = b;
  }
  if (!creators_) return;
  const std::span<const RecordId> next = creators_->next(r);
  const std::span<const Place> modified = refinement.modified(r);
  for (std::size_t k = 0; k < modified.size(); ++k)
    if (!modified[k].is_ghost()) made_by_[slot_of_place_[modified[k].index()]] = next[k];
}

void SlotMesh::collapse(RecordId r) {
  const Refinement& refinement = hierarchy_.content().refinement;
  const std::uint32_t u = slot_of_vertex_[refinement.target(r).index()];
  const std::uint32_t v = slot_of_vertex_[refinement.vertex_of(r).index()];
  for (const Place place : refinement.modified(r))
    replace(place, v, u);
  const std::span<const VertexId> rim = refinement.rim(r);
  if (!is_settled_) rim_place_[r.index()] = kUnused;
  // Backwards, so that splitting again takes the same slots.
  for (std::size_t i = rim.size(); i-- > 0;) {
    const std::uint32_t slot = slot_of_place_[refinement.rim_place(r) + i];
    if (rim_edge(rim, i).is_of_ghost())
      faces_.release(slot, kNoFace);
    else {
      tets_.release(slot, kNoTet);
      if (creators_) made_by_[slot] = RecordId{};
    }
  }
  if (creators_)
    for (const Place place : refinement.modified(r))
      if (!place.is_ghost()) made_by_[slot_of_place_[place.index()]] = r;
  remove_vertex(refinement.vertex_of(r));
}

// ---- who made the tets ----

void SlotMesh::follow_creators(const BlockSet& known, const std::vector<char>& applied) {
  const bool begins = !creators_.has_value();
  if (begins || !creators_->can_learn(known)) {
    creators_.emplace(hierarchy_);
    creators_->learn(known, [](Place, RecordId, RecordId) {});
    find_creators(applied);
  } else {
    // The tet behind the last record known of a place was taken for an original one; now it is known who made it.
    creators_->learn(known, [&](Place place, RecordId before, RecordId r) {
      const bool is_there = before.is_none() || applied[before.index()] != 0;
      if (is_there && !place.is_ghost() && applied[r.index()] == 0) set_creator(slot_of_place_[place.index()], r);
    });
  }
  if (!begins) return;
  for (std::uint32_t slot = 0; slot < tets_.rows.size(); ++slot)
    if (tets_.rows[slot] != kNoTet) tets_.tell(slot);
}

// What is in a place was made by the record that comes there after the last one that is split.
void SlotMesh::find_creators(const std::vector<char>& applied) {
  const Refinement& refinement = hierarchy_.content().refinement;
  made_by_.resize(tets_.rows.size());
  const auto set_unless_split = [&](std::uint32_t place, RecordId creator) {
    if (creator.is_none() || applied[creator.index()] == 0) set_creator(slot_of_place_[place], creator);
  };
  for (std::uint32_t place = 0; place < refinement.base_tet_count(); ++place)
    set_unless_split(place, creators_->first(place));
  for (std::uint32_t i = 0; i < applied.size(); ++i) {
    if (applied[i] == 0) continue;
    const RecordId r{i};
    const std::span<const RecordId> next = creators_->next(r);
    const std::span<const Place> modified = refinement.modified(r);
    for (std::size_t k = 0; k < modified.size(); ++k)
      if (!modified[k].is_ghost()) set_unless_split(modified[k].index(), next[k]);
    const std::span<const VertexId> rim = refinement.rim(r);
    for (std::uint32_t k = 0; k < rim.size(); ++k)
      if (rim[k] != kDummyVertex && rim[k + 1 < rim.size() ? k + 1 : 0] != kDummyVertex)
        set_unless_split(refinement.rim_place(r) + k, creators_->first(refinement.rim_place(r) + k));
  }
}

void SlotMesh::set_creator(std::uint32_t slot, RecordId creator) {
  if (slot >= made_by_.size()) made_by_.resize(slot + std::size_t{1});
  if (std::exchange(made_by_[slot], creator) != creator) tets_.tell(slot);
}

void SlotMesh::forget_creators() {
  creators_.reset();
  std::vector<RecordId>().swap(made_by_);
}

void SlotMesh::forget_changes() {
  tets_.forget_changes();
  faces_.forget_changes();
  vertices_.forget_changes();
}

} // namespace ptet
