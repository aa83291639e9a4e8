// Certification: after the collapses, the recorded field errors are replaced by exact ones, and the integrals of the
// squared error and the volume that is not covered, from which the mean square error of every cut follows, are added.
//
// A version's error does not depend on the cut it stands in, so each can be measured by itself, in parallel, and holds
// in every mesh that is ever extracted.
#pragma once

#include "build/normalized_fields.hpp"
#include "ptet/progress.hpp"
#include "record/stream.hpp"

#include <vector>

namespace ptet::build {

/// A measured error with what rounding can hide of it.
[[nodiscard]] double certified(double measured);

/// By field, what makes integrals of squared fractions of the range integrals of squared values: the range squared; 1
/// where a double cannot hold these in the units of the field (RecordStream::squared_error).
[[nodiscard]] std::vector<double> squared_scales(const NormalizedFields& fields, double volume);

/// Raises the field errors of every record to the exact maximum over the part of its coarse versions in the domain.
/// What was seen at removed vertices that lie outside of the simplified domain stays in them.
/// Sets the squared errors and what is uncovered, exact but for rounding.
/// `certified`, when not null: how many records have been certified before, in the same stream; kept up to date, and
/// the stream with it, whenever `progress` is called.
/// Runs in the caller's task arena. Throws Error(kCancelled).
void certify_field_errors(const PreparedMesh& prepared, const NormalizedFields& fields, RecordStream& records,
                          const ProgressCallback& progress, std::uint64_t* certified = nullptr);

} // namespace ptet::build
