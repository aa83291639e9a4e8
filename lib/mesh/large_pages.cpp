#include "mesh/large_pages.hpp"

#include <cstdint>

#if defined(__linux__) && __has_include(<sys/mman.h>)
#include <sys/mman.h>
#include <unistd.h>
#endif

namespace ptet {

void ask_for_large_pages([[maybe_unused]] void* begin, [[maybe_unused]] std::size_t bytes) noexcept {
#ifdef MADV_HUGEPAGE
  constexpr std::size_t kLarge = std::size_t{4} << 20U; // two large pages: one of them is whole
  if (bytes < kLarge) return;
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  const std::size_t into_page = reinterpret_cast<std::uintptr_t>(begin) % page;
  const std::size_t before = into_page == 0 ? 0 : page - into_page;
  // An advice: whatever comes of it, nothing has failed.
  static_cast<void>(madvise(static_cast<char*>(begin) + before, (bytes - before) / page * page, MADV_HUGEPAGE));
#endif
}

} // namespace ptet
