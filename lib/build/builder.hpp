// The builder: collapses a mesh in rounds of independent half-edge collapses and records every accepted one.
//
//   repeat   predict    the cheapest outgoing half-edge of every vertex whose star has changed   (parallel)
//            pick       the best part of them, lower dependency height first
//            measure    method exact only: exact errors of those that do not touch each other; what is not   (parallel)
//                       among the best any more is put back
//            check      link condition, orientation, shape, boundary, errors; refuse or ...
//            collapse   ... commit and record, unless the star was touched in this round
//   until    the target is reached or a whole sweep accepts nothing
//
// Source: Cignoni et al. 2000, sections 3 and 4; rounds instead of one greedy sequence keep the records' dependencies
// short.
#pragma once

#include "mesh/prepare.hpp"
#include "ptet/build.hpp"
#include "record/stream.hpp"

namespace ptet::build {

/// Collapses `prepared` as far as the options allow. `report` receives what is known after the collapses.
/// Throws Error: kBadArgument (options, unknown field), kBadInput (values that are not finite), kCancelled.
[[nodiscard]] RecordStream build_records(const PreparedMesh& prepared, const BuildOptions& options, BuildReport& report,
                                         const ProgressCallback& progress);

} // namespace ptet::build
