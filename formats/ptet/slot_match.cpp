#include "formats/ptet/slot_match.hpp"

#include "ptet/error.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

namespace ptet::file {
namespace {

/// By the file's vertices, ascending: tets of the same vertices are the same.
Tet in_file(Tet tet, const FileOrder& order) {
  for (VertexId& v : tet)
    v = v == kDummyVertex ? v : order.file_vertex[v.index()];
  std::sort(tet.begin(), tet.end());
  return tet;
}

} // namespace

SlotMatch::SlotMatch(const RecordStream& records, const FileOrder& order, const Refinement& refinement)
    : slot_of_(records.slot_count(), kNone), place_of_(records.slot_count(), kNone) {
  std::vector<std::pair<Tet, std::uint32_t>> base;
  for (const std::uint32_t slot : records.base_slots())
    base.emplace_back(in_file(records.slots[slot], order), slot);
  std::sort(base.begin(), base.end());
  if (base.size() != refinement.base_place_count())
    throw Error(ErrorCode::kBadInput, "the records do not lead to a closed base mesh");
  for (std::uint32_t place = 0; place < refinement.base_place_count(); ++place) {
    Tet tet = refinement.tet(place);
    std::sort(tet.begin(), tet.end());
    const auto found = std::lower_bound(base.begin(), base.end(), std::pair(tet, std::uint32_t{0}));
    if (found == base.end() || found->first != tet)
      throw Error(ErrorCode::kBadInput, "the records do not lead to a closed base mesh");
    match(found->second, place);
  }
}

void SlotMatch::add_rims(const Refinement& refinement, const FileStars& stars, std::span<const std::uint32_t> records) {
  oneapi::tbb::parallel_for(oneapi::tbb::blocked_range<std::size_t>(0, records.size(), 16), [&](const auto& range) {
    for (std::size_t i = range.begin(); i != range.end(); ++i)
      add_rim(refinement, stars, RecordId{records[i]});
  });
}

void SlotMatch::add_rim(const Refinement& refinement, const FileStars& stars, RecordId r) {
  const auto rim = refinement.rim(r);
  const auto deleted = stars.deleted(r);
  const auto fail = [&] {
    throw Error(ErrorCode::kBadInput, "record " + std::to_string(r.index()) + " does not undo its collapse");
  };
  if (rim.size() != deleted.size() || refinement.modified(r).size() != stars.modified(r).size()) fail();
  for (const FileStars::Deleted& tet : deleted) {
    const auto is_at = [&](std::size_t i) {
      const auto [a, b] = rim_edge(rim, i);
      return (a == tet.a && b == tet.b) || (a == tet.b && b == tet.a);
    };
    std::size_t i = 0;
    while (i < rim.size() && !is_at(i))
      ++i;
    const auto place = static_cast<std::uint32_t>(refinement.rim_place(r) + i);
    if (i == rim.size() || place >= slot_of_.size() || slot_of_[place] != kNone || place_of_[tet.slot] != kNone) fail();
    match(tet.slot, place);
  }
}

} // namespace ptet::file
