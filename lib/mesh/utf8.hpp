// Text in UTF-8.
#pragma once

#include <cstddef>
#include <string>
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

[[nodiscard]] constexpr bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    if (length == 0) return false;
    text.remove_prefix(length);
  }
  return true;
}

/// The text with each byte that is no UTF-8 taken as a character of Latin-1, as old programs write them.
[[nodiscard]] inline std::string as_utf8(std::string_view text) {
  std::string good;
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    if (length == 0) {
      const auto byte = static_cast<unsigned char>(text[0]); // 0x80 or above
      good += {static_cast<char>(0xC0 | byte >> 6), static_cast<char>(0x80 | (byte & 0x3F))};
      text.remove_prefix(1);
    } else {
      good += text.substr(0, length);
      text.remove_prefix(length);
    }
  }
  return good;
}

} // namespace ptet
