#include "boundary_tets.hpp"

#include <algorithm>

namespace ptet::view {
namespace {

constexpr std::array<std::uint32_t, 3> kNoFace = {kUnusedRow, kUnusedRow, kUnusedRow};

} // namespace

void BoundaryTets::follow(const MeshRows& mesh, const Changes* changes) {
  if (changes == nullptr) {
    key_.clear();
    behind_.clear();
    next_.clear();
    first_.clear();
    count_.clear();
  }
  key_.resize(mesh.faces.size(), kNoFace);
  behind_.resize(mesh.faces.size(), kUnusedRow);
  next_.resize(mesh.faces.size(), kUnusedRow);
  first_.resize(mesh.positions.size(), kUnusedRow);
  count_.resize(mesh.positions.size(), 0);
  if (changes != nullptr) {
    for (const std::uint32_t row : changes->faces)
      set_face(row, mesh.faces[row]);
    for (const std::uint32_t t : changes->tets)
      look_behind(t, mesh.tets[t]);
  } else {
    for (std::uint32_t row = 0; row < mesh.faces.size(); ++row)
      set_face(row, mesh.faces[row]);
  }
  look_at_all(mesh);
}

// A face may come up on a tet that stays as it is, where a boundary vertex went into the inside.
void BoundaryTets::look_at_all(const MeshRows& mesh) {
  is_sought_.assign(mesh.positions.size(), 0);
  bool is_any = false;
  for (std::uint32_t row = 0; row < key_.size(); ++row) {
    if (key_[row] == kNoFace || behind_[row] != kUnusedRow) continue;
    is_any = true;
    for (const std::uint32_t v : key_[row])
      is_sought_[v] = 1;
  }
  for (std::uint32_t t = 0; is_any && t < mesh.tets.size(); ++t) {
    const auto& tet = mesh.tets[t];
    if (tet[0] == kUnusedRow || (is_sought_[tet[0]] | is_sought_[tet[1]]) == 0) continue; // nearly all end here
    if (is_sought_[tet[0]] + is_sought_[tet[1]] + is_sought_[tet[2]] + is_sought_[tet[3]] >= 3) look_behind(t, tet);
  }
}

// Takes the face that was there out of its list first.
void BoundaryTets::set_face(std::uint32_t row, const Face& face) {
  Face& key = key_[row];
  if (key != kNoFace) {
    std::uint32_t* link = &first_[key[0]];
    while (*link != row)
      link = &next_[*link];
    *link = next_[row];
    for (const std::uint32_t v : key)
      --count_[v];
  }
  key = face;
  std::sort(key.begin(), key.end());
  behind_[row] = kUnusedRow;
  if (key == kNoFace) return;
  next_[row] = first_[key[0]];
  first_[key[0]] = row;
  for (const std::uint32_t v : key)
    ++count_[v];
}

void BoundaryTets::look_behind(std::uint32_t tet, const std::array<std::uint32_t, 4>& corners) {
  if (corners[0] == kUnusedRow) return;
  int on_boundary = 0;
  for (const std::uint32_t v : corners)
    on_boundary += count_[v] != 0 ? 1 : 0;
  if (on_boundary < 3) return;
  for (std::size_t left_out = 0; left_out < 4; ++left_out) {
    Face face{};
    for (std::size_t i = 0; i < 3; ++i)
      face[i] = corners[i < left_out ? i : i + 1];
    if (count_[face[0]] == 0 || count_[face[1]] == 0 || count_[face[2]] == 0) continue;
    std::sort(face.begin(), face.end());
    for (std::uint32_t row = first_[face[0]]; row != kUnusedRow; row = next_[row])
      if (key_[row] == face) behind_[row] = tet;
  }
}

} // namespace ptet::view
