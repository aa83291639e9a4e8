// What a build's report says of its records, once all of them are there and their errors are final.
#pragma once

#include "mesh/prepare.hpp"
#include "ptet/build.hpp"
#include "record/stream.hpp"

namespace ptet::build {

/// Counts, largest errors, and the errors so far at the end of each round of `report.walk`. Cost: O(records).
void report_records(const PreparedMesh& prepared, const RecordStream& records, BuildReport& report);

} // namespace ptet::build
