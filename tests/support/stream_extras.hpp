// What the plain simplifier does not find, made up: dependencies between any two records, squared errors of any sign,
// and what budgets are to keep small. Files and cuts must carry whatever they are given.
#pragma once

#include "record/stream.hpp"

namespace ptet::test {

/// Gives about one record in `one_in` up to three later records that it also needs.
void add_random_dependencies(RecordStream& stream, unsigned seed, unsigned one_in = 8);
/// Squared errors like those of a build: the field error squared times a volume times a random factor, one in eight
/// negative, a few of them 0 or out of all proportion.
void add_random_squared_errors(RecordStream& stream, unsigned seed);
/// Budgets go by all kinds of errors.
void add_budget_weights(RecordStream& stream);

} // namespace ptet::test
