#include "formats/ptet/slot_match.hpp"

#include "ptet/error.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <string>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

namespace ptet::file {
namespace {

/// Tets of the same vertices have the same.
Tet sorted(Tet tet) {
  std::sort(tet.begin(), tet.end());
  return tet;
}

} // namespace

SlotMatch::SlotMatch(const RecordStream& records, const FileOrder& order, const Refinement& refinement)
    : records_(records), order_(order), slot_of_(records.slot_count(), kNone), place_of_(records.slot_count(), kNone) {
  std::map<Tet, std::uint32_t> slot_of_tet;
  for (const std::uint32_t slot : records.base_slots())
    slot_of_tet.emplace(sorted(in_file(records.slots[slot])), slot);
  for (std::uint32_t place = 0; place < refinement.base_place_count(); ++place) {
    const auto found = slot_of_tet.find(sorted(refinement.tet(place)));
    if (found == slot_of_tet.end()) throw Error(ErrorCode::kBadInput, "the records do not lead to a closed base mesh");
    match(found->second, place);
  }
}

/// A tet of the stream by the file's vertices.
Tet SlotMatch::in_file(Tet tet) const {
  for (VertexId& v : tet)
    v = v == kDummyVertex ? v : order_.file_vertex[v.index()];
  return tet;
}

void SlotMatch::add_rims(const Refinement& refinement, std::span<const std::uint32_t> records) {
  oneapi::tbb::parallel_for(oneapi::tbb::blocked_range<std::size_t>(0, records.size(), 16), [&](const auto& range) {
    for (std::size_t i = range.begin(); i != range.end(); ++i)
      add_rim(refinement, RecordId{records[i]});
  });
}

void SlotMatch::add_rim(const Refinement& refinement, RecordId r) {
  const std::uint32_t record = order_.stream_record[r.index()];
  const auto rim = refinement.rim(r);
  const auto deleted = records_.deleted(record);
  const auto fail = [&] {
    throw Error(ErrorCode::kBadInput, "collapse " + std::to_string(record) + " cannot be undone by a vertex split");
  };
  if (rim.size() != deleted.size() || refinement.modified(r).size() != records_.modified_count[record]) fail();
  for (const std::uint32_t slot : deleted) {
    const Tet tet = in_file(records_.slots[slot]);
    const auto has = [&](VertexId v) { return std::find(tet.begin(), tet.end(), v) != tet.end(); };
    std::size_t i = 0;
    while (i < rim.size() && !(has(rim[i]) && has(rim[i + 1 < rim.size() ? i + 1 : 0])))
      ++i;
    if (i == rim.size() || !has(refinement.vertex_of(r)) || !has(refinement.target(r))) fail();
    const auto place = static_cast<std::uint32_t>(refinement.rim_place(r) + i);
    if (place >= slot_of_.size() || slot_of_[place] != kNone) fail();
    match(slot, place);
  }
}

} // namespace ptet::file
