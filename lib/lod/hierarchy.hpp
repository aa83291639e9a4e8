// An opened file in memory: what has been read of it, and reading more. What is read only grows, so a cut found
// under one lock is good under the next.
#pragma once

#include "formats/ptet/reader.hpp"

#include <array>
#include <exception>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <vector>

namespace ptet {

/// One flag a block.
using BlockSet = std::vector<char>;

class Hierarchy {
public:
  explicit Hierarchy(std::unique_ptr<file::Source> source);

  // Never changes; no lock needed.
  [[nodiscard]] const file::Header& header() const { return reader_.header(); }
  [[nodiscard]] const file::Manifest& manifest() const { return reader_.manifest(); }
  [[nodiscard]] const std::vector<file::BlockInfo>& blocks() const { return reader_.blocks(); }
  [[nodiscard]] std::uint64_t file_bytes() const { return reader_.file_bytes(); }
  /// Governing fields and, last, the domain.
  [[nodiscard]] std::uint32_t errors_per_record() const { return content_.errors_per_record; }
  /// Base vertices that some base tet uses.
  [[nodiscard]] std::uint32_t used_base_vertex_count() const { return used_base_vertex_count_; }
  [[nodiscard]] std::uint32_t base_face_count() const { return base_face_count_; }

  /// Adds every block that one of the set needs, directly or not.
  void close(BlockSet& set) const {
    std::vector<std::uint32_t> open;
    close(set, open);
  }
  /// The same with memory to work in, which it keeps.
  void close(BlockSet& set, std::vector<std::uint32_t>& open) const;
  /// Reads what is missing of a closed set. Takes the lock itself. Throws what the reader throws, and again at every
  /// later call.
  void load(const BlockSet& closed);

  /// Hold it to look at what follows.
  [[nodiscard]] std::shared_lock<std::shared_mutex> lock() const { return std::shared_lock(mutex_); }
  [[nodiscard]] const file::Content& content() const { return content_; }
  [[nodiscard]] std::uint64_t bytes_read() const { return reader_.bytes_read(); }
  [[nodiscard]] Point position(VertexId v) const;
  /// Bounding box of the star of the record's vertex; of a loaded record.
  [[nodiscard]] std::pair<Point, Point> star_box(RecordId r) const;

private:
  /// In steps of the domain's box.
  struct StepBox {
    std::array<std::uint16_t, 3> min, max;
  };

  void check_dependencies(const file::BlockInfo& block) const;
  template <class T>
  void measure_stars(const file::BlockInfo& block);

  file::Reader reader_;
  file::Content content_;
  std::vector<StepBox> star_box_; ///< rounded outward
  std::uint32_t used_base_vertex_count_ = 0;
  std::uint32_t base_face_count_ = 0; ///< of the boundary
  std::exception_ptr broken_;
  mutable std::shared_mutex mutex_;
};

} // namespace ptet
