// How one record is coded: one text for the reader's side and the writer's (see range_coder.hpp for the sides). Each
// step takes the true value on the writer's side and returns it on both.
//
//   seeds      where the split happens: a version of C(r), named by the record that made it (PTET.md, "Seeds")
//   position   of the new vertex v, predicted from the first seed
//   growth     one bit for each face met while the region grows
//   arrays     of v, predicted from the vertices around it
//   errors     own, and how much more the finer records that depend on it have
//   squared    what the collapse raised the mean square errors by, predicted from the own error and the star's volume,
//              and what it uncovered, predicted from what its tets lost
//   order      when budgets undo the collapse, below that of the parents
//
// Everything used to predict is the same in every closed set of loaded blocks.
#pragma once

#include "formats/ptet/error_codec.hpp"
#include "formats/ptet/number_codec.hpp"
#include "formats/ptet/reader.hpp"
#include "formats/ptet/schema.hpp"
#include "formats/ptet/seed_codec.hpp"
#include "mesh/large_pages.hpp"
#include "mesh/scalar_dispatch.hpp"
#include "mesh/vec3.hpp"
#include "record/ghost.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

namespace ptet::file {

/// What the reader's side knows of a record before: nothing.
struct NothingKnown {
  static constexpr bool kWriter = false;
};

/// What the writer's side knows: its seeds, and the region.
template <class InRegion>
struct RecordKnown {
  static constexpr bool kWriter = true;
  std::span<const Seed> seeds;
  InRegion in_region; ///< (place) -> bool
};

/// Codes records one after the other. Holds scratch for as many vertices as the mesh has.
class RecordCodec {
public:
  RecordCodec(const Schema& schema, std::span<const BlockInfo> blocks, std::size_t vertex_count)
      : schema_(schema), blocks_(blocks), marks_(vertex_count + 1) {
    std::size_t column = 0;
    for (std::uint32_t array = 0; array < schema.arrays.size(); ++array) {
      for (std::uint32_t component = 0; component < schema.arrays[array].size(); ++component, ++column) {
        if (column % kColumnsAtOnce == 0) groups_.emplace_back();
        auto& group = groups_.back();
        if (group.empty() || group.back().array != array) group.push_back({array, component, 0});
        ++group.back().components;
      }
    }
  }

  /// Codes record `r` and applies its split. The writer's `content` holds all values beforehand, the reader's gets
  /// those of the record. `others`: parents that are not told by the region.
  template <class Coder, class Known>
  void code(Coder& coder, BlockState& state, Content& content, RecordId r, const Known& known,
            std::span<const RecordId> others) {
    next_stamp();
    code_seeds(coder, state, content, r, known);
    code_position(coder, content, r);
    u_position_ = position(content, target_);
    v_position_ = position(content, content.refinement.vertex_of(r));
    const auto joins = [&](const GrowthFace& face) {
      if constexpr (Known::kWriter) {
        return code_growth(coder, content, face, known.in_region(face.behind));
      } else {
        return code_growth(coder, content, face, false);
      }
    };
    content.refinement.split(r, target_, seed_places_, joins, others);
    weigh_link(content);
    code_arrays(coder, content, r);
    code_errors(coder, schema_, state, content, r, at_boundary_, missed_);
    if (schema_.has_squared_errors) {
      code_squared_errors(coder, schema_, state, content, r, six_star_volumes(content, r));
      code_uncovered(coder, schema_, state, content, r, [&] { return six_volumes_lost(content, r); });
    }
    code_order(coder, schema_, blocks_[state.block].max_order, content, r);
  }

  /// Box of the star of the record coded last.
  [[nodiscard]] const Point& star_least() const { return star_least_; }
  [[nodiscard]] const Point& star_greatest() const { return star_greatest_; }
  /// Extends a box by it.
  void extend_by_star(Point& least, Point& greatest) const {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      least[axis] = std::min(least[axis], star_least_[axis]);
      greatest[axis] = std::max(greatest[axis], star_greatest_[axis]);
    }
  }

private:
  /// Scratch by vertex, valid for the record whose stamp it holds; the last row is the dummy's.
  struct Mark {
    std::uint32_t stamp = 0;
    std::uint32_t near = 0; ///< index into near_
  };
  /// A vertex near v, met while the region grows.
  struct NearVertex {
    Point at, from_u;
    double v_distance_sq;
    std::uint8_t nearness; ///< 0: near v .. 5: near u; 6: the dummy
    std::uint8_t rim;      ///< faces of the rim at this vertex so far, 2 at most
  };
  static constexpr std::uint8_t kDummyNearness = 6;
  static constexpr std::size_t kMaxPrefetched = 8;
  struct LinkVertex {
    std::size_t vertex;
    double weight;
  };

  void next_stamp() {
    near_.clear();
    if (++stamp_ != 0) return;
    std::fill(marks_.begin(), marks_.end(), Mark{});
    stamp_ = 1;
  }
  /// Index into near_.
  [[nodiscard]] std::uint32_t near(const Content& content, VertexId v) {
    Mark& mark = marks_[v == kDummyVertex ? marks_.size() - 1 : v.index()];
    if (mark.stamp != stamp_) {
      mark = {stamp_, static_cast<std::uint32_t>(near_.size())};
      near_.push_back(measure(content, v));
    }
    return mark.near;
  }
  [[nodiscard]] static Point position(const Content& content, VertexId v) {
    const PointArray& positions = content.positions;
    // The one hot load: the two types that nearly every mesh has go without a switch for each coordinate.
    if (positions.type == ScalarType::kFloat32) {
      const std::byte* at = positions.bytes.data() + v.index() * std::size_t{12};
      return {load<float>(at), load<float>(at + 4), load<float>(at + 8)};
    }
    if (positions.type == ScalarType::kFloat64) {
      const std::byte* at = positions.bytes.data() + v.index() * std::size_t{24};
      return {load<double>(at), load<double>(at + 8), load<double>(at + 16)};
    }
    return {positions.value(v.index(), 0), positions.value(v.index(), 1), positions.value(v.index(), 2)};
  }
  [[nodiscard]] static std::byte* scalar_at(PointArray& array, const Column& column, std::size_t row,
                                            std::size_t component) {
    return array.bytes.data() + (row * array.components + component) * (column.bits / 8);
  }
  /// The values of a vertex of the link are wanted soon, each from another place in memory.
  void prefetch_values(const Content& content, VertexId v) const {
    for (std::size_t i = 0; i < std::min(content.arrays.size(), kMaxPrefetched); ++i) {
      const std::size_t row_bytes = content.arrays[i].components * (schema_.arrays[i].front().bits / 8);
      __builtin_prefetch(content.arrays[i].bytes.data() + v.index() * row_bytes);
    }
  }

  template <class Coder, class Known>
  void code_seeds(Coder& coder, BlockState& state, const Content& content, RecordId r, const Known& known);
  template <class Coder>
  void code_position(Coder& coder, Content& content, RecordId r);
  template <class Coder>
  std::optional<std::uint64_t> code_same(Coder& coder, std::size_t axis, std::uint32_t earlier,
                                         std::span<const std::uint64_t> corners, std::uint64_t rank);
  template <class Coder>
  bool code_growth(Coder& coder, const Content& content, const GrowthFace& face, bool joins);
  template <class Coder>
  void code_arrays(Coder& coder, Content& content, RecordId r);
  [[nodiscard]] static double six_volumes(const Content& content, const Point& apex, const Tet& tet);
  [[nodiscard]] double six_star_volumes(const Content& content, RecordId r) const;
  [[nodiscard]] double six_volumes_lost(const Content& content, RecordId r) const;

  struct Prediction {
    double value, spread;
  };
  /// Components of an array.
  struct Columns {
    std::uint32_t array, first_component, components;
  };
  static constexpr std::size_t kColumnsAtOnce = 16;
  void predict(const Content& content, const std::vector<Columns>& group);
  [[nodiscard]] Prediction predict_finite(std::size_t column) const;
  [[nodiscard]] NearVertex measure(const Content& content, VertexId v) const;
  [[nodiscard]] std::uint32_t height_class(const Content& content, const GrowthFace& face, std::uint32_t a,
                                           std::uint32_t b);
  void weigh_link(const Content& content);

  const Schema& schema_;
  std::span<const BlockInfo> blocks_;
  LargeVector<Mark> marks_;
  std::uint32_t stamp_ = 0;

  // Of the record at hand.
  std::vector<std::uint32_t> seed_places_;
  VertexId target_;
  Point u_position_{}, v_position_{};
  Point star_least_{}, star_greatest_{};
  std::vector<NearVertex> near_;
  std::vector<LinkVertex> link_;
  std::vector<std::vector<Columns>> groups_;                    ///< of all columns, predicted together
  std::vector<std::array<double, kColumnsAtOnce>> near_values_; ///< of a group, by vertex of the link
  std::array<Prediction, kColumnsAtOnce> predictions_{};        ///< of a group
  bool at_boundary_ = false;
  std::vector<std::int32_t> missed_; ///< by governing field: how far the prediction was off, as an error code
};

template <class Coder, class Known>
void RecordCodec::code_seeds(Coder& coder, BlockState& state, const Content& content, RecordId r, const Known& known) {
  const BlockInfo& block = blocks_[state.block];
  const Refinement& refinement = content.refinement;
  seed_places_.clear();
  for (bool more = true; more;) {
    Seed seed;
    if constexpr (Known::kWriter) seed = known.seeds[seed_places_.size()];
    std::uint32_t rank = 0;
    code_seed(coder, schema_, state.seeds, block, refinement, blocks_, seed, rank, r);
    state.seeds.note(seed, rank);
    std::uint32_t place = seed.index;
    RecordId parent;
    if (seed.source != block.needs.size() + 1) {
      const BlockInfo& home = seed.source == 0 ? block : blocks_[block.needs[seed.source - 1]];
      parent = RecordId{home.first_record + seed.index};
      place = refinement.fine_place(parent, seed.fine);
    }
    if (refinement.consumer(place) != parent) fail_record(r, "its seed is not in the mesh any more");
    const VertexId target = refinement.tet(place)[seed.corner];
    if (target == kDummyVertex) fail_record(r, "its target is no vertex");
    if (seed_places_.empty()) {
      target_ = target;
    } else if (target != target_) {
      fail_record(r, "its seeds do not share the target");
    }
    seed_places_.push_back(place);
    if constexpr (Known::kWriter) more = seed_places_.size() < known.seeds.size();
    more = coder.bit(schema_.more_seeds, more);
    if (seed_places_.size() > Refinement::kMaxRegion) fail_record(r, "it has too many seeds");
  }
}

// v is expected on the way from u to the middle of the other corners of its first seed. Meshes of CAD parts and of
// grids repeat coordinates: that of one of the corners is tried first.
template <class Coder>
void RecordCodec::code_position(Coder& coder, Content& content, RecordId r) {
  constexpr double kTowardsMiddle = 0.6;
  std::array<VertexId, 4> corners{target_};
  std::array<Point, 4> points{position(content, target_)};
  std::size_t count = 1;
  for (const VertexId v : content.refinement.tet(seed_places_.front())) {
    if (v == target_ || v == kDummyVertex) continue;
    corners[count] = v;
    points[count++] = position(content, v);
  }
  std::uint32_t earlier = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Column& column = schema_.position[axis];
    std::array<std::uint64_t, 4> ranks{};
    const double u = points[0][axis];
    double sum = 0, least = u, greatest = u;
    for (std::size_t i = 0; i < count; ++i) {
      ranks[i] = load_rank(column.type, scalar_at(content.positions, column, corners[i].index(), axis));
      const double x = points[i][axis];
      if (i > 0) sum += x;
      least = std::min(least, x);
      greatest = std::max(greatest, x);
    }
    std::byte* at = scalar_at(content.positions, column, content.refinement.vertex_of(r).index(), axis);
    const std::uint64_t actual = known_rank<Coder>(column, at);
    const auto same = code_same(coder, axis, earlier, {ranks.data(), count}, actual);
    if (same) earlier |= 1U << axis;
    const double middle = sum / static_cast<double>(count - 1);
    store_rank(
        column.type,
        same ? *same : code_scalar(coder, column, u + kTowardsMiddle * (middle - u), greatest - least, actual, r), at);
  }
}

template <class Coder>
std::optional<std::uint64_t> RecordCodec::code_same(Coder& coder, std::size_t axis, std::uint32_t earlier,
                                                    std::span<const std::uint64_t> corners, std::uint64_t rank) {
  for (std::size_t i = 0, candidate = 0; i < corners.size(); ++i) {
    if (std::find(corners.begin(), corners.begin() + static_cast<std::ptrdiff_t>(i), corners[i]) !=
        corners.begin() + static_cast<std::ptrdiff_t>(i)) {
      continue;
    }
    const auto times = static_cast<std::uint32_t>(std::count(corners.begin(), corners.end(), corners[i]));
    const auto context =
        schema_.same + static_cast<std::uint32_t>(((axis * 4 + candidate) * 4 + times - 1) * 4) + (earlier & 3U);
    if (coder.bit(context, corners[i] == rank)) return corners[i];
    ++candidate;
  }
  return std::nullopt;
}

/// How many of `steps` have not value < step * unit; without a branch on any.
template <std::size_t Count>
std::uint32_t count_not_below(double value, double unit, const double (&steps)[Count]) {
  std::uint32_t count = 0;
  for (const double step : steps)
    count += value < step * unit ? 0 : 1;
  return count;
}

// Squared distance to v against that to u: a vertex near v is likely inside the region, one near u outside.
inline RecordCodec::NearVertex RecordCodec::measure(const Content& content, VertexId v) const {
  if (v == kDummyVertex) return {{}, {}, 0, kDummyNearness, 0};
  using vec::operator-;
  content.refinement.prefetch(v);
  prefetch_values(content, v);
  const Point at = position(content, v);
  const Point from_u = at - u_position_, from_v = at - v_position_;
  const double du = dot(from_u, from_u), dv = dot(from_v, from_v);
  return {at, from_u, dv, static_cast<std::uint8_t>(count_not_below(dv, du, {0.3, 0.6, 0.9, 1.3, 2.0})), 0};
}

// Height of v above the face, against that of the region's tet. The face of a rim tet has v above it. `a`, `b`: where
// the face's vertices are in near_.
inline std::uint32_t RecordCodec::height_class(const Content& content, const GrowthFace& face, std::uint32_t a,
                                               std::uint32_t b) {
  using vec::operator-;
  const NearVertex& c = near_[near(content, face.c)]; // may move the others
  if (near_[a].nearness == kDummyNearness || near_[b].nearness == kDummyNearness) return c.nearness;
  const Point normal = cross(near_[a].from_u, near_[b].from_u);
  const double height = dot(normal, v_position_ - u_position_);
  if (c.nearness == kDummyNearness) return height > 0 ? 7 : 6;
  const double whole = dot(normal, c.from_u);
  if (!(height > 0)) return 0;
  return 1 + count_not_below(height, whole, {0.1, 0.3, 0.6, 1.2});
}

// The rim is one cycle: once it has passed both ways through a corner of the face, the face cannot be of it.
template <class Coder>
bool RecordCodec::code_growth(Coder& coder, const Content& content, const GrowthFace& face, bool joins) {
  const std::uint32_t a = near(content, face.a), b = near(content, face.b);
  const bool rim_is_full = near_[a].rim >= 2 || near_[b].rim >= 2;
  const std::uint32_t height = rim_is_full ? 0 : height_class(content, face, a, b);
  NearVertex& at_a = near_[a];
  NearVertex& at_b = near_[b];
  const std::uint32_t rim = rim_is_full ? 3 : at_a.rim + at_b.rim;
  const std::uint32_t greater = std::max(at_a.nearness, at_b.nearness), lesser = std::min(at_a.nearness, at_b.nearness);
  const bool coded = coder.bit(schema_.growth + ((height * 8 + greater) * 8 + lesser) * 4 + rim, joins);
  if (!coded) {
    at_a.rim = static_cast<std::uint8_t>(std::min(at_a.rim + 1, 2));
    at_b.rim = static_cast<std::uint8_t>(std::min(at_b.rim + 1, 2));
  }
  return coded;
}

// The vertices around v, in the order in which F(r) names them, with the inverse of the squared distance as weight. u
// comes last: only tets of the rim have it.
inline void RecordCodec::weigh_link(const Content& content) {
  link_.clear();
  at_boundary_ = false;
  star_least_ = star_greatest_ = v_position_;
  const auto add = [&](VertexId v) {
    const NearVertex& vertex = near_[near(content, v)];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      star_least_[axis] = std::min(star_least_[axis], vertex.at[axis]);
      star_greatest_[axis] = std::max(star_greatest_[axis], vertex.at[axis]);
    }
    link_.push_back({v.index(), vertex.v_distance_sq > 0 ? 1 / vertex.v_distance_sq : 0});
  };
  for (const VertexId v : content.refinement.last_link()) {
    if (v == kDummyVertex)
      at_boundary_ = true;
    else
      add(v);
  }
  add(target_);
}

// The weighted mean around v, and the mean distance from it with the same weights, of some columns together: their sums
// do not wait for one another.
inline void RecordCodec::predict(const Content& content, const std::vector<Columns>& group) {
  near_values_.resize(link_.size());
  std::size_t columns = 0;
  for (const Columns& of : group) {
    const PointArray& array = content.arrays[of.array];
    dispatch(array.type, [&]<class T>(T) {
      const std::byte* const first = array.bytes.data() + of.first_component * sizeof(T);
      const std::size_t row_bytes = array.components * sizeof(T);
      for (std::size_t c = 0; c < of.components; ++c)
        for (std::size_t i = 0; i < link_.size(); ++i) {
          near_values_[i][columns + c] =
              static_cast<double>(load<T>(first + link_[i].vertex * row_bytes + c * sizeof(T)));
        }
    });
    columns += of.components;
  }
  double weights = 0;
  for (const LinkVertex& vertex : link_)
    weights += vertex.weight;
  predictions_.fill({0, 0});
  if (!(weights > 0)) return;
  constexpr std::size_t kTogether = 4; // behind `columns` stand numbers of no matter
  for (std::size_t first = 0; first < columns; first += kTogether) {
    std::array<double, kTogether> sums{}, means{}, apart{};
    for (std::size_t i = 0; i < link_.size(); ++i)
      for (std::size_t c = 0; c < kTogether; ++c)
        sums[c] += link_[i].weight * near_values_[i][first + c];
    for (std::size_t c = 0; c < kTogether; ++c)
      means[c] = sums[c] / weights;
    for (std::size_t i = 0; i < link_.size(); ++i)
      for (std::size_t c = 0; c < kTogether; ++c)
        apart[c] += link_[i].weight * std::fabs(near_values_[i][first + c] - means[c]);
    for (std::size_t c = 0; c < kTogether; ++c) {
      // A sum of terms one of which is not finite is not finite.
      predictions_[first + c] =
          std::isfinite(sums[c]) ? Prediction{means[c], apart[c] / weights} : predict_finite(first + c);
    }
  }
}

// What is not finite does not count.
inline RecordCodec::Prediction RecordCodec::predict_finite(std::size_t column) const {
  double sum = 0, weights = 0, apart = 0;
  for (std::size_t i = 0; i < link_.size(); ++i) {
    if (!std::isfinite(near_values_[i][column])) continue;
    sum += link_[i].weight * near_values_[i][column];
    weights += link_[i].weight;
  }
  if (!(weights > 0)) return {0, 0};
  const double mean = sum / weights;
  for (std::size_t i = 0; i < link_.size(); ++i) {
    if (std::isfinite(near_values_[i][column])) apart += link_[i].weight * std::fabs(near_values_[i][column] - mean);
  }
  return {mean, apart / weights};
}

template <class Coder>
void RecordCodec::code_arrays(Coder& coder, Content& content, RecordId r) {
  const std::size_t row = content.refinement.vertex_of(r).index();
  missed_.assign(schema_.governing.size(), 0);
  std::size_t field = 0, column_number = 0;
  for (std::size_t i = 0; i < schema_.arrays.size(); ++i) {
    PointArray& array = content.arrays[i];
    const bool governing = field < schema_.governing.size() && schema_.governing[field] == i;
    double missed = 0;
    for (std::uint32_t c = 0; c < array.components; ++c) {
      const std::size_t in_group = column_number++ % kColumnsAtOnce;
      if (in_group == 0) predict(content, groups_[column_number / kColumnsAtOnce]);
      const auto [predicted, spread] = predictions_[in_group];
      const Column& column = schema_.arrays[i][c];
      std::byte* at = scalar_at(array, column, row, c);
      store_rank(column.type, code_scalar(coder, column, predicted, spread, known_rank<Coder>(column, at), r), at);
      if (governing) missed = std::max(missed, std::fabs(array.value(row, c) - predicted));
    }
    if (governing) {
      const auto logarithm = [](double x) { return static_cast<std::int32_t>(std::bit_cast<std::uint64_t>(x) >> 48); };
      missed_[field] = missed > 0 ? std::clamp(logarithm(missed) - logarithm(schema_.scale[field]) + 1280, 1, 2047) : 0;
      ++field;
    }
  }
}

/// Six times the volume of a tet with the last three corners of `tet` and one at `apex`.
inline double RecordCodec::six_volumes(const Content& content, const Point& apex, const Tet& tet) {
  using vec::operator-;
  const Point a = position(content, tet[1]) - apex, b = position(content, tet[2]) - apex;
  return std::fabs(dot(cross(a, b), position(content, tet[3]) - apex));
}

inline double RecordCodec::six_star_volumes(const Content& content, RecordId r) const {
  double sum = 0;
  for (std::uint32_t k = 0; k < content.refinement.fine_count(r); ++k)
    if (const Tet& tet = content.refinement.tet(content.refinement.fine_place(r, k)); !is_ghost(tet))
      sum += six_volumes(content, v_position_, tet);
  return sum;
}

/// Six times what the collapse took from the volume of the mesh.
inline double RecordCodec::six_volumes_lost(const Content& content, RecordId r) const {
  double sum = 0;
  for (std::uint32_t k = 0; k < content.refinement.fine_count(r); ++k) {
    const Tet& tet = content.refinement.tet(content.refinement.fine_place(r, k));
    if (is_ghost(tet)) continue;
    sum += six_volumes(content, v_position_, tet);
    if (std::find(tet.begin(), tet.end(), target_) == tet.end()) sum -= six_volumes(content, u_position_, tet);
  }
  return sum;
}

} // namespace ptet::file
