// The governing fields as the builder sees them: channels (one for each component) as fractions of the field's range,
// so that units never matter, nor where their zero is.
#pragma once

#include "error/exact_field_error.hpp"
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
  /// not finite at a used vertex.
  /// `ranges`: those of a whole mesh of which this is a part, by field; null: those of this mesh.
  NormalizedFields(const PreparedMesh& prepared, const std::vector<std::string>& names,
                   const std::vector<double>* ranges = nullptr);

  [[nodiscard]] std::size_t field_count() const { return fields_.size(); }
  [[nodiscard]] std::size_t channel_count() const { return channel_field_.size(); }
  [[nodiscard]] const std::vector<GoverningField>& fields() const { return fields_; }
  /// The field that channel `c` is a component of.
  [[nodiscard]] std::size_t field_of(std::size_t c) const { return channel_field_[c]; }
  /// Whether channel `c` is the last component of its field.
  [[nodiscard]] bool ends_field(std::size_t c) const {
    return c + 1 == channel_field_.size() || channel_field_[c + 1] != channel_field_[c];
  }
  [[nodiscard]] ChannelView view() const { return {values_, channel_field_.size(), channel_field_}; }
  /// The channels of vertex `v`.
  [[nodiscard]] const double* at(std::uint32_t v) const { return values_.data() + v * channel_field_.size(); }

private:
  std::vector<GoverningField> fields_;
  std::vector<std::size_t> channel_field_;
  std::vector<double> values_;
};

} // namespace ptet::build
