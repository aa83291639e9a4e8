// Where a .ptet file's bytes come from, when neither a path nor memory will do: a part of a larger file, range requests
// to a server, an object store.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace ptet {

class ByteSource {
public:
  virtual ~ByteSource() = default;
  /// Bytes of the whole file; must not change.
  virtual std::uint64_t size() = 0;
  /// Fills `into` from `offset`; asked for nothing beyond size(). Throws Error(kIo), or anything else, when the bytes
  /// cannot be had: what it throws comes out of the call that needs them.
  /// Thread rule: called from the threads that use the dataset, one call at a time.
  virtual void read(std::uint64_t offset, std::span<std::byte> into) = 0;
};

} // namespace ptet
