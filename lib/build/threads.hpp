// As many threads as the options ask for, wherever parallel work is begun.
#pragma once

#include "ptet/build.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/task_arena.h>

namespace ptet::build {

/// While one is there, run() works on so many threads. More than there are cores are allowed, where they are asked for.
class Threads {
public:
  explicit Threads(const BuildOptions& options)
      : count_(options.threads == 0 ? oneapi::tbb::info::default_concurrency()
                                    : static_cast<int>(std::min(options.threads, kMost))),
        control_(oneapi::tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(count_)),
        arena_(count_) {}

  /// On the calling thread, with the others where `work` has them share it.
  template <class Work>
  decltype(auto) run(Work&& work) {
    return arena_.execute(std::forward<Work>(work));
  }

private:
  static constexpr unsigned kMost = 1024;

  int count_;
  oneapi::tbb::global_control control_;
  oneapi::tbb::task_arena arena_;
};

} // namespace ptet::build
