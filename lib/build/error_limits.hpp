// How large the errors of a collapse may become, by the options of the build, and so what errors weigh against one
// another. A file rounds errors up; what it states is not to be above what was asked, so the limits are the largest
// errors that it does not.
//
// Source: Cignoni et al. 2000, section 4.3 (each kind of error counts by its threshold).
#pragma once

#include "build/mesh_scales.hpp"
#include "build/normalized_fields.hpp"
#include "mesh/prepare.hpp"
#include "ptet/build.hpp"

#include <optional>
#include <string>
#include <vector>

namespace ptet::build {

class ErrorLimits {
public:
  /// `diagonal`: of the whole mesh, mesh units.
  /// Throws Error(kBadArgument) for a limit that is no number >= 0 or is of something that is no governing field.
  ErrorLimits(const PreparedMesh& prepared, const NormalizedFields& fields, const BuildOptions& options,
              double diagonal);

  /// By field, as fractions of the ranges; infinite where there is no limit.
  [[nodiscard]] const std::vector<double>& field() const { return field_; }
  /// Mesh units.
  [[nodiscard]] double domain() const { return domain_; }
  /// Whether any field has a limit.
  [[nodiscard]] bool bounds_fields() const;
  /// Whether one of `errors`, which are one a field or none at all, is beyond its limit.
  [[nodiscard]] bool passed_by(const std::vector<double>& errors) const {
    for (std::size_t f = 0; f < errors.size(); ++f)
      if (errors[f] > field_[f]) return true;
    return false;
  }

  /// By field, of errors as fractions of the ranges.
  [[nodiscard]] std::vector<double> field_weights() const;
  /// Of errors as fractions of the diagonal, as they are predicted.
  [[nodiscard]] double domain_weight() const;
  /// Of errors in mesh units, as they are measured.
  [[nodiscard]] double measured_domain_weight() const;

private:
  std::vector<double> field_;
  double domain_;
  double diagonal_;
};

/// A note on a limit on the domain error that is more than the domain is thick, on the whole; nothing of others.
[[nodiscard]] std::optional<std::string> flat_domain_note(const PreparedMesh& prepared, const MeshScales& scales,
                                                          const BuildOptions& options);

} // namespace ptet::build
