#include "formats/vtk/cell_splitting.hpp"

#include "formats/vtk/split_cell.hpp"
#include "mesh/disjoint_sets.hpp"
#include "mesh/predicates.hpp"
#include "mesh/vec3.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <numeric>
#include <tuple>
#include <utility>

namespace ptet::vtkio {
namespace {

/// Tets of a cell that are turned over count most, flat ones where nothing else differs, but those of parts of cells
/// more. A cell gives no more than 48, a part no more than two.
constexpr std::uint32_t kTurned = 256, kFlatInPart = 64, kFlat = 1;
/// Places with more cells around them stay where they are: each look at one takes them all.
constexpr std::size_t kMostAround = 256;
/// Some milliseconds of work.
constexpr std::size_t kBetweenLooks = 4096;

} // namespace

std::span<const VertexId> CellSplitting::points_of(const Cell& cell) const {
  return std::span(points_).subspan(cell.points_begin, cell_size(cell.type).points);
}

void CellSplitting::add(int vtk_cell_type, std::span<const VertexId> points, std::uint64_t id, std::size_t tets_before,
                        bool is_part) {
  cells_.push_back({id, tets_before, points_.size(), vtk_cell_type, is_part});
  points_.insert(points_.end(), points.begin(), points.end());
}

/// The order that all cells are split by, and what it is changed to where that helps.
class OrderOfPoints {
public:
  OrderOfPoints(const CellSplitting& splitting, const TetMesh& mesh, const std::function<void()>& look)
      : splitting_(splitting), mesh_(mesh), look_(look) {}

  using Cell = CellSplitting::Cell;

  void append_tets(const Cell& cell, std::vector<Tet>& tets) const {
    const std::span<const VertexId> points = splitting_.points_of(cell);
    split_cell(cell.type, points, has_diagonals(cell.type) ? ranks_of(points) : Ranks{}, mesh_, tets);
  }

  /// Looks at all cells, and changes the order where some give turned tets, or parts of cells flat ones.
  void improve();
  /// Whether a cell, by its place in the splitting, gives turned tets by the order that improve() left.
  [[nodiscard]] bool gives_turned(std::size_t cell) const { return badness_[cell] >= kTurned; }
  /// Whether it may give flat ones.
  [[nodiscard]] bool may_be_flat(std::size_t cell) const { return badness_[cell] != 0; }

private:
  [[nodiscard]] bool is_worth_a_move(std::size_t cell) const { return badness_[cell] >= kFlatInPart; }
  /// How bad the tets are that a cell gives: 0 when all of them have the orientation of the whole cell, or no order
  /// makes them better.
  [[nodiscard]] std::uint32_t badness(const Cell& cell) {
    using namespace vec;
    if (!has_diagonals(cell.type)) return 0;
    tets_.clear();
    append_tets(cell, tets_);
    std::uint32_t turned = 0, straight = 0, flat = 0;
    double volume = 0;
    for (const Tet& tet : tets_) {
      const Point a = mesh_.position(tet[0]), b = mesh_.position(tet[1]), c = mesh_.position(tet[2]),
                  d = mesh_.position(tet[3]);
      volume += dot(b - a, cross(c - a, d - a));
      const int sign = sure_orientation(a, b, c, d);
      ++(sign > 0 ? straight : sign < 0 ? turned : flat);
    }
    const bool is_turned = volume < 0 && !cell.is_part;
    return kTurned * (is_turned ? straight : turned) + (cell.is_part ? kFlatInPart : kFlat) * flat;
  }

  /// Where a place goes, and how much less bad cells are for it.
  struct Move {
    std::uint32_t place = 0;
    std::int64_t to = 0;
    std::uint32_t gain = 0;
  };

  [[nodiscard]] std::int64_t moved(VertexId v) const { return place_.empty() ? 0 : moved_[place_[v.index()]]; }
  [[nodiscard]] Ranks ranks_of(std::span<const VertexId> points) const {
    std::array<std::tuple<std::int64_t, Point, VertexId>, kMaxCellPoints> keys;
    for (std::size_t i = 0; i < points.size(); ++i)
      keys[i] = {moved(points[i]), mesh_.position(points[i]), points[i]};
    // Counted, not sorted: a coordinate that is not a number has no place in an order.
    Ranks ranks{};
    for (std::size_t i = 0; i < points.size(); ++i)
      for (std::size_t j = 0; j < points.size(); ++j)
        ranks[i] = static_cast<std::uint8_t>(ranks[i] + (keys[j] < keys[i] ? 1 : 0));
    return ranks;
  }
  void find_places();
  void find_cells_around();
  [[nodiscard]] std::span<const std::uint32_t> cells_around(std::uint32_t place) const {
    return std::span(around_).subspan(around_begin_[place], around_begin_[place + 1] - around_begin_[place]);
  }
  /// Finds badness_, and returns its sum.
  std::uint64_t examine_all();
  void keep_columns_together();
  [[nodiscard]] Move best_move(std::uint32_t cell);
  [[nodiscard]] std::uint32_t gain_of(const Move& move, std::uint32_t cell);

  const CellSplitting& splitting_;
  const TetMesh& mesh_;
  const std::function<void()>& look_;
  std::vector<Tet> tets_;
  // Where the order is changed.
  std::vector<std::uint32_t> place_; ///< by vertex, in the order of positions; vertices at one place have the same
  std::vector<std::int64_t> moved_;  ///< by place: before others (negative) or behind
  std::vector<std::uint32_t> around_;
  std::vector<std::size_t> around_begin_; ///< by place, and the end
  std::vector<std::uint32_t> badness_;    ///< by cell
};

void OrderOfPoints::find_places() {
  std::vector<std::uint32_t> sorted;
  sorted.reserve(splitting_.points_.size());
  for (const VertexId v : splitting_.points_)
    sorted.push_back(v.index());
  std::sort(sorted.begin(), sorted.end());
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  std::sort(sorted.begin(), sorted.end(), [&](std::uint32_t a, std::uint32_t b) {
    return mesh_.position(VertexId(a)) < mesh_.position(VertexId(b));
  });
  std::vector<std::uint32_t> place(mesh_.vertex_count());
  std::uint32_t next = 0;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    if (i > 0 && mesh_.position(VertexId(sorted[i])) != mesh_.position(VertexId(sorted[i - 1]))) ++next;
    place[sorted[i]] = next;
  }
  moved_.assign(std::size_t{next} + 1, 0);
  place_ = std::move(place);
}

void OrderOfPoints::find_cells_around() {
  around_begin_.assign(moved_.size() + 1, 0);
  const auto each = [&](auto&& visit) {
    for (std::uint32_t c = 0; c < splitting_.cells_.size(); ++c) {
      const std::span<const VertexId> points = splitting_.points_of(splitting_.cells_[c]);
      for (std::size_t i = 0; i < points.size(); ++i) {
        // Once, also where several of its points are at one place: what is weighed must be what changes.
        const std::uint32_t place = place_[points[i].index()];
        if (std::none_of(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(i),
                         [&](VertexId v) { return place_[v.index()] == place; }))
          visit(place, c);
      }
    }
  };
  each([&](std::uint32_t place, std::uint32_t) { ++around_begin_[place + 1]; });
  std::partial_sum(around_begin_.begin(), around_begin_.end(), around_begin_.begin());
  around_.resize(around_begin_.back());
  std::vector<std::size_t> at(around_begin_.begin(), around_begin_.end() - 1);
  each([&](std::uint32_t place, std::uint32_t c) { around_[at[place]++] = c; });
}

std::uint64_t OrderOfPoints::examine_all() {
  badness_.clear();
  for (const Cell& cell : splitting_.cells_) {
    if (badness_.size() % kBetweenLooks == 0) look_();
    badness_.push_back(badness(cell));
  }
  return std::accumulate(badness_.begin(), badness_.end(), std::uint64_t{0});
}

/// Points that are near one another beside the width of a cell, as those across a layer of thin ones, come one after
/// the other, so that all of such a column is before or behind all of the next.
void OrderOfPoints::keep_columns_together() {
  constexpr double kNear = 1.0 / 9; // of the squared width
  constexpr std::size_t kMostCorners = 8;
  DisjointSets columns(moved_.size());
  const auto squared_distance = [&](VertexId v, VertexId w) {
    using namespace vec;
    const Point apart = mesh_.position(v) - mesh_.position(w);
    return dot(apart, apart);
  };
  for (const Cell& cell : splitting_.cells_) {
    const std::span<const VertexId> points = splitting_.points_of(cell);
    double width = 0;
    for (const VertexId v : points)
      for (const VertexId w : points)
        width = std::max(width, squared_distance(v, w));
    if (points.size() > kMostCorners) width /= 4; // from one point of an edge to the next
    for (const VertexId v : points)
      for (const VertexId w : points)
        if (squared_distance(v, w) < kNear * width) columns.join(place_[v.index()], place_[w.index()]);
  }
  std::vector<std::int64_t> first(moved_.size(), -1);
  for (std::uint32_t place = 0; place < moved_.size(); ++place) {
    std::int64_t& of_column = first[columns.root(place)];
    if (of_column < 0) of_column = place;
    moved_[place] = of_column;
  }
}

/// How much less bad the cells around a place are with it moved; 0 when `cell` itself is none the better for it.
std::uint32_t OrderOfPoints::gain_of(const Move& move, std::uint32_t cell) {
  const std::int64_t from = std::exchange(moved_[move.place], move.to);
  std::uint32_t before = 0, after = 0;
  if (badness(splitting_.cells_[cell]) < badness_[cell]) {
    for (const std::uint32_t c : cells_around(move.place)) {
      before += badness_[c];
      after += badness(splitting_.cells_[c]);
    }
  }
  moved_[move.place] = from;
  return before - std::min(before, after);
}

OrderOfPoints::Move OrderOfPoints::best_move(std::uint32_t cell) {
  Move best{};
  for (const VertexId v : splitting_.points_of(splitting_.cells_[cell])) {
    const std::uint32_t place = place_[v.index()];
    if (cells_around(place).size() > kMostAround) continue;
    std::int64_t least = moved_[place], most = moved_[place];
    for (const std::uint32_t c : cells_around(place)) {
      for (const VertexId w : splitting_.points_of(splitting_.cells_[c])) {
        least = std::min(least, moved_[place_[w.index()]]);
        most = std::max(most, moved_[place_[w.index()]]);
      }
    }
    for (const std::int64_t to : {least - 1, most + 1}) {
      Move move{place, to};
      move.gain = gain_of(move, cell);
      if (move.gain > best.gain) best = move;
    }
  }
  return best;
}

void OrderOfPoints::improve() {
  const std::uint64_t sum_by_position = examine_all();
  if (std::none_of(badness_.begin(), badness_.end(), [](std::uint32_t b) { return b >= kFlatInPart; })) return;
  for (const VertexId v : splitting_.points_) {
    const Point at = mesh_.position(v);
    if (!is_finite(at)) return; // there is no order
  }
  find_places();
  find_cells_around();
  keep_columns_together();
  std::vector<std::uint32_t> by_position = badness_;
  if (examine_all() >= sum_by_position) {
    std::fill(moved_.begin(), moved_.end(), 0);
    badness_ = std::move(by_position);
  }
  // Every move lessens the sum of what is bad, so this ends.
  std::deque<std::uint32_t> bad;
  std::vector<char> is_queued(splitting_.cells_.size(), 0);
  const auto queue = [&](std::uint32_t c) {
    if (!is_worth_a_move(c) || is_queued[c] != 0) return;
    is_queued[c] = 1;
    bad.push_back(c);
  };
  for (std::uint32_t c = 0; c < splitting_.cells_.size(); ++c)
    queue(c);
  for (std::size_t looked_at = 0; !bad.empty(); ++looked_at) {
    if (looked_at % 64 == 0) look_();
    const std::uint32_t cell = bad.front();
    bad.pop_front();
    is_queued[cell] = 0;
    if (!is_worth_a_move(cell)) continue;
    const Move move = best_move(cell);
    if (move.gain == 0) continue;
    moved_[move.place] = move.to;
    for (const std::uint32_t c : cells_around(move.place))
      badness_[c] = badness(splitting_.cells_[c]);
    for (const std::uint32_t c : cells_around(move.place))
      queue(c);
  }
}

namespace {

/// Marks pairs of some tets that stand on the same vertices, one the other turned over, with 1. `is_out`: by tet, as
/// far as was marked.
void mark_pairs(const std::vector<Tet>& tets, const std::vector<std::size_t>& some, std::vector<char>& is_out) {
  struct Candidate {
    Tet sorted;
    bool is_odd; ///< the order of its vertices, against the sorted one
    std::size_t place;
  };
  std::vector<Candidate> candidates;
  for (const std::size_t place : some) {
    Candidate candidate{tets[place], false, place};
    for (std::size_t i = 1; i < 4; ++i)
      for (std::size_t j = i; j > 0 && candidate.sorted[j] < candidate.sorted[j - 1]; --j) {
        std::swap(candidate.sorted[j], candidate.sorted[j - 1]);
        candidate.is_odd = !candidate.is_odd;
      }
    candidates.push_back(candidate);
  }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return std::tie(a.sorted, a.is_odd, a.place) < std::tie(b.sorted, b.is_odd, b.place);
  });
  for (auto run = candidates.begin(); run != candidates.end();) {
    const auto end = std::find_if(run, candidates.end(), [&](const Candidate& c) { return c.sorted != run->sorted; });
    const auto odd = std::find_if(run, end, [](const Candidate& c) { return c.is_odd; });
    const auto pairs = std::min(odd - run, end - odd);
    if (pairs > 0 && is_out.size() < tets.size()) is_out.resize(tets.size(), 0);
    for (std::ptrdiff_t i = 0; i < pairs; ++i)
      is_out[run[i].place] = is_out[odd[i].place] = 1;
    run = end;
  }
}

/// Returns how many tets were out.
std::size_t take_out(std::vector<Tet>& tets, std::vector<char>& is_out) {
  if (is_out.empty()) return 0;
  is_out.resize(tets.size(), 0);
  std::size_t kept = 0;
  for (std::size_t t = 0; t < tets.size(); ++t)
    if (is_out[t] == 0) tets[kept++] = tets[t];
  const std::size_t out = tets.size() - kept;
  tets.resize(kept);
  return out;
}

} // namespace

CellSplitting::Unsplit CellSplitting::split(TetMesh& mesh, const std::function<void()>& look) const {
  Unsplit unsplit;
  if (cells_.empty() && part_tets_.empty()) return unsplit;
  OrderOfPoints order(*this, mesh, look);
  order.improve();
  std::vector<Tet> tets;
  std::size_t most = mesh.tets.size();
  for (const Cell& cell : cells_)
    most += cell_size(cell.type).most_tets;
  tets.reserve(most);
  std::size_t done = 0;
  std::vector<std::size_t> flat, of_cell; // places in tets
  std::vector<char> is_out;
  struct Turned {
    std::size_t place;
    std::uint64_t id; // of its cell
  };
  std::vector<Turned> turned; // parts
  const auto sign = [&](const Tet& tet) {
    return sure_orientation(mesh.position(tet[0]), mesh.position(tet[1]), mesh.position(tet[2]), mesh.position(tet[3]));
  };
  // Pairs are found cell by cell, whose parts come one after the other: there may be many.
  std::uint64_t cell_of_parts = 0;
  const auto look_at_part = [&](std::size_t place, std::uint64_t id) {
    if (id != cell_of_parts) {
      mark_pairs(tets, of_cell, is_out);
      of_cell.clear();
      cell_of_parts = id;
    }
    of_cell.push_back(place);
    if (sign(tets[place]) < 0) turned.push_back({place, id});
  };
  auto parts = part_tets_.begin();
  const auto take_others_until = [&](std::size_t end) {
    const std::size_t moved = tets.size() - done;
    tets.insert(tets.end(), mesh.tets.begin() + static_cast<std::ptrdiff_t>(done),
                mesh.tets.begin() + static_cast<std::ptrdiff_t>(end));
    done = end;
    for (; parts != part_tets_.end() && parts->begin < end; ++parts)
      for (std::size_t t = parts->begin; t < parts->end; ++t)
        look_at_part(moved + t, parts->id);
  };
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    if (c % kBetweenLooks == 0) look();
    const Cell& cell = cells_[c];
    take_others_until(cell.tets_before);
    const std::size_t before = tets.size();
    order.append_tets(cell, tets);
    if (tets.size() == before) unsplit.gone.push_back(cell.id);
    for (std::size_t t = before; cell.is_part && t < tets.size(); ++t)
      look_at_part(t, cell.id);
    if (cell.is_part) continue;
    if (order.gives_turned(c)) unsplit.turned.push_back(cell.id);
    for (std::size_t t = before; order.may_be_flat(c) && t < tets.size(); ++t)
      if (sign(tets[t]) == 0) flat.push_back(t); // but for rounding
  }
  take_others_until(mesh.tets.size());
  mark_pairs(tets, of_cell, is_out);
  mark_pairs(tets, flat, is_out);
  for (const auto& [place, id] : turned)
    if ((place >= is_out.size() || is_out[place] == 0) &&
        (unsplit.turned_parts.empty() || unsplit.turned_parts.back() != id))
      unsplit.turned_parts.push_back(id);
  unsplit.paired = take_out(tets, is_out);
  mesh.tets = std::move(tets);
  return unsplit;
}

} // namespace ptet::vtkio
