// Bytes of a .ptet file that Python holds or fetches.
#pragma once

#include "interrupt.hpp"
#include "ptet/source.hpp"

#include <memory>

namespace ptet::python {

/// The memory of a bytes-like object, read where it is. The GIL must be held to make one, and only for that.
[[nodiscard]] std::shared_ptr<ByteSource> over_buffer(const py::buffer& buffer);

/// What `read(offset, size)` gives, called from whatever thread the library reads in. What it raises becomes an
/// Error(kIo), or, if it is no Exception (KeyboardInterrupt), goes to `pending` and stops the call.
[[nodiscard]] std::shared_ptr<ByteSource> over_reader(const py::object& read, std::uint64_t size,
                                                      std::shared_ptr<PendingError> pending);

/// Waits for calls of `read` that are under way and lets no other begin: for the end of the interpreter, after which a
/// thread of the library must not ask for the GIL. The GIL must be held.
void shut_readers();

} // namespace ptet::python
