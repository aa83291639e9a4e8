// Whether the errors that a file states are true: they are measured once more, for some of the records or for all,
// against the mesh that full refinement gives.
//
//   field     the exact maximum of |Phi - phi| over the tets that the collapse made is no more than the own error
//   square    what the collapse raised the integral of |Phi - phi|^2 by is what the squared error says, rounded up
//   covered   what it made the mesh uncover of the original's volume is what is said of it, rounded up
//   domain    the distance of the boundary faces that it made to the original boundary is no more than the own error;
//             of the bound, which is on distances both ways, this is the half that a face alone tells
#pragma once

#include "formats/ptet/verification.hpp"

#include <cstdint>

namespace ptet::file {

/// What was found of one kind of error.
struct StatedError {
  std::string name;        ///< of the array, or "domain"
  std::uint64_t above = 0; ///< records whose error was measured above the stated one
  double most = 0;         ///< the greatest measured error, in the units of the field or of the mesh
  double most_above = 0;   ///< the greatest ratio of a measured to a stated error; infinite where 0 was stated
};

struct StatedErrors {
  std::uint64_t records = 0;  ///< looked at
  std::uint64_t versions = 0; ///< measured
  /// Whether the file says that its errors were evaluated exactly. Where they were not they are no bounds, and what
  /// lies above them is no violation.
  bool are_bounds = false;
  std::vector<StatedError> errors; ///< governing arrays, then the domain
};

/// Measures `samples` records, or all when that is 0 or more than there are; always the same ones.
/// `verified` must be whole and oriented. Throws Error: kBadInput when full refinement gives no mesh that can be
/// measured against, kCancelled. Threads: as many as the machine has; the result does not depend
/// on it. Cost: some 50 us a version, 10 to 20 of them a record, besides an examination of the whole mesh.
[[nodiscard]] StatedErrors check_stated_errors(const Verified& verified, std::uint64_t samples,
                                               const Violations& violations, const ProgressCallback& progress = {});

} // namespace ptet::file
