// No cut crosses itself: dependencies between records beyond those of the coarse versions.
//
// The boundary faces that stand together at one moment of the collapses were checked against one another. A cut that
// mixes levels may hold two that never did: f, which collapse c consumed, and g, which the later collapse k made.
//
//      collapses   ------- c ----------- k ------->        f is in a cut only if the split of c is applied
//            f     ========|                               g is in a cut only if the split of k is not applied
//            g                           |=========
//
// So if the split of c needs that of k, no cut holds both; k is later than c, so needs never run in a circle. Mostly
// k is among what c needs anyway: g lies over the place of f, many levels up. What is left is found here: all such
// pairs that meet elsewhere than in common vertices and edges (exact), of which k is not among what c needs.
//
// Conversely each pair that is found stands in some closed cut: that of all that c and the consumer of g need.
#pragma once

#include "mesh/prepare.hpp"
#include "ptet/progress.hpp"
#include "record/stream.hpp"

namespace ptet::build {

/// Sets what each record also needs (RecordStream::also_needs), without what follows from its parents and from what
/// those need. Faces that stand for faces of one curve along which the input crosses itself may cross
/// (self_crossings.hpp).
/// Returns the number of dependencies. The same for any number of threads; runs in the caller's task arena. Throws
/// Error(kCancelled).
std::size_t add_cut_dependencies(const PreparedMesh& prepared, RecordStream& records, const ProgressCallback& progress);

} // namespace ptet::build
