// Large pages behind lists that are large: the system hands out memory page by page when it is first written to, which
// for lists of many megabytes takes longer than writing them, and what is looked up all over such a list is found
// sooner where fewer pages have to be known. Where the system has no large pages, or decides against them, everything
// is as without.
#pragma once

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <memory>
#include <vector>

namespace ptet {

/// Asks for large pages in [begin, begin + bytes), memory that is there but not yet written to. Not where it is little.
/// Thread rule: any.
void ask_for_large_pages(void* begin, std::size_t bytes) noexcept;

/// As std::allocator, and asks for large pages.
template <class T>
struct LargePageAllocator {
  using value_type = T;

  LargePageAllocator() = default;
  template <class U>
  LargePageAllocator(const LargePageAllocator<U>& /*other*/) {}

  [[nodiscard]] T* allocate(std::size_t count) {
    T* const memory = std::allocator<T>().allocate(count);
    ask_for_large_pages(memory, count * sizeof(T));
    return memory;
  }
  void deallocate(T* memory, std::size_t count) { std::allocator<T>().deallocate(memory, count); }

  template <class U>
  friend bool operator==(const LargePageAllocator& /*a*/, const LargePageAllocator<U>& /*b*/) {
    return true;
  }
};

template <class T>
using LargeVector = std::vector<T, LargePageAllocator<T>>;

/// list.reserve(count), for lists that have to be std::vectors, and asks for large pages where that takes new memory.
template <class T>
void reserve_large(std::vector<T>& list, std::size_t count) {
  if (count <= list.capacity()) return;
  std::vector<T> larger;
  larger.reserve(count);
  ask_for_large_pages(larger.data(), count * sizeof(T));
  larger.insert(larger.end(), std::make_move_iterator(list.begin()), std::make_move_iterator(list.end()));
  list.swap(larger);
}

/// To be called before a list that grows gets its `count`-th element: where there is no room it gets twice as much.
template <class T>
void grow_large(std::vector<T>& list, std::size_t count) {
  if (count > list.capacity()) reserve_large(list, std::max(count, 2 * list.capacity()));
}

/// list.resize(count, value), and asks for large pages where that takes new memory.
template <class T>
void resize_large(std::vector<T>& list, std::size_t count, const T& value = T()) {
  grow_large(list, count);
  list.resize(count, value);
}

} // namespace ptet
