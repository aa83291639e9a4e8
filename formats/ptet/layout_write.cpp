#include "formats/ptet/box_grid.hpp"
#include "formats/ptet/layout.hpp"
#include "formats/ptet/planes.hpp"

#include <algorithm>

namespace ptet::file {
namespace {

void put_box(ByteWriter& out, const Point& least, const Point& greatest) {
  for (const double x : least)
    out.put(x);
  for (const double x : greatest)
    out.put(x);
}

void put_base_array(ByteWriter& out, const PointArray& array, std::uint32_t rows) {
  const std::size_t width = size_of(array.type);
  std::vector<std::uint64_t> numbers(rows);
  for (std::size_t c = 0; c < array.components; ++c) {
    std::uint64_t last = 0;
    for (std::size_t row = 0; row < rows; ++row) {
      const std::uint64_t rank = load_rank(array.type, array.bytes.data() + row * array.row_bytes() + c * width);
      numbers[row] = rank - last;
      last = rank;
    }
    put_planes(out, numbers, width);
  }
}

} // namespace

void put_header(ByteWriter& out, const FixedHeader& fixed) {
  const Header& header = fixed.header;
  const std::size_t start = out.size();
  out.put_text(kMagic);
  out.put(kVersion);
  out.put(std::uint32_t{0});
  out.put(header.base_vertex_count);
  out.put(header.base_tet_count);
  out.put(header.record_count);
  out.put(header.tet_count);
  out.put(header.block_count);
  out.put(fixed.array_count);
  out.put(fixed.version_count);
  out.put(static_cast<std::uint16_t>(fixed.records_per_block));
  out.put(static_cast<std::uint8_t>(header.position_type));
  for (const Precision& precision : fixed.position_precisions)
    out.put(precision.byte());
  out.put(static_cast<std::uint16_t>((header.has_squared_errors ? kHasSquaredErrors : 0) |
                                     (header.overlaps_itself ? kOverlapsItself : 0)));
  put_box(out, header.box_min, header.box_max);
  out.put(header.diagonal);
  out.put(header.volume);
  out.put(hash_of(std::span(out.bytes()).subspan(start)));
}

void put_footer(ByteWriter& out, const Footer& footer) {
  out.put(footer.directory_offset);
  out.put(footer.section_count);
  out.put(std::uint32_t{0});
  out.put(footer.directory_hash);
  out.put(footer.file_bytes);
  out.put_text(kEndMagic);
}

void put_directory(ByteWriter& out, const std::vector<Section>& sections) {
  for (const Section& section : sections) {
    out.put(section.kind);
    out.put(section.flags);
    out.put(section.offset);
    out.put(section.stored_bytes);
    out.put(section.raw_bytes);
    out.put(section.hash);
  }
}

void put_arrays(ByteWriter& out, const Header& header, const std::vector<Precisions>& precisions) {
  for (std::size_t i = 0; i < header.arrays.size(); ++i) {
    const ArrayInfo& info = header.arrays[i];
    out.put_varint(info.name.size());
    out.put_text(info.name);
    out.put(static_cast<std::uint8_t>(info.type));
    out.put_varint(info.components);
    out.put(static_cast<std::uint8_t>(info.governing ? 1 : 0));
    out.put(info.range);
    for (const Precision& precision : precisions[i + 1])
      out.put(precision.byte());
  }
}

void put_table(ByteWriter& out, const Header& header, const std::vector<TableRow>& rows) {
  const BoxGrid grid(header.box_min, header.box_max);
  for (const TableRow& row : rows) {
    out.put_varint(row.info.stored_bytes);
    out.put_varint(row.info.record_count);
    out.put_varint(row.version_count);
    out.put(row.hash);
    for (std::size_t axis = 0; axis < 3; ++axis)
      out.put(grid.below(axis, row.info.box_min[axis]));
    for (std::size_t axis = 0; axis < 3; ++axis)
      out.put(grid.above(axis, row.info.box_max[axis]));
    for (const ErrorCode16 code : row.info.max_error)
      out.put(code);
    for (const ErrorCode16 code : row.info.max_own)
      out.put(code);
    out.put(row.info.max_order);
    for (const double sum : row.info.squared_error)
      out.put(sum);
    out.put_varint(row.info.needs.size());
    std::uint32_t next = 0;
    for (const std::uint32_t needed : row.info.needs) {
      out.put_varint(needed - next);
      next = needed + 1;
    }
  }
}

void put_base(ByteWriter& out, const PointArray& positions, const std::vector<PointArray>& arrays,
              std::uint32_t vertex_count, const std::vector<Tet>& tets) {
  put_base_array(out, positions, vertex_count);
  for (const PointArray& array : arrays)
    put_base_array(out, array, vertex_count);
  std::vector<std::uint64_t> numbers(tets.size());
  for (std::size_t corner = 0; corner < 4; ++corner) {
    std::uint32_t last = 0;
    for (std::size_t t = 0; t < tets.size(); ++t) {
      numbers[t] = tets[t][corner].index() - (corner == 0 ? last : tets[t][0].index());
      last = tets[t][0].index();
    }
    put_planes(out, numbers, 4);
  }
}

void put_runs(ByteWriter& out, std::span<const std::uint32_t> generations) {
  std::uint64_t next = 0;
  for (std::size_t i = 0; i < generations.size();) {
    std::size_t end = i;
    while (end < generations.size() && generations[end] == generations[i])
      ++end;
    out.put_varint(generations[i] - next);
    out.put_varint(end - i);
    next = std::uint64_t{generations[i]} + 1;
    i = end;
  }
}

void put_others(ByteWriter& out, std::uint32_t block, std::span<const BlockInfo> blocks, const OtherParents& others) {
  const BlockInfo& info = blocks[block];
  out.put_varint(others.records.size());
  std::uint32_t next = info.first_record;
  for (std::size_t i = 0; i < others.records.size(); ++i) {
    out.put_varint(others.records[i].index() - next);
    next = others.records[i].index() + 1;
    out.put_varint(others.begin[i + 1] - others.begin[i]);
    for (std::uint32_t k = others.begin[i]; k < others.begin[i + 1]; ++k) {
      const std::uint32_t parent = others.parents[k].index();
      const auto holds = [&](const BlockInfo& home) {
        return parent >= home.first_record && parent - home.first_record < home.record_count;
      };
      const auto place = std::find_if(info.needs.begin(), info.needs.end(),
                                      [&](std::uint32_t needed) { return holds(blocks[needed]); });
      out.put_varint(holds(info) ? 0 : static_cast<std::uint64_t>(place - info.needs.begin()) + 1);
      out.put_varint(parent - (holds(info) ? info : blocks[*place]).first_record);
    }
  }
}

} // namespace ptet::file
