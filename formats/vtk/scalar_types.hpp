// VTK's numeric types and ours.
#pragma once

#include "ptet/mesh.hpp"

#include <limits>
#include <optional>

#include <vtkType.h>

namespace ptet::vtkio {

/// The ScalarType with the same bits as VTK's; nothing for bits, strings and variants.
inline std::optional<ScalarType> scalar_type(int vtk_type) {
  const auto integer = [](bool is_signed, std::size_t bytes) {
    switch (bytes) {
    case 1: return is_signed ? ScalarType::kInt8 : ScalarType::kUInt8;
    case 2: return is_signed ? ScalarType::kInt16 : ScalarType::kUInt16;
    case 4: return is_signed ? ScalarType::kInt32 : ScalarType::kUInt32;
    default: return is_signed ? ScalarType::kInt64 : ScalarType::kUInt64;
    }
  };
  switch (vtk_type) {
  case VTK_CHAR: return integer(std::numeric_limits<char>::is_signed, 1);
  case VTK_SIGNED_CHAR: return integer(true, 1);
  case VTK_UNSIGNED_CHAR: return integer(false, 1);
  case VTK_SHORT: return integer(true, sizeof(short));
  case VTK_UNSIGNED_SHORT: return integer(false, sizeof(short));
  case VTK_INT: return integer(true, sizeof(int));
  case VTK_UNSIGNED_INT: return integer(false, sizeof(int));
  case VTK_LONG: return integer(true, sizeof(long));
  case VTK_UNSIGNED_LONG: return integer(false, sizeof(long));
  case VTK_LONG_LONG: return integer(true, sizeof(long long));
  case VTK_UNSIGNED_LONG_LONG: return integer(false, sizeof(long long));
  case VTK_ID_TYPE: return integer(true, sizeof(vtkIdType));
  case VTK_FLOAT: return ScalarType::kFloat32;
  case VTK_DOUBLE: return ScalarType::kFloat64;
  default: return std::nullopt;
  }
}

/// VTK's type for ours.
inline int vtk_type(ScalarType type) {
  static constexpr int kTypes[] = {VTK_TYPE_INT8,    VTK_TYPE_UINT8,  VTK_TYPE_INT16, VTK_TYPE_UINT16,
                                   VTK_TYPE_INT32,   VTK_TYPE_UINT32, VTK_TYPE_INT64, VTK_TYPE_UINT64,
                                   VTK_TYPE_FLOAT32, VTK_TYPE_FLOAT64};
  return kTypes[static_cast<std::size_t>(type)];
}

} // namespace ptet::vtkio
