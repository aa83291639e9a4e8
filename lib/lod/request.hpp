// A request checked against a file and brought to error codes: what the search for a cut works with.
#pragma once

#include "formats/ptet/reader.hpp"
#include "ptet/dataset.hpp"

#include <optional>
#include <vector>

namespace ptet {

/// The largest codes that are allowed, one per governing field, then the domain's.
using CodeLimits = std::vector<ErrorCode16>;

struct ResolvedRequest {
  /// Bounds over the whole domain; empty when none was asked.
  CodeLimits limits;
  std::vector<FocusRegion> focus;
  /// Bounds inside the focus; empty: everything there must be original.
  CodeLimits focus_limits;
  std::optional<std::uint64_t> max_tets, max_vertices;
  bool origins = false;

  [[nodiscard]] bool has_bounds() const { return !limits.empty(); }
  [[nodiscard]] bool has_budget() const { return max_tets || max_vertices; }
  [[nodiscard]] bool is_original() const { return !has_bounds() && !has_budget() && focus.empty(); }
};

/// Throws Error(kBadArgument), see Dataset::extract.
[[nodiscard]] ResolvedRequest resolve(const Request& request, const file::Header& header);

/// The same into memory that `resolved` has already.
void resolve(const Request& request, const file::Header& header, ResolvedRequest& resolved);

/// The largest code whose value is <= `bound`, so that an error within the limit is within the bound.
[[nodiscard]] ErrorCode16 limit_of(double bound, double scale);

/// Does any error pass its limit? `codes` has as many as there are limits.
[[nodiscard]] inline bool exceeds(const ErrorCode16* codes, const CodeLimits& limits) {
  for (std::size_t i = 0; i < limits.size(); ++i)
    if (codes[i] > limits[i]) return true;
  return false;
}

} // namespace ptet
