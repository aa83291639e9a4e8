// What lies where in a .ptet file, apart from the coded records: PTET.md in C++.
//
//   header | arrays | model | base | blocks ... | input order, if it is kept | manifest | table | directory | footer
#pragma once

#include "formats/ptet/bytes.hpp"
#include "formats/ptet/range_coder.hpp"
#include "formats/ptet/reader.hpp"
#include "formats/ptet/schema.hpp"

#include <array>
#include <string_view>

namespace ptet::file {

inline constexpr std::string_view kMagic{"\x89PTET\r\n\x1a", 8};
inline constexpr std::string_view kEndMagic{"PTETEND\n", 8};
inline constexpr std::uint32_t kVersion = 1;
inline constexpr std::size_t kHeaderBytes = 128;
inline constexpr std::size_t kFooterBytes = 40;
inline constexpr std::size_t kSectionBytes = 40;
inline constexpr std::size_t kMaxSections = 64;

enum class SectionKind : std::uint32_t {
  kArrays = 1,
  kModel = 2,
  kBase = 3,
  kBlocks = 4,
  kManifest = 5,
  kTable = 6,
  kInputOrder = 7, ///< may be missing
};
inline constexpr std::uint32_t kMandatory = 1;                             ///< the one flag of a section
inline constexpr std::uint16_t kHasSquaredErrors = 1, kOverlapsItself = 2; ///< flags of the header
[[nodiscard]] const char* name_of(SectionKind kind);
/// Of a section of this kind in the directory.
[[nodiscard]] std::uint32_t flags_of(SectionKind kind);

/// One row of the directory. When stored_bytes < raw_bytes the section is a zstd frame, else it is stored as it is.
/// The blocks are one section here, raw, and hashed one by one in the table (hash 0).
struct Section {
  std::uint32_t kind = 0;
  std::uint32_t flags = 0;
  std::uint64_t offset = 0;
  std::uint64_t stored_bytes = 0;
  std::uint64_t raw_bytes = 0;
  std::uint64_t hash = 0;

  [[nodiscard]] bool is_compressed() const { return stored_bytes != raw_bytes; }
};

struct Footer {
  std::uint64_t directory_offset = 0;
  std::uint32_t section_count = 0;
  std::uint64_t directory_hash = 0;
  std::uint64_t file_bytes = 0;
};

/// The section of fixed length, with what file::Header does not have.
struct FixedHeader {
  Header header; ///< its arrays: see parse_arrays()
  std::uint32_t array_count = 0;
  std::uint64_t version_count = 0;
  std::uint32_t records_per_block = 0;
  Precisions position_precisions;
};

/// A row of the block table, and what only the codec needs of it.
struct TableRow {
  BlockInfo info;
  std::uint32_t version_count = 0;
  std::uint64_t hash = 0;
};

/// Records of one block that depend on others than the makers of C(r). Most blocks have none.
struct OtherParents {
  std::vector<RecordId> records;       ///< ascending
  std::vector<std::uint32_t> begin{0}; ///< records.size() + 1 offsets into `parents`
  std::vector<RecordId> parents;       ///< of each record at least one, ascending

  [[nodiscard]] std::span<const RecordId> of(RecordId r) const;
};

[[nodiscard]] std::uint64_t hash_of(std::span<const std::byte> bytes);
/// Undoes Section compression. Throws Error(kCorruptFile); a wrong hash is told to `violations` where there are any.
[[nodiscard]] std::vector<std::byte> expand(const Section& section, std::vector<std::byte> stored,
                                            const Violations* violations = nullptr);

// Parsing. Each throws Error(kCorruptFile) for what PTET.md forbids, or tells it (ByteReader::tell).
[[nodiscard]] FixedHeader parse_header(ByteReader& in);
[[nodiscard]] Footer parse_footer(ByteReader& in);
[[nodiscard]] std::vector<Section> parse_directory(ByteReader& in, std::uint32_t count);
/// Sets header.arrays; returns the precisions of the positions and of these.
[[nodiscard]] std::vector<Precisions> parse_arrays(ByteReader& in, FixedHeader& fixed);
[[nodiscard]] std::vector<TableRow> parse_table(ByteReader& in, const FixedHeader& fixed, const Section& blocks);
[[nodiscard]] Manifest parse_manifest(ByteReader& in);
/// The base mesh into the first rows of `positions` and `arrays`; returns the tets.
[[nodiscard]] std::vector<Tet> parse_base(ByteReader& in, const Header& header, PointArray& positions,
                                          std::vector<PointArray>& arrays);
/// The runs at the start of a block of `record_count` records: how many of which generation, each less than the number
/// of records of the file. Returns generations in order of records.
[[nodiscard]] std::vector<std::uint32_t> parse_runs(ByteReader& in, std::uint32_t record_count,
                                                    std::uint32_t file_records);
/// The dependencies that follow the runs: for records of a block what they need besides the makers of C(r).
[[nodiscard]] OtherParents parse_others(ByteReader& in, std::uint32_t block, std::span<const BlockInfo> blocks);

// And the way back.
void put_header(ByteWriter& out, const FixedHeader& fixed);
void put_footer(ByteWriter& out, const Footer& footer);
void put_directory(ByteWriter& out, const std::vector<Section>& sections);
void put_arrays(ByteWriter& out, const Header& header, const std::vector<Precisions>& precisions);
/// The boxes of the rows are rounded outwards, and must lie in the header's.
void put_table(ByteWriter& out, const Header& header, const std::vector<TableRow>& rows);
void put_manifest(ByteWriter& out, const Manifest& manifest);
void put_base(ByteWriter& out, const PointArray& positions, const std::vector<PointArray>& arrays,
              std::uint32_t vertex_count, const std::vector<Tet>& tets);
void put_runs(ByteWriter& out, std::span<const std::uint32_t> generations);
void put_others(ByteWriter& out, std::uint32_t block, std::span<const BlockInfo> blocks, const OtherParents& others);

} // namespace ptet::file
