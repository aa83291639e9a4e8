// Work on a range in parallel whose findings come in the order of the range, whatever the number of threads.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include <oneapi/tbb/parallel_for.h>

namespace ptet {

/// Calls `look_at(part, first, last)` for [begin, end) in runs of `together`, in parallel; returns what they made of
/// their parts, in their order.
template <class Part, class LookAt>
[[nodiscard]] std::vector<Part> by_parts(std::size_t begin, std::size_t end, std::size_t together, LookAt&& look_at) {
  std::vector<Part> parts((end - begin + together - 1) / together);
  oneapi::tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t p) {
    const std::size_t first = begin + p * together;
    look_at(parts[p], first, std::min(first + together, end));
  });
  return parts;
}

template <class T>
void append(std::vector<T>& to, const std::vector<T>& what) {
  to.insert(to.end(), what.begin(), what.end());
}

} // namespace ptet
