#include "lod/demand.hpp"

#include "lod/region.hpp"
#include "lod/star.hpp"
#include "mesh/scalar_dispatch.hpp"
#include "record/ghost.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace ptet {
namespace {

// ---- by the table ----

BlockDemand of_block(const WantAll&, const file::BlockInfo&) {
  return BlockDemand::kAll;
}

/// What bounds that hold in a part of space are about.
struct StatedErrors {
  const ErrorCode16* of_fields; ///< monotone
  ErrorCode16 of_domain;        ///< own
};
StatedErrors errors_of(const file::BlockInfo& block) {
  return {block.max_error.data(), block.max_own.back()};
}
bool fields_exceed(const StatedErrors& errors, const CodeLimits& limits) {
  for (std::size_t i = 0; i + 1 < limits.size(); ++i)
    if (errors.of_fields[i] > limits[i]) return true;
  return false;
}
bool any_exceeds(const StatedErrors& errors, const CodeLimits& limits) {
  return fields_exceed(errors, limits) || errors.of_domain > limits.back();
}

/// With limits. The box is that of the star, or of the block.
bool may_exceed(const StatedErrors& errors, const WantInside& want, const Point& min, const Point& max) {
  return any_exceeds(errors, want.limits) &&
         meets(want.region, min, max, decode_error(errors.of_domain, want.domain_scale));
}
BlockDemand of_block(const WantInside& want, const file::BlockInfo& block) {
  if (!want.limits.empty())
    return may_exceed(errors_of(block), want, block.box_min, block.box_max) ? BlockDemand::kSome : BlockDemand::kNone;
  if (!meets(want.region, block.box_min, block.box_max)) return BlockDemand::kNone;
  return contains(want.region, block.box_min, block.box_max) ? BlockDemand::kAll : BlockDemand::kSome;
}

// Written so that NaN, which 0 per distance makes of an infinite one, allows nothing.
bool exceeds_at(const StatedErrors& errors, const WantNear& want, double distance) {
  const std::size_t domain = want.scale.size() - 1;
  const double domain_error = decode_error(errors.of_domain, want.scale[domain]);
  const double nearest = std::max(0.0, distance - domain_error);
  const auto passes = [&](double error, std::size_t i) {
    return !(error <= want.at_region[i] + want.per_distance[i] * nearest);
  };
  for (std::size_t i = 0; i < domain; ++i)
    if (passes(decode_error(errors.of_fields[i], want.scale[i]), i)) return true;
  return passes(domain_error, domain);
}
BlockDemand of_block(const WantNear& want, const file::BlockInfo& block) {
  const double apart = distance(want.region, block.box_min, block.box_max);
  return exceeds_at(errors_of(block), want, apart) ? BlockDemand::kSome : BlockDemand::kNone;
}

/// With a camera: whether a version with these errors, somewhere in the box or in the hull of the corners, may have one
/// that passes its limit. `has_face`: whether it may be a boundary face; only these have domain errors.
template <class Place>
bool may_exceed(const StatedErrors& errors, const WantBounded& want, const Place& place, bool has_face) {
  const Camera& camera = *want.camera;
  const double domain_error = decode_error(errors.of_domain, want.domain_scale);
  const bool is_seen = camera.meets(place, domain_error);
  const CodeLimits& limits = is_seen ? want.limits : want.limits_unseen;
  if (limits.empty()) return false;
  if (fields_exceed(errors, limits)) return true;
  if (!has_face || errors.of_domain == 0) return false;
  const double allowed = is_seen ? camera.length_of(want.max_pixels, camera.depth(place))
                                 : camera.length_of(want.max_pixels_unseen, camera.eye_distance(place));
  return errors.of_domain > limits.back() || domain_error > allowed;
}
/// The same wherever the version is: a quick "no" for most. Limits outside the picture are no lower than those in it.
bool may_exceed_somewhere(const StatedErrors& errors, const WantBounded& want, bool has_face) {
  if (want.limits.empty()) return true;
  if (!want.camera) return any_exceeds(errors, want.limits);
  return fields_exceed(errors, want.limits) || (has_face && errors.of_domain != 0);
}
BlockDemand of_block(const WantBounded& want, const file::BlockInfo& block) {
  if (want.is_plain()) return exceeds(block.max_error.data(), want.limits) ? BlockDemand::kSome : BlockDemand::kNone;
  const StatedErrors errors = errors_of(block);
  if (!may_exceed_somewhere(errors, want, true)) return BlockDemand::kNone;
  if (want.camera && !may_exceed(errors, want, Box{block.box_min, block.box_max}, true)) return BlockDemand::kNone;
  return BlockDemand::kSome;
}
BlockDemand of_block(const Want& want, const file::BlockInfo& block) {
  return std::visit([&](const auto& of) { return of_block(of, block); }, want);
}

// ---- by the record ----

struct Record {
  const Hierarchy& hierarchy;
  RecordId id;

  [[nodiscard]] const Refinement& refinement() const { return hierarchy.content().refinement; }
  [[nodiscard]] const ErrorCode16* monotone() const { return row(hierarchy.content().monotone); }
  [[nodiscard]] StatedErrors errors() const {
    return {monotone(), row(hierarchy.content().own)[hierarchy.errors_per_record() - std::size_t{1}]};
  }

private:
  [[nodiscard]] const ErrorCode16* row(const std::vector<ErrorCode16>& codes) const {
    return codes.data() + id.index() * std::size_t{hierarchy.content().errors_per_record};
  }
};

bool wants_record(const WantAll&, const Record&) {
  return true;
}

// In the region there must be no tet that the collapse made, and no tet that it consumed must be missing, which matters
// where the boundary has moved. The box of the star is tested for all of them: that takes a fraction of the time of a
// test of each tet, and puts out some 0.5% more tets, 5% at most.
bool wants_record(const WantInside& want, const Record& record) { // with limits; without, see WantsOfBlock::find
  const auto [min, max] = record.hierarchy.star_box(record.id);
  return may_exceed(record.errors(), want, min, max);
}

/// Below which distance from the region errors pass what is allowed, but for rounding; negative: nowhere.
double reach_of(const StatedErrors& errors, const WantNear& want) {
  const std::size_t domain = want.scale.size() - 1;
  const double domain_error = decode_error(errors.of_domain, want.scale[domain]);
  double reach = -1;
  for (std::size_t i = 0; i <= domain; ++i) {
    const double error = i < domain ? decode_error(errors.of_fields[i], want.scale[i]) : domain_error;
    if (error > want.at_region[i])
      reach = std::max(reach, domain_error + (error - want.at_region[i]) / want.per_distance[i]);
  }
  return reach;
}

/// From the region to whatever lies in a box: rounding included, nothing is nearer than `least` or farther than `most`.
struct Distances {
  double least, most;
};
constexpr double kReachSlack = 1e-9; // more than what distances, and where errors reach, are rounded by
Distances distances_to(const Region& region, const Point& min, const Point& max) {
  const double nearest = distance(region, min, max), most = farthest(region, min, max);
  return {nearest - kReachSlack * most, most + kReachSlack * most};
}

enum class Answer { kNo, kYes, kOpen };
/// Whether what is within these distances is nearer than `reach`, as far as they tell.
Answer is_within(double reach, const Distances& distances) {
  // Written so that numbers that are none leave it open.
  if (distances.least > reach * (1 + kReachSlack)) return Answer::kNo;
  return distances.most < reach * (1 - kReachSlack) ? Answer::kYes : Answer::kOpen;
}
Answer is_within(double reach, const Region& region, std::span<const Point> corners) {
  Point min = corners[0], max = min;
  for (const Point& p : corners)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      min[axis] = std::min(min[axis], p[axis]);
      max[axis] = std::max(max[axis], p[axis]);
    }
  const Answer of_box = is_within(reach, distances_to(region, min, max));
  const bool has_corner = of_box == Answer::kOpen && std::any_of(corners.begin(), corners.end(), [&](const Point& p) {
                            return is_within(reach, distances_to(region, p, p)) == Answer::kYes;
                          });
  return has_corner ? Answer::kYes : of_box;
}

// The exact distance of each tet takes most of the time: the boxes of the block (`around`), of the star and of each
// tet, and corners, leave few of these.
bool wants_record(const WantNear& want, const Record& record, const Distances& around) {
  const StatedErrors errors = record.errors();
  const double reach = reach_of(errors, want);
  Answer answer = reach < 0 ? Answer::kNo : is_within(reach, around);
  if (answer == Answer::kOpen) {
    const auto [min, max] = record.hierarchy.star_box(record.id);
    answer = is_within(reach, distances_to(want.region, min, max));
  }
  if (answer != Answer::kOpen) return answer == Answer::kYes;
  return any_in_star(record.refinement(), record.id, [&](const Tet& tet) {
    const Corners corners(record.hierarchy, tet);
    const Answer of_tet = is_within(reach, want.region, corners.points());
    if (of_tet != Answer::kOpen) return of_tet == Answer::kYes;
    return exceeds_at(errors, want, distance(want.region, corners.points()));
  });
}

// Wanted when a version in C(r), which has the values and the place that the request is about, may have an error above
// its limit. Ghosts are looked at like tets: by values, they are the faces that domain errors are about.
bool wants_record(const WantBounded& want, const Record& record) {
  if (want.is_plain()) return exceeds(record.monotone(), want.limits);
  const StatedErrors errors = record.errors();
  if (!may_exceed_somewhere(errors, want, true)) return false;
  const bool may_be_tet = may_exceed_somewhere(errors, want, false);
  if (want.camera) {
    const auto [min, max] = record.hierarchy.star_box(record.id);
    if (!may_exceed(errors, want, Box{min, max}, true)) return false;
  }
  return any_coarse(record.refinement(), record.id, [&](const Tet& tet) {
    if (!may_be_tet && !is_ghost(tet)) return false;
    return (want.values.empty() ||
            std::any_of(want.values.begin(), want.values.end(),
                        [&](const Interval& i) { return may_take(i, record.hierarchy, tet, errors.of_fields); })) &&
           (!want.camera || may_exceed(errors, want, Corners(record.hierarchy, tet).points(), is_ghost(tet)));
  });
}

// ---- values ----

/// Within a tet: the values of a scalar field, or the norms of a field of vectors, lie from `low` to `high`.
struct ValueRange {
  double low = INFINITY, high = -INFINITY;
};
template <class T>
ValueRange scalar_range(const PointArray& array, const Tet& tet) {
  ValueRange range;
  for (const VertexId v : tet) {
    if (v == kDummyVertex) continue;
    const auto x = static_cast<double>(load<T>(array.bytes.data() + v.index() * sizeof(T)));
    range.low = std::min(range.low, x);
    range.high = std::max(range.high, x);
  }
  return range;
}
// The norm is greatest at a corner, and nowhere less than the distance from 0 to the box around the corners' values.
ValueRange norm_range(const PointArray& array, const Tet& tet) {
  ValueRange range{0, 0};
  std::array<double, 4> norm{};
  for (std::uint32_t component = 0; component < array.components; ++component) {
    double low = INFINITY, high = -INFINITY;
    for (std::size_t corner = 0; corner < 4; ++corner) {
      if (tet[corner] == kDummyVertex) continue;
      const double x = array.value(tet[corner].index(), component);
      low = std::min(low, x);
      high = std::max(high, x);
      norm[corner] = std::hypot(norm[corner], x);
    }
    range.low = std::hypot(range.low, std::max({low, -high, 0.0}));
  }
  range.high = *std::max_element(norm.begin(), norm.end());
  return range;
}

} // namespace

bool may_take(const Interval& interval, const Hierarchy& hierarchy, const Tet& tet, const ErrorCode16* errors) {
  const PointArray& array = hierarchy.content().arrays[interval.array];
  const ValueRange range = array.components == 1
                               ? dispatch(array.type, [&]<class T>(T) { return scalar_range<T>(array, tet); })
                               : norm_range(array, tet);
  constexpr double kRounding = 1e-14; // rounding, of norms too
  const double wider = decode_error(errors[interval.code], interval.scale) +
                       kRounding * std::max({std::fabs(range.low), std::fabs(range.high), interval.scale});
  if (range.low > range.high) return false; // nothing but NaN
  // Written so that NaN, which infinite lengths make of each other, leaves nothing out.
  return !(range.low - wider > interval.max) && !(range.high + wider < interval.min);
}

bool Wants::are_closed() const {
  return std::all_of(wants_.begin(), wants_.end(), [](const Want& want) {
    const auto* const bounded = std::get_if<WantBounded>(&want);
    return std::holds_alternative<WantAll>(want) || (bounded != nullptr && bounded->is_plain());
  });
}

BlockDemand Wants::demand_in(const file::BlockInfo& block) const {
  BlockDemand most = BlockDemand::kNone;
  for (const Want& want : wants_)
    most = std::max(most, of_block(want, block));
  return most;
}

void Wants::narrow_to(const file::BlockInfo& block, WantsOfBlock& those) const {
  those.wants_.clear();
  those.demand_ = BlockDemand::kNone;
  for (const Want& want : wants_) {
    const BlockDemand demand = of_block(want, block);
    if (demand != BlockDemand::kNone) those.wants_.push_back(&want);
    those.demand_ = std::max(those.demand_, demand);
  }
}

void WantsOfBlock::find(const Hierarchy& hierarchy, const file::BlockInfo& block, WantedRecords& wanted) const {
  std::vector<char>& found = wanted.found_;
  std::vector<Box>& boxes = wanted.boxes_;
  wanted.first_ = block.first_record;
  found.assign(block.record_count, demand_ == BlockDemand::kAll ? 1 : 0);
  if (demand_ != BlockDemand::kSome) return;
  boxes.clear();
  for (const Want* want : wants_)
    std::visit(
        [&](const auto& of) {
          if constexpr (std::is_same_v<std::decay_t<decltype(of)>, WantInside>) {
            if (of.limits.empty()) {
              if (boxes.empty()) hierarchy.star_boxes(block, boxes);
              find_meeting(of.region, boxes, found);
              return;
            }
          }
          const auto find_each = [&](const auto& wants) {
            for (std::uint32_t i = 0; i < block.record_count; ++i)
              if (found[i] == 0 && wants(Record{hierarchy, RecordId{block.first_record + i}})) found[i] = 1;
          };
          if constexpr (std::is_same_v<std::decay_t<decltype(of)>, WantNear>)
            find_each([&of, around = distances_to(of.region, block.box_min, block.box_max)](const Record& record) {
              return wants_record(of, record, around);
            });
          else
            find_each([&of](const Record& record) { return wants_record(of, record); });
        },
        *want);
}

} // namespace ptet
