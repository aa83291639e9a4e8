#include "fuzz/mutate_file.hpp"

#include "support/file_parts.hpp"

#include <algorithm>
#include <bit>
#include <exception>
#include <limits>

namespace ptet::fuzz {
namespace {

using file::SectionKind;
using test::FileParts;

/// A number that code may trip over, near `value` or at the ends of its type.
std::uint64_t odd_number(std::uint64_t value, unsigned bits, Mutator& mutator) {
  const std::uint64_t most = bits == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << bits) - 1;
  switch (mutator.below(8)) {
  case 0: return value + 1;
  case 1: return value - 1;
  case 2: return 0;
  case 3: return most - mutator.below(3);
  case 4: return most / 2 + mutator.below(3);
  case 5: return value ^ std::uint64_t{1} << mutator.below(bits);
  case 6: return value * 2;
  default: return mutator.random() & most >> mutator.below(bits);
  }
}

double odd_double(double value, Mutator& mutator) {
  switch (mutator.below(8)) {
  case 0: return 0;
  case 1: return -value;
  case 2: return std::numeric_limits<double>::infinity();
  case 3: return std::numeric_limits<double>::quiet_NaN();
  case 4: return std::numeric_limits<double>::max();
  case 5: return std::numeric_limits<double>::denorm_min();
  case 6: return value * 1e-9;
  default: return std::bit_cast<double>(odd_number(std::bit_cast<std::uint64_t>(value), 64, mutator));
  }
}

template <class T>
void make_odd(T& value, Mutator& mutator) {
  if constexpr (std::is_floating_point_v<T>) {
    value = odd_double(value, mutator);
  } else {
    value = static_cast<T>(odd_number(value, 8 * sizeof(T), mutator));
  }
}

/// A field of any width, behind the magic and before the hash; as a number of either kind where it is wide enough.
void mutate_header(Bytes& header, Mutator& mutator) {
  const std::size_t width = std::size_t{1} << mutator.below(4);
  const std::size_t offset = 8 + width * mutator.below((file::kHeaderBytes - 16) / width);
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < width; ++i)
    value |= static_cast<std::uint64_t>(header[offset + i]) << (8 * i);
  if (width == 8 && mutator.below(2) == 0) {
    value = std::bit_cast<std::uint64_t>(odd_double(std::bit_cast<double>(value), mutator));
  } else {
    value = odd_number(value, static_cast<unsigned>(8 * width), mutator);
  }
  for (std::size_t i = 0; i < width; ++i)
    header[offset + i] = static_cast<std::byte>(value >> (8 * i) & 0xFF);
}

void mutate_row(file::TableRow& row, std::size_t blocks, Mutator& mutator) {
  file::BlockInfo& info = row.info;
  switch (mutator.below(10)) {
  case 0: make_odd(info.record_count, mutator); break;
  case 1: make_odd(row.version_count, mutator); break;
  case 2: make_odd(info.box_min[mutator.below(3)], mutator); break;
  case 3: make_odd(info.box_max[mutator.below(3)], mutator); break;
  case 4: make_odd(info.max_error[mutator.below(info.max_error.size())], mutator); break;
  case 5: make_odd(info.max_order, mutator); break;
  case 6:
    if (!info.squared_error.empty()) make_odd(info.squared_error[mutator.below(info.squared_error.size())], mutator);
    break;
  case 7:
    if (!info.needs.empty())
      info.needs.erase(info.needs.begin() + static_cast<std::ptrdiff_t>(mutator.below(info.needs.size())));
    break;
  case 8: make_odd(info.max_own[mutator.below(info.max_own.size())], mutator); break;
  default:
    info.needs.push_back(static_cast<std::uint32_t>(mutator.below(blocks + 1)));
    std::sort(info.needs.begin(), info.needs.end());
    info.needs.erase(std::unique(info.needs.begin(), info.needs.end()), info.needs.end());
    break;
  }
}

/// Changes the bytes of one block, and often its length.
void mutate_block(FileParts& parts, std::vector<file::TableRow>& rows, std::size_t most_bytes, Mutator& mutator) {
  Bytes& all = parts.of(SectionKind::kBlocks);
  const std::size_t which = mutator.below(rows.size());
  const file::BlockInfo& info = rows[which].info;
  const auto begin = all.begin() + static_cast<std::ptrdiff_t>(info.offset);
  Bytes block(begin, begin + static_cast<std::ptrdiff_t>(info.stored_bytes));
  mutator.change(block, block.size() + std::min<std::size_t>(most_bytes, 16));
  Bytes joined(all.begin(), begin);
  joined.insert(joined.end(), block.begin(), block.end());
  joined.insert(joined.end(), begin + static_cast<std::ptrdiff_t>(info.stored_bytes), all.end());
  all = std::move(joined);
  rows[which].info.stored_bytes = block.size();
  for (std::size_t b = which + 1; b < rows.size(); ++b)
    rows[b].info.offset = rows[b - 1].info.offset + rows[b - 1].info.stored_bytes;
  parts.set_rows(rows);
  for (file::TableRow& row : rows)
    row.hash = file::hash_of(std::span(all).subspan(row.info.offset, row.info.stored_bytes));
  parts.set_rows(rows);
}

void mutate_section(FileParts& parts, std::size_t most_bytes, Mutator& mutator) {
  const std::size_t which = mutator.below(parts.raw.size());
  Bytes& raw = parts.raw[which];
  const std::size_t size = raw.size();
  mutator.change(raw, size + std::min<std::size_t>(most_bytes, 64));
  // A model, base or input order of another length is refused at the door.
  const auto is = [&](SectionKind kind) { return FileParts::is(parts.sections[which], kind); };
  const bool has_fixed_size = is(SectionKind::kModel) || is(SectionKind::kBase) || is(SectionKind::kInputOrder);
  if (has_fixed_size && mutator.below(8) != 0) raw.resize(size);
}

void rearrange(FileParts& parts, Mutator& mutator) {
  const std::size_t which = mutator.below(parts.raw.size());
  const std::size_t other = mutator.below(parts.raw.size());
  switch (mutator.below(4)) {
  case 0:
    parts.sections.erase(parts.sections.begin() + static_cast<std::ptrdiff_t>(which));
    parts.raw.erase(parts.raw.begin() + static_cast<std::ptrdiff_t>(which));
    break;
  case 1:
    parts.sections.push_back(
        {static_cast<std::uint32_t>(mutator.below(10)), static_cast<std::uint32_t>(mutator.below(4)), 0, 0, 0, 0});
    parts.raw.emplace_back(mutator.below(9));
    break;
  case 2: make_odd(parts.sections[which].flags, mutator); break;
  default:
    std::swap(parts.sections[which], parts.sections[other]);
    std::swap(parts.raw[which], parts.raw[other]);
    break;
  }
}

void mutate_parts(FileParts& parts, std::size_t most_bytes, Mutator& mutator) {
  switch (mutator.below(8)) {
  case 0: mutate_header(parts.header, mutator); return;
  case 1: mutate_section(parts, most_bytes, mutator); return;
  case 2:
    if (mutator.below(8) == 0 && !parts.raw.empty()) {
      rearrange(parts, mutator);
      return;
    }
    break;
  default: break;
  }
  // Rows cannot be had where the table is not sound, which makes it an Error.
  auto rows = parts.rows();
  if (rows.empty()) {
    mutate_section(parts, most_bytes, mutator);
  } else if (mutator.below(5) == 0) {
    mutate_row(rows[mutator.below(rows.size())], rows.size(), mutator);
    parts.set_rows(rows);
  } else {
    mutate_block(parts, rows, most_bytes, mutator);
  }
}

} // namespace

void change_bytes(Bytes& bytes, std::size_t most_bytes, std::minstd_rand& random) {
  for (std::size_t changes = 1 + random() % 4; changes > 0; --changes) {
    const std::size_t at = bytes.empty() ? 0 : random() % bytes.size();
    const auto place = bytes.begin() + static_cast<std::ptrdiff_t>(at);
    switch (random() % 5) {
    case 0:
      if (bytes.size() < most_bytes) bytes.insert(place, static_cast<std::byte>(random() & 0xFF));
      break;
    case 1:
      if (!bytes.empty()) bytes.erase(place);
      break;
    case 2:
      if (!bytes.empty()) *place = static_cast<std::byte>(random() & 0xFF);
      break;
    default:
      if (!bytes.empty()) *place ^= static_cast<std::byte>(1U << random() % 8);
      break;
    }
  }
  if (bytes.size() > most_bytes) bytes.resize(most_bytes);
}

bool has_parts(Input file) {
  if (file.size() < file::kHeaderBytes + file::kFooterBytes) return false;
  try {
    const std::size_t most = file.size() - file::kHeaderBytes - file::kFooterBytes;
    file::ByteReader in(file.last(file::kFooterBytes), "footer", 0);
    const file::Footer footer = file::parse_footer(in);
    const std::size_t bytes = footer.section_count * file::kSectionBytes;
    if (bytes > most || footer.directory_offset != file::kHeaderBytes + most - bytes) return false;
    file::ByteReader directory(file.subspan(footer.directory_offset, bytes), "directory", 0);
    const auto sections = file::parse_directory(directory, footer.section_count);
    std::uint32_t known = 0;
    for (const file::Section& section : sections) {
      if (section.offset + section.stored_bytes > footer.directory_offset) return false;
      if (section.raw_bytes > std::uint64_t{1} << 24) return false;
      if (section.kind >= 1 && section.kind <= 6) known |= 1U << section.kind;
    }
    return known == 0x7E;
  } catch (const Error&) {
    return false;
  }
}

void mutate_file(Bytes& file, std::size_t most_bytes, Mutator& mutator) {
  if (has_parts(file)) {
    try {
      FileParts parts(file);
      const std::size_t room = most_bytes > file.size() ? most_bytes - file.size() : 0;
      for (std::size_t changes = 1 + mutator.below(3); changes > 0; --changes)
        mutate_parts(parts, room, mutator);
      Bytes changed = parts.join();
      if (changed.size() <= most_bytes) {
        file = std::move(changed);
        return;
      }
    } catch (const std::exception&) { // not sound any more: below
    }
  }
  mutator.change(file, most_bytes);
}

} // namespace ptet::fuzz
