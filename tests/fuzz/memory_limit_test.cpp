// Files that announce more than a reader may take: the peak of what opening and extracting hold at once stays within
// the caller's limit and 64 MiB. Its own program, because it counts all memory.
#include "formats/ptet/layout.hpp"
#include "fuzz/mutate_file.hpp"
#include "fuzz/sample_files.hpp"
#include "ptet/session.hpp"
#include "support/counted_memory.hpp"
#include "support/file_parts.hpp"

#include <algorithm>
#include <cstdio>
#include <string>

#include <zstd.h>

namespace {

using namespace ptet;
using fuzz::Bytes;
using test::FileParts;

constexpr std::size_t kMiB = std::size_t{1} << 20;
constexpr std::size_t kSlack = 64 * kMiB;
constexpr std::size_t kLimits[] = {kMiB / 4, 4 * kMiB, 64 * kMiB};
constexpr std::size_t kLargeLimits[] = {64 * kMiB, 256 * kMiB};

int failures = 0;
std::size_t files = 0, refused = 0, worst_beyond = 0;

void check(const Bytes& bytes, const std::string& what, std::span<const std::size_t> limits = kLimits) {
  for (const std::size_t limit : limits) {
    OpenOptions options;
    options.limits.max_bytes = limit;
    auto copy = bytes;
    const std::size_t before = test::bytes_held();
    test::reset_most_bytes_held();
    try {
      const auto data = Dataset::open_memory(std::move(copy), options);
      Request whole;
      whole.input_order = data->info().has_input_order;
      static_cast<void>(data->extract(whole));
      Session session(data);
      Request request;
      request.max_tets = data->info().tets / 2;
      static_cast<void>(session.update(request));
    } catch (const Error& error) {
      ++refused;
      if (error.code() != ErrorCode::kLimit && error.code() != ErrorCode::kCorruptFile) {
        std::fprintf(stderr, "%s: %s\n", what.c_str(), error.what());
        ++failures;
      }
    }
    ++files;
    const std::size_t taken = test::most_bytes_held() - before;
    worst_beyond = std::max(worst_beyond, taken - std::min(taken, limit));
    if (taken <= limit + kSlack) continue;
    std::fprintf(stderr, "%s: %zu MiB taken under a limit of %zu MiB\n", what.c_str(), taken / kMiB, limit / kMiB);
    ++failures;
  }
}

/// A file put together with sections compressed as far as they go: few bytes that stand for many.
Bytes join(const FileParts& parts) {
  file::ByteWriter out;
  out.put_bytes(std::span(parts.header).first(file::kHeaderBytes - 8));
  out.put(file::hash_of(std::span(parts.header).first(file::kHeaderBytes - 8)));
  auto placed = parts.sections;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    const Bytes& raw = parts.raw[i];
    Bytes stored(ZSTD_compressBound(raw.size()));
    stored.resize(ZSTD_compress(stored.data(), stored.size(), raw.data(), raw.size(), 3));
    const bool is_blocks = FileParts::is(placed[i], file::SectionKind::kBlocks);
    // A frame must not stand for more than so many times its size.
    const bool is_raw = is_blocks || stored.size() >= raw.size() || raw.size() > stored.size() * file::kMaxExpansion;
    const Bytes& bytes = is_raw ? raw : stored;
    placed[i].offset = out.size();
    placed[i].stored_bytes = bytes.size();
    placed[i].raw_bytes = raw.size();
    if (!is_blocks) placed[i].hash = file::hash_of(bytes);
    out.put_bytes(bytes);
  }
  const std::uint64_t directory = out.size();
  file::put_directory(out, placed);
  const auto hash = file::hash_of(std::span(out.bytes()).subspan(directory));
  file::put_footer(out, {directory, static_cast<std::uint32_t>(placed.size()), hash, out.size() + file::kFooterBytes});
  return out.take();
}

/// Zeros, and now and then something else, so that a frame does not stand for too much.
void pad(Bytes& bytes, std::size_t size) {
  while (bytes.size() < size)
    bytes.push_back(bytes.size() % 512 == 0 ? static_cast<std::byte>(bytes.size() >> 9 & 0x7F) : std::byte{0});
}

void change_header(const Bytes& sample) {
  for (std::size_t offset = 8; offset < file::kHeaderBytes - 8; offset += 4)
    for (const std::uint32_t value : {0x7FFFFFFFU, 0xFFFFFFFDU, 0x01000000U, 0x00100000U, 0x00000FFFU}) {
      FileParts parts(sample);
      for (std::size_t i = 0; i < 4; ++i)
        parts.header[offset + i] = static_cast<std::byte>(value >> (8 * i) & 0xFF);
      check(parts.join(), "header at " + std::to_string(offset));
    }
}

file::FixedHeader header_of(const FileParts& parts) {
  file::ByteReader in(parts.header, "header", 0);
  return file::parse_header(in);
}

void set_header(FileParts& parts, const file::FixedHeader& fixed) {
  file::ByteWriter out;
  file::put_header(out, fixed);
  parts.header = out.take();
}

/// A base of many vertices, and of many tets, all zero.
void grow_base(const Bytes& sample) {
  for (const std::uint32_t vertices : {100'000U, 2'000'000U})
    for (const std::uint32_t tets : {0U, 1'000'000U}) {
      FileParts parts(sample);
      file::FixedHeader fixed = header_of(parts);
      file::ByteReader in(parts.of(file::SectionKind::kArrays), "arrays", 0);
      file::FixedHeader with_arrays = fixed;
      static_cast<void>(file::parse_arrays(in, with_arrays));
      fixed.header.base_vertex_count = vertices;
      fixed.header.base_tet_count = tets;
      fixed.header.tet_count = tets + 1;
      set_header(parts, fixed);
      Bytes& base = parts.of(file::SectionKind::kBase);
      base.clear();
      pad(base, vertices * file::vertex_bytes(with_arrays.header) + std::size_t{16} * tets);
      check(join(parts), "base of " + std::to_string(vertices) + " vertices, " + std::to_string(tets) + " tets");
    }
}

/// Arrays of as many components as there may be: a byte of the section is one.
void grow_components(const Bytes& sample) {
  constexpr std::uint32_t kComponents = 1024;
  for (const std::uint32_t arrays : {50U, 840U}) {
    FileParts parts(sample);
    file::FixedHeader fixed = header_of(parts);
    file::Header more;
    std::vector<file::Precisions> precisions{file::Precisions(3)};
    for (std::uint32_t a = 0; a < arrays; ++a) {
      more.arrays.push_back({"more " + std::to_string(a), ScalarType::kUInt8, kComponents});
      precisions.emplace_back(kComponents);
    }
    file::ByteWriter out;
    out.put_bytes(parts.of(file::SectionKind::kArrays));
    file::put_arrays(out, more, precisions);
    parts.of(file::SectionKind::kArrays) = out.take();
    fixed.array_count += arrays;
    set_header(parts, fixed);
    Bytes& base = parts.of(file::SectionKind::kBase);
    pad(base, base.size() + std::size_t{fixed.header.base_vertex_count} * arrays * kComponents);
    check(join(parts), std::to_string(arrays) + " arrays of many components", kLargeLimits);
  }
}

/// Manifest and arrays that are long, and a manifest of nothing but empty texts.
void grow_texts(const Bytes& sample) {
  for (const file::SectionKind kind : {file::SectionKind::kManifest, file::SectionKind::kArrays}) {
    for (const std::size_t size : {100'000U, 8'000'000U}) {
      FileParts parts(sample);
      pad(parts.of(kind), size);
      check(join(parts), std::string("long ") + file::name_of(kind));
    }
  }
  for (const std::size_t texts : {100'000U, 4'000'000U}) {
    FileParts parts(sample);
    file::ByteWriter out;
    for (int i = 0; i < 3; ++i)
      out.put_varint(0);
    out.put_varint(texts);
    Bytes manifest = out.take();
    manifest.resize(manifest.size() + 2 * texts + 1);
    parts.of(file::SectionKind::kManifest) = manifest;
    check(join(parts), "empty texts");
  }
}

/// Many rows of the block table, for many blocks that say all that their bytes allow.
void grow_table(const Bytes& sample) {
  for (const std::uint32_t blocks : {1000U, 200'000U}) {
    FileParts parts(sample);
    auto rows = parts.rows();
    file::TableRow row = rows.front();
    constexpr std::size_t kBlockBytes = 64;
    row.info.stored_bytes = kBlockBytes;
    row.info.record_count = 4;
    row.version_count = kBlockBytes * file::kMaxVersionsPerByte;
    row.info.needs.clear();
    Bytes block(kBlockBytes);
    row.hash = file::hash_of(block);
    rows.assign(blocks, row);
    parts.set_rows(rows);
    parts.of(file::SectionKind::kBlocks) = Bytes(kBlockBytes * blocks);
    file::FixedHeader fixed = header_of(parts);
    fixed.header.block_count = blocks;
    fixed.header.record_count = 4 * blocks;
    fixed.version_count = std::uint64_t{row.version_count} * blocks;
    set_header(parts, fixed);
    check(join(parts), std::to_string(blocks) + " blocks");
  }
}

/// The last run of a block is of a generation that is far from all others.
void grow_generations(const Bytes& sample) {
  for (const std::uint64_t generation :
       {std::uint64_t{1} << 20, std::uint64_t{1} << 28, (std::uint64_t{1} << 32) - 1000}) {
    FileParts parts(sample);
    auto rows = parts.rows();
    file::BlockInfo& info = rows.back().info;
    Bytes& all = parts.of(file::SectionKind::kBlocks);
    const Bytes block(all.begin() + static_cast<std::ptrdiff_t>(info.offset), all.end());
    file::ByteReader in(block, "block", 0);
    std::size_t begin = 0, end = 0;
    for (std::uint64_t records = 0; records < info.record_count;) {
      begin = in.position();
      static_cast<void>(in.get_varint("generation"));
      end = in.position();
      records += in.get_varint("count");
    }
    file::ByteWriter out;
    out.put_bytes(std::span(all).first(info.offset + begin));
    out.put_varint(generation);
    out.put_bytes(std::span(block).subspan(end));
    all = out.take();
    info.stored_bytes = all.size() - info.offset;
    parts.set_rows(rows);
    parts.mend_blocks();
    check(parts.join(), "generation " + std::to_string(generation));
  }
}

void mutate(const std::vector<Bytes>& samples) {
  fuzz::Mutator mutator;
  mutator.change = [&](Bytes& bytes, std::size_t most) { fuzz::change_bytes(bytes, most, mutator.random); };
  for (int i = 0; i < 1000; ++i) {
    Bytes file = samples[static_cast<std::size_t>(i) % samples.size()];
    for (int times = 0; times < 3; ++times)
      fuzz::mutate_file(file, file.size() + 1000, mutator);
    check(file, "mutation " + std::to_string(i));
  }
}

} // namespace

int main() {
  const std::vector<Bytes>& samples = fuzz::sample_files();
  for (const Bytes& sample : {samples.front(), samples.back()}) {
    check(sample, "sample");
    change_header(sample);
    grow_base(sample);
    grow_texts(sample);
    grow_components(sample);
    grow_table(sample);
    grow_generations(sample);
  }
  mutate(samples);
  std::printf("%zu files opened, %zu refused, at most %zu KiB beyond the limit\n", files, refused, worst_beyond / 1024);
  return failures == 0 && refused > files / 10 ? 0 : 1;
}
