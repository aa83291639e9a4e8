#include "formats/ptet/reader.hpp"

#include "formats/ptet/layout.hpp"
#include "formats/ptet/record_codec.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace ptet::file {

/// What decoding takes and the public face does not show.
struct Reader::Decoding {
  Decoding(std::shared_ptr<ByteSource> source, const OpenOptions& options, Violations told)
      : reader(std::move(source), options.max_gap), limits(options.limits), violations(std::move(told)) {
    // What is within it must not wrap around where addresses have 32 bits.
    limits.max_bytes = std::min<std::uint64_t>(limits.max_bytes, std::numeric_limits<std::size_t>::max() / 2);
  }

  RangeReader reader;
  Limits limits;
  Violations violations;
  std::uint64_t claimed = 0; ///< of Limits::max_bytes
  FixedHeader fixed;
  std::vector<DecimalDigits> digits;
  std::vector<TableRow> rows;
  Section base;
  Section input_order;               ///< where there is one
  std::vector<std::byte> base_bytes; ///< as stored, so that the base can be had again without the source
  InitialProbabilities initial;
  std::vector<std::uint32_t> block_of; ///< by record
  std::optional<Schema> schema;
  std::optional<RecordCodec> codec;
};

namespace {

[[noreturn]] void fail_file(const std::string& what, std::uint64_t offset) {
  throw Error(ErrorCode::kCorruptFile, "the file is corrupt: " + what, offset);
}

/// Null where there is none, which only a section that is not mandatory may be.
const Section* find_section(const std::vector<Section>& sections, SectionKind kind, std::uint64_t offset) {
  const auto is_wanted = [&](const Section& section) { return section.kind == static_cast<std::uint32_t>(kind); };
  const auto found = std::find_if(sections.begin(), sections.end(), is_wanted);
  if (found == sections.end() && flags_of(kind) != kMandatory) return nullptr;
  if (found == sections.end() || std::find_if(found + 1, sections.end(), is_wanted) != sections.end()) {
    fail_file(std::string(flags_of(kind) == kMandatory ? "it must have one " : "it may have only one ") + name_of(kind),
              offset);
  }
  return &*found;
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

/// Sections read ahead in few requests.
class ReadAhead {
public:
  explicit ReadAhead(RangeReader& reader) : reader_(reader) {}

  void fetch(std::span<const ByteRange> ranges) {
    auto read = reader_.read_all(ranges);
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      if (read[i].failure) std::rethrow_exception(read[i].failure);
      parts_.push_back({ranges[i].offset, std::move(read[i].bytes)});
    }
  }
  /// Out of what was read ahead, or from the source.
  [[nodiscard]] std::vector<std::byte> get(std::uint64_t offset, std::uint64_t count) const {
    for (const Part& part : parts_) {
      if (offset < part.offset || count > part.bytes.size() || offset - part.offset > part.bytes.size() - count)
        continue;
      const auto first = part.bytes.begin() + static_cast<std::ptrdiff_t>(offset - part.offset);
      return {first, first + static_cast<std::ptrdiff_t>(count)};
    }
    return reader_.read({offset, count});
  }

private:
  struct Part {
    std::uint64_t offset;
    std::vector<std::byte> bytes;
  };
  RangeReader& reader_;
  std::vector<Part> parts_;
};

// What one element takes in memory at most, with the growth of vectors and with scratch.
constexpr std::uint64_t kBytesPerVertex = 32;        // marks of the refinement and of the codec, the values apart
constexpr std::uint64_t kBytesPerRecord = 128;       // tables by record, boxes of stars, a cut
constexpr std::uint64_t kBytesPerBaseTet = 320;      // with its ghosts, and the sorting of faces that joins them
constexpr std::uint64_t kBytesPerVersion = 64;       // corners, state, a place among the present ones, parents
constexpr std::uint64_t kBytesPerManifestByte = 128; // a byte can stand for two empty texts
constexpr std::uint64_t kBytesPerArrayByte = 256;    // and for a column
constexpr std::uint64_t kBytesPerTableByte = 24;

/// What decoding a block's next record depends on.
struct BlockCoding {
  BlockState state;
  RangeDecoder decoder;
};

/// A block that is being decoded.
struct OpenBlock {
  std::uint32_t block;
  OtherParents others;
  std::vector<std::byte> bytes;      ///< until the coding takes them
  std::size_t start = 0;             ///< of the range coder's bytes
  std::optional<BlockCoding> coding; ///< from the first run to the last
  std::uint32_t records_left = 0;
  std::uint64_t versions = 0;
  Point least{}, greatest{};
};

/// The records of one block in one generation.
struct Run {
  std::uint32_t generation;
  std::uint32_t open_block; ///< index into the open blocks, ascending with the block
  std::uint32_t first_record, last_record;
};

/// Runs that stand by block and then by generation in the order in which they are decoded: a run comes after those of
/// smaller generations in the blocks that its block needs. Any such order decodes the same. This one finishes block
/// after block as far as it can, so that most of what a record touches was touched just before.
std::vector<Run> near_ones_together(const std::vector<Run>& by_block, const std::vector<OpenBlock>& open,
                                    const std::vector<BlockInfo>& blocks) {
  constexpr std::uint32_t kNotOpen = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> open_of(blocks.size(), kNotOpen);
  for (std::uint32_t i = 0; i < open.size(); ++i)
    open_of[open[i].block] = i;
  std::vector<std::uint32_t> next(open.size()), end(open.size()); // runs of each block
  for (std::uint32_t i = 0; i < by_block.size(); ++i) {
    if (i == 0 || by_block[i].open_block != by_block[i - 1].open_block) next[by_block[i].open_block] = i;
    end[by_block[i].open_block] = i + 1;
  }
  std::vector<std::vector<std::uint32_t>> needs(open.size()); // those that may have runs left
  for (std::uint32_t i = 0; i < open.size(); ++i)
    for (const std::uint32_t needed : blocks[open[i].block].needs)
      if (open_of[needed] != kNotOpen) needs[i].push_back(open_of[needed]);

  struct Wanted {
    std::uint32_t block, below; ///< its runs of generations below
  };
  std::vector<Run> result;
  result.reserve(by_block.size());
  std::vector<Wanted> wanted;
  for (std::uint32_t first = 0; first < open.size(); ++first) {
    wanted.push_back({first, std::numeric_limits<std::uint32_t>::max()});
    while (!wanted.empty()) {
      const auto [block, below] = wanted.back();
      if (next[block] == end[block] || by_block[next[block]].generation >= below) {
        wanted.pop_back();
        continue;
      }
      // Generations fall from one wanted block to the next, so this comes to an end.
      const Run& run = by_block[next[block]];
      std::erase_if(needs[block], [&](std::uint32_t needed) { return next[needed] == end[needed]; });
      const auto waits_for = std::find_if(needs[block].begin(), needs[block].end(), [&](std::uint32_t needed) {
        return by_block[next[needed]].generation < run.generation;
      });
      if (waits_for != needs[block].end()) {
        wanted.push_back({*waits_for, run.generation});
      } else {
        result.push_back(run);
        ++next[block];
      }
    }
  }
  return result;
}

} // namespace

struct Reader::Batching {
  Reader* reader;
  std::vector<OpenBlock> open;
  std::vector<Run> runs; ///< in the order in which they are decoded
  std::size_t run = 0;   ///< the one at hand
};

Reader::Reader(std::shared_ptr<ByteSource> source, const OpenOptions& options)
    : Reader(std::move(source), options, Violations{}) {}

Reader::Reader(std::shared_ptr<ByteSource> source, const OpenOptions& options, Violations violations)
    : decoding_(std::make_unique<Decoding>(std::move(source), options, std::move(violations))) {
  Decoding& d = *decoding_;
  const std::uint64_t size = d.reader.size();
  if (size < kHeaderBytes + kFooterBytes) {
    throw Error(ErrorCode::kCorruptFile, "the file is too short to be a .ptet file: " + std::to_string(size) + " bytes",
                size);
  }
  ReadAhead ahead(d.reader);
  const auto header_bytes = ahead.get(0, kHeaderBytes);
  ByteReader header_reader(header_bytes, "header", 0);
  header_reader.tell(&d.violations);
  // Magic and version come before the hash: a file of another kind is not called corrupt.
  d.fixed = parse_header(header_reader);
  const auto hashed = std::span(header_bytes).first(kHeaderBytes - 8);
  ByteReader header_hash(std::span{header_bytes}.last(8), "header", kHeaderBytes - 8);
  if (header_hash.get<std::uint64_t>("hash") != hash_of(hashed))
    violated({"the header's hash does not match", 0, {}, {}, {}});

  check_limits();
  constexpr std::uint64_t kEndBytes = kFooterBytes + 6 * kSectionBytes; // of a file with the mandatory sections
  const std::uint64_t end_bytes = std::min<std::uint64_t>(kEndBytes, size - kHeaderBytes);
  ahead.fetch(std::array{ByteRange{size - end_bytes, end_bytes}});
  const auto footer_bytes = ahead.get(size - kFooterBytes, kFooterBytes);
  ByteReader footer_reader(footer_bytes, "footer", size - kFooterBytes);
  footer_reader.tell(&d.violations);
  const Footer footer = parse_footer(footer_reader);
  if (footer.file_bytes != size) {
    violated({"it has " + std::to_string(size) + " bytes and should have " + std::to_string(footer.file_bytes),
              size,
              {},
              {},
              {}});
  }
  const std::uint64_t directory_bytes = footer.section_count * kSectionBytes;
  if (directory_bytes > size - kHeaderBytes - kFooterBytes ||
      footer.directory_offset != size - kFooterBytes - directory_bytes) {
    fail_file("the directory is not before the footer", size - kFooterBytes);
  }
  const auto directory = ahead.get(footer.directory_offset, directory_bytes);
  if (hash_of(directory) != footer.directory_hash) {
    violated({"the directory's hash does not match", footer.directory_offset, {}, {}, {}});
  }
  ByteReader directory_reader(directory, "directory", footer.directory_offset);
  directory_reader.tell(&d.violations);
  const auto sections = parse_directory(directory_reader, footer.section_count);
  const std::uint64_t end = sections.empty() ? kHeaderBytes : sections.back().offset + sections.back().stored_bytes;
  if (end != footer.directory_offset) fail_file("the sections do not end where the directory begins", end);

  const auto section = [&](SectionKind kind) -> const Section& {
    return *find_section(sections, kind, footer.directory_offset);
  };
  std::vector<ByteRange> ranges;
  for (const SectionKind kind :
       {SectionKind::kArrays, SectionKind::kModel, SectionKind::kBase, SectionKind::kManifest, SectionKind::kTable}) {
    ranges.push_back({section(kind).offset, section(kind).stored_bytes});
    claim(section(kind).stored_bytes, name_of(kind));
    claim(section(kind).raw_bytes, name_of(kind));
  }
  claim(section(SectionKind::kArrays).raw_bytes * kBytesPerArrayByte, "arrays");
  claim(section(SectionKind::kManifest).raw_bytes * kBytesPerManifestByte, "manifest");
  claim(section(SectionKind::kTable).raw_bytes * kBytesPerTableByte, "block table");
  std::sort(ranges.begin(), ranges.end(), [](const ByteRange& a, const ByteRange& b) { return a.offset < b.offset; });
  ahead.fetch(ranges);
  const auto content = [&](SectionKind kind) {
    return expand(section(kind), ahead.get(section(kind).offset, section(kind).stored_bytes), &d.violations);
  };
  const auto in_section = [&](SectionKind kind, const std::vector<std::byte>& bytes) {
    ByteReader in(bytes, name_of(kind), section(kind).offset, section(kind).stored_bytes != section(kind).raw_bytes);
    in.tell(&d.violations);
    return in;
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
  if (const Section* const order = find_section(sections, SectionKind::kInputOrder, footer.directory_offset)) {
    const std::uint64_t vertices = std::uint64_t{header_.base_vertex_count} + header_.record_count;
    if (order->raw_bytes != input_order_bytes(vertices, header_.tet_count))
      fail_file("the input order section does not fit the header's counts", order->offset);
    header_.has_input_order = true;
    d.input_order = *order;
  }
  const Section& blocks = section(SectionKind::kBlocks);
  if (blocks.raw_bytes != blocks.stored_bytes || blocks.hash != 0) {
    violated({"the blocks' row of the directory is invalid", blocks.offset, {}, {}, {}});
  }
  const auto table_bytes = content(SectionKind::kTable);
  auto table = in_section(SectionKind::kTable, table_bytes);
  d.rows = parse_table(table, d.fixed, blocks);
  for (const TableRow& row : d.rows)
    blocks_.push_back(row.info);
  const auto manifest_bytes = content(SectionKind::kManifest);
  auto manifest = in_section(SectionKind::kManifest, manifest_bytes);
  try {
    manifest_ = parse_manifest(manifest);
  } catch (const Error& error) {
    if (!d.violations) throw;
    violated({error.what(), error.byte_offset(), {}, {}, {}});
  }
  claim(content_bytes(), "mesh");
  d.base_bytes = ahead.get(d.base.offset, d.base.stored_bytes);
}

Reader::~Reader() = default;
Reader::Reader(Reader&&) noexcept = default;
Reader& Reader::operator=(Reader&&) noexcept = default;

std::uint64_t Reader::file_bytes() const {
  return decoding_->reader.size();
}
std::uint64_t Reader::bytes_read() const {
  return decoding_->reader.bytes_read();
}
std::uint64_t Reader::requests() const {
  return decoding_->reader.requests();
}

/// Throws, unless there is somebody to tell.
void Reader::violated(Violation violation) const {
  const Violations& violations = decoding_->violations;
  if (violations) {
    violations(violation);
  } else if (violation.record) {
    fail_record(RecordId{*violation.record}, violation.what.c_str());
  } else {
    fail_file(violation.what, violation.offset.value_or(0));
  }
}

// ---- limits ----

void Reader::check_limits() const {
  const Header& header = decoding_->fixed.header;
  const auto check = [](std::uint64_t count, std::uint64_t most, const char* what) {
    if (count > most) {
      throw Error(ErrorCode::kLimit,
                  "the file has " + std::to_string(count) + what + ", more than the limit of " + std::to_string(most));
    }
  };
  check(std::uint64_t{header.base_vertex_count} + header.record_count, decoding_->limits.max_vertices, " vertices");
  check(header.tet_count, decoding_->limits.max_tets, " tets");
}

void Reader::claim(std::uint64_t bytes, const char* what) {
  Decoding& d = *decoding_;
  if (bytes > d.limits.max_bytes - d.claimed) {
    throw Error(ErrorCode::kLimit, std::string("the ") + what + " would take " + std::to_string(bytes) +
                                       " bytes of memory, more than the limit of " +
                                       std::to_string(d.limits.max_bytes) + " leaves");
  }
  d.claimed += bytes;
}

// No product overflows: counts are below 2^32, and a vertex has less than 2^25 bytes.
std::uint64_t Reader::content_bytes() const {
  const std::uint64_t vertices = std::uint64_t{header_.base_vertex_count} + header_.record_count;
  return vertices * (vertex_bytes(header_) + kBytesPerVertex) +
         header_.record_count * (kBytesPerRecord + std::uint64_t{8} * decoding_->schema->code_count()) +
         header_.base_tet_count * kBytesPerBaseTet;
}

std::uint64_t Reader::fixed_bytes() const {
  return decoding_->claimed;
}

std::uint64_t Reader::decoded_bytes(std::uint32_t block) const {
  const std::uint64_t while_decoding = 2 * blocks_[block].stored_bytes +
                                       std::uint64_t{2} * decoding_->schema->context_count() +
                                       std::uint64_t{64} * blocks_[block].record_count;
  return decoding_->rows[block].version_count * kBytesPerVersion + while_decoding;
}

// ---- content ----

Content Reader::read_base() const {
  const Decoding& d = *decoding_;
  const auto bytes = expand(d.base, d.base_bytes, &d.violations);
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
  const auto fail = [&](const char* what) { violated({what, blocks_[block].offset, block, r.index(), {}}); };
  std::uint32_t named = block; // by the table
  for (const RecordId parent : content.refinement.parents(r)) {
    if (content.generation[parent.index()] >= content.generation[r.index()]) {
      fail("it depends on a record that does not come before it");
    }
    const std::uint32_t home = decoding_->block_of[parent.index()];
    if (home != named && home != block && !std::binary_search(needs.begin(), needs.end(), home)) {
      fail("it depends on a block that the table does not name");
    }
    named = home;
    for (std::size_t i = 0; i < codes; ++i) {
      if (content.monotone[parent.index() * codes + i] < content.monotone[r.index() * codes + i]) {
        fail("its errors are greater than those of a record it depends on");
      }
    }
  }
}

void Reader::check_block(std::uint32_t block, const Content& content) const {
  const BlockInfo& info = blocks_[block];
  const auto fail = [&](const char* what) { violated({what, info.offset, block, {}, {}}); };
  std::vector<ErrorCode16> greatest(content.errors_per_record), greatest_own(content.errors_per_record);
  OrderCode greatest_order = 0;
  for (std::size_t r = info.first_record; r < info.first_record + info.record_count; ++r) {
    for (std::size_t i = 0; i < greatest.size(); ++i) {
      greatest[i] = std::max(greatest[i], content.monotone[r * greatest.size() + i]);
      greatest_own[i] = std::max(greatest_own[i], content.own[r * greatest.size() + i]);
    }
    greatest_order = std::max(greatest_order, content.order[r]);
  }
  if (greatest != info.max_error) fail("a block's errors are not those of the table");
  if (greatest_own != info.max_own) fail("a block's own errors are not those of the table");
  if (greatest_order != info.max_order) fail("a block's order codes are not those of the table");
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
      fail("a block's squared errors are not those of the table");
  }
}

// As the blocks and the base make it. A header that says otherwise is met once, at the block decoded last.
void Reader::check_whole(const Content& content) const {
  if (content.refinement.applied_count() != header_.record_count) return;
  std::uint64_t tets = header_.base_tet_count;
  for (std::uint32_t r = 0; r < header_.record_count; ++r)
    tets += content.refinement.added_tet_count(RecordId{r});
  if (tets != header_.tet_count) {
    violated({"the full mesh does not have the number of tets of the header", 0, {}, {}, {}});
  }
}

void Reader::load(std::span<const std::uint32_t> blocks, Content& content) {
  std::vector<std::uint32_t> wanted(blocks.begin(), blocks.end());
  std::sort(wanted.begin(), wanted.end());
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  if (!wanted.empty() && wanted.back() >= blocks_.size()) {
    throw Error(ErrorCode::kBadArgument, "there is no block " + std::to_string(wanted.back()));
  }
  std::erase_if(wanted, [&](std::uint32_t block) { return content.block_loaded[block] != 0; });
  if (wanted.empty()) return;
  auto fetched = fetch(wanted, [](std::uint32_t, const Error& error) { throw Error(error); });
  Batch batch = begin(std::move(fetched), content);
  while (batch.step(content, header_.record_count)) {
  }
  batch.check(content);
  for (const std::uint32_t block : wanted)
    content.block_loaded[block] = 1;
}

std::vector<FetchedBlock> Reader::fetch(std::span<const std::uint32_t> blocks, const FetchFailed& failed,
                                        const std::function<bool()>& is_stopped) const {
  std::vector<ByteRange> ranges;
  for (const std::uint32_t block : blocks)
    ranges.push_back({blocks_[block].offset, blocks_[block].stored_bytes});
  auto read = decoding_->reader.read_all(ranges, is_stopped);
  std::vector<FetchedBlock> fetched;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    try {
      if (read[i].failure) std::rethrow_exception(read[i].failure);
      if (hash_of(read[i].bytes) != decoding_->rows[blocks[i]].hash)
        fail_file("the hash of a block does not match", ranges[i].offset);
      fetched.push_back({blocks[i], std::move(read[i].bytes)});
    } catch (const Error& error) {
      failed(blocks[i], error);
    }
  }
  return fetched;
}

InputOrder Reader::read_input_order() const {
  const Decoding& d = *decoding_;
  const Section& section = d.input_order;
  // As stored, expanded, and the numbers.
  const std::uint64_t bytes = section.stored_bytes + 3 * section.raw_bytes;
  if (bytes > d.limits.max_bytes - d.claimed) {
    throw Error(ErrorCode::kLimit, "the input order would take " + std::to_string(bytes) +
                                       " bytes of memory, more than the limit of " +
                                       std::to_string(d.limits.max_bytes) + " leaves");
  }
  const auto raw = expand(section, decoding_->reader.read({section.offset, section.stored_bytes}));
  ByteReader in(raw, name_of(SectionKind::kInputOrder), section.offset, section.stored_bytes != section.raw_bytes);
  return parse_input_order(in, header_.base_vertex_count + header_.record_count, header_.tet_count);
}

// ---- decoding ----

template <class F>
void Reader::at_block(std::uint32_t block, F&& f, const RecordId& record) const {
  const std::uint64_t offset = blocks_[block].offset;
  try {
    at_offset(offset, f);
  } catch (const BlockError&) {
    throw;
  } catch (const Error& error) {
    throw BlockError(error, block, offset, record);
  }
}

void Reader::expect(std::span<const FetchedBlock> blocks, Content& content) const {
  std::uint64_t records = 0, versions = 0;
  for (const FetchedBlock& block : blocks) {
    records += blocks_[block.block].record_count;
    versions += decoding_->rows[block.block].version_count;
  }
  if (content.refinement.applied_count() + records == header_.record_count)
    content.refinement.reserve(content.refinement.version_count() + versions);
}

Reader::Batch Reader::begin(std::vector<FetchedBlock> blocks, Content& content) {
  Decoding& d = *decoding_;
  if (!d.codec) {
    d.codec.emplace(*d.schema, blocks_, std::size_t{header_.base_vertex_count} + header_.record_count);
    for (std::uint32_t block = 0; block < blocks_.size(); ++block)
      d.block_of.insert(d.block_of.end(), blocks_[block].record_count, block);
  }
  expect(blocks, content);
  auto batching = std::make_unique<Batching>();
  batching->reader = this;
  batching->open.reserve(blocks.size());
  for (FetchedBlock& fetched : blocks) {
    at_block(fetched.block, [&] {
      const BlockInfo& info = blocks_[fetched.block];
      ByteReader in(fetched.bytes, "block", info.offset);
      const auto generations = parse_runs(in, info.record_count, header_.record_count);
      std::copy(generations.begin(), generations.end(), content.generation.begin() + info.first_record);
      auto& runs = batching->runs;
      for (std::uint32_t i = 0; i < info.record_count; ++i) {
        if (i == 0 || generations[i] != generations[i - 1]) {
          runs.push_back({generations[i], static_cast<std::uint32_t>(batching->open.size()), info.first_record + i, 0});
        }
        runs.back().last_record = info.first_record + i;
      }
      OtherParents others = parse_others(in, fetched.block, blocks_);
      OpenBlock& open = batching->open.emplace_back();
      open.block = fetched.block;
      open.others = std::move(others);
      open.start = in.position();
      open.bytes = std::move(fetched.bytes);
      open.records_left = info.record_count;
      open.least.fill(std::numeric_limits<double>::infinity());
      open.greatest.fill(-std::numeric_limits<double>::infinity());
    });
  }
  // What is told of a file that is wrong is told in the order of the specification.
  if (d.violations) {
    std::sort(batching->runs.begin(), batching->runs.end(), [](const Run& a, const Run& b) {
      return std::pair(a.generation, a.open_block) < std::pair(b.generation, b.open_block);
    });
  } else {
    batching->runs = near_ones_together(batching->runs, batching->open, blocks_);
  }
  return Batch(std::move(batching));
}

Reader::Batch::Batch(std::unique_ptr<Batching> batching) : batching_(std::move(batching)) {}
Reader::Batch::Batch(Batch&&) noexcept = default;
Reader::Batch& Reader::Batch::operator=(Batch&&) noexcept = default;
Reader::Batch::~Batch() = default;

bool Reader::Batch::step(Content& content, std::size_t records, const StarMeasured& measured) {
  const Reader& reader = *batching_->reader;
  Decoding& d = *reader.decoding_;
  for (; batching_->run < batching_->runs.size(); ++batching_->run) {
    Run& run = batching_->runs[batching_->run];
    OpenBlock& block = batching_->open[run.open_block];
    const std::uint32_t most_versions = d.rows[block.block].version_count;
    RecordId r;
    const auto decode = [&] {
      if (!block.coding) {
        const std::size_t needs = reader.blocks_[block.block].needs.size();
        block.coding = BlockCoding{BlockState(block.block, needs, d.schema->code_count()),
                                   RangeDecoder(d.initial, std::move(block.bytes), block.start)};
      }
      for (; run.first_record <= run.last_record && records > 0; ++run.first_record, --records) {
        r = RecordId{run.first_record};
        d.codec->code(block.coding->decoder, block.coding->state, content, r, NothingKnown{}, block.others.of(r));
        block.versions += content.refinement.fine_count(r);
        if (block.versions > most_versions) fail_record(r, "its block makes more tets than the table says");
        reader.check_record(r, block.block, content);
        d.codec->extend_by_star(block.least, block.greatest);
        if (measured) measured(r, d.codec->star_least(), d.codec->star_greatest());
        if (--block.records_left == 0) block.coding.reset();
      }
    };
    reader.at_block(block.block, decode, r);
    if (run.first_record <= run.last_record) return true;
  }
  return false;
}

void Reader::Batch::check(const Content& content) const {
  const Reader& reader = *batching_->reader;
  for (const OpenBlock& block : batching_->open) {
    reader.at_block(block.block, [&] {
      const BlockInfo& info = reader.blocks_[block.block];
      if (block.versions != reader.decoding_->rows[block.block].version_count) {
        reader.violated({"a block makes fewer tets than the table says", info.offset, block.block, {}, {}});
      }
      if (block.least != info.box_min || block.greatest != info.box_max) {
        reader.violated({"a block's bounding box is not that of the table", info.offset, block.block, {}, {}});
      }
      reader.check_block(block.block, content);
    });
  }
  if (!batching_->open.empty()) reader.at_block(batching_->open.back().block, [&] { reader.check_whole(content); });
  if (content.refinement.applied_count() == reader.header_.record_count) {
    reader.decoding_->codec.reset();
    std::vector<std::uint32_t>().swap(reader.decoding_->block_of);
  }
}

} // namespace ptet::file
