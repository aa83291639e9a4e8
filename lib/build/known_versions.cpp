#include "build/known_versions.hpp"

#include "build/process_memory.hpp"

#include <algorithm>

namespace ptet::build {

void KnownOfVertices::set_room(std::size_t bytes) {
  room_ = bytes;
  const std::size_t held = held_;
  most_ = std::max(most_, held);
  if (held >= most_ / 2) return;
  most_ = held;
  release_freed_memory();
}

KnownVersions* KnownOfVertices::of(Vertex v) {
  const bool has_room = held_ < room_;
  if (!known_[v] && has_room) known_[v] = std::make_unique<Counted>();
  if (known_[v]) known_[v]->takes_more = has_room;
  return known_[v].get();
}

void KnownOfVertices::settle(Vertex v) {
  Counted* const known = known_[v].get();
  if (known == nullptr) return;
  known->keys.shrink_to_fit();
  known->values.shrink_to_fit();
  held_ += known->bytes();
  held_ -= known->counted;
  known->counted = known->bytes();
}

void KnownOfVertices::forget(Vertex v) {
  if (known_[v]) held_ -= known_[v]->counted;
  known_[v].reset();
}

} // namespace ptet::build
