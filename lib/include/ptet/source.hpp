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
  /// When it cannot, it throws any std::exception; what it says goes into the error or BlockFailure that follows, but
  /// std::bad_alloc, which goes through to who asked. It must not ask the dataset that it is read for:
  /// Error(kBadArgument). What may hang, as a connection does, has to have a time limit: the end of the last who holds
  /// the dataset waits for a read that is under way.
  virtual void read(std::uint64_t offset, std::span<std::byte> into) = 0;
};

/// How much a file may make the library allocate, for files that nobody vouches for. One that would pass a limit is
/// refused with an Error(kLimit) that names it, before anything of that size is allocated. Whatever the limits, a file
/// that states larger counts than its bytes can hold is refused.
struct Limits {
  /// Memory for what opening holds for good (a bounded number of bytes for each vertex of the original, and the base
  /// mesh) and for decoded blocks, counted with what an extraction and a session take besides: rather high, see
  /// DatasetInfo::memory_for_all. Blocks that do not fit make answers coarser, see LimitedBy::kMemory.
  std::uint64_t max_bytes = std::uint64_t{1} << 35;
  std::uint64_t max_vertices = std::uint64_t{1} << 30; ///< of the original
  std::uint64_t max_tets = std::uint64_t{1} << 32;     ///< of the original
};

struct OpenOptions {
  /// Bytes that decoded blocks may take in memory, as far as the block table tells; 0: as many as Limits::max_bytes
  /// leaves. Matters only where not all blocks of the file fit. Then:
  ///   - a request that needs room has blocks dropped that neither it nor the last update of a living session needs;
  ///     one whose own blocks do not fit beside these is answered coarser (LimitedBy::kMemory)
  ///   - dropping costs what decoding all that stays costs, as it is made anew, and sessions start over from the base
  ///     mesh (SessionUpdate::renumbered)
  ///   - extractions take turns
  ///   - a sixteenth of the limit holds blocks as they are stored, those used last, which need not be read again
  std::uint64_t memory_limit = 0;
  /// A thread of the dataset reads and decodes. extract() does not wait for it but answers with what is there, see
  /// LimitedBy::kLoading; only what Request::input_order takes it reads itself. A block that could not be read is not
  /// tried again for a second, however often it is asked for. Whoever lets the last reference to the dataset or its
  /// sessions go waits until a read that is under way has ended, but within that read itself, where the thread lets the
  /// dataset go at its end; a source that may hang has to have a time limit. A forked process does not have the thread,
  /// and every question is an Error(kIo) there: it opens the file anew. Best for a viewer whose source takes
  /// long to answer: without it Request::max_milliseconds cannot be kept.
  bool background = false;
  /// Blocks so many bytes or less apart in the file are read by one request, with what is between them. For a server
  /// that takes 50 ms to answer a request and sends 10 MB/s some 500,000 are best.
  std::uint64_t max_gap = 0;
  Limits limits;
};

/// A block that could not be had. What needs its records is left out, too, and the answer is coarser there.
struct BlockFailure {
  std::uint32_t block = 0;       ///< row of the block table
  std::uint64_t byte_offset = 0; ///< of the block in the file
  /// kIo: later requests try again, see OpenOptions::background. kCorruptFile: the block is damaged, and left out for
  /// good; where its hash does not match it was read twice.
  ErrorCode code = ErrorCode::kCorruptFile;
  std::string message;
};

} // namespace ptet
