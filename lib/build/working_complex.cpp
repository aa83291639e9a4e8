#include "build/working_complex.hpp"

#include "ptet/error.hpp"

#include <algorithm>
#include <cassert>
#include <limits>
#include <utility>

namespace ptet::build {
namespace {

/// Stars name places in the pool by 32 bits.
void check_pool_size(std::size_t size) {
  if (size > std::numeric_limits<std::uint32_t>::max())
    throw Error(ErrorCode::kLimit, "the stars of the vertices have more than 2^32 - 1 tets and faces together");
}

} // namespace

WorkingComplex::WorkingComplex(std::uint32_t vertex_count, std::span<const Tet> tets,
                               std::span<const std::array<VertexId, 3>> boundary_faces)
    : dummy_(vertex_count), stars_(vertex_count) {
  slots_.reserve(tets.size() + boundary_faces.size());
  const auto add = [&](std::array<Vertex, 4> v) {
    slots_.push_back({v, static_cast<std::uint32_t>(slots_.size()), 0.0F, 0});
    for (const Vertex x : v)
      if (x != dummy_) ++stars_[x].capacity;
  };
  for (const Tet& t : tets)
    add({t[0].index(), t[1].index(), t[2].index(), t[3].index()});
  // An outward face has its normal towards the dummy: (a, b, c, dummy) is positive.
  for (const auto& f : boundary_faces)
    add({f[0].index(), f[1].index(), f[2].index(), dummy_});

  std::size_t begin = 0;
  for (Star& star : stars_) {
    star.begin = static_cast<std::uint32_t>(begin);
    begin += star.capacity;
    check_pool_size(begin);
  }
  pool_.resize(begin);
  for (SlotId s = 0; s < slots_.size(); ++s)
    for (const Vertex x : slots_[s].v)
      if (x != dummy_) pool_[stars_[x].begin + stars_[x].size++] = s;
}

void WorkingComplex::remove_from_star(Vertex v, SlotId s) {
  Star& star = stars_[v];
  SlotId* const first = pool_.data() + star.begin;
  SlotId* const found = std::find(first, first + star.size, s);
  assert(found != first + star.size);
  // The order is kept: what is done with a star must not depend on how it came about.
  std::copy(found + 1, first + star.size, found);
  --star.size;
}

void WorkingComplex::collapse(Vertex vs, Vertex vd, std::span<const SlotId> deleted, std::span<const SlotId> modified) {
  for (const SlotId s : deleted)
    for (const Vertex x : slots_[s].v)
      if (x != vs && x != dummy_) remove_from_star(x, s);
  for (const SlotId s : modified)
    *std::find(slots_[s].v.begin(), slots_[s].v.end(), vs) = vd;

  Star& from = stars_[vs];
  Star& to = stars_[vd];
  const auto new_size = static_cast<std::uint32_t>(to.size + modified.size());
  if (new_size > to.capacity) {
    // `modified` may be a view of a caller's list, but not of this chunk: it is a copy of the star's parts.
    const Star moved = from.capacity >= new_size ? std::exchange(from, {}) : take_chunk(new_size);
    std::copy_n(pool_.begin() + to.begin, to.size, pool_.begin() + moved.begin);
    free_chunk(to);
    to = {moved.begin, to.size, moved.capacity};
  }
  std::copy(modified.begin(), modified.end(), pool_.begin() + to.begin + to.size);
  to.size = new_size;
  free_chunk(from);
  from = {};
}

/// Room for a star of `size` slots, and some more.
WorkingComplex::Star WorkingComplex::take_chunk(std::uint32_t size) {
  const std::uint32_t most = size + size / 2;
  for (std::uint32_t capacity = size; capacity <= most && capacity < free_.size(); ++capacity) {
    std::vector<std::uint32_t>& chunks = free_[capacity];
    if (chunks.empty()) continue;
    const std::uint32_t begin = chunks.back();
    chunks.pop_back();
    return {begin, 0, capacity};
  }
  const auto begin = static_cast<std::uint32_t>(pool_.size());
  check_pool_size(pool_.size() + most);
  pool_.resize(pool_.size() + most);
  return {begin, 0, most};
}

void WorkingComplex::free_chunk(const Star& star) {
  if (star.capacity > 0 && star.capacity < free_.size()) free_[star.capacity].push_back(star.begin);
}

void WorkingComplex::forget_stars() {
  LargeVector<Star>().swap(stars_);
  LargeVector<SlotId>().swap(pool_);
  free_ = {};
}

std::string WorkingComplex::validate() const {
  for (Vertex v = 0; v < stars_.size(); ++v) {
    if (stars_[v].size > stars_[v].capacity) return "star of vertex " + std::to_string(v) + " passes its capacity";
    for (const SlotId s : star(v)) {
      if (s >= slots_.size()) return "star of vertex " + std::to_string(v) + " names slot " + std::to_string(s);
      const auto& corners = slots_[s].v;
      if (std::count(corners.begin(), corners.end(), v) != 1)
        return "slot " + std::to_string(s) + " stands in the star of vertex " + std::to_string(v) +
               " without it as one corner";
      for (const Vertex x : corners) {
        if (x == dummy_) continue;
        const auto other = star(x);
        if (std::find(other.begin(), other.end(), s) == other.end())
          return "slot " + std::to_string(s) + " is missing in the star of its vertex " + std::to_string(x);
      }
    }
  }
  return {};
}

} // namespace ptet::build
