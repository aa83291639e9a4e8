// An error bound as a user states it: absolute, or as a fraction of the field's range or the domain's diagonal.
#pragma once

#include <string>

namespace ptet {

struct Bound {
  double value = 0; ///< >= 0, and finite where nothing else is said
  /// false: in the units of the field (or of the mesh, for the domain).
  /// true: a fraction of the field's range (or of the bounding-box diagonal); 0.01 is 1%.
  bool relative = false;

  /// The bound in absolute units, given the range or the diagonal it may be relative to.
  [[nodiscard]] double absolute(double scale) const { return relative ? value * scale : value; }
};

/// A bound on one field; an empty name means every field that governed the build.
struct FieldBound {
  std::string field;
  Bound bound;
};

} // namespace ptet
