#include "formats/ptet/file_stars.hpp"

#include "ptet/error.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

namespace ptet::file {

FileStars::FileStars(RecordStream& records, const FileOrder& order) : blocks_(order.blocks.size()) {
  rows_.reserve(records.size());
  std::vector<char> is_deleted(records.slots.size());
  for (std::uint32_t b = 0; b < blocks_.size(); ++b) {
    Block& block = blocks_[b];
    const std::span ids =
        std::span(order.stream_record).subspan(order.blocks[b].first_record, order.blocks[b].record_count);
    std::size_t modified_count = 0, deleted_count = 0;
    for (const std::uint32_t record : ids) {
      rows_.push_back({b, static_cast<std::uint32_t>(modified_count), static_cast<std::uint32_t>(deleted_count),
                       records.modified_count[record], static_cast<std::uint16_t>(records.deleted(record).size())});
      modified_count += records.modified_count[record];
      deleted_count += records.deleted(record).size();
    }
    block.modified.reserve(modified_count);
    block.deleted.reserve(deleted_count);
    for (const std::uint32_t record : ids) {
      const auto modified = records.modified(record);
      block.modified.insert(block.modified.end(), modified.begin(), modified.end());
      for (const std::uint32_t slot : records.deleted(record)) {
        if (std::exchange(is_deleted[slot], 1) != 0)
          throw Error(ErrorCode::kBadInput, "collapse " + std::to_string(record) + " deletes a tet that is gone");
        std::array<VertexId, 4> others{};
        std::size_t count = 0;
        for (const VertexId v : records.slots[slot])
          if (v != records.removed[record] && v != records.target[record])
            others[count++] = v == kDummyVertex ? v : order.file_vertex[v.index()];
        if (count != 2)
          throw Error(ErrorCode::kBadInput,
                      "collapse " + std::to_string(record) + " deletes a tet that is not at its edge");
        block.deleted.push_back({slot, others[0], others[1]});
      }
    }
  }
  records.stars = std::vector<std::uint32_t>(); // {} would keep its memory
  records.star_begin = std::vector<std::uint64_t>();
  records.slots = std::vector<Tet>();
}

} // namespace ptet::file
