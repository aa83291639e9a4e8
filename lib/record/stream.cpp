#include "record/stream.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace ptet {
namespace {

constexpr std::uint32_t kDeleted = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint32_t kOriginal = kDeleted - 1;

bool contains(const Tet& tet, VertexId v) {
  return std::find(tet.begin(), tet.end(), v) != tet.end();
}

std::string check_counts(const RecordStream& s) {
  const std::size_t n = s.size();
  if (s.target.size() != n || s.round.size() != n || s.modified_count.size() != n || s.domain_error.size() != n ||
      s.field_error.size() != n * s.fields.size() || s.star_begin.size() != n + 1 ||
      (!s.outside_error.empty() && s.outside_error.size() != n * s.fields.size()) ||
      (!s.squared_error.empty() && s.squared_error.size() != n * s.fields.size()) ||
      (!s.uncovered_volume.empty() && s.uncovered_volume.size() != n) || s.also_needs_begin.size() != n + 1)
    return "the tables of the records differ in length";
  if (s.star_begin.front() != 0 || s.star_begin.back() != s.stars.size())
    return "the offsets of the stars do not span their table";
  if (s.also_needs_begin.front() != 0 || s.also_needs_begin.back() != s.also_needs.size())
    return "the offsets of the other records needed do not span their table";
  if (s.slots.size() != s.slot_count()) return "there are not as many slots as original tets and ghosts";
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

std::string check_slots(const RecordStream& s) {
  for (std::uint32_t slot = 0; slot < s.slots.size(); ++slot) {
    const Tet& tet = s.slots[slot];
    for (std::size_t i = 0; i < 4; ++i)
      if (tet[i].is_none() || std::find(tet.begin(), tet.begin() + i, tet[i]) != tet.begin() + i)
        return "slot " + std::to_string(slot) + " does not have four vertices";
    if (contains(tet, kDummyVertex) != s.is_ghost(slot))
      return "slot " + std::to_string(slot) + " holds a tet among the ghosts or a ghost among the tets";
  }
  return {};
}

/// What the records have done so far, from the first collapse on.
struct Replay {
  std::vector<Tet> tets;                    ///< by slot
  std::vector<std::uint32_t> made_in_round; ///< by slot; kDeleted for those that hold nothing any more
  std::vector<char> is_removed;             ///< by vertex
};

/// Whether the stars can be gone through at all.
std::string check_star(const RecordStream& s, std::size_t i) {
  if (s.star_begin[i] > s.star_begin[i + 1] || s.star_begin[i + 1] > s.stars.size())
    return "the offsets of its star decrease";
  const auto star = s.star(i);
  if (s.modified_count[i] == 0 || s.modified_count[i] >= star.size()) return "it modifies nothing or deletes nothing";
  if (std::any_of(star.begin(), star.end(), [&](std::uint32_t slot) { return slot >= s.slots.size(); }))
    return "it takes a slot that is not there";
  return {};
}

std::string apply_record(const RecordStream& s, std::size_t i, Replay& replay) {
  const VertexId removed = s.removed[i], target = s.target[i];
  const std::size_t vertex_count = replay.is_removed.size();
  if (removed.index() >= vertex_count || target.index() >= vertex_count || removed == target)
    return "its vertices are not two vertices of the mesh";
  if (replay.is_removed[removed.index()] || replay.is_removed[target.index()])
    return "one of its vertices was removed before";
  if (i > 0 && s.round[i] < s.round[i - 1]) return "its round is less than that of the record before";
  const auto star = s.star(i);
  const std::size_t modified = s.modified_count[i];
  for (std::size_t m = 0; m < star.size(); ++m) {
    const std::uint32_t slot = star[m];
    std::uint32_t& made_in_round = replay.made_in_round[slot];
    if (made_in_round == kDeleted) return "it takes a slot that was deleted";
    if (made_in_round == s.round[i]) return "it takes a slot that was taken in its own round";
    const Tet& tet = replay.tets[slot];
    if (!contains(tet, removed) || contains(tet, target) != (m >= modified))
      return "slot " + std::to_string(slot) + " is not one that it modifies or deletes";
    made_in_round = m < modified ? s.round[i] : kDeleted;
  }
  s.collapse(i, replay.tets);
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

std::uint64_t RecordStream::version_count() const {
  return std::accumulate(modified_count.begin(), modified_count.end(), std::uint64_t{slot_count()});
}

void RecordStream::replace(std::size_t record, VertexId from, VertexId to, std::span<Tet> tets) const {
  for (const std::uint32_t slot : modified(record))
    std::replace(tets[slot].begin(), tets[slot].end(), from, to);
}

std::vector<Tet> RecordStream::original() const {
  std::vector<Tet> tets = slots;
  for (std::size_t record = size(); record-- > 0;)
    split(record, tets);
  return tets;
}

std::vector<std::uint32_t> RecordStream::base_slots() const {
  std::vector<char> is_deleted(slot_count());
  for (std::size_t record = 0; record < size(); ++record)
    for (const std::uint32_t slot : deleted(record))
      is_deleted[slot] = 1;
  std::vector<std::uint32_t> left;
  for (std::uint32_t slot = 0; slot < is_deleted.size(); ++slot)
    if (is_deleted[slot] == 0) left.push_back(slot);
  return left;
}

bool RecordStream::moves_boundary(std::size_t record) const {
  const auto of_record = star(record);
  return std::any_of(of_record.begin(), of_record.end(), [&](std::uint32_t slot) { return is_ghost(slot); });
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
  if (std::string broken = check_slots(*this); !broken.empty()) return broken;
  const auto of_record = [](std::size_t i, const std::string& broken) {
    return "record " + std::to_string(i) + ": " + broken;
  };
  for (std::size_t i = 0; i < size(); ++i)
    if (const std::string broken = check_star(*this, i); !broken.empty()) return of_record(i, broken);
  Replay replay{original(), std::vector<std::uint32_t>(slots.size(), kOriginal), {}};
  std::size_t vertex_count = 0;
  for (const Tet& tet : replay.tets)
    for (const VertexId v : tet)
      if (v != kDummyVertex) vertex_count = std::max<std::size_t>(vertex_count, v.index() + std::size_t{1});
  replay.is_removed.resize(vertex_count);
  for (std::size_t i = 0; i < size(); ++i)
    if (const std::string broken = apply_record(*this, i, replay); !broken.empty()) return of_record(i, broken);
  if (replay.tets != slots) return "the records do not lead to what the slots hold";
  return {};
}

bool holds_squares(double range, double volume) {
  const double most = 4 * range * range * volume;
  return std::isfinite(most) && most > std::numeric_limits<double>::min() / std::numeric_limits<double>::epsilon();
}

} // namespace ptet
