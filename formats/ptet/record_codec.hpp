// How one record is coded: one text for the reader's side and the writer's (see range_coder.hpp for the sides). Each
// step takes the true value on the writer's side and returns it on both.
//
//   seeds      where the split happens: a version of C(r), named by the record that made it (PTET.md, "Seeds")
//   position   of the new vertex v, predicted from the first seed
//   growth     one bit for each face met while the region grows
//   arrays     of v, predicted from the vertices around it
//   errors     own, and how much more the finer records that depend on it have
//   squared    what the collapse raised the mean square errors by, predicted from the own error and the star's volume
//   order      how coarse the mesh was when the collapse was made, below that of the parents
//
// Everything used to predict is the same in every closed set of loaded blocks.
#pragma once

#include "formats/ptet/range_coder.hpp"
#include "formats/ptet/reader.hpp"
#include "formats/ptet/schema.hpp"
#include "mesh/scalar_dispatch.hpp"

#include <bit>
#include <cfloat>
#include <cmath>

namespace ptet::file {

static_assert(FLT_EVAL_METHOD == 0 || FLT_EVAL_METHOD == 1,
              "doubles have to be computed with as such (32-bit x86: -msse2 -mfpmath=sse)");

[[noreturn]] inline void fail_record(RecordId r, const char* what) {
  throw Error(ErrorCode::kCorruptFile, "record " + std::to_string(r.index()) + " is corrupt: " + what);
}

/// Whether a coder is on the reader's side, where values are not known before.
template <class Coder>
inline constexpr bool kReads = std::is_same_v<Coder, RangeDecoder>;

// ---- numbers ----

/// The bits of `value` below 2^levels, high one first, in a tree of 2^levels contexts.
template <class Coder>
std::uint32_t code_tree(Coder& coder, std::uint32_t first_context, unsigned levels, std::uint32_t value) {
  if constexpr (kReads<Coder>) return coder.tree(first_context, levels) - (1U << levels);
  std::uint32_t node = 1;
  for (unsigned level = levels; level-- > 0;) {
    node = node << 1 | (coder.bit(first_context + node, (value >> level & 1) != 0) ? 1U : 0U);
  }
  return node - (1U << levels);
}

/// The bits of `value` below its leading one, given its length: the top two by contexts, the rest as they are.
template <class Coder>
std::uint64_t code_mantissa(Coder& coder, std::uint32_t first_context, unsigned length, std::uint64_t value) {
  if (length < 2) return length;
  const std::uint32_t context = first_context + 3 * length;
  unsigned left = length - 1;
  const bool high = coder.bit(context, (value >> --left & 1) != 0);
  std::uint64_t result = high ? 3 : 2;
  if (left > 0) {
    --left;
    result = result << 1 | (coder.bit(context + (high ? 2 : 1), (value >> left & 1) != 0) ? 1U : 0U);
  }
  const std::uint64_t rest = left == 0 ? 0 : coder.raw(left, value & ((std::uint64_t{1} << left) - 1));
  return result << left | rest;
}

/// An unsigned number below 2^31: Schema::kUintContexts contexts.
template <class Coder>
std::uint32_t code_uint(Coder& coder, std::uint32_t first_context, std::uint32_t value) {
  const std::uint32_t length = code_tree(coder, first_context, 5, static_cast<std::uint32_t>(std::bit_width(value)));
  return static_cast<std::uint32_t>(code_mantissa(coder, first_context + 32, length, value));
}

/// A signed one: 32 contexts more, for the sign by length.
template <class Coder>
std::int64_t code_int(Coder& coder, std::uint32_t first_context, std::int64_t value) {
  const auto magnitude = code_uint(coder, first_context, static_cast<std::uint32_t>(value < 0 ? -value : value));
  if (magnitude == 0) return 0;
  const bool negative = coder.bit(
      first_context + Schema::kUintContexts + static_cast<std::uint32_t>(std::bit_width(magnitude)), value < 0);
  return negative ? -static_cast<std::int64_t>(magnitude) : static_cast<std::int64_t>(magnitude);
}

/// The rank of the scalar that is to be coded, where it is known.
template <class Coder>
std::uint64_t known_rank(const Column& column, const std::byte* at) {
  if constexpr (kReads<Coder>) return 0;
  return load_rank(column.type, at);
}

/// A difference modulo 2^64, as sign and magnitude, in the contexts of a column and a spread.
template <class Coder>
std::uint64_t code_difference(Coder& coder, const Column& column, std::uint64_t spread, std::uint64_t difference,
                              RecordId r) {
  const unsigned spread_class =
      std::min(static_cast<unsigned>(std::bit_width(spread)), column.bits > 32 ? 64U : 32U) / 2;
  const bool negative = static_cast<std::int64_t>(difference) < 0;
  const std::uint64_t magnitude = negative ? 0 - difference : difference;
  const std::uint32_t length = code_tree(coder, column.length + (spread_class << column.length_levels),
                                         column.length_levels, static_cast<std::uint32_t>(std::bit_width(magnitude)));
  if (length == 0) return 0;
  if (length > (column.bits > 32 ? 64U : 32U)) fail_record(r, "a number has too many bits");
  const bool is_negative = coder.bit(column.sign, negative);
  const std::uint64_t coded = code_mantissa(coder, column.mantissa, length, magnitude);
  return is_negative ? 0 - coded : coded;
}

/// A scalar by its rank, given a prediction and how far the numbers it was made from lie apart.
template <class Coder>
std::uint64_t code_scalar(Coder& coder, const Column& column, double predicted, double spread, std::uint64_t rank,
                          RecordId r) {
  if (column.decimals) {
    std::optional<std::int64_t> exact;
    if constexpr (!kReads<Coder>) exact = column.decimals->exact(rank);
    if (!coder.bit(column.escape, !exact.has_value())) {
      const std::int64_t from = column.decimals->nearest(predicted);
      const std::int64_t apart = column.decimals->nearest(predicted + spread) - from;
      const std::uint64_t difference =
          code_difference(coder, column, static_cast<std::uint64_t>(apart < 0 ? -apart : apart),
                          static_cast<std::uint64_t>(exact.value_or(0)) - static_cast<std::uint64_t>(from), r);
      const auto coded =
          column.decimals->value_rank(static_cast<std::int64_t>(static_cast<std::uint64_t>(from) + difference));
      if (!coded) fail_record(r, "a decimal number is out of range");
      return *coded;
    }
  }
  const std::uint64_t from = rank_of(column.type, predicted);
  const std::uint64_t apart = rank_of(column.type, predicted + spread) - from;
  const unsigned unused = 64 - column.bits;
  // The difference modulo 2^bits, its sign extended.
  const auto difference = static_cast<std::uint64_t>(static_cast<std::int64_t>((rank - from) << unused) >> unused);
  const auto apart_signed = static_cast<std::int64_t>(apart << unused) >> unused;
  const std::uint64_t coded = code_difference(
      coder, column, static_cast<std::uint64_t>(apart_signed < 0 ? -apart_signed : apart_signed), difference, r);
  return ((from + coded) << unused) >> unused;
}

// ---- a block ----

/// Where a seed is found: version `fine` of the list of F(p), p the `index`-th record of a block; or version `index`
/// of the base. `corner`: of the target in that version.
struct Seed {
  std::uint32_t source = 0; ///< 0: this block; 1 ..: BlockInfo::needs; behind them: the base
  std::uint32_t index = 0;
  std::uint32_t fine = 0;
  std::uint32_t corner = 0;
};

/// What the coding of a block's next record depends on, the contexts aside.
struct BlockState {
  std::uint32_t block = 0;
  std::vector<std::uint32_t> recent;     ///< sources, the one used last in front
  std::vector<std::uint32_t> last_index; ///< by source
  std::uint32_t last_rank = 0;
  std::vector<std::int32_t> last_own; ///< by error code
  std::vector<char> last_own_zero, last_above_zero;
  /// By governing array: the sign of the last squared error (1: positive, 2: negative). For both signs how much above
  /// its estimate it has been of late, in 1/16 codes, and the last code where the own error was 0.
  std::vector<std::uint8_t> last_squared_sign;
  std::vector<std::array<std::int32_t, 2>> squared_drift, last_squared;

  BlockState(std::uint32_t block_number, std::size_t needs, std::size_t codes)
      : block(block_number), recent(needs + 2), last_index(needs + 2), last_own(codes, 1280), last_own_zero(codes),
        last_above_zero(codes), last_squared_sign(codes - 1), squared_drift(codes - 1, {-960, -960}),
        last_squared(codes - 1, {800, 800}) {
    for (std::size_t i = 0; i < recent.size(); ++i)
      recent[i] = static_cast<std::uint32_t>(i);
  }
  void note(const Seed& seed, std::uint32_t rank) {
    last_rank = rank;
    recent.erase(recent.begin() + rank);
    recent.insert(recent.begin(), seed.source);
    last_index[seed.source] = seed.index;
  }
};

template <class Coder>
void code_seed(Coder& coder, const Schema& schema, const BlockState& state, const BlockInfo& block,
               const Refinement& refinement, std::span<const BlockInfo> blocks, Seed& seed, std::uint32_t& rank,
               RecordId r) {
  const auto found = std::find(state.recent.begin(), state.recent.end(), seed.source);
  rank = code_uint(coder, schema.source + (state.last_rank == 0 ? 0 : Schema::kUintContexts),
                   static_cast<std::uint32_t>(found - state.recent.begin()));
  if (rank >= state.recent.size()) fail_record(r, "its seed is in no block that this one needs");
  seed.source = state.recent[rank];
  const bool own_block = seed.source == 0;
  const std::int64_t last = state.last_index[seed.source];
  const std::int64_t index =
      last + code_int(coder, schema.index + (own_block ? 0 : Schema::kUintContexts + 32), seed.index - last);
  if (index < 0 || index > 0x7FFFFFFF) fail_record(r, "its seed is out of range");
  seed.index = static_cast<std::uint32_t>(index);

  if (seed.source == block.needs.size() + 1) {
    if (seed.index >= refinement.base_version_count()) fail_record(r, "its seed is no tet of the base");
    seed.corner = code_tree(coder, schema.corner, 2, seed.corner);
    return;
  }
  const BlockInfo& home = own_block ? block : blocks[block.needs[seed.source - 1]];
  if (seed.index >= home.record_count) fail_record(r, "its seed is of no record");
  const RecordId parent{home.first_record + seed.index};
  if (!refinement.applied(parent)) fail_record(r, "its seed is of a record not yet decoded");
  const std::uint32_t fine = seed.fine;
  seed.fine = code_tree(coder, schema.fine + (own_block ? 0 : 32), 5, std::min(fine, 31U));
  if (seed.fine == 31) seed.fine += code_uint(coder, schema.fine_rest, fine - 31);
  if (seed.fine >= refinement.fine_count(parent)) fail_record(r, "its seed is not among the tets of its record");
  seed.corner = code_tree(coder, schema.corner + 4, 2, seed.corner);
}

// ---- records ----

/// What the reader's side knows of a record before: nothing.
struct NothingKnown {
  static constexpr bool kWriter = false;
};

/// What the writer's side knows: its seeds, and the region.
template <class InRegion>
struct RecordKnown {
  static constexpr bool kWriter = true;
  std::span<const Seed> seeds;
  InRegion in_region; ///< (VersionId) -> bool
};

/// Bits coded of each kind, for measurements; a coder without bits() leaves it zero.
struct CodedBits {
  double seed = 0, position = 0, growth = 0, arrays = 0, errors = 0, squared = 0, order = 0;
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
    bits_mark_ = bits_of_coder(coder);
    code_seeds(coder, state, content, r, known);
    account(coder, bits_.seed);
    code_position(coder, content, r);
    account(coder, bits_.position);
    u_position_ = position(content, target_);
    v_position_ = position(content, content.refinement.vertex_of(r));
    const auto joins = [&](const GrowthFace& face) {
      if constexpr (Known::kWriter) {
        return code_growth(coder, content, face, known.in_region(face.behind));
      } else {
        return code_growth(coder, content, face, false);
      }
    };
    content.refinement.split(r, target_, seed_versions_, joins, others);
    account(coder, bits_.growth);
    weigh_link(content);
    code_arrays(coder, content, r);
    account(coder, bits_.arrays);
    code_errors(coder, state, content, r);
    account(coder, bits_.errors);
    if (schema_.has_squared_errors) code_squared_errors(coder, state, content, r);
    account(coder, bits_.squared);
    code_order(coder, state, content, r);
    account(coder, bits_.order);
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
  [[nodiscard]] const CodedBits& bits() const { return bits_; }

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

  template <class Coder>
  static double bits_of_coder(const Coder& coder) {
    if constexpr (requires { coder.bits(); }) return coder.bits();
    return 0;
  }
  template <class Coder>
  void account(const Coder& coder, double& kind) {
    const double now = bits_of_coder(coder);
    kind += now - bits_mark_;
    bits_mark_ = now;
  }
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
  template <class Coder>
  void code_errors(Coder& coder, BlockState& state, Content& content, RecordId r);
  template <class Coder>
  void code_squared_errors(Coder& coder, BlockState& state, Content& content, RecordId r);
  template <class Coder>
  void code_order(Coder& coder, const BlockState& state, Content& content, RecordId r);
  template <class Coder>
  std::int32_t code_near(Coder& coder, std::uint32_t first_context, std::int32_t expected, std::int32_t value);
  [[nodiscard]] double six_star_volumes(const Content& content, RecordId r) const;

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
  std::vector<Mark> marks_;
  std::uint32_t stamp_ = 0;
  CodedBits bits_;
  double bits_mark_ = 0;

  // Of the record at hand.
  std::vector<VersionId> seed_versions_;
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
  seed_versions_.clear();
  for (bool more = true; more;) {
    Seed seed;
    if constexpr (Known::kWriter) seed = known.seeds[seed_versions_.size()];
    std::uint32_t rank = 0;
    code_seed(coder, schema_, state, block, refinement, blocks_, seed, rank, r);
    state.note(seed, rank);
    VersionId version{seed.index};
    if (seed.source != block.needs.size() + 1) {
      const BlockInfo& home = seed.source == 0 ? block : blocks_[block.needs[seed.source - 1]];
      version = VersionId{refinement.first_fine(RecordId{home.first_record + seed.index}).index() + seed.fine};
    }
    const VertexId target = refinement.vertices(version)[seed.corner];
    if (target == kDummyVertex) fail_record(r, "its target is no vertex");
    if (seed_versions_.empty()) {
      target_ = target;
    } else if (target != target_) {
      fail_record(r, "its seeds do not share the target");
    }
    seed_versions_.push_back(version);
    if constexpr (Known::kWriter) more = seed_versions_.size() < known.seeds.size();
    more = coder.bit(schema_.more_seeds, more);
    if (seed_versions_.size() > 4096) fail_record(r, "it has too many seeds");
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
  for (const VertexId v : content.refinement.vertices(seed_versions_.front())) {
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

inline double dot(const Point& a, const Point& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Point minus(const Point& a, const Point& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
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
  content.refinement.prefetch(v);
  prefetch_values(content, v);
  const Point at = position(content, v);
  const Point from_u = minus(at, u_position_), from_v = minus(at, v_position_);
  const double du = dot(from_u, from_u), dv = dot(from_v, from_v);
  return {at, from_u, dv, static_cast<std::uint8_t>(count_not_below(dv, du, {0.3, 0.6, 0.9, 1.3, 2.0})), 0};
}

// Height of v above the face, against that of the region's tet. The face of a rim tet has v above it. `a`, `b`: where
// the face's vertices are in near_.
inline std::uint32_t RecordCodec::height_class(const Content& content, const GrowthFace& face, std::uint32_t a,
                                               std::uint32_t b) {
  const NearVertex& c = near_[near(content, face.c)]; // may move the others
  if (near_[a].nearness == kDummyNearness || near_[b].nearness == kDummyNearness) return c.nearness;
  const Point normal = cross(near_[a].from_u, near_[b].from_u);
  const double height = dot(normal, minus(v_position_, u_position_));
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

/// A code by its difference from what is expected: Schema::kErrorContexts contexts.
template <class Coder>
std::int32_t RecordCodec::code_near(Coder& coder, std::uint32_t first_context, std::int32_t expected,
                                    std::int32_t value) {
  const std::int32_t difference = value - expected;
  const auto magnitude = static_cast<std::uint32_t>(std::abs(difference));
  const std::uint32_t length =
      code_tree(coder, first_context, 4, static_cast<std::uint32_t>(std::bit_width(magnitude)));
  if (length == 0) return expected;
  const bool negative = coder.bit(first_context + 64, difference < 0);
  const auto coded = static_cast<std::int32_t>(code_mantissa(coder, first_context + 16, length, magnitude));
  return expected + (negative ? -coded : coded);
}

template <class Coder>
void RecordCodec::code_errors(Coder& coder, BlockState& state, Content& content, RecordId r) {
  const std::uint32_t codes = schema_.code_count();
  for (std::uint32_t i = 0; i < codes; ++i) {
    ErrorCode16& own = content.own[r.index() * std::size_t{codes} + i];
    const bool domain = i + 1 == codes;
    const std::uint32_t place = domain ? (at_boundary_ ? 1 : 0) : (missed_[i] > 0 ? 1 : 0);
    const bool zero = coder.bit(schema_.own_zero + 4 * i + 2 * place + (state.last_own_zero[i] != 0 ? 1 : 0), own == 0);
    state.last_own_zero[i] = zero ? 1 : 0;
    std::int32_t value = 0;
    if (!zero) {
      const std::int32_t expected = state.last_own[i];
      const std::int32_t above = domain ? 0 : missed_[i] - expected;
      const std::uint32_t relation = static_cast<std::uint32_t>(std::clamp((above + 16 * 16) / 16 - 16 + 4, 0, 7));
      const std::uint32_t first = schema_.own + (i * Schema::kErrorClasses + relation) * Schema::kErrorContexts;
      value = code_near(coder, first, expected, own);
      if (value < 1 || value > kMaxErrorCode) fail_record(r, "an error is out of range");
      state.last_own[i] = value;
    }
    own = static_cast<ErrorCode16>(value);

    ErrorCode16& monotone = content.monotone[r.index() * std::size_t{codes} + i];
    const bool none = coder.bit(
        schema_.above_zero + 4 * i + 2 * (zero ? 1 : 0) + (state.last_above_zero[i] != 0 ? 1 : 0), monotone == own);
    state.last_above_zero[i] = none ? 1 : 0;
    if (!none) {
      const std::uint32_t more =
          code_uint(coder, schema_.above + Schema::kUintContexts * i, static_cast<std::uint32_t>(monotone - own) - 1);
      if (more >= static_cast<std::uint32_t>(kMaxErrorCode - value)) fail_record(r, "an error is out of range");
      value += static_cast<std::int32_t>(more) + 1;
    }
    monotone = static_cast<ErrorCode16>(value);
  }
}

inline double RecordCodec::six_star_volumes(const Content& content, RecordId r) const {
  double sum = 0;
  const std::uint32_t first = content.refinement.first_fine(r).index();
  for (std::uint32_t t = first; t < first + content.refinement.fine_count(r); ++t) {
    const Tet& tet = content.refinement.vertices(VersionId{t});
    if (content.refinement.is_ghost(VersionId{t})) continue;
    const Point a = minus(position(content, tet[1]), v_position_), b = minus(position(content, tet[2]), v_position_);
    sum += std::fabs(dot(cross(a, b), minus(position(content, tet[3]), v_position_)));
  }
  return sum;
}

// About the own error squared times the volume of the star: a code of either is the same step. How much less it is, the
// records before tell.
template <class Coder>
void RecordCodec::code_squared_errors(Coder& coder, BlockState& state, Content& content, RecordId r) {
  const auto logarithm = [](double x) {
    return x > 0 ? static_cast<std::int32_t>(std::bit_cast<std::uint64_t>(x) >> 49) : 0;
  };
  constexpr std::int32_t kAtOwnScale = 1600 - 1280;
  const std::int32_t size = logarithm(six_star_volumes(content, r)) - logarithm(schema_.volume) + kAtOwnScale;
  const std::size_t fields = schema_.governing.size();
  for (std::uint32_t i = 0; i < fields; ++i) {
    const std::int32_t own = content.own[r.index() * (fields + 1) + i];
    SquaredErrorCode& squared = content.squared_error[r.index() * fields + i];
    std::uint8_t& last_sign = state.last_squared_sign[i];
    const std::uint32_t no_error = own == 0 ? 1 : 0;
    if (coder.bit(schema_.squared_zero + 4 * i + 2 * no_error + (last_sign == 0 ? 1 : 0), squared == 0)) {
      squared = 0;
      last_sign = 0;
      continue;
    }
    const bool negative = coder.bit(schema_.squared_negative + 6 * i + 3 * no_error + last_sign, squared < 0);
    last_sign = negative ? 2 : 1;
    std::int32_t& drift = state.squared_drift[i][negative ? 1 : 0];
    std::int32_t& last = state.last_squared[i][negative ? 1 : 0];
    const std::int32_t estimate = own + size;
    const std::int32_t expected =
        own == 0 ? last : std::clamp<std::int32_t>(estimate + drift / 16, 1, kMaxSquaredErrorCode);
    const std::uint32_t first = schema_.squared + (4 * i + 2 * no_error + (negative ? 1 : 0)) * Schema::kErrorContexts;
    const std::int32_t value = code_near(coder, first, expected, std::abs(squared));
    if (value < 1 || value > kMaxSquaredErrorCode) fail_record(r, "a squared error is out of range");
    if (own == 0) {
      last = value;
    } else {
      drift += (16 * std::clamp(value - estimate, -4096, 4096) - drift) / 8;
    }
    squared = static_cast<SquaredErrorCode>(negative ? -value : value);
  }
}

// Coded by how much less it is than the least of the parents' and the largest of the block.
template <class Coder>
void RecordCodec::code_order(Coder& coder, const BlockState& state, Content& content, RecordId r) {
  const std::uint32_t largest = blocks_[state.block].max_order;
  std::uint32_t most = largest;
  for (const RecordId parent : content.refinement.parents(r))
    most = std::min<std::uint32_t>(most, content.order[parent.index()]);
  const std::uint32_t below = std::min((largest - most) / 8, Schema::kOrderClasses - 1);
  OrderCode& order = content.order[r.index()];
  const std::uint32_t less = code_uint(coder, schema_.order + below * Schema::kUintContexts, most - order);
  if (less > most) fail_record(r, "its order code is out of range");
  order = static_cast<OrderCode>(most - less);
}

} // namespace ptet::file
