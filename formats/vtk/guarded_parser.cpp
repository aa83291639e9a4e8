#include "formats/vtk/guarded_parser.hpp"

#include <algorithm>
#include <cctype>
#include <iterator>

#include <vtkBase64InputStream.h>
#include <vtkInputStream.h>

namespace ptet::vtkio {
namespace {

/// A stream of VTK's that gives all that is asked for or nothing: the parser takes a part of an array for the whole,
/// and leaves the rest as it finds it in memory. Of compressed data it looks at the header before the parser does,
/// which divides by the block size and indexes by the block count as they stand in the file. Says how many bytes the
/// header announces: the parser takes as many as it needs, and is silent on the rest.
template <class Base>
class GuardedStream : public Base {
public:
  static GuardedStream* New() { VTK_STANDARD_NEW_BODY(GuardedStream); }

  // The parser reads a compressed array in two goes: the header's three words and block sizes, then the blocks. Others
  // in one, and first the word that is their length.
  void StartReading() override {
    at_start_ = true;
    Base::StartReading();
  }
  void EndReading() override {
    in_header_ = !in_header_;
    Base::EndReading();
  }

  std::size_t Read(void* to, std::size_t length) override {
    const std::size_t got = Base::Read(to, length);
    if (got < length) return 0;
    const bool is_first = at_start_;
    const bool is_head = in_header_ && is_first;
    at_start_ = false;
    // Of a compressor that it does not know the parser takes the data for plain.
    const std::size_t head_words = compressed_ ? (is_head ? 3 : 0) : (is_first ? 1 : 0);
    if (length < head_words * word_bytes_) return 0;
    if (!compressed_ && is_first) *array_bytes_ = word(static_cast<const unsigned char*>(to));
    if (!compressed_ || !in_header_) return got;
    if (!is_head) return are_block_sizes(static_cast<const unsigned char*>(to), got) ? got : 0;
    const auto* data = static_cast<const unsigned char*>(to);
    const std::uint64_t blocks = word(data);
    const std::uint64_t block_bytes = word(data + word_bytes_);
    const std::uint64_t last_bytes = word(data + 2 * word_bytes_);
    const bool sound = (blocks == 0 && last_bytes == 0) ||
                       (blocks != 0 && block_bytes != 0 && last_bytes <= block_bytes && blocks <= file_bytes_ &&
                        is_true_size(static_cast<double>(blocks) * static_cast<double>(block_bytes), file_bytes_));
    if (!sound) return 0;
    *array_bytes_ = (last_bytes == 0 ? blocks : blocks - 1) * block_bytes + last_bytes;
    return got;
  }

  void guard(bool compressed, std::size_t word_bytes, bool big_endian, std::uint64_t file_bytes,
             std::uint64_t& array_bytes) {
    compressed_ = compressed;
    word_bytes_ = word_bytes;
    big_endian_ = big_endian;
    file_bytes_ = file_bytes;
    array_bytes_ = &array_bytes;
  }

private:
  [[nodiscard]] bool are_block_sizes(const unsigned char* data, std::size_t length) const {
    for (std::size_t at = 0; at + word_bytes_ <= length; at += word_bytes_) {
      if (word(data + at) > file_bytes_) return false;
    }
    return true;
  }

  [[nodiscard]] std::uint64_t word(const unsigned char* data) const {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < word_bytes_; ++i)
      value |= static_cast<std::uint64_t>(data[i]) << 8 * (big_endian_ ? word_bytes_ - 1 - i : i);
    return value;
  }

  bool compressed_ = false;
  bool in_header_ = true;
  bool at_start_ = false;
  std::size_t word_bytes_ = 4;
  bool big_endian_ = false;
  std::uint64_t file_bytes_ = 0;
  std::uint64_t* array_bytes_ = nullptr; ///< of the array whose header was read last
};

} // namespace

std::string attribute(vtkXMLDataElement& element, const char* name) {
  const char* value = element.GetAttribute(name);
  return value ? value : "";
}

int count_of(vtkXMLDataElement& parent, const std::string& name) {
  int count = 0;
  for (int i = 0; i < parent.GetNumberOfNestedElements(); ++i)
    count += parent.GetNestedElement(i)->GetName() == name ? 1 : 0;
  return count;
}

template <class Base>
void GuardedParser::guard(vtkInputStream*& stream) {
  auto* guarded = GuardedStream<Base>::New();
  guarded->guard(RootElement->GetAttribute("compressor") != nullptr, HeaderType == 64 ? 8 : 4, ByteOrder == BigEndian,
                 file_bytes, array_bytes);
  stream->Delete();
  stream = guarded;
}

int GuardedParser::Parse() {
  const int result = Superclass::Parse();
  if (!result || !RootElement) return result;
  guard<vtkBase64InputStream>(InlineDataStream);
  if (vtkBase64InputStream::SafeDownCast(AppendedDataStream))
    guard<vtkBase64InputStream>(AppendedDataStream);
  else
    guard<vtkInputStream>(AppendedDataStream);
  return result;
}

std::uint64_t GuardedParser::inline_bytes(vtkXMLDataElement& array) {
  const std::uint64_t head_bytes = HeaderType == 64 ? 8 : 4;
  std::uint64_t bytes = 0;
  each_word(array, [&](const std::string& word) {
    bytes += word.size() / 4 * 3 - static_cast<std::uint64_t>(std::count(word.begin(), word.end(), '='));
    return true;
  });
  return bytes - std::min(bytes, head_bytes);
}

bool GuardedParser::each_word(vtkXMLDataElement& array, const std::function<bool(const std::string&)>& visit) {
  SeekInlineDataPosition(&array);
  std::string word;
  for (std::istreambuf_iterator<char> at(*GetStream()), end;; ++at) {
    const bool is_over = at == end || *at == '<';
    if (!is_over && std::isspace(static_cast<unsigned char>(*at)) == 0) {
      word += *at;
      continue;
    }
    if (!word.empty() && !visit(word)) return false;
    word.clear();
    if (is_over) return true;
  }
}

} // namespace ptet::vtkio
