// Text in UTF-8.
#pragma once

#include <cstddef>
#include <string_view>

namespace ptet {

/// The length of the character that begins the text, or 0 when that is no well-formed UTF-8 or the text is empty.
/// Source: The Unicode Standard, table 3-7.
[[nodiscard]] constexpr std::size_t utf8_length(std::string_view text) {
  const auto in = [&](std::size_t i, unsigned low, unsigned high) {
    return i < text.size() && static_cast<unsigned char>(text[i]) >= low && static_cast<unsigned char>(text[i]) <= high;
  };
  if (in(0, 0x00, 0x7F)) return 1;
  if (in(0, 0xC2, 0xDF)) return in(1, 0x80, 0xBF) ? 2 : 0;
  // No overlong forms, no surrogates, nothing above U+10FFFF.
  if (in(0, 0xE0, 0xEF)) {
    const unsigned low = in(0, 0xE0, 0xE0) ? 0xA0 : 0x80, high = in(0, 0xED, 0xED) ? 0x9F : 0xBF;
    return in(1, low, high) && in(2, 0x80, 0xBF) ? 3 : 0;
  }
  if (in(0, 0xF0, 0xF4)) {
    const unsigned low = in(0, 0xF0, 0xF0) ? 0x90 : 0x80, high = in(0, 0xF4, 0xF4) ? 0x8F : 0xBF;
    return in(1, low, high) && in(2, 0x80, 0xBF) && in(3, 0x80, 0xBF) ? 4 : 0;
  }
  return 0;
}

} // namespace ptet
