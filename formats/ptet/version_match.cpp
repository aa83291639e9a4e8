#include "formats/ptet/version_match.hpp"

#include "ptet/error.hpp"

#include <algorithm>
#include <string>
#include <unordered_map>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

namespace ptet::file {
namespace {

/// The same for two tets of the same four vertices, and hardly ever for others of one star.
std::uint64_t key_of(const Tet& tet) {
  std::uint64_t sum = 0;
  for (const VertexId v : tet) {
    std::uint64_t x = v.index() * std::uint64_t{0x9E3779B97F4A7C15} + 0x632BE59BD9B4E019;
    x = (x ^ x >> 29) * 0xBF58476D1CE4E5B9;
    sum += x ^ x >> 32;
  }
  return sum;
}

} // namespace

VersionMatch::VersionMatch(const RecordStream& records, const FileOrder& order,
                           std::span<const std::uint32_t> consumers, const Refinement& refinement)
    : records_(records), order_(order), stream_of_(records.versions.size(), VersionId::kNone),
      version_of_(records.versions.size()) {
  std::unordered_map<std::uint64_t, std::uint32_t> by_key;
  for (std::uint32_t t = 0; t < records.versions.size(); ++t)
    if (consumers[t] == RecordId::kNone) by_key.emplace(key_of(in_file(records.versions[t])), t);
  for (std::uint32_t t = 0; t < refinement.base_version_count(); ++t) {
    const auto found = by_key.find(key_of(refinement.vertices(VersionId{t})));
    if (found == by_key.end()) throw Error(ErrorCode::kBadInput, "the records do not lead to a closed base mesh");
    stream_of_[t] = found->second;
    version_of_[found->second] = VersionId{t};
  }
}

/// A tet of the stream by the file's vertices.
Tet VersionMatch::in_file(Tet tet) const {
  for (VertexId& v : tet)
    v = v == kDummyVertex ? v : order_.file_vertex[v.index()];
  return tet;
}

void VersionMatch::add_fine(const Refinement& refinement, std::span<const std::uint32_t> records) {
  oneapi::tbb::parallel_for(oneapi::tbb::blocked_range<std::size_t>(0, records.size(), 16), [&](const auto& range) {
    Scratch& scratch = scratch_.local();
    for (std::size_t i = range.begin(); i != range.end(); ++i)
      add_fine(refinement, RecordId{records[i]}, scratch);
  });
}

void VersionMatch::add_fine(const Refinement& refinement, RecordId r, Scratch& scratch) {
  auto& [fine_keys, stream_keys] = scratch;
  const std::uint32_t record = order_.stream_record[r.index()];
  fine_keys.clear();
  stream_keys.clear();
  const std::uint32_t first = refinement.first_fine(r).index();
  for (std::uint32_t t = first; t < first + refinement.fine_count(r); ++t)
    fine_keys.emplace_back(key_of(refinement.vertices(VersionId{t})), t);
  for (const VersionId t : records_.consumed(record))
    stream_keys.emplace_back(key_of(in_file(records_.versions[t.index()])), t.index());
  std::sort(fine_keys.begin(), fine_keys.end());
  std::sort(stream_keys.begin(), stream_keys.end());
  const auto same_key = [](const auto& a, const auto& b) { return a.first == b.first; };
  if (!std::equal(fine_keys.begin(), fine_keys.end(), stream_keys.begin(), stream_keys.end(), same_key))
    throw Error(ErrorCode::kBadInput, "collapse " + std::to_string(record) + " cannot be undone by a vertex split");
  for (std::size_t i = 0; i < fine_keys.size(); ++i) {
    stream_of_[fine_keys[i].second] = stream_keys[i].second;
    version_of_[stream_keys[i].second] = VersionId{fine_keys[i].second};
  }
}

} // namespace ptet::file
