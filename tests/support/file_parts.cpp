#include "support/file_parts.hpp"

#include <algorithm>
#include <stdexcept>

namespace ptet::test {

void flip(std::vector<std::byte>& bytes, std::size_t bit) {
  bytes[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
}

FileParts::FileParts(const Bytes& bytes) {
  file::ByteReader footer_reader(std::span{bytes}.last(file::kFooterBytes), "footer", 0);
  const file::Footer footer = file::parse_footer(footer_reader);
  file::ByteReader directory(
      std::span{bytes}.subspan(footer.directory_offset, footer.section_count * file::kSectionBytes), "directory", 0);
  sections = file::parse_directory(directory, footer.section_count);
  header.assign(bytes.begin(), bytes.begin() + file::kHeaderBytes);
  for (const file::Section& section : sections) {
    const auto first = bytes.begin() + static_cast<std::ptrdiff_t>(section.offset);
    Bytes stored(first, first + static_cast<std::ptrdiff_t>(section.stored_bytes));
    raw.push_back(is(section, file::SectionKind::kBlocks) ? stored : file::expand(section, stored));
  }
}

FileParts::Bytes& FileParts::of(file::SectionKind kind) {
  const auto found = std::find_if(sections.begin(), sections.end(), [&](const auto& s) { return is(s, kind); });
  return raw.at(static_cast<std::size_t>(found - sections.begin()));
}

std::vector<file::TableRow> FileParts::rows() {
  file::ByteReader header_reader(header, "header", 0);
  auto fixed = file::parse_header(header_reader);
  file::ByteReader arrays(of(file::SectionKind::kArrays), "arrays", 0);
  static_cast<void>(file::parse_arrays(arrays, fixed));
  file::ByteReader table(of(file::SectionKind::kTable), "table", 0);
  const std::size_t size = of(file::SectionKind::kBlocks).size();
  return file::parse_table(table, fixed, {0, 0, 0, size, size, 0});
}

void FileParts::set_rows(const std::vector<file::TableRow>& rows) {
  file::ByteReader header_reader(header, "header", 0);
  file::ByteWriter out;
  file::put_table(out, file::parse_header(header_reader).header, rows);
  of(file::SectionKind::kTable) = out.take();
}

void FileParts::mend_blocks() {
  auto table = rows();
  for (file::TableRow& row : table) {
    row.hash = file::hash_of(std::span(of(file::SectionKind::kBlocks)).subspan(row.info.offset, row.info.stored_bytes));
  }
  set_rows(table);
}

FileParts::Bytes FileParts::join() const {
  file::ByteWriter out;
  out.put_bytes(std::span(header).first(file::kHeaderBytes - 8));
  out.put(file::hash_of(std::span(header).first(file::kHeaderBytes - 8)));
  auto placed = sections;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    placed[i].offset = out.size();
    placed[i].stored_bytes = placed[i].raw_bytes = raw[i].size();
    if (!is(placed[i], file::SectionKind::kBlocks)) placed[i].hash = file::hash_of(raw[i]);
    out.put_bytes(raw[i]);
  }
  const std::uint64_t directory = out.size();
  file::put_directory(out, placed);
  const auto hash = file::hash_of(std::span(out.bytes()).subspan(directory));
  file::put_footer(out, {directory, static_cast<std::uint32_t>(placed.size()), hash, out.size() + file::kFooterBytes});
  return out.take();
}

FailingSource::FailingSource(std::vector<std::byte> bytes, Fails fails)
    : bytes_(std::move(bytes)), fails_(std::move(fails)) {}

void FailingSource::read(std::uint64_t offset, std::span<std::byte> into) {
  ++reads_;
  const std::lock_guard guard(mutex_);
  if (fails_ && fails_(offset, into.size())) throw std::runtime_error("the line is dead");
  std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), into.size(), into.begin());
  if (times_garbled_ > 0 && offset <= garbled_ && garbled_ - offset < into.size()) {
    --times_garbled_;
    into[garbled_ - offset] ^= std::byte{1};
  }
  bytes_given_ += into.size();
}

void FailingSource::set(Fails fails) {
  const std::lock_guard guard(mutex_);
  fails_ = std::move(fails);
}

void FailingSource::garble(std::uint64_t offset, int times) {
  const std::lock_guard guard(mutex_);
  garbled_ = offset;
  times_garbled_ = times;
}

} // namespace ptet::test
