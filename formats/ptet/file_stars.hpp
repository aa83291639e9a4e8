// What the writer has to know of the collapses of a record stream to code them, in the order of the file: it is let go
// block by block, as the refinement grows.
#pragma once

#include "formats/ptet/ordering.hpp"
#include "record/stream.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace ptet::file {

class FileStars {
public:
  /// A slot that a collapse deleted, and its vertices, in the file's numbers, less the one removed and its target.
  struct Deleted {
    std::uint32_t slot;
    VertexId a, b;
  };

  /// Takes the stars and slots of `records`, to save their memory: the stream is none afterwards. Throws
  /// Error(kBadInput) when a deleted slot did not hold both vertices of its collapse, or is deleted twice.
  FileStars(RecordStream& records, const FileOrder& order);

  // Of a record of the file, until its block is forgotten.
  [[nodiscard]] std::span<const std::uint32_t> modified(RecordId r) const {
    const Row& row = rows_[r.index()];
    return std::span(blocks_[row.block].modified).subspan(row.first_modified, row.modified_count);
  }
  [[nodiscard]] std::span<const Deleted> deleted(RecordId r) const {
    const Row& row = rows_[r.index()];
    return std::span(blocks_[row.block].deleted).subspan(row.first_deleted, row.deleted_count);
  }
  void forget(std::uint32_t block) { blocks_[block] = {}; }

private:
  struct Block {
    std::vector<std::uint32_t> modified;
    std::vector<Deleted> deleted;
  };
  struct Row {
    std::uint32_t block, first_modified, first_deleted;
    std::uint16_t modified_count, deleted_count;
  };
  std::vector<Block> blocks_;
  std::vector<Row> rows_; ///< by record
};

} // namespace ptet::file
