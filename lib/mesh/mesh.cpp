#include "ptet/mesh.hpp"

#include "mesh/scalar_dispatch.hpp"

#include <algorithm>

namespace ptet {

std::size_t size_of(ScalarType type) {
  return dispatch(type, []<class T>(T) { return sizeof(T); });
}

const char* name_of(ScalarType type) {
  static constexpr std::array kNames = {"int8",   "uint8", "int16",  "uint16",  "int32",
                                        "uint32", "int64", "uint64", "float32", "float64"};
  return kNames.at(static_cast<std::size_t>(type));
}

double PointArray::value(std::size_t row, std::uint32_t component) const {
  return dispatch(type, [&]<class T>(T) {
    return static_cast<double>(load<T>(bytes.data() + (row * components + component) * sizeof(T)));
  });
}

const PointArray* TetMesh::find(const std::string& name) const {
  const auto found = std::find_if(point_arrays.begin(), point_arrays.end(),
                                  [&](const PointArray& array) { return array.name == name; });
  return found == point_arrays.end() ? nullptr : &*found;
}

} // namespace ptet
