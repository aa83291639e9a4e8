#include "formats/ptet/reader.hpp"

#include "formats/ptet/box_grid.hpp"
#include "formats/ptet/reader_decoding.hpp"
#include "formats/ptet/record_runs.hpp"
#include "mesh/large_pages.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace ptet::file {

namespace {

// What one element takes in memory at most, with the growth of vectors and with scratch.
constexpr std::uint64_t kBytesPerVertex = 32;   // marks of the refinement and of the codec, the values apart
constexpr std::uint64_t kBytesPerRecord = 128;  // tables by record, boxes of stars, a cut
constexpr std::uint64_t kBytesPerBaseTet = 320; // with its ghosts, and the sorting of faces that joins them
constexpr std::uint64_t kBytesPerVersion = 40;  // a place and what stands there, its split, parents, as lists grow

/// Calls `f`. An Error(kCorruptFile) that it throws without a byte offset is thrown on with `offset`.
template <class F>
decltype(auto) at_offset(std::uint64_t offset, F&& f) {
  try {
    return f();
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kCorruptFile || error.byte_offset()) throw;
    throw Error(error.code(), error.what(), offset);
  }
}

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

} // namespace

struct Reader::Batching {
  Reader* reader;
  std::vector<OpenBlock> open;
  std::vector<Run> runs; ///< in the order in which they are decoded
  std::size_t run = 0;   ///< the one at hand
};

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

/// Tells who listens to violations; throws where nobody does.
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

void Reader::claim(std::uint64_t bytes, const char* what) {
  Decoding& d = *decoding_;
  if (bytes > d.limits.max_bytes - d.claimed) {
    throw Error(d.beyond_limit(), std::string("the ") + what + " would take " + std::to_string(bytes) +
                                      " bytes of memory, more than the limit of " + std::to_string(d.limits.max_bytes) +
                                      " leaves");
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
  return decoding_->decoded[block].version_count * kBytesPerVersion + 2 * blocks_[block].stored_bytes;
}

std::uint64_t Reader::decoding_bytes(std::uint32_t block) const {
  return std::uint64_t{2} * decoding_->schema->context_count() + std::uint64_t{64} * blocks_[block].record_count;
}

// ---- content ----

Content Reader::read_base() const {
  const Decoding& d = *decoding_;
  const auto bytes = expand(d.base, d.base_bytes, &d.violations);
  ByteReader in(bytes, name_of(SectionKind::kBase), d.base.offset, true);
  const std::size_t vertices = std::size_t{header_.base_vertex_count} + header_.record_count;
  PointArray positions{"", header_.position_type, 3, {}};
  resize_large(positions.bytes, vertices * positions.row_bytes());
  std::vector<PointArray> arrays;
  for (const ArrayInfo& info : header_.arrays) {
    PointArray& array = arrays.emplace_back(PointArray{info.name, info.type, info.components, {}});
    resize_large(array.bytes, vertices * array.row_bytes());
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
          std::vector<SquaredErrorCode>(header_.has_squared_errors ? errors : 0),
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

bool Reader::is_box_of(const BlockInfo& info, const Point& least, const Point& greatest) const {
  const BoxGrid grid(header_.box_min, header_.box_max);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // Where a star leaves the mesh's box no place is around it.
    if (info.box_min[axis] > least[axis] || info.box_max[axis] < greatest[axis] ||
        info.box_min[axis] != grid.at(axis, grid.below(axis, least[axis])) ||
        info.box_max[axis] != grid.at(axis, grid.above(axis, greatest[axis])))
      return false;
  }
  return true;
}

void Reader::check_block(std::uint32_t block, const Content& content) const {
  const BlockInfo& info = blocks_[block];
  const auto fail = [&](const char* what) { violated({what, info.offset, block, {}, {}}); };
  std::vector<ErrorCode16> greatest(content.errors_per_record), greatest_own(content.errors_per_record);
  OrderCode greatest_order = 0;
  for (std::size_t r = info.first_record; r < info.end_record(); ++r) {
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
    for (std::size_t r = info.first_record; r < info.end_record(); ++r) {
      const SquaredErrorCode code = content.squared_error[r * info.squared_error.size() + i];
      const double upper = decode_sum(header_, i, info.squared_error.size(), code);
      const double lower = decode_sum(header_, i, info.squared_error.size(), static_cast<SquaredErrorCode>(code - 1));
      least += lower;
      most += upper;
      slack += 0x1p-40 * std::max(std::fabs(lower), std::fabs(upper));
    }
    if (info.squared_error[i] < least - slack || info.squared_error[i] > most + slack)
      fail(i + 1 == info.squared_error.size() ? "what a block uncovers is not what the table says"
                                              : "a block's squared errors are not those of the table");
  }
}

// Whether the mesh of all records is what the header says of the original; can be told once all blocks are decoded.
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
                                        const std::function<bool(std::uint32_t)>& is_wanted,
                                        const std::function<bool()>& is_stopped) const {
  std::vector<ByteRange> ranges;
  for (const std::uint32_t block : blocks)
    ranges.push_back({blocks_[block].offset, blocks_[block].stored_bytes});
  std::vector<FetchedBlock> fetched;
  const auto take = [&](std::size_t i, RangeBytes read) {
    try {
      if (read.failure) std::rethrow_exception(read.failure);
      const std::uint64_t hash = decoding_->decoded[blocks[i]].hash;
      if (hash_of(read.bytes) != hash) { // garbled on the way, perhaps
        if (is_stopped && is_stopped()) return;
        read.bytes = decoding_->reader.read(ranges[i]);
        if (hash_of(read.bytes) != hash) fail_file("the hash of a block does not match", ranges[i].offset);
      }
      fetched.push_back({blocks[i], std::move(read.bytes)});
    } catch (const Error& error) {
      failed(blocks[i], error);
    }
  };
  decoding_->reader.read_each(
      ranges, [&](std::size_t i) { return is_wanted(blocks[i]); }, take, is_stopped);
  return fetched;
}

InputOrder Reader::read_input_order() const {
  const Decoding& d = *decoding_;
  const Section& section = d.input_order;
  // The bytes as stored, the same expanded, and the numbers that they stand for.
  const std::uint64_t bytes = section.stored_bytes + 3 * section.raw_bytes;
  if (bytes > d.limits.max_bytes - d.claimed) {
    throw Error(ErrorCode::kLimit, "the input order would take " + std::to_string(bytes) +
                                       " bytes of memory, more than the limit of " +
                                       std::to_string(d.limits.max_bytes) + " leaves");
  }
  const auto raw = expand(section, decoding_->reader.read({section.offset, section.stored_bytes}));
  ByteReader in(raw, name_of(SectionKind::kInputOrder), section.offset, section.is_compressed());
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
    versions += decoding_->decoded[block.block].version_count;
  }
  // There are more places than tets, by the boundary faces; what is not used takes no memory.
  const std::uint64_t tets_and_faces = header_.tet_count + std::uint64_t{header_.tet_count} / 4;
  if (content.refinement.applied_count() + records == header_.record_count)
    content.refinement.reserve({.places = std::min(content.refinement.place_count() + versions, tets_and_faces)});
}

Reader::Batch Reader::begin(std::vector<FetchedBlock> blocks, Content& content) {
  Decoding& d = *decoding_;
  if (!d.codec) {
    d.codec.emplace(*d.schema, blocks_, std::size_t{header_.base_vertex_count} + header_.record_count);
    d.block_of = blocks_by_record(blocks_);
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
  // Violations are to be told in the order of the specification, whatever order decodes fastest.
  if (d.violations) {
    std::sort(batching->runs.begin(), batching->runs.end(), [](const Run& a, const Run& b) {
      return std::pair(a.generation, a.open_block) < std::pair(b.generation, b.open_block);
    });
  } else {
    std::vector<std::uint32_t> numbers;
    for (const OpenBlock& open : batching->open)
      numbers.push_back(open.block);
    batching->runs = near_ones_together(batching->runs, numbers, blocks_);
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
    const std::uint32_t most_versions = d.decoded[block.block].version_count;
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
      if (block.versions != reader.decoding_->decoded[block.block].version_count) {
        reader.violated({"a block makes fewer tets than the table says", info.offset, block.block, {}, {}});
      }
      if (!reader.is_box_of(info, block.least, block.greatest)) {
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
