// Little-endian bytes, written and read field by field. Each field has a name: a violation says where and what, and an
// observer sees every field with its place (the annotated dump is made of this).
#pragma once

#include "formats/ptet/violation.hpp"
#include "mesh/number_text.hpp"
#include "ptet/error.hpp"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace ptet::file {

class ByteWriter {
public:
  template <class T>
  void put(T value) {
    if constexpr (std::is_same_v<T, double>) {
      put(std::bit_cast<std::uint64_t>(value));
    } else {
      for (std::size_t i = 0; i < sizeof(T); ++i) {
        bytes_.push_back(static_cast<std::byte>(static_cast<std::uint64_t>(value) >> (8 * i) & 0xFF));
      }
    }
  }
  /// 7 bits a byte, low ones first; the top bit says that more follow.
  void put_varint(std::uint64_t value) {
    for (; value >= 0x80; value >>= 7)
      put(static_cast<std::uint8_t>(value | 0x80));
    put(static_cast<std::uint8_t>(value));
  }
  void put_bytes(std::span<const std::byte> bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }
  void put_text(std::string_view text) { put_bytes(std::as_bytes(std::span(text.data(), text.size()))); }

  [[nodiscard]] std::size_t size() const { return bytes_.size(); }
  [[nodiscard]] const std::vector<std::byte>& bytes() const { return bytes_; }
  [[nodiscard]] std::vector<std::byte> take() { return std::move(bytes_); }

private:
  std::vector<std::byte> bytes_;
};

/// Sees each field read: its offset and bytes, its name and its value as text.
using FieldObserver = std::function<void(std::uint64_t offset, std::span<const std::byte> bytes, std::string_view name,
                                         std::string value)>;

class ByteReader {
public:
  /// `place` is what the bytes are called in messages. `file_offset` is reported with an error: where `bytes` begin in
  /// the file, or, when they were compressed there, where the compressed ones do (`compressed` true).
  ByteReader(std::span<const std::byte> bytes, std::string place, std::uint64_t file_offset, bool compressed = false,
             FieldObserver observer = {})
      : bytes_(bytes), place_(std::move(place)), file_offset_(file_offset), compressed_(compressed),
        observer_(std::move(observer)) {}

  /// From now on violate() tells `violations`, which must outlive the object, instead of throwing.
  void tell(const Violations* violations) { violations_ = violations; }

  [[nodiscard]] std::size_t position() const { return position_; }
  [[nodiscard]] std::size_t remaining() const { return bytes_.size() - position_; }
  /// In the file.
  [[nodiscard]] std::uint64_t offset() const { return compressed_ ? file_offset_ : file_offset_ + position_; }

  template <class T>
  [[nodiscard]] T get(std::string_view name) {
    if constexpr (std::is_same_v<T, double>) {
      const std::size_t start = position_;
      const auto value = std::bit_cast<double>(assemble<std::uint64_t>(name));
      if (observer_) observe(start, name, number_text(value));
      return value;
    } else {
      const std::size_t start = position_;
      const T value = assemble<T>(name);
      if (observer_) observe(start, name, std::to_string(value));
      return value;
    }
  }
  [[nodiscard]] std::uint64_t get_varint(std::string_view name) {
    const std::size_t start = position_;
    std::uint64_t value = 0;
    for (unsigned shift = 0;; shift += 7) {
      const auto byte = assemble<std::uint8_t>(name);
      if (shift > 56) fail(std::string(name) + " is too long a number");
      value |= static_cast<std::uint64_t>(byte & 0x7F) << shift;
      if (byte < 0x80) break;
    }
    if (observer_) observe(start, name, std::to_string(value));
    return value;
  }
  /// A varint, at most `most`.
  [[nodiscard]] std::uint64_t get_count(std::string_view name, std::uint64_t most) {
    const std::uint64_t value = get_varint(name);
    if (value > most) {
      fail(std::string(name) + " is " + std::to_string(value) + ", more than the " + std::to_string(most) +
           " possible");
    }
    return value;
  }
  [[nodiscard]] std::span<const std::byte> get_bytes(std::size_t count, std::string_view name) {
    need(count, name);
    const auto result = bytes_.subspan(position_, count);
    position_ += count;
    if (observer_) observe(position_ - count, name, std::to_string(count) + " bytes");
    return result;
  }
  [[nodiscard]] std::string get_text(std::size_t count, std::string_view name) {
    need(count, name);
    std::string text(reinterpret_cast<const char*>(bytes_.data() + position_), count);
    position_ += count;
    if (observer_) observe(position_ - count, name, '"' + text + '"');
    return text;
  }
  /// Nothing may be left.
  void finish() const {
    if (remaining() != 0) fail(std::to_string(remaining()) + " bytes too many");
  }
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorCode::kCorruptFile, "the " + place_ + " is corrupt: " + what, offset());
  }
  /// The same for what does not keep the rest from being read: returns where somebody is told.
  void violate(const std::string& what) const {
    if (violations_ == nullptr || !*violations_) fail(what);
    (*violations_)({"the " + place_ + " is corrupt: " + what, offset(), {}, {}, {}});
  }

private:
  void need(std::size_t count, std::string_view name) const {
    if (count > remaining()) fail("it ends within " + std::string(name));
  }
  template <class T>
  [[nodiscard]] T assemble(std::string_view name) {
    need(sizeof(T), name);
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      value |= static_cast<std::uint64_t>(bytes_[position_ + i]) << (8 * i);
    }
    position_ += sizeof(T);
    return static_cast<T>(value);
  }
  void observe(std::size_t start, std::string_view name, std::string value) const {
    observer_(compressed_ ? start : file_offset_ + start, bytes_.subspan(start, position_ - start), name,
              std::move(value));
  }

  std::span<const std::byte> bytes_;
  std::size_t position_ = 0;
  std::string place_;
  std::uint64_t file_offset_;
  bool compressed_;
  FieldObserver observer_;
  const Violations* violations_ = nullptr;
};

} // namespace ptet::file
