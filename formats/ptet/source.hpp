// A .ptet file's bytes from a file or from memory, and fewer, larger requests for many ranges of them.
//
//   ranges    [a][b]   [c]              [d]
//   requests  [-----------]             [-]     where the gap between b and c is small enough
#pragma once

#include "formats/ptet/owned_mutex.hpp"
#include "ptet/source.hpp"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace ptet::file {

/// Read by pread: any number of threads at a time. Throws Error(kIo) when the file cannot be opened; the message names
/// it.
[[nodiscard]] std::unique_ptr<ByteSource> open_file(const std::string& path);
/// Any number of threads at a time.
[[nodiscard]] std::unique_ptr<ByteSource> over_memory(std::vector<std::byte> bytes);

struct ByteRange {
  std::uint64_t offset = 0;
  std::uint64_t count = 0;
};

/// The bytes of one range, or why they could not be had.
struct RangeBytes {
  std::vector<std::byte> bytes;
  std::exception_ptr failure; ///< an Error
};

/// Asks a source for ranges, one at a time, and counts. Thread rule: any number of threads.
class RangeReader {
public:
  /// No request is longer than this, unless a single range is.
  static constexpr std::uint64_t kLongestRequest = std::uint64_t{1} << 23;

  /// `max_gap`: OpenOptions::max_gap. Throws Error(kBadArgument) without a source, and as read().
  RangeReader(std::shared_ptr<ByteSource> source, std::uint64_t max_gap);

  [[nodiscard]] std::uint64_t size() const { return size_; }
  /// Throws Error(kIo) whatever the source throws, with its words; std::bad_alloc as it is.
  [[nodiscard]] std::vector<std::byte> read(ByteRange range);
  /// Whether a range, by its place among those given, is to be read. Asked just before each request that it would be
  /// in.
  using IsWanted = std::function<bool(std::size_t range)>;
  /// Told of each range that was wanted, as soon as it was read or could not be.
  using RangeRead = std::function<void(std::size_t range, RangeBytes read)>;
  /// `ranges`: ascending, not overlapping; near ones by one request. A request that fails is repeated range by range,
  /// so that a range has no failure but its own. `is_stopped`, if any, is asked before each request: whether that and
  /// all others are not to be made.
  void read_each(std::span<const ByteRange> ranges, const IsWanted& is_wanted, const RangeRead& done,
                 const std::function<bool()>& is_stopped = {});
  /// All of them.
  [[nodiscard]] std::vector<RangeBytes> read_all(std::span<const ByteRange> ranges);

  [[nodiscard]] std::uint64_t bytes_read() const { return bytes_; }
  [[nodiscard]] std::uint64_t requests() const { return requests_; }

private:
  std::shared_ptr<ByteSource> source_;
  std::uint64_t size_;
  std::uint64_t max_gap_;
  OwnedMutex mutex_; ///< of the source
  std::atomic<std::uint64_t> bytes_{0}, requests_{0};
};

} // namespace ptet::file
