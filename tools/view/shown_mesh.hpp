// A copy of a session's mesh in the form in which it is drawn, kept up to date by the slots that changed: positions,
// and of up to two fields one number a vertex (of vectors the length).
#pragma once

#include "geometry.hpp"
#include "placement.hpp"
#include "ptet/session.hpp"

#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

namespace ptet::view {

/// Least and largest; none yet: least > most.
struct Range {
  double least = std::numeric_limits<double>::infinity();
  double most = -std::numeric_limits<double>::infinity();
  bool has_gaps = false; ///< there are NaN besides

  void widen(double x) {
    if (x < least) least = x;
    if (x > most) most = x;
  }
  [[nodiscard]] bool empty() const { return !(least <= most); }
  friend bool operator==(const Range&, const Range&) = default;
};

class ShownMesh {
public:
  static constexpr std::size_t kColumns = 2;

  /// Positions are where `placement` draws them.
  explicit ShownMesh(const Placement& placement) : placement_(placement) {}

  /// Which field column `column` is of: a row of DatasetInfo::fields.
  void choose(std::size_t column, std::size_t field);
  /// The session's mesh as it is after `update`, which must follow the update of the last call.
  void follow(const Session& session, const SessionUpdate& update);

  /// Valid until the next call of follow. `values` are those of column 0, and there are no tet_values.
  [[nodiscard]] MeshRows rows() const;
  [[nodiscard]] std::span<const double> values(std::size_t column) const { return columns_[column].values; }
  /// Of all values that the column's field has had here since it was chosen.
  [[nodiscard]] const Range& range(std::size_t column) const { return columns_[column].range; }

private:
  struct Column {
    std::size_t field = 0;
    bool is_stale = true;
    std::vector<double> values;
    Range range;
  };

  void set_row(Column& column, std::span<const PointArray> arrays, std::size_t row);

  Placement placement_;
  std::vector<Point> positions_;
  std::array<Column, kColumns> columns_;
  std::span<const std::array<std::uint32_t, 4>> tets_;
  std::span<const std::array<std::uint32_t, 3>> faces_;
};

} // namespace ptet::view
