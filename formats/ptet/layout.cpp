#include "formats/ptet/layout.hpp"

#include "formats/ptet/archive.hpp"
#include "formats/ptet/box_grid.hpp"
#include "formats/ptet/planes.hpp"

#include <algorithm>
#include <cmath>

#include <xxhash.h>
#include <zstd.h>

namespace ptet::file {
namespace {

std::uint64_t product(std::uint64_t a, std::uint64_t b) { // counts below 2^32, or saturated
  return a != 0 && b > ~std::uint64_t{0} / a ? ~std::uint64_t{0} : a * b;
}

double get_finite(ByteReader& in, std::string_view name) {
  const auto value = in.get<double>(name);
  if (!std::isfinite(value)) in.fail(std::string(name) + " is not finite");
  return value;
}

constexpr std::array<const char*, 3> kBoxMin = {"box_min x", "box_min y", "box_min z"};
constexpr std::array<const char*, 3> kBoxMax = {"box_max x", "box_max y", "box_max z"};

void get_box(ByteReader& in, Point& least, Point& greatest) {
  for (std::size_t i = 0; i < 3; ++i)
    least[i] = get_finite(in, kBoxMin[i]);
  for (std::size_t i = 0; i < 3; ++i)
    greatest[i] = get_finite(in, kBoxMax[i]);
  for (std::size_t i = 0; i < 3; ++i) {
    if (least[i] > greatest[i]) in.violate("a bounding box ends before it begins");
    if (!std::isfinite(greatest[i] - least[i])) in.fail("a side of the bounding box is not finite");
  }
}

void get_box_on_grid(ByteReader& in, const BoxGrid& grid, BlockInfo& info) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    info.box_min[axis] = grid.at(axis, in.get<std::uint16_t>(kBoxMin[axis]));
  for (std::size_t axis = 0; axis < 3; ++axis)
    info.box_max[axis] = grid.at(axis, in.get<std::uint16_t>(kBoxMax[axis]));
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (info.box_min[axis] > info.box_max[axis]) in.violate("a block's bounding box ends before it begins");
}

template <class T>
void expect(ByteReader& in, std::string_view name, T wanted) {
  const auto value = in.get<T>(name);
  if (value != wanted)
    in.violate(std::string(name) + " is " + std::to_string(value) + ", not " + std::to_string(wanted));
}

ScalarType get_type(ByteReader& in, std::string_view name) {
  const auto type = in.get<std::uint8_t>(name);
  if (type > static_cast<std::uint8_t>(ScalarType::kFloat64)) in.fail(std::string(name) + " is unknown");
  return static_cast<ScalarType>(type);
}

Precision get_precision(ByteReader& in, ScalarType type) {
  const auto precision = Precision::of_byte(type, in.get<std::uint8_t>("precision"));
  if (!precision) in.fail("a precision is out of range");
  return *precision;
}

void parse_base_array(ByteReader& in, std::size_t rows, PointArray& array, const std::string& name) {
  const std::size_t width = size_of(array.type);
  for (std::size_t c = 0; c < array.components; ++c) {
    const Planes planes(in, rows, width, name);
    std::uint64_t rank = 0;
    for (std::size_t row = 0; row < rows; ++row) {
      rank += planes.at(row);
      store_rank(array.type, rank, array.bytes.data() + row * array.row_bytes() + c * width);
    }
  }
}

} // namespace

const char* name_of(SectionKind kind) {
  switch (kind) {
  case SectionKind::kArrays: return "arrays section";
  case SectionKind::kModel: return "model section";
  case SectionKind::kBase: return "base section";
  case SectionKind::kBlocks: return "blocks";
  case SectionKind::kManifest: return "manifest section";
  case SectionKind::kTable: return "table section";
  case SectionKind::kInputOrder: return "input order section";
  }
  return "unknown section";
}

std::uint32_t flags_of(SectionKind kind) {
  return kind == SectionKind::kInputOrder ? 0 : kMandatory;
}

std::uint64_t hash_of(std::span<const std::byte> bytes) {
  return XXH64(bytes.data(), bytes.size(), 0);
}

std::vector<std::byte> expand(const Section& section, std::vector<std::byte> stored, const Violations* violations) {
  const std::string name = name_of(static_cast<SectionKind>(section.kind));
  if (hash_of(stored) != section.hash) {
    const std::string what = "the " + name + " is corrupt: its hash does not match";
    if (violations == nullptr || !*violations) throw Error(ErrorCode::kCorruptFile, what, section.offset);
    (*violations)({what, section.offset, {}, {}, {}});
  }
  if (!section.is_compressed()) return stored;
  std::vector<std::byte> raw(section.raw_bytes);
  const std::size_t size = ZSTD_decompress(raw.data(), raw.size(), stored.data(), stored.size());
  // One frame only: ZSTD_decompress would go on with a second one.
  if (ZSTD_isError(size) != 0 || size != raw.size() ||
      ZSTD_findFrameCompressedSize(stored.data(), stored.size()) != stored.size()) {
    throw Error(ErrorCode::kCorruptFile, "the " + name + " is corrupt: it does not decompress to its size",
                section.offset);
  }
  return raw;
}

FixedHeader parse_header(ByteReader& in) {
  if (const std::uint64_t begin = in.offset(); in.get_text(kMagic.size(), "magic") != kMagic)
    throw Error(ErrorCode::kCorruptFile, "this is not a .ptet file", begin);
  if (const auto version = in.get<std::uint32_t>("version"); version != kVersion) {
    in.fail("version " + std::to_string(version) + " is unknown; this program reads version 1");
  }
  expect<std::uint32_t>(in, "reserved", 0);
  FixedHeader fixed;
  Header& header = fixed.header;
  header.base_vertex_count = in.get<std::uint32_t>("base_vertex_count");
  header.base_tet_count = in.get<std::uint32_t>("base_tet_count");
  header.record_count = in.get<std::uint32_t>("record_count");
  header.tet_count = in.get<std::uint32_t>("tet_count");
  header.block_count = in.get<std::uint32_t>("block_count");
  fixed.array_count = in.get<std::uint32_t>("array_count");
  fixed.version_count = in.get<std::uint64_t>("version_count");
  fixed.records_per_block = in.get<std::uint16_t>("records_per_block");
  header.position_type = get_type(in, "position_type");
  for (int axis = 0; axis < 3; ++axis)
    fixed.position_precisions.push_back(get_precision(in, header.position_type));
  const auto flags = in.get<std::uint16_t>("flags");
  if ((flags & ~(kHasSquaredErrors | kOverlapsItself)) != 0) in.violate("a reserved flag is set");
  header.has_squared_errors = (flags & kHasSquaredErrors) != 0;
  header.overlaps_itself = (flags & kOverlapsItself) != 0;
  get_box(in, header.box_min, header.box_max);
  header.diagonal = get_finite(in, "diagonal");
  if (header.diagonal < 0) in.fail("diagonal is negative");
  header.volume = get_finite(in, "volume");
  if (header.volume < 0 || (header.has_squared_errors && header.volume == 0)) in.fail("volume is not positive");
  // The hash over what came before is the header's last field; the reader has checked it.
  static_cast<void>(in.get<std::uint64_t>("header hash"));

  if (fixed.records_per_block == 0 || fixed.records_per_block > kMaxRecordsPerBlock) {
    in.fail("records_per_block is out of range");
  }
  if (fixed.array_count > kMaxArrays) in.fail("array_count is out of range");
  if (header.record_count > Refinement::kMaxRecords) in.fail("record_count is out of range");
  if (std::uint64_t{header.base_vertex_count} + header.record_count >= 0xFFFFFFFE) in.fail("too many vertices");
  if (fixed.version_count >= 0xFFFFFFFE) in.fail("version_count is out of range");
  if (header.tet_count < header.base_tet_count || header.tet_count > header.base_tet_count + fixed.version_count) {
    in.fail("tet_count does not fit the other counts");
  }
  return fixed;
}

Footer parse_footer(ByteReader& in) {
  Footer footer;
  footer.directory_offset = in.get<std::uint64_t>("directory_offset");
  footer.section_count = in.get<std::uint32_t>("section_count");
  const auto reserved = in.get<std::uint32_t>("reserved");
  footer.directory_hash = in.get<std::uint64_t>("directory_hash");
  footer.file_bytes = in.get<std::uint64_t>("file_bytes");
  if (in.get_text(kEndMagic.size(), "end magic") != kEndMagic)
    in.fail("it does not end as it should: the file is cut short, or something was added at its end");
  if (reserved != 0) in.violate("reserved is " + std::to_string(reserved) + ", not 0");
  if (footer.section_count > kMaxSections) in.fail("section_count is out of range");
  return footer;
}

std::vector<Section> parse_directory(ByteReader& in, std::uint32_t count) {
  std::vector<Section> sections(count);
  std::uint64_t expected = kHeaderBytes;
  for (Section& section : sections) {
    section.kind = in.get<std::uint32_t>("kind");
    section.flags = in.get<std::uint32_t>("flags");
    section.offset = in.get<std::uint64_t>("offset");
    section.stored_bytes = in.get<std::uint64_t>("stored_bytes");
    section.raw_bytes = in.get<std::uint64_t>("raw_bytes");
    section.hash = in.get<std::uint64_t>("hash");
    if ((section.flags & ~kMandatory) != 0) in.violate("a reserved flag of a section is set");
    if (section.offset != expected || section.stored_bytes > ~std::uint64_t{0} - expected) {
      in.fail("a section does not begin where the one before ends");
    }
    expected += section.stored_bytes;
    const std::uint32_t flags = flags_of(static_cast<SectionKind>(section.kind));
    const bool known = section.kind >= 1 && section.kind <= static_cast<std::uint32_t>(SectionKind::kInputOrder);
    if (!known && (section.flags & kMandatory) != 0) {
      in.violate("section " + std::to_string(section.kind) + " is mandatory but unknown to this program");
    }
    if (known && (section.flags & kMandatory) < flags) in.violate("a mandatory section is not marked so");
    if (known && (section.flags & kMandatory) > flags) in.violate("a section is marked as mandatory that is not");
    if (section.raw_bytes < section.stored_bytes || section.raw_bytes > product(section.stored_bytes, kMaxExpansion)) {
      in.fail("a section's raw size is out of range");
    }
  }
  in.finish();
  return sections;
}

std::vector<Precisions> parse_arrays(ByteReader& in, FixedHeader& fixed) {
  fixed.header.arrays.clear();
  std::vector<Precisions> precisions{fixed.position_precisions};
  for (std::uint32_t i = 0; i < fixed.array_count; ++i) {
    ArrayInfo info;
    info.name = in.get_text(in.get_count("length of name", in.remaining()), "name");
    info.type = get_type(in, "type");
    info.components = static_cast<std::uint32_t>(in.get_count("components", kMostComponents));
    if (info.components == 0) in.fail("an array has no component");
    const auto governing = in.get<std::uint8_t>("governing");
    if (governing > 1) in.violate("a reserved bit of governing is set");
    info.governing = governing != 0;
    info.range = get_finite(in, "range");
    if (info.range < 0) in.fail("range is negative");
    auto& array_precisions = precisions.emplace_back();
    for (std::uint32_t c = 0; c < info.components; ++c)
      array_precisions.push_back(get_precision(in, info.type));
    fixed.header.arrays.push_back(std::move(info));
  }
  in.finish();
  return precisions;
}

std::vector<TableRow> parse_table(ByteReader& in, const FixedHeader& fixed, const Section& blocks) {
  const Header& header = fixed.header;
  const auto codes =
      1 + static_cast<std::size_t>(std::count_if(header.arrays.begin(), header.arrays.end(),
                                                 [](const ArrayInfo& array) { return array.governing; }));
  const std::size_t squared = header.has_squared_errors ? codes : 0;
  const std::size_t least_row_bytes = 3 + 8 + 12 + 4 * codes + 2 + 8 * squared + 1;
  if (header.block_count > in.remaining() / least_row_bytes) in.fail("it is too short for its number of blocks");
  std::vector<TableRow> rows(header.block_count);
  const BoxGrid grid(header.box_min, header.box_max);
  std::uint64_t offset = blocks.offset, records = 0, versions = 0;
  const std::uint64_t end = blocks.offset + blocks.stored_bytes;
  for (std::uint32_t b = 0; b < header.block_count; ++b) {
    TableRow& row = rows[b];
    BlockInfo& info = row.info;
    info.offset = offset;
    info.stored_bytes = in.get_count("stored_bytes", end - offset);
    offset += info.stored_bytes;
    info.first_record = static_cast<std::uint32_t>(records);
    info.record_count = static_cast<std::uint32_t>(in.get_count("record_count", fixed.records_per_block));
    records += info.record_count;
    row.version_count = static_cast<std::uint32_t>(
        in.get_count("version_count", std::min<std::uint64_t>(product(info.stored_bytes, kMaxVersionsPerByte),
                                                              fixed.version_count - versions)));
    versions += row.version_count;
    if (info.record_count == 0 || row.version_count / 4 < info.record_count) {
      in.fail("a block has too few records or versions");
    }
    if (product(info.record_count, vertex_bytes(header)) > product(info.stored_bytes, kMaxValueBytesPerByte)) {
      in.fail("a block has too few bytes for its records");
    }
    row.hash = in.get<std::uint64_t>("hash");
    get_box_on_grid(in, grid, info);
    for (std::size_t i = 0; i < codes; ++i) {
      info.max_error.push_back(in.get<std::uint16_t>("max_error"));
      if (info.max_error.back() > kMaxErrorCode) in.violate("max_error is out of range");
    }
    for (std::size_t i = 0; i < codes; ++i) {
      info.max_own.push_back(in.get<std::uint16_t>("max_own"));
      if (info.max_own.back() > info.max_error[i]) in.violate("max_own is greater than max_error");
    }
    info.max_order = in.get<OrderCode>("max_order");
    if (info.max_order > kMaxOrderCode) in.violate("max_order is out of range");
    for (std::size_t i = 0; i < squared; ++i) {
      info.squared_error.push_back(in.get<double>("squared_error"));
      if (!(std::fabs(info.squared_error.back()) <= kMaxSquaredErrorSum)) in.violate("squared_error is out of range");
    }
    info.needs.resize(
        in.get_count("number of needed blocks", std::min<std::uint64_t>(header.block_count - 1, in.remaining())));
    std::uint64_t next = 0;
    for (std::uint32_t& needed : info.needs) {
      next += in.get_count("needed block", header.block_count);
      if (next >= header.block_count || next == b) in.fail("a needed block is out of range");
      needed = static_cast<std::uint32_t>(next++);
    }
  }
  if (records != header.record_count || versions != fixed.version_count || offset != end) {
    in.fail("the blocks do not add up to the header's counts");
  }
  in.finish();
  return rows;
}

Manifest parse_manifest(ByteReader& in) {
  Manifest manifest;
  InputArchive archive(in);
  archive& manifest;
  in.finish();
  return manifest;
}

void put_manifest(ByteWriter& out, const Manifest& manifest) {
  OutputArchive archive(out);
  archive& manifest;
}

std::size_t vertex_bytes(const Header& header) {
  std::size_t bytes = 3 * size_of(header.position_type);
  for (const ArrayInfo& array : header.arrays)
    bytes += array.components * size_of(array.type);
  return bytes;
}

std::vector<Tet> parse_base(ByteReader& in, const Header& header, PointArray& positions,
                            std::vector<PointArray>& arrays) {
  parse_base_array(in, header.base_vertex_count, positions, "positions");
  for (PointArray& array : arrays)
    parse_base_array(in, header.base_vertex_count, array, "array " + array.name);
  std::array<std::optional<Planes>, 4> planes;
  for (auto& column : planes)
    column.emplace(in, header.base_tet_count, 4, "tets");
  std::vector<Tet> tets(header.base_tet_count);
  std::uint32_t first = 0;
  for (std::size_t t = 0; t < tets.size(); ++t) {
    first += static_cast<std::uint32_t>(planes[0]->at(t));
    tets[t][0] = VertexId{first};
    for (std::size_t i = 1; i < 4; ++i)
      tets[t][i] = VertexId{first + static_cast<std::uint32_t>(planes[i]->at(t))};
  }
  in.finish();
  return tets;
}

std::vector<std::uint32_t> parse_runs(ByteReader& in, std::uint32_t record_count, std::uint32_t file_records) {
  std::vector<std::uint32_t> generations;
  std::uint64_t generation = 0;
  while (generations.size() < record_count) {
    generation += in.get_count("generation", file_records - generation) + (generations.empty() ? 0 : 1);
    const std::uint64_t count = in.get_count("records of a generation", record_count - generations.size());
    if (count == 0) in.fail("a generation has no record");
    // Bounded by the number of records, so that one may sort by counting.
    if (generation >= file_records) in.fail("generation is out of range");
    generations.insert(generations.end(), count, static_cast<std::uint32_t>(generation));
  }
  return generations;
}

std::span<const RecordId> OtherParents::of(RecordId r) const {
  const auto found = std::lower_bound(records.begin(), records.end(), r);
  if (found == records.end() || *found != r) return {};
  const auto i = static_cast<std::size_t>(found - records.begin());
  return {parents.data() + begin[i], parents.data() + begin[i + 1]};
}

OtherParents parse_others(ByteReader& in, std::uint32_t block, std::span<const BlockInfo> blocks) {
  const BlockInfo& info = blocks[block];
  OtherParents others;
  const std::uint64_t count = in.get_count("records with other parents", info.record_count);
  std::uint64_t next = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    next += in.get_count("record", info.record_count);
    if (next >= info.record_count) in.fail("a record with other parents is not of the block");
    others.records.emplace_back(info.first_record + static_cast<std::uint32_t>(next++));
    // One of these takes two bytes at least: that bounds how many there may be before anything is allocated.
    const std::uint64_t parents = in.get_count("number of other parents", in.remaining() / 2);
    if (parents == 0) in.fail("a record with other parents has none");
    for (std::uint64_t k = 0; k < parents; ++k) {
      const std::uint64_t source = in.get_count("block of the parent", info.needs.size());
      const BlockInfo& home = source == 0 ? info : blocks[info.needs[source - 1]];
      const std::uint64_t index = in.get_count("parent", home.record_count - std::uint64_t{1});
      const RecordId parent{home.first_record + static_cast<std::uint32_t>(index)};
      if (k > 0 && parent <= others.parents.back()) in.fail("other parents are out of order");
      others.parents.push_back(parent);
    }
    others.begin.push_back(static_cast<std::uint32_t>(others.parents.size()));
  }
  return others;
}

} // namespace ptet::file
