// The governing fields as the builder sees them: channels (one for each component) as fractions of the field's range,
// so that units never matter; and as errors are measured with them, no digit lost.
#pragma once

#include "error/field_values.hpp"
#include "mesh/prepare.hpp"
#include "record/stream.hpp"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace ptet::build {

class NormalizedFields {
public:
  /// `names` empty: every floating-point array, and if there is none every array.
  /// Throws Error: kBadArgument for an unknown name (the message lists the known ones), kBadInput for a value that is
  /// not finite at a used vertex, and for values that doubles cannot hold relative to one another.
  /// `ranges`: those of a whole mesh of which this is a part, by field; null: those of this mesh.
  NormalizedFields(const PreparedMesh& prepared, const std::vector<std::string>& names,
                   const std::vector<double>* ranges = nullptr);

  [[nodiscard]] std::size_t field_count() const { return fields_.size(); }
  [[nodiscard]] std::size_t channel_count() const { return exact_.channel_count(); }
  [[nodiscard]] const std::vector<GoverningField>& fields() const { return fields_; }
  /// The field that channel `c` is a component of.
  [[nodiscard]] std::size_t field_of(std::size_t c) const { return exact_.field_of()[c]; }
  /// Whether channel `c` is the last component of its field.
  [[nodiscard]] bool ends_field(std::size_t c) const {
    return c + 1 == channel_count() || field_of(c + 1) != field_of(c);
  }
  /// Errors measured with it are fractions of the ranges.
  [[nodiscard]] ChannelView view() const { return exact_.view(); }
  /// The values as errors are measured with them, in their own units.
  [[nodiscard]] const FieldValues& exact() const { return exact_; }
  /// The channels of vertex `v`, rounded fractions of the ranges; those far from 0 count from the least of them.
  [[nodiscard]] const double* at(std::uint32_t v) const { return values_.data() + v * channel_count(); }
  /// What is odd about the values, in words; none where `ranges` were given.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }

private:
  std::vector<GoverningField> fields_;
  FieldValues exact_;
  std::vector<double> values_;
  std::vector<std::string> notes_;
};

} // namespace ptet::build
