#include "formats/ptet/packing.hpp"

#include "formats/ptet/schema.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <memory>

#include <zstd.h>

namespace ptet::file {
namespace {

constexpr int kLevel = 19;
/// Of more than kLittle bytes the level's own tables take up to 85 MB; with these it is 10, and frames of some
/// megabytes become 0.03% longer.
constexpr std::size_t kLittle = std::size_t{1} << 20;
constexpr int kChainLog = 20, kHashLog = 20;
/// Between looks: some seconds of work.
constexpr std::size_t kPackedTogether = std::size_t{1} << 22;
/// A block of a frame takes 4 bytes at least.
constexpr std::size_t kLeastBlock = 4;

void check(std::size_t result) {
  if (ZSTD_isError(result) != 0) throw Error(ErrorCode::kLimit, "compression failed: out of memory");
}

/// Each part of `raw` ends a block: so long as it is no longer than kLeastBlock * kMaxExpansion, the frame is never too
/// small.
std::vector<std::byte> frame_of(std::span<const std::byte> raw, std::size_t part, ZSTD_EndDirective after_part,
                                const std::function<void(std::size_t)>& look) {
  const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(), &ZSTD_freeCCtx);
  if (!context) throw Error(ErrorCode::kLimit, "compression failed: out of memory");
  check(ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, kLevel));
  if (raw.size() > kLittle) {
    check(ZSTD_CCtx_setParameter(context.get(), ZSTD_c_chainLog, kChainLog));
    check(ZSTD_CCtx_setParameter(context.get(), ZSTD_c_hashLog, kHashLog));
  }
  check(ZSTD_CCtx_setPledgedSrcSize(context.get(), raw.size()));
  std::vector<std::byte> frame(ZSTD_compressBound(raw.size()) + kLeastBlock * (raw.size() / part + 1));
  ZSTD_outBuffer out{frame.data(), frame.size(), 0};
  bool is_last = false;
  for (std::size_t begin = 0; !is_last; begin += part) {
    const auto bytes = raw.subspan(begin, std::min(part, raw.size() - begin));
    is_last = begin + bytes.size() == raw.size();
    const ZSTD_EndDirective end = is_last ? ZSTD_e_end : after_part;
    ZSTD_inBuffer in{bytes.data(), bytes.size(), 0};
    std::size_t left = 0;
    do {
      left = ZSTD_compressStream2(context.get(), &out, &in, end);
      check(left);
    } while (in.pos < in.size || (end != ZSTD_e_continue && left > 0));
    look(begin + bytes.size());
  }
  frame.resize(out.pos);
  return frame;
}

} // namespace

std::vector<std::byte> packed(std::span<const std::byte> raw, const std::function<void(std::size_t)>& look) {
  std::vector<std::byte> frame = frame_of(raw, kPackedTogether, ZSTD_e_continue, look);
  if (raw.size() > frame.size() * kMaxExpansion) frame = frame_of(raw, kLeastBlock * kMaxExpansion, ZSTD_e_flush, look);
  if (frame.size() < raw.size()) return frame;
  return {raw.begin(), raw.end()};
}

} // namespace ptet::file
