#include "formats/ptet/dump.hpp"

#include "formats/ptet/layout.hpp"

#include <algorithm>
#include <iomanip>
#include <ostream>
#include <sstream>

namespace ptet::file {
namespace {

constexpr std::size_t kBytesPerLine = 16;

std::string hex(std::uint64_t value, int digits) {
  std::ostringstream text;
  text << std::hex << std::setfill('0') << std::setw(digits) << value;
  return text.str();
}

/// Control characters and what is no ASCII as \xNN.
std::string printable(std::string_view text) {
  std::string result;
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (code >= 0x20 && code < 0x7F) {
      result += c;
    } else {
      result += "\\x" + hex(code, 2);
    }
  }
  return result;
}

std::string number(double value) {
  std::ostringstream text;
  text << std::setprecision(9) << value;
  return text.str();
}

/// Lines of offset, hex and, beside the first, the meaning. Offsets within expanded sections begin with '+'.
void put_range(std::ostream& out, char mark, std::uint64_t offset, std::span<const std::byte> bytes,
               const std::string& meaning) {
  for (std::size_t begin = 0; begin < bytes.size() || begin == 0; begin += kBytesPerLine) {
    std::string line;
    for (std::size_t i = begin; i < std::min(begin + kBytesPerLine, bytes.size()); ++i) {
      line += hex(static_cast<std::uint64_t>(bytes[i]), 2) + ' ';
    }
    out << mark << hex(offset + begin, 8) << "  ";
    if (begin == 0) {
      out << std::left << std::setfill(' ') << std::setw(3 * kBytesPerLine) << line << ' ' << meaning;
    } else {
      out << line.substr(0, line.size() - 1);
    }
    out << '\n';
  }
}

class Dump {
public:
  Dump(std::ostream& out, const std::string& path)
      : out_(out), bytes_(read_all(path)), reader_(over_memory(bytes_)), content_(reader_.read_base()) {
    std::vector<std::uint32_t> blocks(reader_.blocks().size());
    for (std::uint32_t b = 0; b < blocks.size(); ++b)
      blocks[b] = b;
    reader_.load(blocks, content_);
    auto header = part(0, kHeaderBytes, "header");
    fixed_ = parse_header(header);
    auto footer = part(bytes_.size() - kFooterBytes, kFooterBytes, "footer");
    footer_ = parse_footer(footer);
    auto directory = part(footer_.directory_offset, footer_.section_count * kSectionBytes, "directory");
    sections_ = parse_directory(directory, footer_.section_count);
  }

  void annotate();

private:
  static std::vector<std::byte> read_all(const std::string& path) {
    const auto source = open_file(path);
    std::vector<std::byte> bytes(source->size());
    source->read(0, bytes);
    return bytes;
  }
  [[nodiscard]] std::span<const std::byte> range(std::uint64_t offset, std::uint64_t count) const {
    return std::span(bytes_).subspan(offset, count);
  }
  [[nodiscard]] ByteReader part(std::uint64_t offset, std::uint64_t count, const std::string& name,
                                FieldObserver observer = {}) const {
    return {range(offset, count), name, offset, false, std::move(observer)};
  }
  [[nodiscard]] FieldObserver printer(char mark) {
    return [this, mark](std::uint64_t offset, std::span<const std::byte> field, std::string_view name,
                        const std::string& value) {
      put_range(out_, mark, offset, field, std::string(name) + ": " + printable(value));
    };
  }
  void annotate_section(const Section& section);
  void annotate_content(const Section& section, ByteReader& in);
  void annotate_blocks();
  void describe_record(RecordId r);

  std::ostream& out_;
  std::vector<std::byte> bytes_;
  Reader reader_;
  Content content_;
  FixedHeader fixed_;
  Footer footer_;
  std::vector<Section> sections_;
  std::vector<TableRow> rows_;
};

void Dump::annotate() {
  out_ << "header\n";
  auto header = part(0, kHeaderBytes, "header", printer(' '));
  static_cast<void>(parse_header(header));
  // The sections' contents first: the blocks are explained by the table, which stands behind them.
  for (const Section& section : sections_) {
    const auto raw =
        section.kind == static_cast<std::uint32_t>(SectionKind::kBlocks)
            ? std::vector<std::byte>{}
            : expand(section, {bytes_.begin() + static_cast<std::ptrdiff_t>(section.offset),
                               bytes_.begin() + static_cast<std::ptrdiff_t>(section.offset + section.stored_bytes)});
    ByteReader in(raw, "section", 0, true);
    if (section.kind == static_cast<std::uint32_t>(SectionKind::kArrays)) static_cast<void>(parse_arrays(in, fixed_));
    if (section.kind == static_cast<std::uint32_t>(SectionKind::kTable)) {
      const auto blocks = std::find_if(sections_.begin(), sections_.end(), [](const Section& other) {
        return other.kind == static_cast<std::uint32_t>(SectionKind::kBlocks);
      });
      rows_ = parse_table(in, fixed_, *blocks);
    }
  }
  for (const Section& section : sections_)
    annotate_section(section);
  out_ << "\ndirectory\n";
  auto directory = part(footer_.directory_offset, footer_.section_count * kSectionBytes, "directory", printer(' '));
  static_cast<void>(parse_directory(directory, footer_.section_count));
  out_ << "\nfooter\n";
  auto footer = part(bytes_.size() - kFooterBytes, kFooterBytes, "footer", printer(' '));
  static_cast<void>(parse_footer(footer));
}

void Dump::annotate_section(const Section& section) {
  const auto kind = static_cast<SectionKind>(section.kind);
  out_ << '\n' << name_of(kind) << '\n';
  if (kind == SectionKind::kBlocks) return annotate_blocks();
  const auto stored = range(section.offset, section.stored_bytes);
  const bool compressed = section.is_compressed();
  const auto raw = expand(section, {stored.begin(), stored.end()});
  if (compressed) {
    put_range(out_, ' ', section.offset, stored, "a zstd frame of " + std::to_string(raw.size()) + " bytes:");
  }
  // The model is all one field: its lines are made in annotate_content().
  ByteReader in(raw, name_of(kind), section.offset, compressed,
                kind == SectionKind::kModel ? FieldObserver{} : printer(compressed ? '+' : ' '));
  annotate_content(section, in);
}

void Dump::annotate_content(const Section& section, ByteReader& in) {
  switch (static_cast<SectionKind>(section.kind)) {
  case SectionKind::kArrays: {
    FixedHeader fixed = fixed_;
    static_cast<void>(parse_arrays(in, fixed));
    return;
  }
  case SectionKind::kBase: {
    PointArray positions = content_.positions;
    auto arrays = content_.arrays;
    const auto tets = parse_base(in, reader_.header(), positions, arrays);
    for (std::uint32_t v = 0; v < reader_.header().base_vertex_count; ++v) {
      out_ << "           vertex " << v << " at";
      for (std::uint32_t c = 0; c < 3; ++c)
        out_ << ' ' << number(positions.value(v, c));
      out_ << '\n';
    }
    for (std::size_t t = 0; t < tets.size(); ++t) {
      out_ << "           tet " << t << ':';
      for (const VertexId v : tets[t])
        out_ << ' ' << v.index();
      out_ << '\n';
    }
    return;
  }
  case SectionKind::kManifest: static_cast<void>(parse_manifest(in)); return;
  case SectionKind::kTable: {
    const auto blocks = std::find_if(sections_.begin(), sections_.end(), [](const Section& other) {
      return other.kind == static_cast<std::uint32_t>(SectionKind::kBlocks);
    });
    static_cast<void>(parse_table(in, fixed_, *blocks));
    return;
  }
  case SectionKind::kModel: {
    const bool compressed = section.is_compressed();
    out_ << "           80 for each context but these:\n";
    const auto raw = in.get_bytes(in.remaining(), "model");
    for (std::size_t i = 0; i < raw.size(); ++i) {
      if (raw[i] != std::byte{0x80})
        put_range(out_, compressed ? '+' : ' ', compressed ? i : section.offset + i, raw.subspan(i, 1),
                  "context " + std::to_string(i));
    }
    return;
  }
  case SectionKind::kInputOrder: {
    const Header& header = reader_.header();
    static_cast<void>(parse_input_order(in, header.base_vertex_count + header.record_count, header.tet_count));
    return;
  }
  case SectionKind::kBlocks: break;
  }
}

void Dump::annotate_blocks() {
  for (std::size_t b = 0; b < rows_.size(); ++b) {
    const BlockInfo& info = rows_[b].info;
    out_ << "block " << b << '\n';
    auto in = part(info.offset, info.stored_bytes, "block", printer(' '));
    static_cast<void>(parse_runs(in, info.record_count, reader_.header().record_count));
    static_cast<void>(parse_others(in, static_cast<std::uint32_t>(b), reader_.blocks()));
    const std::size_t left = in.remaining();
    if (left > 0) put_range(out_, ' ', info.offset + in.position(), range(info.offset + in.position(), left), "coded:");
    for (std::uint32_t i = 0; i < info.record_count; ++i)
      describe_record(RecordId{info.first_record + i});
  }
}

void Dump::describe_record(RecordId r) {
  const Refinement& refinement = content_.refinement;
  const VertexId v = refinement.vertex_of(r);
  out_ << "           record " << r.index() << ": vertex " << v.index() << " at";
  for (std::uint32_t c = 0; c < 3; ++c)
    out_ << ' ' << number(content_.positions.value(v.index(), c));
  out_ << ", split from vertex " << refinement.target(r).index() << ", generation " << content_.generation[r.index()]
       << '\n';
  for (const PointArray& array : content_.arrays) {
    out_ << "             " << printable(array.name) << ':';
    for (std::uint32_t c = 0; c < array.components; ++c)
      out_ << ' ' << number(array.value(v.index(), c));
    out_ << '\n';
  }
  out_ << "             error codes, own / monotone:";
  const std::size_t codes = content_.errors_per_record;
  for (std::size_t i = 0; i < codes; ++i) {
    out_ << ' ' << content_.own[r.index() * codes + i] << " / " << content_.monotone[r.index() * codes + i];
  }
  for (std::size_t i = 0; !content_.squared_error.empty() && i < codes; ++i)
    out_ << (i + 1 == codes ? ", uncovered: "
             : i == 0       ? ", squared: "
                            : " ")
         << content_.squared_error[r.index() * codes + i];
  out_ << "\n             order code: " << content_.order[r.index()];
  if (const auto parents = refinement.parents(r); !parents.empty()) {
    out_ << "\n             after records";
    for (const RecordId parent : parents)
      out_ << ' ' << parent.index();
  }
  out_ << "\n             makes";
  const std::vector<Tet> made = refinement.fine_tets(r);
  for (std::size_t k = 0; k < made.size(); ++k) {
    const Tet& tet = made[k];
    out_ << (k == 0 ? " (" : ", (");
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const VertexId at = tet[corner];
      out_ << (corner == 0 ? "" : " ") << (at == kDummyVertex ? "-" : std::to_string(at.index()));
    }
    out_ << ')';
  }
  out_ << '\n';
}

void summarise(std::ostream& out, const std::string& path) {
  const Reader reader(open_file(path));
  const Header& header = reader.header();
  out << "file bytes      " << reader.file_bytes() << '\n'
      << "base            " << header.base_vertex_count << " vertices, " << header.base_tet_count << " tets\n"
      << "records         " << header.record_count << " in " << header.block_count << " blocks\n"
      << "original        " << std::uint64_t{header.base_vertex_count} + header.record_count << " vertices, "
      << header.tet_count << " tets\n"
      << "positions       " << name_of(header.position_type) << '\n'
      << "box            ";
  for (const double x : header.box_min)
    out << ' ' << number(x);
  out << "  to ";
  for (const double x : header.box_max)
    out << ' ' << number(x);
  out << "\ndiagonal        " << number(header.diagonal) << '\n';
  if (header.volume > 0) out << "volume          " << number(header.volume) << '\n';
  out << "input order     " << (header.has_input_order ? "kept" : "not kept") << '\n';
  out << "squared errors  " << (header.has_squared_errors ? "measured" : "not measured") << '\n';
  if (header.overlaps_itself) out << "overlaps        found in the original\n";
  for (const ArrayInfo& array : header.arrays) {
    out << "array           " << printable(array.name) << ": " << name_of(array.type) << " x " << array.components;
    if (array.governing) out << ", governing, range " << number(array.range);
    out << '\n';
  }
  const Manifest& manifest = reader.manifest();
  out << "tool version    " << printable(manifest.tool_version) << '\n'
      << "source          " << printable(manifest.source_name) << "  " << printable(manifest.source_hash) << '\n';
  for (const auto& [name, value] : manifest.options) {
    out << "option          " << printable(name) << " = " << printable(value) << '\n';
  }
  for (const std::string& note : manifest.notes)
    out << "note            " << printable(note) << '\n';
  for (std::size_t b = 0; b < reader.blocks().size(); ++b) {
    const BlockInfo& info = reader.blocks()[b];
    out << "block " << b << ": bytes " << info.offset << " + " << info.stored_bytes << ", records " << info.first_record
        << " + " << info.record_count << ", largest errors";
    std::size_t code = 0;
    for (const ArrayInfo& array : header.arrays) {
      if (array.governing) out << ' ' << number(decode_error(info.max_error[code++], array.range));
    }
    out << " domain " << number(decode_error(info.max_error[code], header.diagonal));
    out << ", order " << info.max_order;
    for (std::size_t i = 0; i < info.squared_error.size(); ++i) {
      if (i == 0) out << ", mean squares / range^2";
      if (i + 1 == info.squared_error.size()) out << ", uncovered";
      out << ' ' << number(info.squared_error[i]);
    }
    out << ", needs " << info.needs.size() << " blocks\n";
  }
}

} // namespace

void dump(std::ostream& out, const std::string& path, bool annotate) {
  if (annotate) {
    Dump(out, path).annotate();
  } else {
    summarise(out, path);
  }
}

} // namespace ptet::file
