// What every function of the C interface is wrapped in: no exception leaves it, and what went wrong becomes a status
// and, where the caller wants one, an error object.
#pragma once

#include "ptet/error.hpp"
#include "ptet/progress.hpp"
#include "ptet/ptet.h"

#include <algorithm>
#include <cstring>
#include <string>

namespace ptet::capi {

/// Called while an exception is being handled: its status, and its error object at `error` unless that is nullptr.
ptet_status report_exception(ptet_error** error) noexcept;

[[nodiscard]] ptet_status status_of(ErrorCode code);

/// Runs the body of a function that may fail.
template <class Body>
ptet_status guarded(ptet_error** error, Body&& body) noexcept {
  if (error != nullptr) *error = nullptr;
  try {
    body();
    return PTET_OK;
  } catch (...) {
    return report_exception(error);
  }
}

[[noreturn]] void refuse(const std::string& why);

/// Throws Error(kBadArgument) when the pointer is NULL; `what` begins the sentence.
template <class T>
T& required(T* pointer, const char* what) {
  if (pointer == nullptr) refuse(std::string(what) + " is NULL");
  return *pointer;
}

/// Bytes of the first published version of a struct: no caller knows less. To be given for a struct that grows.
template <class Struct>
inline constexpr std::uint64_t kFirstSize = sizeof(Struct);

/// How many bytes of the struct both sides know. Throws Error(kBadArgument) when struct_size was not set.
template <class Struct>
std::size_t known_size(const Struct* given, const char* what) {
  constexpr std::uint64_t kMost = 4096; // no version will have as much: what was never set often has
  const std::uint64_t size = required(given, what).struct_size;
  if (size < kFirstSize<Struct> || size > kMost)
    refuse(std::string(what) + " has a struct_size of " + std::to_string(size) + "; it is " +
           std::to_string(sizeof(Struct)) + " bytes");
  return static_cast<std::size_t>(std::min<std::uint64_t>(size, sizeof(Struct)));
}

/// Hands out a struct whose caller may know fewer or more of its members than we do.
template <class Struct>
void fill(Struct* out, Struct value, const char* what) {
  const std::size_t known = known_size(out, what);
  value.struct_size = out->struct_size;
  std::memset(out, 0, static_cast<std::size_t>(value.struct_size));
  std::memcpy(out, &value, known);
}

/// Takes one in; members that the caller does not know are 0.
template <class Struct>
[[nodiscard]] Struct take(const Struct* given, const char* what) {
  Struct taken{};
  std::memcpy(&taken, given, known_size(given, what));
  return taken;
}

/// The callback as the C++ interface has it; empty when there is none.
[[nodiscard]] ProgressCallback progress_through(ptet_progress_callback callback, void* user);

[[nodiscard]] inline std::string text_or_empty(const char* text) {
  return text == nullptr ? std::string() : std::string(text);
}

} // namespace ptet::capi
