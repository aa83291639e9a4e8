// Typed ids. Each names a row of one table; none converts to another or to a number by itself.
#pragma once

#include <compare>
#include <cstdint>
#include <limits>

namespace ptet {

/// A 32-bit row number of the table that `Tag` names.
template <class Tag>
class Id {
public:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  constexpr Id() = default;
  constexpr explicit Id(std::uint32_t index) : index_(index) {}

  [[nodiscard]] constexpr std::uint32_t index() const { return index_; }
  [[nodiscard]] constexpr bool is_none() const { return index_ == kNone; }

  friend constexpr auto operator<=>(Id, Id) = default;

private:
  std::uint32_t index_ = kNone;
};

using VertexId = Id<struct VertexTag>;
using TetId = Id<struct TetTag>;
/// A record is one accepted collapse, read backwards as a vertex split.
using RecordId = Id<struct RecordTag>;

/// The dummy vertex of the link condition. A boundary face (a, b, c) is the ghost tetrahedron (a, b, c, dummy).
/// It has no row in any vertex table.
inline constexpr VertexId kDummyVertex{std::numeric_limits<std::uint32_t>::max() - 1};

} // namespace ptet
