#include "error/exact_field_error.hpp"

#include "error/measured_parts.hpp"
#include "error/original_cells.hpp"

#include <algorithm>
#include <array>

namespace ptet {

ExactFieldError::Workspace::Workspace(const ExactFieldError& original)
    : view_(*original.original_), tet_stamp_(original.original_->cells.size()) {}

ExactFieldError::ExactFieldError(const PreparedMesh& prepared, ChannelView channels)
    : original_(std::make_unique<OriginalCells>(prepared, channels)) {}
ExactFieldError::~ExactFieldError() = default;

/// One measurement: the walk over the original tets that a version meets.
class ExactFieldError::Walk {
public:
  /// `squared` empty: not wanted. `limit` empty: none.
  Walk(const OriginalCells& original, Workspace& w, std::span<double> errors, std::span<double> squared,
       std::span<const double> limit)
      : original_(original), w_(w), view_(w.view_), parts_(original, w.view_, errors, squared, limit) {}

  /// False when it was given up.
  bool run(const Tet& version) {
    switch (view_.begin(version)) {
    case VersionView::Shape::kFlat: return true;
    case VersionView::Shape::kUntold: bound_by_values(); return !parts_.beyond_limit();
    case VersionView::Shape::kSolid: break;
    }
    measure();
    if (!view_.is_finite())
      parts_.fail();
    else
      parts_.take_rest();
    return !parts_.beyond_limit();
  }

private:
  using Cell = OriginalCells::Cell;
  static constexpr std::uint32_t kOutside = OriginalCells::kOutside;
  static constexpr std::uint32_t kLargeStar = OriginalCells::kLargeStar;

  void measure() {
    clear_workspace();
    // Around a vertex inside the domain the corner of the version is full of original tets. At the boundary there may
    // be none, and those that do not lie beyond one of the version's planes need not meet it.
    const auto& corners = view_.corners();
    const auto start =
        std::find_if(corners.begin(), corners.end(), [&](std::uint32_t v) { return !original_.on_boundary[v]; });
    met_boundary_ = start == corners.end();
    if (!met_boundary_) {
      enter_star(*start);
      walk();
    }
    if (!met_boundary_ || parts_.beyond_limit()) return;
    const auto near = [&, version = box()](const BoundingBox& other) {
      return version.meets(other) && !view_.is_beyond(other);
    };
    original_.boundary_tree->each_where(near, 0, [&](std::uint32_t face) {
      const HalfFace h = original_.boundary_faces[face];
      if (w_.tet_stamp_[h / 4] < queued() && !apart(original_.cells[h / 4], kOutwardFace[h % 4])) push(h / 4);
    });
    for (const std::uint32_t v : corners) {
      enter_star(v);
      for (const std::uint32_t t : original_.behind_thin(v))
        enter(t);
    }
    walk();
  }

  /// A tet's stamp while it waits in the queue and after it has left it.
  [[nodiscard]] std::uint32_t queued() const { return w_.stamp_; }
  [[nodiscard]] std::uint32_t done() const { return w_.stamp_ + 1; }

  [[nodiscard]] BoundingBox box() const {
    const auto at = [&](std::size_t k) { return original_.point(view_.corners()[k]); };
    return box_of<4>({at(0), at(1), at(2), at(3)});
  }

  void clear_workspace() {
    w_.queue_.clear();
    w_.stamp_ += 2;
    if (w_.stamp_ < 2) { // the stamps have gone round
      std::fill(w_.tet_stamp_.begin(), w_.tet_stamp_.end(), 0);
      w_.stamp_ = 2;
    }
  }

  /// In the version phi is between the values at its corners, and Phi between those at the corners of the original
  /// tets that come near it: no difference is greater than that of two of these.
  void bound_by_values() {
    const BoundingBox version = box();
    parts_.begin_values();
    for (const Cell& cell : original_.cells) {
      const auto at = [&](std::size_t k) { return original_.point(cell.v[k]); };
      if (!version.meets(box_of<4>({at(0), at(1), at(2), at(3)}))) continue;
      for (const std::uint32_t v : cell.v)
        for (const std::uint32_t corner : view_.corners())
          parts_.take_in_values(v, corner);
    }
    parts_.take_values_everywhere();
  }

  /// Whether one plane of the version has all these corners of a tet on its outer side (or on it).
  template <std::size_t N>
  [[nodiscard]] bool apart(const Cell& cell, const std::array<std::uint8_t, N>& corners) {
    unsigned common = 0xF;
    for (const std::uint8_t k : corners)
      common &= view_.row(view_.look_at(cell.v[k])).beyond;
    return common != 0;
  }

  void push(std::uint32_t t) {
    w_.tet_stamp_[t] = queued();
    w_.queue_.push_back(t);
  }

  void enter(std::uint32_t t) {
    if (w_.tet_stamp_[t] < queued() && !apart<4>(original_.cells[t], {0, 1, 2, 3})) push(t);
  }

  void enter_star(std::uint32_t v) {
    const std::uint32_t begin = original_.star_begin[v];
    const std::uint32_t end = original_.star_begin[v + 1];
    if (end - begin > kLargeStar) {
      enter_large_star(v);
      return;
    }
    for (std::uint32_t i = begin; i != end; ++i)
      enter(original_.star[i]);
  }

  /// The same tets in the same order, but for those that leave the corner in other directions.
  void enter_large_star(std::uint32_t v) {
    const auto& large = original_.large_stars;
    const auto place = std::lower_bound(large.begin(), large.end(), v) - large.begin();
    original_.cones[static_cast<std::size_t>(place)].find_near(original_.opposite(view_.corners(), v), w_.near_);
    for (const std::uint32_t i : w_.near_)
      enter(original_.star[original_.star_begin[v] + i]);
  }

  void walk() {
    for (; next_ < w_.queue_.size() && !parts_.beyond_limit(); ++next_) {
      const std::uint32_t t = w_.queue_[next_];
      w_.tet_stamp_[t] = done();
      const Cell& cell = original_.cells[t];
      std::array<std::uint32_t, 4> rows{};
      std::array<unsigned, 4> beyond{};
      for (std::size_t k = 0; k < 4; ++k) {
        rows[k] = view_.look_at(cell.v[k]);
        beyond[k] = view_.row(rows[k]).beyond;
      }
      const bool thin = original_.is_thin(t);
      const bool has_part =
          !cell.is_flat() && parts_.take_in(view_.is_fine() ? rows_by_place(cell) : rows, cell.volume);
      if (!thin && !has_part) continue;
      for (std::size_t k = 0; k < 4; ++k) {
        const auto& face = kOutwardFace[k];
        if ((beyond[face[0]] & beyond[face[1]] & beyond[face[2]]) != 0) continue;
        const std::uint32_t other = cell.neighbor[k];
        if (other == kOutside || original_.is_thin(other) != thin) met_boundary_ = true;
        if (other != kOutside && w_.tet_stamp_[other] < queued()) push(other);
      }
    }
  }

  /// The rows of an original tet's corners in the order of their places. In a flat version what rounding makes of a
  /// part depends on the order, and the same tet, however numbered, is to be measured from the same parts.
  std::array<std::uint32_t, 4> rows_by_place(const Cell& cell) {
    std::array<std::uint32_t, 4> v = cell.v;
    std::sort(v.begin(), v.end(), [&](std::uint32_t a, std::uint32_t b) {
      return original_.point(a) != original_.point(b) ? original_.point(a) < original_.point(b) : a < b;
    });
    return {view_.look_at(v[0]), view_.look_at(v[1]), view_.look_at(v[2]), view_.look_at(v[3])};
  }

  const OriginalCells& original_;
  Workspace& w_;
  VersionView& view_;
  MeasuredParts parts_;
  std::size_t next_ = 0;
  bool met_boundary_ = false;
};

void ExactFieldError::measure(const Tet& version, Workspace& workspace, std::span<double> errors) const {
  Walk(*original_, workspace, errors, {}, {}).run(version);
}

void ExactFieldError::measure(const Tet& version, Workspace& workspace, std::span<double> errors,
                              std::span<double> squared) const {
  Walk(*original_, workspace, errors, squared, {}).run(version);
}

bool ExactFieldError::measure(const Tet& version, Workspace& workspace, std::span<double> errors,
                              std::span<double> squared, std::span<const double> limit) const {
  return Walk(*original_, workspace, errors, squared, limit).run(version);
}

} // namespace ptet
