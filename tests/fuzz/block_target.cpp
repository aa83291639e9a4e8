#include "fuzz/checks.hpp"
#include "fuzz/sample_files.hpp"
#include "fuzz/targets.hpp"
#include "support/file_parts.hpp"

namespace ptet::fuzz {
namespace {

/// A block of a sample file, to be filled with anything.
struct Place {
  std::size_t file, block;
};

const std::vector<Place>& places() {
  static const std::vector<Place> all = [] {
    std::vector<Place> found;
    for (std::size_t f = 0; f < sample_files().size(); ++f) {
      const std::size_t blocks = test::FileParts(sample_files()[f]).rows().size();
      for (std::size_t b = 0; b < blocks; ++b)
        found.push_back({f, b});
    }
    return found;
  }();
  return all;
}

Bytes with_block(const Place& place, Input payload) {
  test::FileParts parts(sample_files()[place.file]);
  auto rows = parts.rows();
  Bytes& all = parts.of(file::SectionKind::kBlocks);
  Bytes joined;
  for (std::size_t b = 0; b < rows.size(); ++b) {
    file::TableRow& row = rows[b];
    const Input old = std::span(all).subspan(row.info.offset, row.info.stored_bytes);
    const Input block = b == place.block ? payload : old;
    row.info.offset = joined.size();
    row.info.stored_bytes = block.size();
    row.hash = file::hash_of(block);
    joined.insert(joined.end(), block.begin(), block.end());
  }
  all = std::move(joined);
  parts.set_rows(rows);
  return parts.join();
}

} // namespace

void run_block(Input input) {
  if (input.empty()) return;
  const Place& place = places()[static_cast<std::size_t>(input[0]) % places().size()];
  const Bytes bytes = with_block(place, input.subspan(1));
  try {
    file::Reader reader(file::over_memory(bytes), small_limits());
    static_cast<void>(load_all(reader));
  } catch (const Error& error) {
    check_refusal(error);
  }
}

std::vector<Bytes> block_seeds() {
  std::vector<Bytes> seeds;
  for (std::size_t i = 0; i < places().size(); ++i) {
    test::FileParts parts(sample_files()[places()[i].file]);
    const auto rows = parts.rows();
    const file::BlockInfo& info = rows[places()[i].block].info;
    const Input block = std::span(parts.of(file::SectionKind::kBlocks)).subspan(info.offset, info.stored_bytes);
    Bytes& seed = seeds.emplace_back(Bytes{static_cast<std::byte>(i)});
    seed.insert(seed.end(), block.begin(), block.end());
  }
  return seeds;
}

} // namespace ptet::fuzz
