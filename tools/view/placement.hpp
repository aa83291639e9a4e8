// Where a mesh lies in the space that is drawn. VTK and OpenGL compute in 32-bit floats and with tolerances of their
// own: a mesh of some nanometres in metres comes out black, one of 1e30 not at all, one far from the origin ragged.
// Such a mesh is drawn with its middle at the origin and its diagonal as the unit; any other as it is, bit for bit.
#pragma once

#include "geometry.hpp"
#include "ptet/dataset.hpp"
#include "ptet/request.hpp"

namespace ptet::view {

class Placement {
public:
  /// As it is.
  Placement() = default;
  explicit Placement(const DatasetInfo& info);

  /// From the file's space to the one that is drawn.
  [[nodiscard]] Point drawn(const Point& p) const {
    if (is_identity_) return p;
    return {(p[0] - origin_[0]) / unit_, (p[1] - origin_[1]) / unit_, (p[2] - origin_[2]) / unit_};
  }
  [[nodiscard]] double drawn(double length) const { return length / unit_; }
  [[nodiscard]] Plane drawn(const Plane& plane) const;
  [[nodiscard]] Region drawn(const Region& region) const;
  /// And back.
  [[nodiscard]] Region in_file(const Region& region) const;

private:
  bool is_identity_ = true;
  Point origin_{};
  double unit_ = 1;
};

} // namespace ptet::view
