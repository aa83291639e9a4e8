// Numbers in messages.
#pragma once

#include <array>
#include <charconv>
#include <string>

namespace ptet {

/// With the fewest digits that read back as the same number, whatever locale the program has set.
[[nodiscard]] inline std::string number_text(double x) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), x).ptr};
}

} // namespace ptet
