// A .ptet file taken apart, so that a part can be damaged and everything hashed anew; and sources that fail as told.
#pragma once

#include "formats/ptet/layout.hpp"
#include "ptet/source.hpp"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <mutex>
#include <span>
#include <vector>

namespace ptet::test {

/// Sections are put back uncompressed.
struct FileParts {
  using Bytes = std::vector<std::byte>;

  Bytes header;
  std::vector<file::Section> sections;
  std::vector<Bytes> raw; ///< by section

  explicit FileParts(const Bytes& bytes);
  static bool is(const file::Section& section, file::SectionKind kind) {
    return section.kind == static_cast<std::uint32_t>(kind);
  }
  /// Throws std::out_of_range when there is none.
  Bytes& of(file::SectionKind kind);
  /// Rows of the table, which must be sound; offsets count from the beginning of the blocks.
  [[nodiscard]] std::vector<file::TableRow> rows();
  void set_rows(const std::vector<file::TableRow>& rows);
  /// Hashes the blocks anew in the table, which must be sound.
  void mend_blocks();
  [[nodiscard]] Bytes join() const;
};

/// A number in the bytes, in the machine's order.
template <class T>
void put(std::vector<std::byte>& bytes, std::size_t offset, T value) {
  std::memcpy(bytes.data() + offset, &value, sizeof value);
}
template <class T>
[[nodiscard]] T get(const std::vector<std::byte>& bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

/// Flips bit `bit` of all.
void flip(std::vector<std::byte>& bytes, std::size_t bit);

/// Bytes in memory; every read asks first whether it fails. Any number of threads.
class FailingSource final : public ByteSource {
public:
  using Fails = std::function<bool(std::uint64_t offset, std::uint64_t count)>;

  explicit FailingSource(std::vector<std::byte> bytes, Fails fails = {});
  std::uint64_t size() override { return bytes_.size(); }
  /// Throws std::runtime_error("the line is dead").
  void read(std::uint64_t offset, std::span<std::byte> into) override;
  void set(Fails fails);
  /// That byte is given wrong the next so many times.
  void garble(std::uint64_t offset, int times);
  [[nodiscard]] std::uint64_t reads() const { return reads_; }
  [[nodiscard]] std::uint64_t bytes_given() const { return bytes_given_; }

private:
  std::vector<std::byte> bytes_;
  std::mutex mutex_;
  Fails fails_;
  std::uint64_t garbled_ = 0;
  int times_garbled_ = 0; ///< still to come
  std::atomic<std::uint64_t> reads_{0}, bytes_given_{0};
};

} // namespace ptet::test
