#include "formats/ptet/reader.hpp"

#include "formats/ptet/layout.hpp"
#include "formats/ptet/record_codec.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace ptet::file {

/// What decoding takes and the public face does not show.
struct Reader::Decoding {
  FixedHeader fixed;
  std::vector<DecimalDigits> digits;
  std::vector<TableRow> rows;
  Section base;
  InitialProbabilities initial;
  std::vector<std::uint32_t> block_of; ///< by record
  std::optional<Schema> schema;
  std::optional<RecordCodec> codec;
};

namespace {

[[noreturn]] void fail_file(const std::string& what, std::uint64_t offset) {
  throw Error(ErrorCode::kCorruptFile, "the file is corrupt: " + what, offset);
}

const Section& find_section(const std::vector<Section>& sections, SectionKind kind, std::uint64_t offset) {
  const auto is_wanted = [&](const Section& section) { return section.kind == static_cast<std::uint32_t>(kind); };
  const auto found = std::find_if(sections.begin(), sections.end(), is_wanted);
  if (found == sections.end() || std::find_if(found + 1, sections.end(), is_wanted) != sections.end()) {
    fail_file(std::string("it must have one ") + name_of(kind), offset);
  }
  return *found;
}

/// Calls `f`; what it says of a corrupt file gets a place in the file if it has none.
template <class F>
decltype(auto) at_offset(std::uint64_t offset, F&& f) {
  try {
    return f();
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kCorruptFile || error.byte_offset()) throw;
    throw Error(error.code(), error.what(), offset);
  }
}

/// A block that is being decoded.
struct OpenBlock {
  std::uint32_t block;
  OtherParents others;
  BlockState state;
  RangeDecoder decoder;
  std::uint64_t versions = 0;
  Point least, greatest;
};

/// The records of one block in one generation.
struct Run {
  std::uint32_t generation;
  std::uint32_t open_block; ///< index into the open blocks, ascending with the block
  std::uint32_t first_record, last_record;
};

} // namespace

Reader::Reader(std::unique_ptr<Source> source) : source_(std::move(source)), decoding_(std::make_unique<Decoding>()) {
  const std::uint64_t size = source_->size();
  if (size < kHeaderBytes + kFooterBytes) {
    throw Error(ErrorCode::kCorruptFile, "the file is too short to be a .ptet file: " + std::to_string(size) + " bytes",
                size);
  }
  const auto header_bytes = fetch(0, kHeaderBytes);
  ByteReader header_reader(header_bytes, "header", 0);
  // Magic and version come before the hash: a file of another kind is not called corrupt.
  Decoding& d = *decoding_;
  d.fixed = parse_header(header_reader);
  const auto hashed = std::span(header_bytes).first(kHeaderBytes - 8);
  ByteReader header_hash(std::span{header_bytes}.last(8), "header", kHeaderBytes - 8);
  if (header_hash.get<std::uint64_t>("hash") != hash_of(hashed)) fail_file("the header's hash does not match", 0);

  const auto footer_bytes = fetch(size - kFooterBytes, kFooterBytes);
  ByteReader footer_reader(footer_bytes, "footer", size - kFooterBytes);
  const Footer footer = parse_footer(footer_reader);
  if (footer.file_bytes != size) {
    fail_file("it has " + std::to_string(size) + " bytes and should have " + std::to_string(footer.file_bytes), size);
  }
  const std::uint64_t directory_bytes = footer.section_count * kSectionBytes;
  if (directory_bytes > size - kHeaderBytes - kFooterBytes ||
      footer.directory_offset != size - kFooterBytes - directory_bytes) {
    fail_file("the directory is not before the footer", size - kFooterBytes);
  }
  const auto directory = fetch(footer.directory_offset, directory_bytes);
  if (hash_of(directory) != footer.directory_hash) {
    fail_file("the directory's hash does not match", footer.directory_offset);
  }
  ByteReader directory_reader(directory, "directory", footer.directory_offset);
  const auto sections = parse_directory(directory_reader, footer.section_count);
  const std::uint64_t end = sections.empty() ? kHeaderBytes : sections.back().offset + sections.back().stored_bytes;
  if (end != footer.directory_offset) fail_file("the sections do not end where the directory begins", end);

  const auto section = [&](SectionKind kind) -> const Section& {
    return find_section(sections, kind, footer.directory_offset);
  };
  const auto content = [&](SectionKind kind) {
    return expand(section(kind), fetch(section(kind).offset, section(kind).stored_bytes));
  };
  const auto in_section = [&](SectionKind kind, const std::vector<std::byte>& bytes) {
    return ByteReader(bytes, name_of(kind), section(kind).offset,
                      section(kind).stored_bytes != section(kind).raw_bytes);
  };
  const auto array_bytes = content(SectionKind::kArrays);
  auto arrays = in_section(SectionKind::kArrays, array_bytes);
  d.digits = parse_arrays(arrays, d.fixed);
  header_ = d.fixed.header;
  d.schema.emplace(header_, d.digits);
  if (section(SectionKind::kModel).raw_bytes != d.schema->context_count()) {
    fail_file("the model section does not fit the arrays", section(SectionKind::kModel).offset);
  }
  for (const std::byte byte : content(SectionKind::kModel))
    d.initial.push_back(static_cast<std::uint8_t>(byte));
  d.base = section(SectionKind::kBase);
  // Both factors are below 2^32: no overflow.
  const std::uint64_t base_values = header_.base_vertex_count * static_cast<std::uint64_t>(vertex_bytes(header_));
  if (base_values > d.base.raw_bytes || d.base.raw_bytes - base_values != std::uint64_t{16} * header_.base_tet_count) {
    fail_file("the base section does not fit the header's counts", d.base.offset);
  }
  const Section& blocks = section(SectionKind::kBlocks);
  if (blocks.raw_bytes != blocks.stored_bytes || blocks.hash != 0) {
    fail_file("the blocks' row of the directory is invalid", blocks.offset);
  }
  const auto table_bytes = content(SectionKind::kTable);
  auto table = in_section(SectionKind::kTable, table_bytes);
  d.rows = parse_table(table, d.fixed, blocks);
  for (const TableRow& row : d.rows)
    blocks_.push_back(row.info);
  const auto manifest_bytes = content(SectionKind::kManifest);
  auto manifest = in_section(SectionKind::kManifest, manifest_bytes);
  manifest_ = parse_manifest(manifest);
}

Reader::~Reader() = default;
Reader::Reader(Reader&&) noexcept = default;
Reader& Reader::operator=(Reader&&) noexcept = default;

std::vector<std::byte> Reader::fetch(std::uint64_t offset, std::uint64_t count) {
  std::vector<std::byte> bytes(count);
  source_->read(offset, bytes);
  bytes_read_ += count;
  return bytes;
}

Content Reader::read_base() {
  const Decoding& d = *decoding_;
  const auto bytes = expand(d.base, fetch(d.base.offset, d.base.stored_bytes));
  ByteReader in(bytes, name_of(SectionKind::kBase), d.base.offset, true);
  const std::size_t vertices = std::size_t{header_.base_vertex_count} + header_.record_count;
  PointArray positions{"", header_.position_type, 3, {}};
  positions.resize(vertices);
  std::vector<PointArray> arrays;
  for (const ArrayInfo& info : header_.arrays) {
    arrays.push_back({info.name, info.type, info.components, {}});
    arrays.back().resize(vertices);
  }
  auto tets = parse_base(in, header_, positions, arrays);
  const std::uint32_t codes = d.schema->code_count();
  const std::size_t errors = std::size_t{header_.record_count} * codes;
  return {at_offset(d.base.offset,
                    [&] { return Refinement(std::move(tets), header_.base_vertex_count, header_.record_count); }),
          std::move(positions),
          std::move(arrays),
          codes,
          std::vector<ErrorCode16>(errors),
          std::vector<ErrorCode16>(errors),
          std::vector<OrderCode>(header_.record_count),
          std::vector<SquaredErrorCode>(header_.has_squared_errors ? errors - header_.record_count : 0),
          std::vector<std::uint32_t>(header_.record_count),
          std::vector<char>(header_.block_count)};
}

// The promises that cuts rest on: parents come earlier, lie in blocks that the table names, and have no smaller error.
// That they have no smaller order code is checked as codes are read.
void Reader::check_record(RecordId r, std::uint32_t block, const Content& content) const {
  const std::size_t codes = content.errors_per_record;
  const auto& needs = blocks_[block].needs;
  for (const RecordId parent : content.refinement.parents(r)) {
    if (content.generation[parent.index()] >= content.generation[r.index()]) {
      fail_record(r, "it depends on a record that does not come before it");
    }
    const std::uint32_t home = decoding_->block_of[parent.index()];
    if (home != block && !std::binary_search(needs.begin(), needs.end(), home)) {
      fail_record(r, "it depends on a block that the table does not name");
    }
    for (std::size_t i = 0; i < codes; ++i) {
      if (content.monotone[parent.index() * codes + i] < content.monotone[r.index() * codes + i]) {
        fail_record(r, "its errors are greater than those of a record it depends on");
      }
    }
  }
}

void Reader::check_block(std::uint32_t block, const Content& content) const {
  const BlockInfo& info = blocks_[block];
  std::vector<ErrorCode16> greatest(content.errors_per_record);
  OrderCode greatest_order = 0;
  for (std::size_t r = info.first_record; r < info.first_record + info.record_count; ++r) {
    for (std::size_t i = 0; i < greatest.size(); ++i) {
      greatest[i] = std::max(greatest[i], content.monotone[r * greatest.size() + i]);
    }
    greatest_order = std::max(greatest_order, content.order[r]);
  }
  if (greatest != info.max_error) fail_file("a block's errors are not those of the table", info.offset);
  if (greatest_order != info.max_order) fail_file("a block's order codes are not those of the table", info.offset);
  // The table's sums are of numbers that the codes stand for, rounded up.
  for (std::size_t i = 0; i < info.squared_error.size(); ++i) {
    double least = 0, most = 0, slack = 0;
    for (std::size_t r = info.first_record; r < info.first_record + info.record_count; ++r) {
      const SquaredErrorCode code = content.squared_error[r * info.squared_error.size() + i];
      const double upper = decode_squared_error(code);
      const double lower = decode_squared_error(static_cast<SquaredErrorCode>(code - 1));
      least += lower;
      most += upper;
      slack += 0x1p-40 * std::max(std::fabs(lower), std::fabs(upper));
    }
    if (info.squared_error[i] < least - slack || info.squared_error[i] > most + slack)
      fail_file("a block's squared errors are not those of the table", info.offset);
  }
}

void Reader::load(std::span<const std::uint32_t> blocks, Content& content) {
  Decoding& d = *decoding_;
  std::vector<std::uint32_t> wanted(blocks.begin(), blocks.end());
  std::sort(wanted.begin(), wanted.end());
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  if (!wanted.empty() && wanted.back() >= blocks_.size()) {
    throw Error(ErrorCode::kBadArgument, "there is no block " + std::to_string(wanted.back()));
  }
  std::erase_if(wanted, [&](std::uint32_t block) { return content.block_loaded[block] != 0; });
  if (wanted.empty()) return;
  if (!d.codec) {
    d.codec.emplace(*d.schema, blocks_, std::size_t{header_.base_vertex_count} + header_.record_count);
    for (std::uint32_t block = 0; block < blocks_.size(); ++block)
      d.block_of.insert(d.block_of.end(), blocks_[block].record_count, block);
  }

  std::vector<OpenBlock> open;
  open.reserve(wanted.size());
  std::vector<Run> runs;
  for (const std::uint32_t block : wanted) {
    const BlockInfo& info = blocks_[block];
    auto bytes = fetch(info.offset, info.stored_bytes);
    if (hash_of(bytes) != d.rows[block].hash) fail_file("the hash of a block does not match", info.offset);
    ByteReader in(bytes, "block", info.offset);
    const auto generations = parse_runs(in, info.record_count);
    std::copy(generations.begin(), generations.end(), content.generation.begin() + info.first_record);
    for (std::uint32_t i = 0; i < info.record_count; ++i) {
      if (i == 0 || generations[i] != generations[i - 1]) {
        runs.push_back({generations[i], static_cast<std::uint32_t>(open.size()), info.first_record + i, 0});
      }
      runs.back().last_record = info.first_record + i;
    }
    OtherParents others = parse_others(in, block, blocks_);
    const std::size_t start = in.position();
    open.push_back({block,
                    std::move(others),
                    BlockState(block, info.needs.size(), d.schema->code_count()),
                    RangeDecoder(d.initial, std::move(bytes), start),
                    0,
                    {},
                    {}});
    open.back().least.fill(std::numeric_limits<double>::infinity());
    open.back().greatest.fill(-std::numeric_limits<double>::infinity());
  }
  std::sort(runs.begin(), runs.end(), [](const Run& a, const Run& b) {
    return std::pair(a.generation, a.open_block) < std::pair(b.generation, b.open_block);
  });

  for (const Run& run : runs) {
    OpenBlock& block = open[run.open_block];
    const std::uint32_t most_versions = d.rows[block.block].version_count;
    at_offset(blocks_[block.block].offset, [&] {
      for (std::uint32_t index = run.first_record; index <= run.last_record; ++index) {
        const RecordId r{index};
        d.codec->code(block.decoder, block.state, content, r, NothingKnown{}, block.others.of(r));
        block.versions += content.refinement.fine_count(r);
        if (block.versions > most_versions) fail_record(r, "its block makes more tets than the table says");
        check_record(r, block.block, content);
        d.codec->extend_by_star(block.least, block.greatest);
      }
    });
  }
  for (const OpenBlock& block : open) {
    const BlockInfo& info = blocks_[block.block];
    if (block.versions != d.rows[block.block].version_count) {
      fail_file("a block makes fewer tets than the table says", info.offset);
    }
    if (block.least != info.box_min || block.greatest != info.box_max) {
      fail_file("a block's bounding box is not that of the table", info.offset);
    }
    check_block(block.block, content);
    content.block_loaded[block.block] = 1;
  }
  if (content.refinement.applied_count() == header_.record_count) {
    std::uint64_t tets = header_.base_tet_count;
    for (std::uint32_t r = 0; r < header_.record_count; ++r)
      tets += content.refinement.added_tet_count(RecordId{r});
    if (tets != header_.tet_count) fail_file("the full mesh does not have the number of tets of the header", 0);
    d.codec.reset();
    std::vector<std::uint32_t>().swap(d.block_of);
  }
}

} // namespace ptet::file
