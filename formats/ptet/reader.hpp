// The .ptet reader: header, table and base mesh at once, record blocks as they are asked for. PTET.md is the
// specification. Nothing that the file says is believed before it is checked.
#pragma once

#include "formats/ptet/manifest.hpp"
#include "formats/ptet/source.hpp"
#include "ptet/mesh.hpp"
#include "record/error_code.hpp"
#include "record/order_code.hpp"
#include "record/refinement.hpp"

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
};

/// One row of the block table. Records are numbered from coarse to fine levels; block b holds the records
/// first_record .. first_record + record_count - 1.
struct BlockInfo {
  std::uint64_t offset = 0;
  std::uint64_t stored_bytes = 0;
  std::uint32_t first_record = 0;
  std::uint32_t record_count = 0;
  Point box_min{}; ///< of the stars of all its records
  Point box_max{};
  /// Largest monotone error codes of its records: one per governing field, then the domain's.
  std::vector<ErrorCode16> max_error;
  OrderCode max_order = 0; ///< largest order code of its records
  /// What its records raise the mean of |Phi - phi|^2 over the domain by, as a fraction of range^2; one per governing
  /// field, empty when it was not measured.
  std::vector<double> squared_error;
  /// Every block that holds a parent of one of its records, itself left out; ascending.
  std::vector<std::uint32_t> needs;
};

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
  /// By record: how coarse the mesh was when its collapse was made, so that { r : order > t } is a closed cut, too: the
  /// mesh that the builder had.
  std::vector<OrderCode> order;
  /// record_count x governing fields: see BlockInfo::squared_error; empty when it was not measured.
  std::vector<SquaredErrorCode> squared_error;
  /// Rank in the dependency order: a record's parents have a smaller one.
  std::vector<std::uint32_t> generation;
  std::vector<char> block_loaded;
};

/// Not thread safe.
class Reader {
public:
  /// Reads and checks header, manifest and table. Throws Error: kIo, kCorruptFile with byte offset, kLimit.
  explicit Reader(std::unique_ptr<Source> source);
  ~Reader();
  Reader(Reader&&) noexcept;
  Reader& operator=(Reader&&) noexcept;

  [[nodiscard]] const Header& header() const { return header_; }
  [[nodiscard]] const Manifest& manifest() const { return manifest_; }
  [[nodiscard]] const std::vector<BlockInfo>& blocks() const { return blocks_; }
  [[nodiscard]] std::uint64_t file_bytes() const { return source_->size(); }
  [[nodiscard]] std::uint64_t bytes_read() const { return bytes_read_; }

  /// The base mesh, no record applied.
  [[nodiscard]] Content read_base();
  /// Applies all records of `blocks` (any order; those loaded already are skipped). Together with what is loaded they
  /// must be closed under BlockInfo::needs. Throws Error(kCorruptFile); `content` must not be used after that.
  void load(std::span<const std::uint32_t> blocks, Content& content);

private:
  struct Decoding;
  [[nodiscard]] std::vector<std::byte> fetch(std::uint64_t offset, std::uint64_t count);
  void check_record(RecordId r, std::uint32_t block, const Content& content) const;
  void check_block(std::uint32_t block, const Content& content) const;

  std::unique_ptr<Source> source_;
  std::unique_ptr<Decoding> decoding_;
  Header header_;
  Manifest manifest_;
  std::vector<BlockInfo> blocks_;
  std::uint64_t bytes_read_ = 0;
};

} // namespace ptet::file
