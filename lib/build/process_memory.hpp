// What the process has of memory, as the system counts it.
#pragma once

#include <cstdint>

namespace ptet::build {

/// Resident bytes now; 0 where the system does not tell.
[[nodiscard]] std::uint64_t resident_bytes();
/// The most that were resident at any time since the process began; 0 where the system does not tell.
[[nodiscard]] std::uint64_t peak_resident_bytes();
/// Memory that was freed goes back to the system now, as far as the C library can.
void release_freed_memory();

} // namespace ptet::build
