// What is printed has '?' for control characters: names in files may hold any, and a terminal obeys them.
#pragma once

#include <ostream>
#include <streambuf>
#include <string>
#include <string_view>

namespace ptet::cli {

/// Whether this is the second byte of a control character from U+0080 to U+009F in UTF-8.
[[nodiscard]] inline bool ends_late_control(char before, char c) {
  return before == '\xC2' && static_cast<unsigned char>(c) >= 0x80 && static_cast<unsigned char>(c) < 0xA0;
}

[[nodiscard]] inline std::string plain_text(std::string_view text, bool may_end_lines) {
  std::string plain;
  plain.reserve(text.size());
  for (const char c : text) {
    if (!plain.empty() && ends_late_control(plain.back(), c))
      plain.back() = '?';
    else if ((static_cast<unsigned char>(c) < 0x20 && !(c == '\n' && may_end_lines)) || c == 0x7F)
      plain += '?';
    else
      plain += c;
  }
  return plain;
}

/// A name as reports have it: a line end in it would begin a line that no report has.
[[nodiscard]] inline std::string on_one_line(std::string_view name) {
  return plain_text(name, false);
}

/// JSON in which the control characters that it may hold as they are stand as escapes: what reads it gets them back.
[[nodiscard]] inline std::string escaped_json(std::string_view json) {
  std::string escaped;
  escaped.reserve(json.size());
  for (const char c : json) {
    const bool late = !escaped.empty() && ends_late_control(escaped.back(), c);
    if (!late && c != 0x7F) {
      escaped += c;
      continue;
    }
    if (late) escaped.pop_back();
    constexpr std::string_view kDigits = "0123456789abcdef";
    const auto code = static_cast<unsigned char>(c);
    escaped += std::string("\\u00") + kDigits[code / 16] + kDigits[code % 16];
  }
  return escaped;
}

/// All that is printed to the stream, while this is there.
class PlainOutput final : public std::streambuf {
public:
  explicit PlainOutput(std::ostream& stream) : stream_(stream), target_(*stream.rdbuf(this)) {}
  ~PlainOutput() override { stream_.rdbuf(&target_); }
  PlainOutput(const PlainOutput&) = delete;
  PlainOutput& operator=(const PlainOutput&) = delete;

protected:
  int_type overflow(int_type c) override {
    if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
    const char text = traits_type::to_char_type(c);
    return xsputn(&text, 1) == 1 ? c : traits_type::eof();
  }
  std::streamsize xsputn(const char* text, std::streamsize count) override {
    const std::string plain = plain_text({text, static_cast<std::size_t>(count)}, true);
    const auto length = static_cast<std::streamsize>(plain.size());
    return target_.sputn(plain.data(), length) == length ? count : 0;
  }
  int sync() override { return target_.pubsync(); }

private:
  std::ostream& stream_;
  std::streambuf& target_;
};

} // namespace ptet::cli
