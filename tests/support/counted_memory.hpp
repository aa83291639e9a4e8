// Memory that is counted: what operator new has given and not got back. For programs of their own, which compile
// counted_memory.cpp in: it replaces operator new and delete.
#pragma once

#include <cstddef>

namespace ptet::test {

[[nodiscard]] std::size_t bytes_held();
/// The most at any time since the last reset.
[[nodiscard]] std::size_t most_bytes_held();
void reset_most_bytes_held();

} // namespace ptet::test
