#include "geometry.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace ptet::view {
namespace {

using Face = std::array<std::uint32_t, 3>;

/// The corners opposite each corner of a positively oriented tet, outward.
constexpr std::array<std::array<std::uint8_t, 3>, 4> kOutward = {{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

Face outward_face(const std::array<std::uint32_t, 4>& tet, std::size_t corner) {
  const auto [a, b, c] = kOutward[corner];
  return {tet[a], tet[b], tet[c]};
}

Face sorted(Face face) {
  if (face[0] > face[1]) std::swap(face[0], face[1]);
  if (face[1] > face[2]) std::swap(face[1], face[2]);
  if (face[0] > face[1]) std::swap(face[0], face[1]);
  return face;
}

std::size_t hash_of(const Face& face) {
  std::uint64_t hash = face[0];
  for (const std::uint32_t v : {face[1], face[2]})
    hash = (hash ^ (hash >> 29)) * 0x9E3779B97F4A7C15U + v;
  hash = (hash ^ (hash >> 32)) * 0x9E3779B97F4A7C15U;
  return hash ^ (hash >> 31);
}

Point between(const Point& a, const Point& b, double t) {
  return {a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])};
}

} // namespace

void Polygons::clear() {
  points.clear();
  point_values.clear();
  cell_values.clear();
  offsets.assign(1, 0);
  corners.clear();
}

// At most half full.
void Geometry::begin_faces(std::size_t count) {
  const std::size_t size = std::bit_ceil(2 * count + 1);
  if (table_.size() < size) {
    table_.assign(size, {});
  } else {
    for (const std::uint32_t row : filled_)
      table_[row].tet = kUnusedRow;
  }
  filled_.clear();
}

Geometry::FaceEntry& Geometry::entry_of(const Face& face, bool& is_new) {
  const Face key = sorted(face);
  const std::size_t mask = table_.size() - 1;
  std::size_t row = hash_of(key) & mask;
  while (table_[row].tet != kUnusedRow && table_[row].key != key)
    row = (row + 1) & mask;
  is_new = table_[row].tet == kUnusedRow;
  if (is_new) {
    table_[row] = {key, 0, 0, kUnusedRow};
    filled_.push_back(static_cast<std::uint32_t>(row));
  }
  return table_[row];
}

void Geometry::emit(const MeshRows& mesh, const Face& face, std::uint32_t tet, Polygons& out) {
  for (const std::uint32_t v : face) {
    if (row_[v] == kUnusedRow) {
      row_[v] = static_cast<std::uint32_t>(out.points.size());
      out.points.push_back(mesh.positions[v]);
      if (mesh.tet_values.empty()) out.point_values.push_back(mesh.values[v]);
    }
    out.corners.push_back(row_[v]);
  }
  out.offsets.push_back(static_cast<std::int64_t>(out.corners.size()));
  if (!mesh.tet_values.empty()) out.cell_values.push_back(mesh.tet_values[tet]);
}

// Looks for the tets behind the faces among those with three corners on them.
void Geometry::emit_boundary_by_tet(const MeshRows& mesh, std::span<const char> is_kept, std::span<const Face> wanted,
                                    Polygons& out) {
  begin_faces(wanted.size());
  on_wanted_.assign(mesh.positions.size(), 0);
  bool is_new = false;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    entry_of(wanted[i], is_new);
    for (const std::uint32_t v : wanted[i])
      on_wanted_[v] = 1;
  }
  const std::size_t mask = table_.size() - 1;
  for (std::uint32_t t = 0; t < mesh.tets.size(); ++t) {
    const auto& tet = mesh.tets[t];
    if (tet[0] == kUnusedRow || (!is_kept.empty() && is_kept[t] == 0)) continue;
    if (on_wanted_[tet[0]] + on_wanted_[tet[1]] + on_wanted_[tet[2]] + on_wanted_[tet[3]] < 3) continue;
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const Face face = outward_face(tet, corner);
      const Face key = sorted(face);
      std::size_t row = hash_of(key) & mask;
      while (table_[row].tet != kUnusedRow && table_[row].key != key)
        row = (row + 1) & mask;
      if (table_[row].tet != kUnusedRow) emit(mesh, face, t, out);
    }
  }
}

void Geometry::boundary(const MeshRows& mesh, Polygons& out) {
  out.clear();
  row_.assign(mesh.positions.size(), kUnusedRow);
  unowned_.clear();
  for (const Face& face : mesh.faces) {
    if (face[0] == kUnusedRow) continue;
    if (mesh.tet_values.empty())
      emit(mesh, face, 0, out);
    else
      unowned_.push_back(face);
  }
  if (!unowned_.empty()) emit_boundary_by_tet(mesh, {}, unowned_, out);
}

template <class IsThere>
void Geometry::find_sides(const MeshRows& mesh, const Changes* changes, IsThere&& is_there) {
  side_.resize(mesh.positions.size());
  if (changes == nullptr) {
    for (std::size_t v = 0; v < side_.size(); ++v)
      side_[v] = is_there(v) ? 1 : 0;
  } else {
    for (const std::uint32_t v : changes->vertices)
      side_[v] = is_there(v) ? 1 : 0;
  }
}

// Where a vertex changes sides, or is another one, its tets are others.
void Geometry::find_mixed(const MeshRows& mesh, const Changes* changes) {
  const auto is_mixed = [&](const std::array<std::uint32_t, 4>& tet) {
    if (tet[0] == kUnusedRow) return false;
    const int there = side_[tet[0]] + side_[tet[1]] + side_[tet[2]] + side_[tet[3]];
    return there != 0 && there != 4;
  };
  if (changes == nullptr) {
    mixed_.clear();
    mixed_place_.assign(mesh.tets.size(), kUnusedRow);
    for (std::uint32_t t = 0; t < mesh.tets.size(); ++t)
      if (is_mixed(mesh.tets[t])) set_mixed(t, true);
  } else {
    mixed_place_.resize(mesh.tets.size(), kUnusedRow);
    for (const std::uint32_t t : changes->tets)
      set_mixed(t, is_mixed(mesh.tets[t]));
  }
}

void Geometry::set_mixed(std::uint32_t tet, bool mixed) {
  std::uint32_t& place = mixed_place_[tet];
  if (mixed == (place != kUnusedRow)) return;
  if (mixed) {
    place = static_cast<std::uint32_t>(mixed_.size());
    mixed_.push_back(tet);
  } else {
    mixed_[place] = mixed_.back();
    mixed_place_[mixed_.back()] = place;
    mixed_.pop_back();
    place = kUnusedRow;
  }
}

// A face between a kept and a dropped tet belongs to a tet that the plane cuts, a mixed one: were both on one side,
// both were kept or dropped. So only faces of mixed tets are hashed. Of those met once the tet behind is on one side,
// or there is none: a face with all corners in front has nothing kept behind it, and one with all corners behind is
// drawn where the mixed tet is dropped and it is no boundary face, or kept and it is one.
void Geometry::cut_open(const MeshRows& mesh, const Plane& plane, Polygons& out, const Changes* changes) {
  out.clear();
  row_.assign(mesh.positions.size(), kUnusedRow);
  distance_.resize(mesh.positions.size());
  find_sides(mesh, changes, [&](std::size_t v) {
    distance_[v] = plane.distance(mesh.positions[v]);
    return distance_[v] <= 0;
  });
  find_mixed(mesh, changes);
  const auto is_kept = [&](const std::array<std::uint32_t, 4>& tet) {
    return distance_[tet[0]] + distance_[tet[1]] + distance_[tet[2]] + distance_[tet[3]] <= 0;
  };
  const bool by_tet = !mesh.tet_values.empty();
  on_mixed_.assign(mesh.positions.size(), 0);
  for (const std::uint32_t t : mixed_)
    for (const std::uint32_t v : mesh.tets[t])
      on_mixed_[v] = 1;
  begin_faces(4 * mixed_.size());
  bool is_new = false;
  for (const std::uint32_t t : mixed_) {
    for (std::uint32_t corner = 0; corner < 4; ++corner) {
      FaceEntry& entry = entry_of(outward_face(mesh.tets[t], corner), is_new);
      (is_new ? entry.tet : entry.other) = t;
      if (is_new) entry.corner = corner;
    }
  }
  unowned_.clear();
  // Boundary faces: of mixed tets those of kept ones, of others those behind. `other` then tells that the face is done.
  const std::size_t mask = table_.size() - 1;
  for (const Face& face : mesh.faces) {
    if (face[0] == kUnusedRow) continue;
    const int behind = side_[face[0]] + side_[face[1]] + side_[face[2]];
    const auto emit_if_behind = [&] {
      if (behind == 3) (by_tet ? unowned_.push_back(face) : emit(mesh, face, 0, out));
    };
    if (on_mixed_[face[0]] + on_mixed_[face[1]] + on_mixed_[face[2]] != 3) {
      emit_if_behind();
      continue;
    }
    const Face key = sorted(face);
    std::size_t row = hash_of(key) & mask;
    while (table_[row].tet != kUnusedRow && table_[row].key != key)
      row = (row + 1) & mask;
    FaceEntry& entry = table_[row];
    if (entry.tet == kUnusedRow) {
      emit_if_behind();
      continue;
    }
    if (is_kept(mesh.tets[entry.tet])) emit(mesh, face, entry.tet, out);
    entry.other = entry.tet;
  }
  for (const std::uint32_t row : filled_) {
    const FaceEntry& entry = table_[row];
    if (entry.other == entry.tet) continue;
    const bool kept = is_kept(mesh.tets[entry.tet]);
    const Face face = outward_face(mesh.tets[entry.tet], entry.corner);
    const bool inward_kept = entry.other != kUnusedRow ? is_kept(mesh.tets[entry.other])
                                                       : side_[face[0]] + side_[face[1]] + side_[face[2]] == 3;
    if (kept == inward_kept) continue;
    const Face turned = {face[0], face[2], face[1]};
    if (kept)
      emit(mesh, face, entry.tet, out);
    else if (!by_tet || entry.other != kUnusedRow)
      emit(mesh, turned, entry.other, out);
    else
      unowned_.push_back(turned);
  }
  if (unowned_.empty()) return;
  is_kept_.resize(mesh.tets.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t)
    is_kept_[t] = mesh.tets[t][0] != kUnusedRow && is_kept(mesh.tets[t]) ? 1 : 0;
  emit_boundary_by_tet(mesh, is_kept_, unowned_, out);
}

void Geometry::level_set(const MeshRows& mesh, std::span<const double> function, double value, Polygons& out,
                         const Changes* changes) {
  out.clear();
  find_sides(mesh, changes, [&](std::size_t v) { return function[v] >= value; });
  find_mixed(mesh, changes);
  const bool by_tet = !mesh.tet_values.empty();
  for (const std::uint32_t t : mixed_) {
    const auto& tet = mesh.tets[t];
    const int above = side_[tet[0]] + side_[tet[1]] + side_[tet[2]] + side_[tet[3]];
    if (!std::isfinite(function[tet[0]] + function[tet[1]] + function[tet[2]] + function[tet[3]])) continue;
    std::array<std::uint32_t, 4> order{}; // corners above, then those below
    std::size_t first = 0, last = 4;
    for (const std::uint32_t v : tet)
      order[side_[v] != 0 ? first++ : --last] = v;
    const auto cross = [&](std::size_t i, std::size_t j) {
      const std::uint32_t a = order[i], b = order[j];
      const double s = (function[a] - value) / (function[a] - function[b]);
      out.corners.push_back(static_cast<std::int64_t>(out.points.size()));
      out.points.push_back(between(mesh.positions[a], mesh.positions[b], s));
      if (!by_tet) out.point_values.push_back(mesh.values[a] + s * (mesh.values[b] - mesh.values[a]));
    };
    if (above == 2) {
      cross(0, 2);
      cross(0, 3);
      cross(1, 3);
      cross(1, 2);
    } else {
      const std::size_t alone = above == 1 ? 0 : 3;
      for (std::size_t i = 0; i < 4; ++i)
        if (i != alone) cross(above == 1 ? alone : i, above == 1 ? i : alone);
    }
    out.offsets.push_back(static_cast<std::int64_t>(out.corners.size()));
    if (by_tet) out.cell_values.push_back(mesh.tet_values[t]);
  }
}

} // namespace ptet::view
