// The faces of some tets, each with the one or two of them that share it; tets come and go.
//
//   least corner of a face -> list of the faces that have it -> { corners, tet, other tet }
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace ptet::view {

class FaceTable {
public:
  using Face = std::array<std::uint32_t, 3>;
  using Corners = std::array<std::uint32_t, 4>;
  static constexpr std::uint32_t kNone = 0xFFFFFFFF;

  struct Entry {
    Face key{};                ///< ascending
    std::uint32_t tet = kNone; ///< none: the entry is not in use
    std::uint32_t other = kNone;
    std::uint32_t next = kNone;
  };

  [[nodiscard]] static Face sorted(Face face) {
    if (face[0] > face[1]) std::swap(face[0], face[1]);
    if (face[1] > face[2]) std::swap(face[1], face[2]);
    if (face[0] > face[1]) std::swap(face[0], face[1]);
    return face;
  }

  void clear() {
    entries_.clear();
    free_.clear();
    std::fill(first_.begin(), first_.end(), kNone);
  }
  /// Corners are below `count`.
  void make_room(std::size_t count) {
    if (first_.size() < count) first_.resize(count, kNone);
  }
  void add(std::uint32_t tet, const Corners& corners) {
    for (std::size_t left_out = 0; left_out < 4; ++left_out) {
      const Face key = face_of(corners, left_out);
      if (const std::uint32_t row = find(key); row != kNone) {
        entries_[row].other = tet;
        continue;
      }
      std::uint32_t row = static_cast<std::uint32_t>(entries_.size());
      if (free_.empty()) {
        entries_.emplace_back();
      } else {
        row = free_.back();
        free_.pop_back();
      }
      entries_[row] = {key, tet, kNone, std::exchange(first_[key[0]], row)};
    }
  }
  /// Must have been added with these corners.
  void remove(std::uint32_t tet, const Corners& corners) {
    for (std::size_t left_out = 0; left_out < 4; ++left_out) {
      const Face key = face_of(corners, left_out);
      std::uint32_t* link = &first_[key[0]];
      while (entries_[*link].key != key)
        link = &entries_[*link].next;
      Entry& entry = entries_[*link];
      if (entry.tet == tet) entry.tet = entry.other;
      entry.other = kNone;
      if (entry.tet != kNone) continue;
      free_.push_back(*link);
      *link = entry.next;
    }
  }
  /// The row of the face in entries(), or none.
  [[nodiscard]] std::uint32_t find(const Face& key) const {
    std::uint32_t row = first_[key[0]];
    while (row != kNone && entries_[row].key != key)
      row = entries_[row].next;
    return row;
  }
  [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }

private:
  static Face face_of(const Corners& corners, std::size_t left_out) {
    Face face{};
    for (std::size_t i = 0; i < 3; ++i)
      face[i] = corners[i < left_out ? i : i + 1];
    return sorted(face);
  }

  std::vector<Entry> entries_;
  std::vector<std::uint32_t> free_;
  std::vector<std::uint32_t> first_; ///< by vertex
};

} // namespace ptet::view
