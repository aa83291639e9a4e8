#include "lod/part_errors.hpp"

#include "lod/region.hpp"
#include "lod/star.hpp"
#include "record/ghost.hpp"

#include <algorithm>
#include <numeric>

namespace ptet {
namespace {

using Codes = std::vector<ErrorCode16>;

/// Of the record that made it. `codes`: those of all records, own or monotone.
const ErrorCode16* errors_of(const std::vector<ErrorCode16>& codes, const Hierarchy& hierarchy,
                             const MadeVersion& version) {
  return codes.data() + version.maker.index() * std::size_t{hierarchy.errors_per_record()};
}
const ErrorCode16* own_errors(const Hierarchy& hierarchy, const MadeVersion& version) {
  return errors_of(hierarchy.content().own, hierarchy, version);
}

using Blocks = std::vector<const file::BlockInfo*>;

Blocks unread_blocks(const Hierarchy& hierarchy, const Cut& cut) {
  Blocks unread;
  for (std::size_t b = 0; b < cut.read.size(); ++b)
    if (cut.read[b] == 0) unread.push_back(&hierarchy.blocks()[b]);
  return unread;
}

/// In the order of the records that made them, and where those of each block begin.
class ByBlock {
public:
  ByBlock(std::span<const MadeVersion> versions, const std::vector<file::BlockInfo>& blocks)
      : versions_(versions.size()), begin_(blocks.size() + 1, 0) {
    const std::vector<std::uint32_t> block_of = file::blocks_by_record(blocks);
    for (const MadeVersion& version : versions)
      ++begin_[block_of[version.maker.index()] + 1];
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
    for (const MadeVersion& version : versions)
      versions_[next[block_of[version.maker.index()]]++] = version;
  }
  [[nodiscard]] std::span<const MadeVersion> of(std::size_t block) const {
    return std::span(versions_).subspan(begin_[block], begin_[block + 1] - begin_[block]);
  }

private:
  std::vector<MadeVersion> versions_;
  std::vector<std::size_t> begin_;
};

/// The largest codes, of the fields over tets, of the domain over faces, where `is_in(version, own)` holds; with those
/// of the unread blocks. `may_hold(box, domain)`: whether it may in that box, of versions with no larger domain error;
/// most is not looked at for that.
template <class IsIn, class MayHold>
Codes largest(const Hierarchy& hierarchy, const ByBlock& tets, const ByBlock& ghosts, const Blocks& unread,
              IsIn&& is_in, MayHold&& may_hold) {
  const std::size_t count = hierarchy.errors_per_record();
  Codes most(count, 0);
  for (const file::BlockInfo* const block : unread)
    if (may_hold(Box{block->box_min, block->box_max}, block->max_own.back()))
      for (std::size_t i = 0; i < count; ++i)
        most[i] = std::max(most[i], block->max_own[i]);
  const auto look_at = [&](std::span<const MadeVersion> versions, std::size_t first, std::size_t last) {
    for (const MadeVersion& version : versions) {
      const ErrorCode16* const own = own_errors(hierarchy, version);
      bool is_larger = false;
      for (std::size_t i = first; i < last; ++i)
        is_larger = is_larger || own[i] > most[i];
      if (!is_larger) continue;
      const auto [min, max] = hierarchy.star_box(version.maker);
      if (!may_hold(Box{min, max}, own[count - 1]) || !is_in(version, own)) continue;
      for (std::size_t i = first; i < last; ++i)
        most[i] = std::max(most[i], own[i]);
    }
  };
  for (std::size_t b = 0; b < hierarchy.blocks().size(); ++b) {
    const file::BlockInfo& block = hierarchy.blocks()[b];
    if (tets.of(b).empty() && ghosts.of(b).empty()) continue;
    if (!may_hold(Box{block.box_min, block.box_max}, block.max_own.back())) continue;
    look_at(tets.of(b), 0, count - 1);
    look_at(ghosts.of(b), count - 1, count);
  }
  return most;
}

PartErrors decoded(const Codes& codes, const file::Header& header) {
  PartErrors errors;
  for (const file::ArrayInfo& array : header.arrays)
    if (array.governing) errors.field_error.push_back(decode_error(codes[errors.field_error.size()], array.range));
  errors.domain_error = decode_error(codes.back(), header.diagonal);
  return errors;
}

double largest_in_pixels(const Hierarchy& hierarchy, std::span<const MadeVersion> ghosts, const Blocks& unread,
                         const Camera& camera) {
  const std::size_t domain = hierarchy.errors_per_record() - std::size_t{1};
  const auto in_pixels = [&](ErrorCode16 code, const auto& place) {
    const double error = decode_error(code, hierarchy.header().diagonal);
    return camera.meets(place, error) ? camera.pixels_of(error, camera.depth(place)) : 0;
  };
  double most = 0;
  for (const file::BlockInfo* const block : unread)
    if (block->max_own[domain] > 0)
      most = std::max(most, in_pixels(block->max_own[domain], Box{block->box_min, block->box_max}));
  for (const MadeVersion& ghost : ghosts)
    if (const ErrorCode16* const own = own_errors(hierarchy, ghost); own[domain] > 0)
      most = std::max(most, in_pixels(own[domain], Corners(hierarchy, ghost.tet).points()));
  return most;
}

/// Whether what is promised, whatever the budgets for size are, is there.
bool has_all_promised(const Cut& cut) {
  return cut.limited_by != LimitedBy::kTime &&
         std::find(cut.missing.begin(), cut.missing.end(), 1) == cut.missing.end();
}

} // namespace

bool names_parts(const ResolvedRequest& request) {
  return !request.focus.empty() || !request.values.empty() || request.camera;
}

void state_part_errors(const Hierarchy& hierarchy, const Cut& cut, const ResolvedRequest& request,
                       std::span<const MadeVersion> tets, std::span<const MadeVersion> ghosts, Extraction& result) {
  const Blocks unread = unread_blocks(hierarchy, cut);
  const ByBlock tets_of(tets, hierarchy.blocks()), ghosts_of(ghosts, hierarchy.blocks());
  const auto state = [&](auto&& is_in, auto&& may_hold) {
    return decoded(largest(hierarchy, tets_of, ghosts_of, unread, is_in, may_hold), hierarchy.header());
  };
  // A face stands for what of the original is outside of the mesh, as far from it as its domain error: see WantBounded.
  const auto domain_error = [&](ErrorCode16 code) { return decode_error(code, hierarchy.header().diagonal); };
  const auto around = [&](const MadeVersion& version, const ErrorCode16* own) {
    return is_ghost(version.tet) ? domain_error(own[hierarchy.errors_per_record() - std::size_t{1}]) : 0;
  };
  const bool is_met = has_all_promised(cut);
  for (const ResolvedRequest::FocusRegion& focus : request.focus) {
    const Region& region = focus.region;
    // Else nothing of the original in it is outside of the mesh.
    const bool stands_for_more = !(focus.is_original && is_met);
    result.in_focus.push_back(state(
        [&](const MadeVersion& version, const ErrorCode16* own) {
          return meets(region, Corners(hierarchy, version.tet).points(), stands_for_more ? around(version, own) : 0);
        },
        [&](const Box& box, ErrorCode16 domain) {
          return meets(region, box.min, box.max, stands_for_more ? domain_error(domain) : 0);
        }));
  }
  for (const Interval& interval : request.values)
    result.at_values.push_back(state(
        [&](const MadeVersion& version, const ErrorCode16* own) {
          return may_take(interval, hierarchy, version.tet,
                          is_ghost(version.tet) ? errors_of(hierarchy.content().monotone, hierarchy, version) : own);
        },
        [](const Box&, ErrorCode16) { return true; }));
  if (request.camera) {
    const Camera& camera = *request.camera;
    result.in_view = state(
        [&](const MadeVersion& version, const ErrorCode16* own) {
          return camera.meets(Corners(hierarchy, version.tet).points(), around(version, own));
        },
        [&](const Box& box, ErrorCode16 domain) { return camera.meets(box, domain_error(domain)); });
    result.pixels_in_view = largest_in_pixels(hierarchy, ghosts, unread, camera);
  }
}

} // namespace ptet
