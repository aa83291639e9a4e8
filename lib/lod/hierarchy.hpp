// An opened file in memory: what has been read of it, and reading more (loader.hpp). What was read may be gone under
// the next lock, so whoever goes on with a cut under another one asks Loader::holds() and Loader::revision().
#pragma once

#include "formats/ptet/reader.hpp"
#include "lod/loader.hpp"

#include <array>
#include <limits>
#include <memory>
#include <shared_mutex>
#include <vector>

namespace ptet {

class Hierarchy {
public:
  explicit Hierarchy(std::shared_ptr<ByteSource> source, const OpenOptions& options = {});

  // Of the source so far; no lock needed.
  [[nodiscard]] std::uint64_t bytes_read() const { return reader_.bytes_read(); }
  [[nodiscard]] std::uint64_t read_requests() const { return reader_.requests(); }

  // Never changes; no lock needed.
  [[nodiscard]] const file::Header& header() const { return reader_.header(); }
  [[nodiscard]] const file::Manifest& manifest() const { return reader_.manifest(); }
  [[nodiscard]] const std::vector<file::BlockInfo>& blocks() const { return reader_.blocks(); }
  [[nodiscard]] std::uint64_t file_bytes() const { return reader_.file_bytes(); }
  /// Governing fields and, last, the domain.
  [[nodiscard]] std::uint32_t errors_per_record() const { return errors_per_record_; }
  /// Base vertices that some base tet uses.
  [[nodiscard]] std::uint32_t used_base_vertex_count() const { return used_base_vertex_count_; }
  [[nodiscard]] std::uint32_t base_face_count() const { return base_face_count_; }

  /// See file::Reader. Nothing else waits for it but another read of the source. Refused as Loader::lock() is.
  [[nodiscard]] file::InputOrder read_input_order() const {
    loader_.refuse_orphaned();
    return reader_.read_input_order();
  }

  [[nodiscard]] Loader& loader() { return loader_; }
  [[nodiscard]] const Loader& loader() const { return loader_; }
  /// See Loader.
  void close(BlockSet& set) const { loader_.close(set); }
  /// With memory to work in, which it keeps.
  void close(BlockSet& set, std::vector<std::uint32_t>& open) const { loader_.close(set, open); }

  /// Hold it to look at what follows.
  [[nodiscard]] std::shared_lock<std::shared_mutex> lock() { return loader_.lock(); }
  [[nodiscard]] const file::Content& content() const { return content_; }
  [[nodiscard]] Point position(VertexId v) const;
  /// Bounding box of the star of the record's vertex; of a loaded record.
  [[nodiscard]] std::pair<Point, Point> star_box(RecordId r) const {
    const StepBox& box = star_box_[r.index()];
    Point min, max;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      min[axis] = steps_[axis].lower(box.min[axis]);
      max[axis] = steps_[axis].upper(box.max[axis]);
    }
    return {min, max};
  }

  /// Of all records of a loaded block, in their order, at the end of `boxes`.
  void star_boxes(const file::BlockInfo& block, std::vector<Box>& boxes) const {
    for (std::uint32_t r = block.first_record; r < block.end_record(); ++r) {
      const auto [min, max] = star_box(RecordId{r});
      boxes.push_back({min, max});
    }
  }

private:
  /// Steps from one side of all stars' box to the other along an axis; both ends are exact.
  struct Steps {
    double min, max, size;
    static constexpr std::uint16_t kMost = std::numeric_limits<std::uint16_t>::max();

    [[nodiscard]] double lower(std::uint16_t step) const { return min + step * size; }
    [[nodiscard]] double upper(std::uint16_t step) const { return max - (kMost - step) * size; }
    [[nodiscard]] std::uint16_t rounded_down(double x) const;
    [[nodiscard]] std::uint16_t rounded_up(double x) const;
    [[nodiscard]] std::uint16_t nearest(double x) const;
  };
  /// In steps of that box.
  struct StepBox {
    std::array<std::uint16_t, 3> min, max;
  };

  void keep_star(RecordId r, const Point& least, const Point& greatest);

  file::Reader reader_;
  file::Content content_;
  const std::uint32_t errors_per_record_;
  std::array<Steps, 3> steps_{};
  std::vector<StepBox> star_box_; ///< rounded outward
  std::uint32_t used_base_vertex_count_ = 0;
  std::uint32_t base_face_count_ = 0; ///< of the boundary
  Loader loader_;                     ///< last: its thread works on what is above
};

} // namespace ptet
