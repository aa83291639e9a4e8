// From a ScalarType at run time to a C++ type at compile time.
#pragma once

#include "ptet/error.hpp"
#include "ptet/mesh.hpp"

#include <cstring>

namespace ptet {

/// Calls `f(T{})` with the C++ type T of `type`.
template <class F>
decltype(auto) dispatch(ScalarType type, F&& f) {
  switch (type) {
  case ScalarType::kInt8: return f(std::int8_t{});
  case ScalarType::kUInt8: return f(std::uint8_t{});
  case ScalarType::kInt16: return f(std::int16_t{});
  case ScalarType::kUInt16: return f(std::uint16_t{});
  case ScalarType::kInt32: return f(std::int32_t{});
  case ScalarType::kUInt32: return f(std::uint32_t{});
  case ScalarType::kInt64: return f(std::int64_t{});
  case ScalarType::kUInt64: return f(std::uint64_t{});
  case ScalarType::kFloat32: return f(float{});
  case ScalarType::kFloat64: return f(double{});
  }
  throw Error(ErrorCode::kBadArgument, "unknown scalar type " + std::to_string(static_cast<int>(type)));
}

/// An unaligned load and its inverse.
template <class T>
[[nodiscard]] T load(const std::byte* from) {
  T value;
  std::memcpy(&value, from, sizeof(T));
  return value;
}
template <class T>
void store(std::byte* to, T value) {
  std::memcpy(to, &value, sizeof(T));
}

} // namespace ptet
