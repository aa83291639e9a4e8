// The options of a build as text: what a file says of how it was made, and what a checkpoint compares.
#pragma once

#include "mesh/prepare.hpp"
#include "ptet/build.hpp"
#include "record/stream.hpp"

#include <string>
#include <utility>
#include <vector>

namespace ptet::build {

/// Name and value of the options as they were used; those that cannot change the result (threads, checkpoints) are left
/// out.
[[nodiscard]] std::vector<std::pair<std::string, std::string>>
describe_options(const BuildOptions& options, const PreparedMesh& prepared, const std::vector<GoverningField>& fields);

/// BuildOptions::min_quality, or what it is for this mesh where nobody says.
[[nodiscard]] double min_quality_of(const BuildOptions& options, const PreparedMesh& prepared);

} // namespace ptet::build
