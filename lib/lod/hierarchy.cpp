#include "lod/hierarchy.hpp"

#include "mesh/scalar_dispatch.hpp"

#include <algorithm>
#include <cmath>

namespace ptet {

std::uint16_t Hierarchy::Steps::rounded_down(double x) const {
  std::uint16_t step = nearest(x);
  while (step > 0 && lower(step) > x)
    --step;
  return step;
}

std::uint16_t Hierarchy::Steps::rounded_up(double x) const {
  std::uint16_t step = nearest(x);
  while (step < kMost && upper(step) < x)
    ++step;
  return step;
}

std::uint16_t Hierarchy::Steps::nearest(double x) const {
  const double step = x / size - min / size; // x - min might overflow
  return step > 0 ? static_cast<std::uint16_t>(std::min<double>(step, kMost)) : std::uint16_t{0}; // NaN: 0
}

Hierarchy::Hierarchy(std::shared_ptr<ByteSource> source, const OpenOptions& options)
    : reader_(std::move(source), options), content_(reader_.read_base()), star_box_(reader_.header().record_count),
      loader_(reader_, content_, options, [this](std::uint32_t block) { adopt(block); }) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // The boxes of the blocks are checked as they are read, the header's is only what the file says.
    double min = INFINITY, max = -INFINITY;
    for (const file::BlockInfo& block : blocks()) {
      min = std::min(min, block.box_min[axis]);
      max = std::max(max, block.box_max[axis]);
    }
    steps_[axis] = {min, max, max / Steps::kMost - min / Steps::kMost};
  }
  std::vector<char> is_used(header().base_vertex_count, 0);
  for (std::uint32_t t = 0; t < content_.refinement.base_tet_count(); ++t)
    for (const VertexId v : content_.refinement.vertices(VersionId{t}))
      is_used[v.index()] = 1;
  used_base_vertex_count_ = static_cast<std::uint32_t>(std::count(is_used.begin(), is_used.end(), 1));
  base_face_count_ = content_.refinement.base_version_count() - content_.refinement.base_tet_count();
}

void Hierarchy::adopt(std::uint32_t block) {
  check_dependencies(blocks()[block]);
  dispatch(content_.positions.type, [&]<class T>(T) { measure_stars<T>(blocks()[block]); });
}

// Cuts rest on this: a threshold on monotone errors, and a prefix of the order of collapses, hold every record's
// parents.
void Hierarchy::check_dependencies(const file::BlockInfo& block) const {
  const std::size_t codes = content_.errors_per_record;
  for (std::uint32_t r = block.first_record; r < block.first_record + block.record_count; ++r) {
    const ErrorCode16* const mine = content_.monotone.data() + r * codes;
    bool holds = content_.order[r] <= block.max_order;
    for (std::size_t i = 0; i < codes; ++i)
      holds =
          holds && content_.own[r * codes + i] <= std::min(mine[i], block.max_own[i]) && mine[i] <= block.max_error[i];
    for (const RecordId parent : content_.refinement.parents(RecordId{r})) {
      holds = holds && content_.generation[parent.index()] < content_.generation[r] &&
              content_.order[parent.index()] >= content_.order[r];
      for (std::size_t i = 0; i < codes; ++i)
        holds = holds && mine[i] <= content_.monotone[parent.index() * codes + i];
    }
    if (!holds)
      throw file::BlockError(Error(ErrorCode::kCorruptFile,
                                   "record " + std::to_string(r) + " breaks the order of errors and dependencies",
                                   block.offset),
                             static_cast<std::uint32_t>(&block - blocks().data()), block.offset);
  }
}

template <class T>
void Hierarchy::measure_stars(const file::BlockInfo& block) {
  const Refinement& refinement = content_.refinement;
  for (std::uint32_t r = block.first_record; r < block.first_record + block.record_count; ++r) {
    const RecordId record{r};
    Point min{INFINITY, INFINITY, INFINITY}, max{-INFINITY, -INFINITY, -INFINITY};
    const auto add = [&](VertexId v) {
      if (v == kDummyVertex) return;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto x = static_cast<double>(
            ptet::load<T>(content_.positions.bytes.data() + (v.index() * std::size_t{3} + axis) * sizeof(T)));
        min[axis] = std::min(min[axis], x);
        max[axis] = std::max(max[axis], x);
      }
    };
    add(refinement.target(record));
    add(refinement.vertex_of(record));
    const std::uint32_t first = refinement.first_fine(record).index();
    for (std::uint32_t t = first; t < first + refinement.fine_count(record); ++t)
      for (std::size_t corner = 1; corner < 4; ++corner)
        add(refinement.vertices(VersionId{t})[corner]);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      star_box_[r].min[axis] = steps_[axis].rounded_down(min[axis]);
      star_box_[r].max[axis] = steps_[axis].rounded_up(max[axis]);
    }
  }
}

Point Hierarchy::position(VertexId v) const {
  const PointArray& positions = content_.positions;
  if (positions.type != ScalarType::kFloat32)
    return {positions.value(v.index(), 0), positions.value(v.index(), 1), positions.value(v.index(), 2)};
  // The usual one, without a look at the type for each coordinate.
  const std::byte* const row = positions.bytes.data() + v.index() * (3 * sizeof(float));
  return {ptet::load<float>(row), ptet::load<float>(row + sizeof(float)), ptet::load<float>(row + 2 * sizeof(float))};
}

std::pair<Point, Point> Hierarchy::star_box(RecordId r) const {
  const StepBox& box = star_box_[r.index()];
  Point min, max;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    min[axis] = steps_[axis].lower(box.min[axis]);
    max[axis] = steps_[axis].upper(box.max[axis]);
  }
  return {min, max};
}

} // namespace ptet
