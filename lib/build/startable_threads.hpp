// How many threads the system lets this process have: less than the machine has cores, perhaps, in a container that
// limits processes or under a limit of address space.
#pragma once

namespace ptet::build {

/// Of BuildOptions::threads; more are as many.
inline constexpr unsigned kMostThreads = 1024;

/// At most `wanted`, the one that calls included, at least 1. To be asked before TBB is: where the system refuses one
/// of the threads that it starts, TBB ends the process. Where fewer than wanted can be started it is a quarter of
/// these: room for the stacks and the memory of those that do the work. Cost: starts the threads and ends them, some 20
/// microseconds each.
[[nodiscard]] unsigned startable_threads(unsigned wanted);

} // namespace ptet::build
