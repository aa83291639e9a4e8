// Where the bytes of a .ptet file come from, and how a file is opened: the limits it must keep, the memory it may take.
#pragma once

#include "ptet/error.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace ptet {

/// The bytes of one .ptet file, wherever they are: an HTTP server that knows ranges, an object store, an archive.
///
/// Thread rule: may be called from any thread, never from two at a time, except by datasets that share it.
class ByteSource {
public:
  virtual ~ByteSource() = default;
  /// Bytes in all; the same at every call.
  virtual std::uint64_t size() = 0;
  /// Fills all of `into` with the bytes from `offset` on; `offset + into.size() <= size()`.
  /// When it cannot, it throws any std::exception; what it says goes into the error or BlockFailure that follows.
  virtual void read(std::uint64_t offset, std::span<std::byte> into) = 0;
};

/// What a file may make the library do, however it came to be: an Error(kLimit) says which of them it would pass,
/// before anything of that size is allocated. Counts are also held against the bytes that the file has for them.
struct Limits {
  /// Memory for what opening holds for good (a bounded number of bytes for each vertex of the original, and the base
  /// mesh) and for decoded blocks. Blocks that do not fit make answers coarser, see LimitedBy::kMemory.
  std::uint64_t max_bytes = std::uint64_t{1} << 35;
  std::uint64_t max_vertices = std::uint64_t{1} << 30; ///< of the original
  std::uint64_t max_tets = std::uint64_t{1} << 32;     ///< of the original
};

struct OpenOptions {
  /// Bytes that decoded blocks may take in memory, as the block table lets them be estimated; 0: as many as
  /// Limits::max_bytes leaves. When a request would pass it, blocks that it does not need are dropped; extractions then
  /// take turns. What its own blocks would pass is left out, see LimitedBy::kMemory. Dropping costs what decoding all
  /// that stays costs, since it is made anew; sessions then start over from the base mesh, see
  /// SessionUpdate::renumbered. A sixteenth is for blocks as they are stored: those used last are not read again.
  std::uint64_t memory_limit = 0;
  /// A thread of the dataset reads and decodes; extract() never waits for it (but for Request::input_order, which it
  /// reads itself) and answers with what is there, see LimitedBy::kLoading. A forked process does not have the thread:
  /// there what is in memory can be extracted, and more is an Error(kIo).
  bool background = false;
  /// Blocks this many bytes or less apart are read by one request. A server that takes 50 ms a request and sends 10
  /// MB/s is best asked with some 500,000.
  std::uint64_t max_gap = 0;
  Limits limits;
};

/// A block that could not be had. What needs its records is left out, too, and the answer is coarser there.
struct BlockFailure {
  std::uint32_t block = 0;                  ///< row of the block table
  std::uint64_t byte_offset = 0;            ///< of the block in the file
  ErrorCode code = ErrorCode::kCorruptFile; ///< kIo: later requests try again
  std::string message;
};

} // namespace ptet
