// The .ptet reader: header, table and base mesh at once, record blocks as they are asked for. PTET.md is the
// specification. Nothing that the file says is believed before it is checked.
#pragma once

#include "formats/ptet/input_order.hpp"
#include "formats/ptet/manifest.hpp"
#include "formats/ptet/source.hpp"
#include "formats/ptet/violation.hpp"
#include "ptet/mesh.hpp"
#include "ptet/source.hpp"
#include "record/error_code.hpp"
#include "record/order_code.hpp"
#include "record/refinement.hpp"

#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace ptet::file {

/// One point array as the file describes it.
struct ArrayInfo {
  std::string name;
  ScalarType type = ScalarType::kFloat32;
  std::uint32_t components = 1;
  bool governing = false; ///< its errors are recorded
  double range = 0;       ///< scale of its error codes, field units
};

struct Header {
  std::uint32_t base_vertex_count = 0; ///< those of no tet (unused points of the input) included
  std::uint32_t base_tet_count = 0;
  std::uint32_t record_count = 0;
  std::uint32_t tet_count = 0; ///< of the original
  std::uint32_t block_count = 0;
  ScalarType position_type = ScalarType::kFloat32;
  std::vector<ArrayInfo> arrays;
  Point box_min{};
  Point box_max{};
  double diagonal = 0; ///< scale of the domain error codes, mesh units
  double volume = 0;   ///< of the original, mesh units cubed; 0 when it is not known
  bool has_squared_errors = false;
  bool overlaps_itself = false; ///< see RecordStream::overlaps_itself
  bool has_input_order = false;
};
/// Bytes of a vertex, positions and arrays.
[[nodiscard]] std::size_t vertex_bytes(const Header& header);

/// One row of the block table. Records are numbered from coarse to fine levels; block b holds the records
/// first_record .. first_record + record_count - 1.
struct BlockInfo {
  std::uint64_t offset = 0;
  std::uint64_t stored_bytes = 0;
  std::uint32_t first_record = 0;
  std::uint32_t record_count = 0;
  Point box_min{}; ///< around the stars of all its records
  Point box_max{};
  /// Largest monotone error codes of its records: one per governing field, then the domain's.
  std::vector<ErrorCode16> max_error;
  std::vector<ErrorCode16> max_own; ///< likewise its largest own codes
  OrderCode max_order = 0;          ///< largest order code of its records
  /// What its records raise the integral of |Phi - phi|^2 by, as a fraction of range^2 * volume; one per governing
  /// field, and last the volume that the mesh does not cover, as a fraction of volume. Empty when it was not measured.
  std::vector<double> squared_error;
  /// Every block that holds a parent of one of its records, itself left out; ascending.
  std::vector<std::uint32_t> needs;

  [[nodiscard]] std::uint32_t end_record() const { return first_record + record_count; }
};

/// By record, the block that it is in. `blocks`: in order, each with its record_count.
template <class Blocks>
[[nodiscard]] std::vector<std::uint32_t> blocks_by_record(const Blocks& blocks) {
  std::vector<std::uint32_t> block_of;
  std::uint32_t number = 0;
  for (const auto& block : blocks)
    block_of.insert(block_of.end(), block.record_count, number++);
  return block_of;
}

/// What has been loaded so far. Rows and records not loaded yet are zero.
struct Content {
  Refinement refinement;
  PointArray positions;                ///< base_vertex_count + record_count rows
  std::vector<PointArray> arrays;      ///< likewise, in the header's order
  std::uint32_t errors_per_record = 0; ///< governing fields + 1 (domain, last)
  /// record_count x errors_per_record: largest error over C(r); and the same or that of any finer record that
  /// depends on r, so that { r : monotone > t } is a closed cut.
  std::vector<ErrorCode16> own;
  std::vector<ErrorCode16> monotone;
  /// By record: when a budget has room for it, so that { r : order > t } is a closed cut, too.
  std::vector<OrderCode> order;
  /// record_count x errors_per_record: see BlockInfo::squared_error; empty when it was not measured.
  std::vector<SquaredErrorCode> squared_error;
  /// Rank in the dependency order: a record's parents have a smaller one.
  std::vector<std::uint32_t> generation;
  std::vector<char> block_loaded;
};

/// What a code in column `i` of the `columns` of Content::squared_error stands for.
[[nodiscard]] inline double decode_sum(const Header& header, std::size_t i, std::size_t columns,
                                       SquaredErrorCode code) {
  return i + 1 == columns ? decode_uncovered(code, header.record_count) : decode_squared_error(code);
}

/// What decoding found wrong with a block.
class BlockError : public Error {
public:
  BlockError(const Error& error, std::uint32_t number, std::uint64_t offset, RecordId at = {})
      : Error(error), block(number), block_offset(offset), record(at) {}

  std::uint32_t block;
  std::uint64_t block_offset;
  RecordId record; ///< the one that was being decoded; none before the first
};

struct FetchedBlock {
  std::uint32_t block = 0;
  std::vector<std::byte> bytes; ///< as stored, their hash checked
};

/// Thread rule: const where that is said, and what asks for counts and sizes; all else by one thread at a time.
class Reader {
public:
  /// Reads and checks header, manifest and table, and reads the base mesh, in four requests or so. What `options` says
  /// of background and memory_limit is for others.
  /// Throws Error: kIo, kCorruptFile with byte offset, kLimit.
  explicit Reader(std::shared_ptr<ByteSource> source, const OpenOptions& options = {});
  /// The same, but goes on after what does not keep the rest from being read, there and in Batch, and tells it.
  Reader(std::shared_ptr<ByteSource> source, const OpenOptions& options, Violations violations);
  ~Reader();
  Reader(Reader&&) noexcept;
  Reader& operator=(Reader&&) noexcept;

  [[nodiscard]] const Header& header() const { return header_; }
  [[nodiscard]] const Manifest& manifest() const { return manifest_; }
  [[nodiscard]] const std::vector<BlockInfo>& blocks() const { return blocks_; }
  [[nodiscard]] std::uint64_t file_bytes() const;
  [[nodiscard]] std::uint64_t bytes_read() const;
  [[nodiscard]] std::uint64_t requests() const;

  /// Memory that what does not depend on blocks takes, within Limits::max_bytes.
  [[nodiscard]] std::uint64_t fixed_bytes() const;
  /// Memory that the block takes in Content, and its bytes when they are read: an estimate from its counts.
  [[nodiscard]] std::uint64_t decoded_bytes(std::uint32_t block) const;
  /// Memory that it takes besides while it is decoded.
  [[nodiscard]] std::uint64_t decoding_bytes(std::uint32_t block) const;

  /// The base mesh, no record applied. Asks the source for nothing.
  [[nodiscard]] Content read_base() const;
  /// Applies all records of `blocks` (any order; those loaded already are skipped). Together with what is loaded they
  /// must be closed under BlockInfo::needs. Throws Error(kCorruptFile); `content` must not be used after that.
  void load(std::span<const std::uint32_t> blocks, Content& content);

  // The same in steps, for callers that live on with what can be had.

  /// Told of a block that cannot be had, and why.
  using FetchFailed = std::function<void(std::uint32_t block, const Error& error)>;
  /// The bytes of `blocks` (ascending), near ones by one request, but of those that cannot be read or whose hash does
  /// not match, nor that of the same bytes read once more, as it may be the transfer that garbled them: these `failed`
  /// is told of before more is read. `is_wanted` is asked just before each request that a block would be in,
  /// `is_stopped` before each, see RangeReader; what is then not read is left out.
  /// Thread rule: const.
  [[nodiscard]] std::vector<FetchedBlock> fetch(
      std::span<const std::uint32_t> blocks, const FetchFailed& failed,
      const std::function<bool(std::uint32_t block)>& is_wanted = [](std::uint32_t) { return true; },
      const std::function<bool()>& is_stopped = {}) const;
  /// In what order the input stood; header().has_input_order. Thread rule: const.
  /// Throws Error: kIo, kCorruptFile, kLimit.
  [[nodiscard]] InputOrder read_input_order() const;
  /// Makes room for the records of blocks that are decoded next, in several batches, where they are the last of the
  /// file: lists that grow no more need no room to do so.
  void expect(std::span<const FetchedBlock> blocks, Content& content) const;
  class Batch;
  /// Prepares to decode; the blocks must be closed as for load(). One batch at a time.
  /// Throws BlockError; nothing is applied then.
  [[nodiscard]] Batch begin(std::vector<FetchedBlock> blocks, Content& content);

private:
  struct Decoding;
  class Opening;
  struct Batching;
  void check_record(RecordId r, std::uint32_t block, const Content& content) const;
  void check_block(std::uint32_t block, const Content& content) const;
  /// Whether the table's box is that around the stars of its records, which reach from `least` to `greatest`.
  [[nodiscard]] bool is_box_of(const BlockInfo& info, const Point& least, const Point& greatest) const;
  void check_whole(const Content& content) const;
  void violated(Violation violation) const;
  void claim(std::uint64_t bytes, const char* what);
  [[nodiscard]] std::uint64_t content_bytes() const;
  /// Calls `f`; what it finds wrong is the block's.
  template <class F>
  void at_block(std::uint32_t block, F&& f, const RecordId& record = {}) const;

  std::unique_ptr<Decoding> decoding_;
  Header header_;
  Manifest manifest_;
  std::vector<BlockInfo> blocks_;
};

/// Blocks that are being decoded together. Between any two records the content is sound for all that is loaded already:
/// it may be looked at, and a batch may be given up while it has not thrown.
class Reader::Batch {
public:
  Batch(Batch&&) noexcept;
  Batch& operator=(Batch&&) noexcept;
  ~Batch();
  /// Told of each record that is applied the bounding box of its star.
  using StarMeasured = std::function<void(RecordId r, const Point& least, const Point& greatest)>;
  /// Applies up to `records` more. Returns whether any are left.
  /// Throws BlockError; `content` must be made anew then.
  bool step(Content& content, std::size_t records, const StarMeasured& measured = {});
  /// Checks what only the whole of a block tells, after the last step. Content::block_loaded is the caller's to set.
  /// Throws as step().
  void check(const Content& content) const;

private:
  friend class Reader;
  explicit Batch(std::unique_ptr<Batching> batching);
  std::unique_ptr<Batching> batching_;
};

} // namespace ptet::file
