// A request checked against a file and brought to error codes: what the search for a cut works with.
#pragma once

#include "formats/ptet/reader.hpp"
#include "lod/demand.hpp"
#include "ptet/dataset.hpp"

#include <optional>
#include <vector>

namespace ptet {

struct Budgets {
  std::optional<std::uint64_t> max_tets, max_vertices, max_bytes;
  std::optional<double> max_seconds;

  [[nodiscard]] bool limits_size() const { return max_tets || max_vertices || max_bytes; }
  [[nodiscard]] bool any() const { return limits_size() || max_seconds; }
};

struct ResolvedRequest {
  Demand demand;
  Budgets budgets;
  /// What Extraction::limited_by says of a mesh that has all that is demanded.
  LimitedBy when_met = LimitedBy::kNothing;
  // The parts of the mesh whose errors are stated by themselves.
  struct FocusRegion {
    Region region;
    bool is_original; ///< no error is allowed in it
  };
  std::vector<FocusRegion> focus;
  Intervals values;
  std::optional<Camera> camera;
  bool origins = false;
};

/// Throws Error(kBadArgument), see Dataset::extract.
[[nodiscard]] ResolvedRequest resolve(const Request& request, const file::Header& header);

/// The same into memory that `resolved` has already.
void resolve(const Request& request, const file::Header& header, ResolvedRequest& resolved);

/// The largest code whose value is <= `bound`, so that an error within the limit is within the bound.
[[nodiscard]] ErrorCode16 limit_of(double bound, double scale);

} // namespace ptet
