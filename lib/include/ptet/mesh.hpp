// A tetrahedral mesh with fields at its vertices, as it is read, built from, extracted and written.
//
//   positions     n x 3 of one numeric type     |  every array keeps its type and its bits:
//   point_arrays  n x components, named         |  what comes out at full resolution is what went in
//   tets          m x 4 vertex ids, positively oriented: det(b - a, c - a, d - a) > 0
#pragma once

#include "ptet/ids.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace ptet {

using Point = std::array<double, 3>;

/// The numeric types that a point array may hold. The values are those of the .ptet file.
enum class ScalarType : std::uint8_t {
  kInt8 = 0,
  kUInt8 = 1,
  kInt16 = 2,
  kUInt16 = 3,
  kInt32 = 4,
  kUInt32 = 5,
  kInt64 = 6,
  kUInt64 = 7,
  kFloat32 = 8,
  kFloat64 = 9,
};

/// Bytes of one scalar of the type.
[[nodiscard]] std::size_t size_of(ScalarType type);
/// "float32", "uint8" and so on.
[[nodiscard]] const char* name_of(ScalarType type);

/// A row has at least one component, and at most so many.
inline constexpr std::uint32_t kMostComponents = 1024;

/// A table of numbers: `size()` rows of `components` scalars of one type, row after row without gaps, in the machine's
/// byte order. In a mesh, row v is that of vertex v.
struct PointArray {
  std::string name;
  ScalarType type = ScalarType::kFloat32;
  std::uint32_t components = 1;
  std::vector<std::byte> bytes;

  [[nodiscard]] std::size_t row_bytes() const { return size_of(type) * components; }
  [[nodiscard]] std::size_t size() const { return row_bytes() == 0 ? 0 : bytes.size() / row_bytes(); }
  /// One scalar as a double; 64-bit integers beyond 2^53 are rounded. Not checked: row < size(), component <
  /// components.
  [[nodiscard]] double value(std::size_t row, std::uint32_t component) const;
  /// New rows are 0.
  void resize(std::size_t rows) { bytes.resize(rows * row_bytes()); }

  friend bool operator==(const PointArray&, const PointArray&) = default;
};

/// Four vertices; positively oriented unless the mesh says otherwise.
using Tet = std::array<VertexId, 4>;

struct TetMesh {
  PointArray positions{"", ScalarType::kFloat64, 3, {}}; ///< 3 components, any numeric type
  std::vector<PointArray> point_arrays;                  ///< the fields: rows as `positions` has, names of their own
  std::vector<Tet> tets;                                 ///< vertex ids are rows of `positions`

  [[nodiscard]] std::size_t vertex_count() const { return positions.size(); }
  /// Not checked: v < vertex_count().
  [[nodiscard]] Point position(VertexId v) const {
    return {positions.value(v.index(), 0), positions.value(v.index(), 1), positions.value(v.index(), 2)};
  }
  /// The array of that name, or nullptr.
  [[nodiscard]] const PointArray* find(const std::string& name) const;
};

} // namespace ptet
