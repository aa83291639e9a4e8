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
    : reader_(std::move(source), options), content_(reader_.read_base()),
      errors_per_record_(content_.errors_per_record), star_box_(reader_.header().record_count),
      loader_(reader_, content_, options,
              [this](RecordId r, const Point& least, const Point& greatest) { keep_star(r, least, greatest); }) {
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
    for (const VertexId v : content_.refinement.base_tet(t))
      is_used[v.index()] = 1;
  used_base_vertex_count_ = static_cast<std::uint32_t>(std::count(is_used.begin(), is_used.end(), 1));
  base_face_count_ = content_.refinement.base_place_count() - content_.refinement.base_tet_count();
}

void Hierarchy::keep_star(RecordId r, const Point& least, const Point& greatest) {
  StepBox& box = star_box_[r.index()];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.min[axis] = steps_[axis].rounded_down(least[axis]);
    box.max[axis] = steps_[axis].rounded_up(greatest[axis]);
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

} // namespace ptet
