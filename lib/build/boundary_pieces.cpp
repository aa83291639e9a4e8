#include "build/boundary_pieces.hpp"

#include "error/tolerances.hpp"

#include <algorithm>

namespace ptet::build {
namespace {

/// What rounding can hide of a distance.
constexpr double kSlack = 1e-9;
/// One piece is not cut into more in one collapse; a triangle in so many pieces is not cut any more.
constexpr std::size_t kMostParts = 64;
/// A bound so close to the truth is good enough, where it is sought in all of the original boundary.
constexpr double kRelative = 0.03;
/// Needles ask for more cuts than they are worth: after these their bounds are a twentieth too wide, and hardly another
/// face needs so many.
constexpr std::size_t kMostCuts = 1000;

std::vector<Triangle> points_of(const std::vector<Point>& positions, std::span<const std::array<Vertex, 3>> triangles) {
  std::vector<Triangle> points;
  points.reserve(triangles.size());
  for (const auto& t : triangles)
    points.push_back({positions[t[0]], positions[t[1]], positions[t[2]]});
  return points;
}

} // namespace

BoundaryPieces::BoundaryPieces(const std::vector<Point>& positions, std::span<const std::array<Vertex, 3>> triangles,
                               double diagonal)
    : positions_(positions), original_(points_of(positions, triangles)), rounding_(kDistanceRounding * diagonal) {}

void BoundaryPieces::add(std::uint32_t face, const std::array<Vertex, 3>& triangle) {
  if (faces_.size() <= face) faces_.resize(face + 1);
  triangles_.push_back(triangle);
  parts_of_.push_back(0);
  push(faces_[face], static_cast<std::uint32_t>(triangles_.size() - 1), Part::whole());
}

std::array<Point, 3> BoundaryPieces::corners(std::uint32_t triangle) const {
  const auto& t = triangles_[triangle];
  return {positions_[t[0]], positions_[t[1]], positions_[t[2]]};
}

void BoundaryPieces::push(Face& face, std::uint32_t triangle, const Part& part) {
  const auto slot_in = [](auto& pool, auto& free) {
    if (free.empty()) {
      pool.emplace_back();
      return static_cast<std::uint32_t>(pool.size() - 1);
    }
    const std::uint32_t slot = free.back();
    free.pop_back();
    return slot;
  };
  std::uint32_t stored = kNone;
  if (!part.is_whole()) {
    stored = slot_in(parts_, free_parts_);
    parts_[stored] = part;
  }
  const std::uint32_t piece = slot_in(pieces_, free_pieces_);
  pieces_[piece] = {triangle, stored, face.first_piece};
  face.first_piece = piece;
  ++parts_of_[triangle];
}

std::vector<BoundaryPieces::Held> BoundaryPieces::held(std::uint32_t face) const {
  std::vector<Held> all;
  for (std::uint32_t p = faces_[face].first_piece; p != kNone; p = pieces_[p].next)
    all.push_back(
        {triangles_[pieces_[p].triangle], pieces_[p].part == kNone ? Part::whole() : parts_[pieces_[p].part]});
  return all;
}

BoundaryPieces::Division::Division(const BoundaryPieces& pieces)
    : of_(pieces), division_(pieces.rounding_), row_of_(pieces.positions_.size()), has_row_(pieces.positions_.size()) {}

/// What the faces hold, with parts of one triangle merged again, by triangle.
void BoundaryPieces::Division::gather(std::span<const std::uint32_t> fine) {
  found_.clear();
  gathered_.clear();
  for (const std::uint32_t f : fine)
    for (std::uint32_t p = of_.faces_[f].first_piece; p != kNone; p = of_.pieces_[p].next)
      found_.emplace_back(of_.pieces_[p].triangle, of_.pieces_[p].part);
  std::sort(found_.begin(), found_.end());
  for (std::size_t i = 0; i < found_.size();) {
    std::size_t end = i + 1;
    while (end < found_.size() && found_[end].first == found_[i].first)
      ++end;
    const std::uint32_t triangle = found_[i].first;
    // A whole one sorts last; all parts together are the whole again.
    if (found_[end - 1].second == kNone || end - i == of_.parts_of_[triangle]) {
      gathered_.push_back({triangle, Part::whole()});
    } else {
      scratch_.clear();
      for (; i < end; ++i)
        scratch_.push_back(of_.parts_[found_[i].second]);
      if (scratch_.size() > 1) merge_parts(scratch_);
      for (const Part& part : scratch_)
        gathered_.push_back({triangle, part});
    }
    i = end;
  }
}

/// Rows of the part's corners; those of vertices are shared.
void BoundaryPieces::Division::add_rows(std::uint32_t triangle, const Part& part) {
  const auto& t = of_.triangles_[triangle];
  const std::array<Point, 3> x = of_.corners(triangle);
  for (std::size_t i = 0; i < part.count; ++i) {
    const Part::Corner& c = part.corner[i];
    Vertex vertex = kNone;
    if (c == Part::Corner{0, 0}) vertex = t[0];
    if (c == Part::Corner{1, 0}) vertex = t[1];
    if (c == Part::Corner{0, 1}) vertex = t[2];
    if (vertex == kNone) {
      Point p{};
      for (std::size_t k = 0; k < 3; ++k)
        p[k] = x[0][k] + c[0] * (x[1][k] - x[0][k]) + c[1] * (x[2][k] - x[0][k]);
      rows_.push_back(division_.add_point(p));
    } else {
      if (has_row_.add(vertex)) row_of_[vertex] = division_.add_point(of_.positions_[vertex]);
      rows_.push_back(row_of_[vertex]);
    }
  }
}

/// Merges what one triangle has in one target, `all`: of all of it; returns the largest distance of what that changes.
double BoundaryPieces::Division::merge_placed(std::size_t first, bool all) {
  double worst = 0;
  const auto begin = handover_.placed.begin() + static_cast<std::ptrdiff_t>(first);
  std::stable_sort(begin, handover_.placed.end(), [](const Placed& a, const Placed& b) { return a.target < b.target; });
  std::size_t kept = first;
  const std::uint32_t triangle = begin->triangle;
  for (std::size_t i = first; i < handover_.placed.size();) {
    const std::uint32_t target = handover_.placed[i].target;
    scratch_.clear();
    for (; i < handover_.placed.size() && handover_.placed[i].target == target; ++i)
      scratch_.push_back(handover_.placed[i].part);
    const std::size_t before = scratch_.size();
    if (all && before == handover_.placed.size() - first)
      scratch_.assign(1, Part::whole());
    else if (before > 1)
      merge_parts(scratch_);
    for (const Part& part : scratch_) {
      if (scratch_.size() < before) worst = std::max(worst, division_.distance(of_.corners(triangle), part, target));
      handover_.placed[kept++] = {triangle, target, part};
    }
  }
  handover_.placed.resize(kept);
  return worst;
}

void BoundaryPieces::Division::begin(std::span<const PatchTriangle> coarse) {
  has_row_.clear();
  division_.begin(coarse);
  rows_.clear();
}

double BoundaryPieces::Division::at_least(std::span<const std::uint32_t> fine, std::span<const PatchTriangle> coarse,
                                          double enough) {
  gather(fine);
  begin(coarse);
  for (std::size_t i = 0; i < gathered_.size() && division_.lower_bound() <= enough; ++i)
    add_rows(gathered_[i].triangle, gathered_[i].part);
  return division_.lower_bound() > of_.rounding_ ? division_.lower_bound() : 0;
}

double BoundaryPieces::Division::divide(std::span<const PatchTriangle> coarse, double limit) {
  begin(coarse);
  handover_.placed.clear();
  for (const Gathered& g : gathered_)
    add_rows(g.triangle, g.part);
  double worst = division_.lower_bound();
  std::size_t row = 0;
  for (std::size_t i = 0; i < gathered_.size() && worst <= limit;) {
    std::size_t end = i + 1;
    while (end < gathered_.size() && gathered_[end].triangle == gathered_[i].triangle)
      ++end;
    const std::uint32_t triangle = gathered_[i].triangle;
    const std::size_t first = handover_.placed.size();
    const std::size_t most_parts = end - i < kMostParts ? kMostParts : 1;
    const bool all = gathered_[i].part.is_whole();
    for (; i < end; ++i) {
      const Part& part = gathered_[i].part;
      divided_.clear();
      worst = std::max(worst, division_.divide(of_.corners(triangle), part, {rows_.data() + row, part.count}, 0,
                                               most_parts, divided_));
      row += part.count;
      for (const PatchDivision::Placed& p : divided_)
        handover_.placed.push_back({triangle, p.target, p.part});
    }
    if (handover_.placed.size() - first > 1) worst = std::max(worst, merge_placed(first, all));
  }
  return worst;
}

/// An upper bound on the largest distance of a point of the face to the targets, offsets included.
double BoundaryPieces::Division::away_from(const PatchTriangle& face, std::span<const PatchTriangle> targets,
                                           double enough) {
  division_.begin(targets);
  std::array<std::uint32_t, 3> rows{};
  for (std::size_t i = 0; i < 3; ++i)
    rows[i] = division_.add_point(face.x[i]);
  divided_.clear();
  return division_.divide(face.x, Part::whole(), rows, enough, kMostParts + 4 * targets.size(), divided_);
}

double BoundaryPieces::Division::away(std::uint32_t target, const PatchTriangle& face,
                                      std::span<const PatchTriangle> fine, double enough) {
  // By way of the faces before the collapse: exact where the surface stays in its own plane.
  double least = away_from(face, fine, enough);
  if (least <= enough) return least;
  near_.clear();
  std::uint32_t last = kNone;
  for (const Placed& p : handover_.placed)
    if (p.target == target && p.triangle != last) {
      last = p.triangle;
      near_.push_back({of_.triangles_[last], of_.corners(last), 0});
    }
  if (!near_.empty()) least = std::min(least, away_from(face, near_, enough));
  if (least <= enough) return least;
  // What else is near may be held by faces elsewhere.
  return std::min(least, of_.original_.farthest(face.x, kRelative, enough, kMostCuts).upper);
}

double BoundaryPieces::Division::hand_over(std::span<const std::uint32_t> fine, std::span<PatchTriangle> fine_triangles,
                                           std::span<const PatchTriangle> coarse, double limit) {
  gather(fine);
  limit = std::max(limit, of_.rounding_);
  double error = divide(coarse, limit);
  if (error > limit) return error;
  for (std::size_t i = 0; i < fine.size(); ++i)
    fine_triangles[i].offset = of_.faces_[fine[i]].away;
  handover_.away.clear();
  const double enough = std::max((1 + kRelative) * error, of_.rounding_);
  for (std::uint32_t i = 0; i < coarse.size(); ++i) {
    const double found = away(i, coarse[i], fine_triangles, enough);
    handover_.away.push_back(found > of_.rounding_ ? found : 0);
    error = std::max(error, found);
    if (error > limit) return error;
  }
  return error > of_.rounding_ ? error * (1 + kSlack) : 0;
}

void BoundaryPieces::commit(std::span<const std::uint32_t> fine, std::span<const std::uint32_t> faces,
                            const Handover& handover) {
  for (const std::uint32_t f : fine) {
    for (std::uint32_t p = faces_[f].first_piece; p != kNone; p = pieces_[p].next) {
      if (pieces_[p].part != kNone) free_parts_.push_back(pieces_[p].part);
      free_pieces_.push_back(p);
      --parts_of_[pieces_[p].triangle];
    }
    faces_[f] = {};
  }
  for (std::size_t i = 0; i < faces.size(); ++i)
    faces_[faces[i]].away = handover.away[i];
  for (const Handover::Placed& p : handover.placed)
    push(faces_[faces[p.target]], p.triangle, p.part);
}

} // namespace ptet::build
