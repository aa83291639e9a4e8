// Collapses that were decided before are made once more, without searching for them: those of a checkpoint, and those
// that were decided in pieces of the mesh.
#pragma once

#include "build/collapser.hpp"
#include "ptet/build.hpp"
#include "ptet/progress.hpp"
#include "record/stream.hpp"

#include <string>

namespace ptet::build {

struct Decisions;

/// Makes all collapses of `decided`, whose removed, target, round and error tables are looked at, in the mesh as it was
/// given, and records them with these errors. Returns what does not fit, or nothing. Throws Error(kCancelled).
[[nodiscard]] std::string replay(const RecordStream& decided, Collapser& collapser, const ProgressCallback& progress);

/// Makes the collapses of every piece of report.pieces, as far as they are possible, and records them with the errors
/// known there. The report gets counts and walk. Throws Error(kCancelled).
void follow(const Decisions& decided, Collapser& collapser, BuildReport& report, const ProgressCallback& progress);

} // namespace ptet::build
