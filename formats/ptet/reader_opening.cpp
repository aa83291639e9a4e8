#include "formats/ptet/reader_decoding.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

namespace ptet::file {
namespace {

// What one element takes in memory at most, with the growth of vectors and with scratch.
constexpr std::uint64_t kBytesPerManifestByte = 128; // a byte can stand for two empty texts
constexpr std::uint64_t kBytesPerArrayByte = 256;    // and for a column
constexpr std::uint64_t kBytesPerTableByte = 24;
/// Bytes of directory and footer in a file with the mandatory sections only; read at once, more if there are others.
constexpr std::uint64_t kEndBytes = kFooterBytes + 6 * kSectionBytes;

/// Null where there is none. Throws where a mandatory section is missing, or there are two of the kind.
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

} // namespace

/// The parts of a file in the order in which they are read: each is checked before the next one is believed.
class Reader::Opening {
public:
  explicit Opening(Reader& reader) : reader_(reader), d_(*reader.decoding_), ahead_(d_.reader) {}

  void run() {
    read_header();
    check_limits();
    read_footer();
    read_directory();
    fetch_sections();
    read_arrays();
    read_model();
    find_base();
    find_input_order();
    read_table();
    read_manifest();
    reader_.claim(reader_.content_bytes(), "mesh");
    d_.base_bytes = ahead_.get(d_.base.offset, d_.base.stored_bytes);
  }

private:
  void read_header();
  void check_limits() const;
  void read_footer();
  void read_directory();
  void fetch_sections();
  void read_arrays();
  void read_model();
  void find_base();
  void find_input_order();
  void read_table();
  void read_manifest();

  void violated(const std::string& what, std::optional<std::uint64_t> offset) const {
    reader_.violated({what, offset, {}, {}, {}});
  }
  /// Of a part that says how much there is.
  void has_wrong_hash(const std::string& part, std::uint64_t offset) const {
    d_.is_sound = false;
    violated("the " + part + "'s hash does not match", offset);
  }
  /// A mandatory section, which every file has.
  [[nodiscard]] const Section& section(SectionKind kind) const {
    return *find_section(sections_, kind, footer_.directory_offset);
  }
  [[nodiscard]] std::vector<std::byte> content(SectionKind kind) const {
    return expand(section(kind), ahead_.get(section(kind).offset, section(kind).stored_bytes), &d_.violations);
  }
  /// `bytes`: the section's content, which must outlive what comes back.
  [[nodiscard]] ByteReader in_section(SectionKind kind, const std::vector<std::byte>& bytes) const {
    ByteReader in(bytes, name_of(kind), section(kind).offset, section(kind).is_compressed());
    in.tell(&d_.violations);
    return in;
  }

  Reader& reader_;
  Decoding& d_;
  ReadAhead ahead_;
  Footer footer_;
  std::vector<Section> sections_;
};

void Reader::Opening::read_header() {
  const std::uint64_t size = d_.reader.size();
  if (size < kHeaderBytes + kFooterBytes)
    throw Error(ErrorCode::kCorruptFile, "the file is too short to be a .ptet file: " + std::to_string(size) + " bytes",
                size);
  const auto bytes = ahead_.get(0, kHeaderBytes);
  ByteReader in(bytes, "header", 0);
  in.tell(&d_.violations);
  // Magic and version come before the hash: a file of another kind is not called corrupt.
  d_.fixed = parse_header(in);
  const auto hashed = std::span(bytes).first(kHeaderBytes - 8);
  ByteReader hash(std::span{bytes}.last(8), "header", kHeaderBytes - 8);
  if (hash.get<std::uint64_t>("hash") != hash_of(hashed)) has_wrong_hash("header", 0);
}

void Reader::Opening::check_limits() const {
  const Header& header = d_.fixed.header;
  const auto check = [&](std::uint64_t count, std::uint64_t most, const char* what) {
    if (count > most)
      throw Error(d_.beyond_limit(),
                  "the file has " + std::to_string(count) + what + ", more than the limit of " + std::to_string(most));
  };
  check(std::uint64_t{header.base_vertex_count} + header.record_count, d_.limits.max_vertices, " vertices");
  check(header.tet_count, d_.limits.max_tets, " tets");
}

void Reader::Opening::read_footer() {
  const std::uint64_t size = d_.reader.size();
  const std::uint64_t end_bytes = std::min<std::uint64_t>(kEndBytes, size - kHeaderBytes);
  ahead_.fetch(std::array{ByteRange{size - end_bytes, end_bytes}});
  const auto bytes = ahead_.get(size - kFooterBytes, kFooterBytes);
  ByteReader in(bytes, "footer", size - kFooterBytes);
  in.tell(&d_.violations);
  footer_ = parse_footer(in);
  if (footer_.file_bytes != size)
    violated("it has " + std::to_string(size) + " bytes and should have " + std::to_string(footer_.file_bytes), size);
}

void Reader::Opening::read_directory() {
  const std::uint64_t size = d_.reader.size();
  const std::uint64_t directory_bytes = footer_.section_count * kSectionBytes;
  if (directory_bytes > size - kHeaderBytes - kFooterBytes ||
      footer_.directory_offset != size - kFooterBytes - directory_bytes)
    fail_file("the directory is not before the footer", size - kFooterBytes);
  const auto bytes = ahead_.get(footer_.directory_offset, directory_bytes);
  if (hash_of(bytes) != footer_.directory_hash) has_wrong_hash("directory", footer_.directory_offset);
  ByteReader in(bytes, "directory", footer_.directory_offset);
  in.tell(&d_.violations);
  sections_ = parse_directory(in, footer_.section_count);
  const std::uint64_t end = sections_.empty() ? kHeaderBytes : sections_.back().offset + sections_.back().stored_bytes;
  if (end != footer_.directory_offset) fail_file("the sections do not end where the directory begins", end);
}

/// Reads the sections that opening needs, in few requests.
void Reader::Opening::fetch_sections() {
  std::vector<ByteRange> ranges;
  for (const SectionKind kind :
       {SectionKind::kArrays, SectionKind::kModel, SectionKind::kBase, SectionKind::kManifest, SectionKind::kTable}) {
    ranges.push_back({section(kind).offset, section(kind).stored_bytes});
    reader_.claim(section(kind).stored_bytes, name_of(kind));
    reader_.claim(section(kind).raw_bytes, name_of(kind));
  }
  reader_.claim(section(SectionKind::kArrays).raw_bytes * kBytesPerArrayByte, "arrays");
  reader_.claim(section(SectionKind::kManifest).raw_bytes * kBytesPerManifestByte, "manifest");
  reader_.claim(section(SectionKind::kTable).raw_bytes * kBytesPerTableByte, "block table");
  std::sort(ranges.begin(), ranges.end(), [](const ByteRange& a, const ByteRange& b) { return a.offset < b.offset; });
  ahead_.fetch(ranges);
}

void Reader::Opening::read_arrays() {
  const auto bytes = content(SectionKind::kArrays);
  auto in = in_section(SectionKind::kArrays, bytes);
  d_.precisions = parse_arrays(in, d_.fixed);
  reader_.header_ = d_.fixed.header;
  d_.schema.emplace(reader_.header_, d_.precisions);
}

void Reader::Opening::read_model() {
  if (section(SectionKind::kModel).raw_bytes != d_.schema->context_count())
    fail_file("the model section does not fit the arrays", section(SectionKind::kModel).offset);
  for (const std::byte byte : content(SectionKind::kModel))
    d_.initial.push_back(static_cast<std::uint8_t>(byte));
}

void Reader::Opening::find_base() {
  const Header& header = reader_.header_;
  d_.base = section(SectionKind::kBase);
  // Both factors are below 2^32: no overflow.
  const std::uint64_t base_values = header.base_vertex_count * static_cast<std::uint64_t>(vertex_bytes(header));
  if (base_values > d_.base.raw_bytes || d_.base.raw_bytes - base_values != std::uint64_t{16} * header.base_tet_count)
    fail_file("the base section does not fit the header's counts", d_.base.offset);
}

void Reader::Opening::find_input_order() {
  Header& header = reader_.header_;
  const Section* const order = find_section(sections_, SectionKind::kInputOrder, footer_.directory_offset);
  if (order == nullptr) return;
  const std::uint64_t vertices = std::uint64_t{header.base_vertex_count} + header.record_count;
  if (order->raw_bytes != input_order_bytes(vertices, header.tet_count))
    fail_file("the input order section does not fit the header's counts", order->offset);
  header.has_input_order = true;
  d_.input_order = *order;
}

void Reader::Opening::read_table() {
  const Section& blocks = section(SectionKind::kBlocks);
  if (blocks.raw_bytes != blocks.stored_bytes || blocks.hash != 0)
    violated("the blocks' row of the directory is invalid", blocks.offset);
  const auto bytes = content(SectionKind::kTable);
  auto in = in_section(SectionKind::kTable, bytes);
  std::vector<TableRow> rows = parse_table(in, d_.fixed, blocks);
  reader_.blocks_.reserve(rows.size());
  d_.decoded.reserve(rows.size());
  for (TableRow& row : rows) {
    reader_.blocks_.push_back(std::move(row.info));
    d_.decoded.push_back({row.version_count, row.hash});
  }
}

void Reader::Opening::read_manifest() {
  const auto bytes = content(SectionKind::kManifest);
  auto in = in_section(SectionKind::kManifest, bytes);
  try {
    reader_.manifest_ = parse_manifest(in);
  } catch (const Error& error) {
    if (!d_.violations) throw;
    violated(error.what(), error.byte_offset());
  }
}

Reader::Reader(std::shared_ptr<ByteSource> source, const OpenOptions& options)
    : Reader(std::move(source), options, Violations{}) {}

Reader::Reader(std::shared_ptr<ByteSource> source, const OpenOptions& options, Violations violations)
    : decoding_(std::make_unique<Decoding>(std::move(source), options, std::move(violations))) {
  Opening(*this).run();
}

} // namespace ptet::file
