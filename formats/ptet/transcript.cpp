#include "formats/ptet/transcript.hpp"

#include "ptet/error.hpp"

#include <zstd.h>

namespace ptet::file {

void Transcript::pack() {
  const std::vector<Unit> units(units_.begin(), units_.end());
  const std::size_t bytes = units.size() * sizeof(Unit);
  std::vector<std::byte> packed(ZSTD_compressBound(bytes));
  const std::size_t size = ZSTD_compress(packed.data(), packed.size(), units.data(), bytes, 1);
  if (ZSTD_isError(size) != 0) throw Error(ErrorCode::kLimit, "compression failed: out of memory");
  packed_.assign(packed.begin(), packed.begin() + static_cast<std::ptrdiff_t>(size));
  packed_units_ = units.size();
  units_ = std::deque<Unit>(); // {} would keep its memory
}

std::vector<Transcript::Unit> Transcript::unpacked() const {
  std::vector<Unit> units(packed_units_);
  const std::size_t bytes = units.size() * sizeof(Unit);
  if (ZSTD_decompress(units.data(), bytes, packed_.data(), packed_.size()) != bytes)
    throw Error(ErrorCode::kLimit, "decompression failed: out of memory");
  return units;
}

} // namespace ptet::file
