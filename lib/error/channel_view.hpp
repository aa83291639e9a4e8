// The fields whose errors are measured.
#pragma once

#include <cstddef>
#include <span>

namespace ptet {

/// Values at the vertices of the original mesh: `channels` numbers a vertex, grouped in fields.
struct ChannelView {
  std::span<const double> values;
  std::size_t channels = 0;
  /// By channel: the field it is a component of; ascending. A field's error is the Euclidean norm over its channels.
  std::span<const std::size_t> field_of;
  /// By field: errors are told as so many times those of the values. Empty: 1 for all.
  std::span<const double> scale = {};
};

} // namespace ptet
