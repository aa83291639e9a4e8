// What is printed has '?' for control characters: names in files may hold any, and a terminal obeys them.
#pragma once

#include <ostream>
#include <streambuf>
#include <string>
#include <string_view>

namespace ptet::cli {

[[nodiscard]] inline std::string plain_text(std::string_view text, bool may_end_lines) {
  std::string plain(text);
  for (char& c : plain)
    if ((static_cast<unsigned char>(c) < 0x20 && !(c == '\n' && may_end_lines)) || c == 0x7F) c = '?';
  return plain;
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
    return target_.sputn(plain.data(), count);
  }
  int sync() override { return target_.pubsync(); }

private:
  std::ostream& stream_;
  std::streambuf& target_;
};

} // namespace ptet::cli
