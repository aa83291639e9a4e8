#include "record/stream.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ptet {
namespace {

constexpr std::uint32_t kNotMade = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint32_t kOriginal = kNotMade - 1;

bool contains(const Tet& tet, VertexId v) {
  return std::find(tet.begin(), tet.end(), v) != tet.end();
}

std::string check_counts(const RecordStream& s) {
  const std::size_t n = s.size();
  if (s.target.size() != n || s.round.size() != n || s.modified_count.size() != n || s.coarse_begin.size() != n ||
      s.domain_error.size() != n || s.field_error.size() != n * s.fields.size() || s.fine_begin.size() != n + 1 ||
      (!s.outside_error.empty() && s.outside_error.size() != n * s.fields.size()) ||
      (!s.squared_error.empty() && s.squared_error.size() != n * s.fields.size()) ||
      (!s.uncovered_volume.empty() && s.uncovered_volume.size() != n) || s.also_needs_begin.size() != n + 1)
    return "the tables of the records differ in length";
  if (s.fine_begin.front() != 0 || s.fine_begin.back() != s.fine.size())
    return "the offsets of the fine versions do not span their table";
  if (s.also_needs_begin.front() != 0 || s.also_needs_begin.back() != s.also_needs.size())
    return "the offsets of the other records needed do not span their table";
  if (s.versions.size() < std::size_t{s.original_tet_count} + s.original_ghost_count)
    return "there are fewer versions than original tets and ghosts";
  if (!(s.volume >= 0) || !std::isfinite(s.volume)) return "the volume is no finite number";
  if (!s.squared_error.empty() && s.uncovered_volume.empty())
    return "there are squared errors but no uncovered volumes";
  if (!s.uncovered_volume.empty() && !(s.volume > 0)) return "there are squared errors but no volume";
  if (!(s.diagonal >= 0) || !std::isfinite(s.diagonal)) return "the diagonal is no length";
  for (const GoverningField& field : s.fields)
    if (!(field.range >= 0) || !std::isfinite(field.range))
      return "the range of array " + std::to_string(field.array) + " is no finite number";
  return {};
}

std::string check_versions(const RecordStream& s) {
  for (std::size_t t = 0; t < s.versions.size(); ++t) {
    const Tet& tet = s.versions[t];
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (tet[i] == tet[j] || tet[i].is_none())
          return "version " + std::to_string(t) + " does not have four vertices";
    const bool is_ghost = contains(tet, kDummyVertex);
    if (t < std::size_t{s.original_tet_count} + s.original_ghost_count && is_ghost != (t >= s.original_tet_count))
      return "version " + std::to_string(t) + " is a tet among the original ghosts or a ghost among the tets";
  }
  return {};
}

/// What the records have done so far, from the first collapse on.
struct Replay {
  std::vector<std::uint32_t> made_in_round; ///< by version; kNotMade while it is not there (yet, or any more)
  std::vector<char> is_removed;             ///< by vertex
  std::size_t next_coarse = 0;
};

std::string apply_record(const RecordStream& s, std::size_t i, Replay& replay) {
  const VertexId removed = s.removed[i], target = s.target[i];
  const std::size_t vertex_count = replay.is_removed.size();
  if (removed.index() >= vertex_count || target.index() >= vertex_count || removed == target)
    return "its vertices are not two vertices of the mesh";
  if (replay.is_removed[removed.index()] || replay.is_removed[target.index()])
    return "one of its vertices was removed before";
  if (i > 0 && s.round[i] < s.round[i - 1]) return "its round is less than that of the record before";
  if (s.fine_begin[i] > s.fine_begin[i + 1] || s.fine_begin[i + 1] > s.fine.size())
    return "the offsets of its fine versions decrease";
  const auto fine = s.consumed(i);
  const std::size_t modified = s.modified_count[i];
  if (modified == 0 || modified >= fine.size()) return "it modifies nothing or deletes nothing";
  if (s.coarse_begin[i].index() != replay.next_coarse || replay.next_coarse + modified > s.versions.size())
    return "its coarse versions do not follow those of the record before";
  for (std::size_t m = 0; m < fine.size(); ++m) {
    const std::uint32_t t = fine[m].index();
    if (t >= s.versions.size() || replay.made_in_round[t] == kNotMade) return "it consumes a version that is not there";
    if (replay.made_in_round[t] == s.round[i]) return "it consumes a version made in its own round";
    replay.made_in_round[t] = kNotMade;
    Tet tet = s.versions[t];
    if (!contains(tet, removed) || contains(tet, target) != (m >= modified))
      return "version " + std::to_string(t) + " is not one that it modifies or deletes";
    if (m >= modified) continue;
    std::replace(tet.begin(), tet.end(), removed, target);
    if (tet != s.versions[replay.next_coarse + m])
      return "version " + std::to_string(replay.next_coarse + m) + " is not version " + std::to_string(t) +
             " with the vertex replaced";
  }
  std::fill_n(replay.made_in_round.begin() + static_cast<std::ptrdiff_t>(replay.next_coarse), modified, s.round[i]);
  replay.next_coarse += modified;
  replay.is_removed[removed.index()] = 1;
  const auto is_error = [](double error) { return error >= 0 && std::isfinite(error); };
  const double* errors = s.field_error.data() + i * s.fields.size();
  const double* outside = s.outside_error.data() + (s.outside_error.empty() ? 0 : i * s.fields.size());
  if (!is_error(s.domain_error[i]) || !std::all_of(errors, errors + s.fields.size(), is_error) ||
      (!s.outside_error.empty() && !std::all_of(outside, outside + s.fields.size(), is_error)))
    return "one of its errors is negative or not a finite number";
  for (std::size_t f = 0; f < s.fields.size() && !s.squared_error.empty(); ++f)
    if (!std::isfinite(s.squared_error[i * s.fields.size() + f]))
      return "its change of the squared error is not a finite number";
  if (!s.uncovered_volume.empty() && !std::isfinite(s.uncovered_volume[i]))
    return "its change of the uncovered volume is not a finite number";
  if (s.also_needs_begin[i] > s.also_needs_begin[i + 1] || s.also_needs_begin[i + 1] > s.also_needs.size())
    return "the offsets of the other records it needs decrease";
  std::size_t before = i;
  for (const std::uint32_t needed : s.others_needed(i)) {
    if (needed <= before || needed >= s.size()) return "it needs a record that is not later, or out of order";
    before = needed;
  }
  return {};
}

} // namespace

bool RecordStream::moves_boundary(std::size_t record) const {
  const auto of_record = consumed(record);
  return std::any_of(of_record.begin(), of_record.end(),
                     [&](VersionId t) { return contains(versions[t.index()], kDummyVertex); });
}

void RecordStream::append_errors(const RecordStream& other, std::size_t record, std::size_t field_count) {
  const auto append = [&](const std::vector<double>& from, std::vector<double>& to) {
    if (from.empty()) return;
    const auto row = from.begin() + static_cast<std::ptrdiff_t>(record * field_count);
    to.insert(to.end(), row, row + static_cast<std::ptrdiff_t>(field_count));
  };
  append(other.field_error, field_error);
  append(other.outside_error, outside_error);
  append(other.squared_error, squared_error);
  if (!other.uncovered_volume.empty()) uncovered_volume.push_back(other.uncovered_volume[record]);
}

std::string RecordStream::validate() const {
  if (std::string broken = check_counts(*this); !broken.empty()) return broken;
  if (std::string broken = check_versions(*this); !broken.empty()) return broken;
  const std::size_t original = std::size_t{original_tet_count} + original_ghost_count;
  std::size_t vertex_count = 0;
  for (std::size_t t = 0; t < original; ++t)
    for (const VertexId v : versions[t])
      if (v != kDummyVertex) vertex_count = std::max<std::size_t>(vertex_count, v.index() + std::size_t{1});
  Replay replay{std::vector<std::uint32_t>(versions.size(), kNotMade), std::vector<char>(vertex_count, 0), original};
  std::fill_n(replay.made_in_round.begin(), original, kOriginal);
  for (std::size_t i = 0; i < size(); ++i)
    if (const std::string broken = apply_record(*this, i, replay); !broken.empty())
      return "record " + std::to_string(i) + ": " + broken;
  if (replay.next_coarse != versions.size()) return "some versions were made by no record";
  return {};
}

bool holds_squares(double range, double volume) {
  const double most = 4 * range * range * volume;
  return std::isfinite(most) && most > std::numeric_limits<double>::min() / std::numeric_limits<double>::epsilon();
}

} // namespace ptet
