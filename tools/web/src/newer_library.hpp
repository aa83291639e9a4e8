// What the run-time library takes from C++20's standard library and Debian's emscripten (libc++ 13) does not have yet.
// Included before everything else, by the compiler's command line.
#pragma once

#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <system_error>
#include <type_traits>
#include <version>

namespace std { // NOLINT: these are the standard's own names

#ifndef __cpp_lib_bit_cast
template <class To, class From>
[[nodiscard]] constexpr To bit_cast(const From& from) noexcept {
  static_assert(sizeof(To) == sizeof(From) && is_trivially_copyable_v<To> && is_trivially_copyable_v<From>);
  return __builtin_bit_cast(To, from);
}
#endif

#ifndef __cpp_lib_smart_ptr_for_overwrite
template <class T>
[[nodiscard]] unique_ptr<T> make_unique_for_overwrite(size_t size) {
  static_assert(is_array_v<T> && extent_v<T> == 0);
  return unique_ptr<T>(new remove_extent_t<T>[size]);
}
#endif

#ifndef __cpp_lib_to_chars
/// The fewest digits that read back as the same number.
inline to_chars_result to_chars(char* first, char* last, double value) {
  const auto room = static_cast<size_t>(last - first);
  for (int digits = 1;; ++digits) {
    const int length = snprintf(first, room, "%.*g", digits, value);
    if (length < 0 || static_cast<size_t>(length) >= room) return {last, errc::value_too_large};
    if (digits == 17 || strtod(first, nullptr) == value) return {first + length, errc{}};
  }
}
#endif

} // namespace std
