// What the handles of ptet.h hold, and how arrays and errors are handed out.
#pragma once

#include "capi/guard.hpp"
#include "ptet/dataset.hpp"

#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace ptet::capi {

/// By field its place among the governing ones, by which errors go.
using GoverningPlaces = std::vector<std::optional<std::size_t>>;

} // namespace ptet::capi

// NOLINTBEGIN(readability-identifier-naming): the names of the C interface
struct ptet_dataset {
  std::shared_ptr<const ptet::Dataset> data;
};
struct ptet_request {
  ptet::Request request;
  // What regions have that are still to be added.
  ptet::Bound focus_error{0, true};
  std::optional<ptet::Bound> falloff;
};
struct ptet_extraction {
  ptet::Extraction extraction;
  ptet::capi::GoverningPlaces governing;
};
// NOLINTEND(readability-identifier-naming)

namespace ptet::capi {

inline constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

[[nodiscard]] GoverningPlaces governing_places(const DatasetInfo& info);
/// NaN when the field does not govern or was not measured.
[[nodiscard]] double error_at(const std::vector<double>& errors, const GoverningPlaces& places, std::size_t field);
[[nodiscard]] ptet_limit number_of(LimitedBy limit);
/// Throws Error(kBadArgument) when there is no such failure.
[[nodiscard]] ptet_block_failure describe_failure(std::span<const BlockFailure> failures, std::uint32_t failure);
[[nodiscard]] ptet_array describe_array(const PointArray& array);
/// Throws Error(kBadArgument) when there is no such field.
[[nodiscard]] const PointArray& array_at(std::span<const PointArray> arrays, std::uint32_t field);

} // namespace ptet::capi
