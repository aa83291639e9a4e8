// As many threads as are asked for, wherever parallel work is begun.
#pragma once

#include "build/startable_threads.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/task_arena.h>

namespace ptet::build {

/// While one is there, run() works on so many threads.
class Threads {
public:
  /// 0: as many as the machine has. More than there are cores are allowed, where they are asked for; fewer than wanted
  /// it is where the system refuses some.
  explicit Threads(unsigned wanted)
      : count_(static_cast<int>(startable_threads(wanted == 0
                                                      ? static_cast<unsigned>(oneapi::tbb::info::default_concurrency())
                                                      : std::min(wanted, kMostThreads)))),
        control_(oneapi::tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(count_)),
        arena_(count_) {}

  /// On the calling thread, with the others where `work` has them share it.
  template <class Work>
  decltype(auto) run(Work&& work) {
    return arena_.execute(std::forward<Work>(work));
  }

private:
  int count_;
  oneapi::tbb::global_control control_;
  oneapi::tbb::task_arena arena_;
};

} // namespace ptet::build
