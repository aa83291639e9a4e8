#include "lod/provenance.hpp"

#include "mesh/utf8.hpp"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace ptet {
namespace {

void append_ascii(std::string& out, char c) {
  constexpr std::array<std::pair<char, char>, 7> kShort{
      {{'"', '"'}, {'\\', '\\'}, {'\b', 'b'}, {'\f', 'f'}, {'\n', 'n'}, {'\r', 'r'}, {'\t', 't'}}};
  const auto* const found =
      std::find_if(kShort.begin(), kShort.end(), [&](const auto& pair) { return pair.first == c; });
  if (found != kShort.end()) {
    out += '\\';
    out += found->second;
  } else if (static_cast<unsigned char>(c) < 0x20) {
    constexpr std::string_view kDigits = "0123456789abcdef";
    out += "\\u00";
    out += kDigits[static_cast<unsigned char>(c) >> 4U];
    out += kDigits[static_cast<unsigned char>(c) & 15U];
  } else {
    out += c;
  }
}

/// Strings between brackets.
std::string list(const std::vector<std::string>& texts) {
  std::string out = "[";
  for (const std::string& text : texts) {
    if (out.size() > 1) out += ',';
    out += json_string(text);
  }
  return out + "]";
}

std::string options(const file::Manifest& manifest) {
  std::vector<std::pair<std::string, std::vector<std::string>>> by_name;
  for (const auto& [name, value] : manifest.options) {
    const auto found =
        std::find_if(by_name.begin(), by_name.end(), [&, &wanted = name](const auto& o) { return o.first == wanted; });
    if (found == by_name.end())
      by_name.push_back({name, {value}});
    else
      found->second.push_back(value);
  }
  std::string out = "{";
  for (const auto& [name, values] : by_name) {
    if (out.size() > 1) out += ',';
    out += json_string(name) + ":" + (values.size() == 1 ? json_string(values.front()) : list(values));
  }
  return out + "}";
}

} // namespace

std::string json_string(std::string_view text) {
  std::string out = "\"";
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    if (length == 1)
      append_ascii(out, text.front());
    else if (length > 1)
      out += text.substr(0, length);
    else
      out += "\xEF\xBF\xBD";
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return out + "\"";
}

std::string to_json(const file::Manifest& manifest) {
  return R"({"tool_version":)" + json_string(manifest.tool_version) + R"(,"source_name":)" +
         json_string(manifest.source_name) + R"(,"source_hash":)" + json_string(manifest.source_hash) +
         R"(,"options":)" + options(manifest) + R"(,"notes":)" + list(manifest.notes) + "}";
}

} // namespace ptet
