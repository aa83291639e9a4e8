#include "geometry.hpp"

#include <algorithm>
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

/// The same for the face with these corners.
Face outward_face(const std::array<std::uint32_t, 4>& tet, const Face& key) {
  std::size_t left_out = 0;
  while (std::find(key.begin(), key.end(), tet[left_out]) != key.end())
    ++left_out;
  return outward_face(tet, left_out);
}

Point between(const Point& a, const Point& b, double t) {
  return {a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])};
}

} // namespace

std::optional<std::size_t> Plane::axis() const {
  const auto is_across = [](double x) { return x != 0; };
  if (std::count_if(normal.begin(), normal.end(), is_across) != 1) return std::nullopt;
  return static_cast<std::size_t>(std::find_if(normal.begin(), normal.end(), is_across) - normal.begin());
}

double Plane::place() const {
  const std::optional<std::size_t> across = axis();
  return across ? offset / normal[*across] : offset;
}

void Plane::move_to(double place) {
  const std::optional<std::size_t> across = axis();
  offset = across ? place * normal[*across] : place;
}

void Polygons::clear() {
  points.clear();
  point_values.clear();
  cell_values.clear();
  offsets.assign(1, 0);
  corners.clear();
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

// Looks for the kept tets behind the faces among those with three corners on them.
template <class IsKept>
void Geometry::emit_by_tet(const MeshRows& mesh, std::span<const Face> wanted, IsKept&& is_kept, Polygons& out) {
  wanted_.clear();
  on_wanted_.assign(mesh.positions.size(), 0);
  for (const Face& face : wanted) {
    wanted_.push_back(FaceTable::sorted(face));
    for (const std::uint32_t v : face)
      on_wanted_[v] = 1;
  }
  std::sort(wanted_.begin(), wanted_.end());
  for (std::uint32_t t = 0; t < mesh.tets.size(); ++t) {
    const auto& tet = mesh.tets[t];
    if (tet[0] == kUnusedRow || (on_wanted_[tet[0]] | on_wanted_[tet[1]]) == 0) continue; // nearly all end here
    if (on_wanted_[tet[0]] + on_wanted_[tet[1]] + on_wanted_[tet[2]] + on_wanted_[tet[3]] < 3 || !is_kept(tet))
      continue;
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const Face face = outward_face(tet, corner);
      if (on_wanted_[face[0]] + on_wanted_[face[1]] + on_wanted_[face[2]] != 3) continue;
      if (std::binary_search(wanted_.begin(), wanted_.end(), FaceTable::sorted(face))) emit(mesh, face, t, out);
    }
  }
}

void Geometry::boundary(const MeshRows& mesh, Polygons& out) {
  out.clear();
  row_.assign(mesh.positions.size(), kUnusedRow);
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    if (mesh.faces[f][0] != kUnusedRow) emit(mesh, mesh.faces[f], mesh.behind.empty() ? 0 : mesh.behind[f], out);
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

// Where a vertex changes sides, or is another one, its tets are others. A tet that changed and stays in the set leaves
// it and comes back, once all have left: at no time do more than two share a face.
template <class Enters, class Leaves>
void Geometry::find_mixed(const MeshRows& mesh, const Changes* changes, Enters&& enters, Leaves&& leaves) {
  const auto is_mixed = [&](const Corners& tet) {
    if (tet[0] == kUnusedRow) return false;
    const int there = side_[tet[0]] + side_[tet[1]] + side_[tet[2]] + side_[tet[3]];
    return there != 0 && there != 4;
  };
  const auto enter = [&](std::uint32_t t) {
    mixed_place_[t] = static_cast<std::uint32_t>(mixed_.size());
    mixed_.push_back({t, mesh.tets[t]});
    enters(t, mesh.tets[t]);
  };
  if (changes == nullptr) {
    mixed_.clear();
    mixed_place_.assign(mesh.tets.size(), kUnusedRow);
    for (std::uint32_t t = 0; t < mesh.tets.size(); ++t)
      if (is_mixed(mesh.tets[t])) enter(t);
    return;
  }
  mixed_place_.resize(mesh.tets.size(), kUnusedRow);
  for (const std::uint32_t t : changes->tets) {
    if (const std::uint32_t place = mixed_place_[t]; place != kUnusedRow) {
      leaves(t, mixed_[place].corners);
      mixed_place_[mixed_.back().tet] = place;
      mixed_[place] = mixed_.back();
      mixed_.pop_back();
      mixed_place_[t] = kUnusedRow;
    }
  }
  for (const std::uint32_t t : changes->tets)
    if (is_mixed(mesh.tets[t])) enter(t);
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
  const auto is_behind = [&](const Corners& tet) {
    return distance_[tet[0]] + distance_[tet[1]] + distance_[tet[2]] + distance_[tet[3]] <= 0;
  };
  if (changes == nullptr) cut_faces_.clear();
  cut_faces_.make_room(mesh.positions.size());
  is_kept_.resize(mesh.tets.size());
  find_mixed(
      mesh, changes,
      [&](std::uint32_t t, const Corners& tet) {
        cut_faces_.add(t, tet);
        is_kept_[t] = is_behind(tet) ? 1 : 0;
      },
      [&](std::uint32_t t, const Corners& tet) { cut_faces_.remove(t, tet); });
  const bool by_tet = !mesh.tet_values.empty();
  on_mixed_.assign(mesh.positions.size(), 0);
  for (const Mixed& mixed : mixed_)
    for (const std::uint32_t v : mixed.corners)
      on_mixed_[v] = 1;
  // Boundary faces: of mixed tets those of kept ones, of others those behind.
  is_done_.assign(cut_faces_.entries().size(), 0);
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const Face& face = mesh.faces[f];
    if (face[0] == kUnusedRow) continue;
    const bool may_be_mixed = on_mixed_[face[0]] + on_mixed_[face[1]] + on_mixed_[face[2]] == 3;
    const std::uint32_t row = may_be_mixed ? cut_faces_.find(FaceTable::sorted(face)) : FaceTable::kNone;
    if (row == FaceTable::kNone) {
      const bool behind = side_[face[0]] + side_[face[1]] + side_[face[2]] == 3;
      if (behind) emit(mesh, face, by_tet ? mesh.behind[f] : 0, out);
      continue;
    }
    const std::uint32_t tet = cut_faces_.entries()[row].tet;
    if (is_kept_[tet] != 0) emit(mesh, face, tet, out);
    is_done_[row] = 1;
  }
  unowned_.clear();
  for (std::size_t row = 0; row < is_done_.size(); ++row) {
    const FaceTable::Entry& entry = cut_faces_.entries()[row];
    if (entry.tet == FaceTable::kNone || is_done_[row] != 0) continue;
    const bool kept = is_kept_[entry.tet] != 0;
    const bool other_kept = entry.other != FaceTable::kNone
                                ? is_kept_[entry.other] != 0
                                : side_[entry.key[0]] + side_[entry.key[1]] + side_[entry.key[2]] == 3;
    if (kept == other_kept) continue;
    const Face face = outward_face(mesh.tets[entry.tet], entry.key);
    const Face turned = {face[0], face[2], face[1]};
    if (kept)
      emit(mesh, face, entry.tet, out);
    else if (!by_tet || entry.other != FaceTable::kNone)
      emit(mesh, turned, entry.other, out);
    else
      unowned_.push_back(turned);
  }
  if (!unowned_.empty()) emit_by_tet(mesh, unowned_, is_behind, out);
}

void Geometry::level_set(const MeshRows& mesh, std::span<const double> function, double value, Polygons& out,
                         const Changes* changes) {
  out.clear();
  find_sides(mesh, changes, [&](std::size_t v) { return function[v] >= value; });
  find_mixed(
      mesh, changes, [](std::uint32_t, const Corners&) {}, [](std::uint32_t, const Corners&) {});
  const bool by_tet = !mesh.tet_values.empty();
  for (const auto& [t, tet] : mixed_) {
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
