// What the objects of ptet._core hold.
#pragma once

#include "arrays.hpp"
#include "interrupt.hpp"
#include "ptet/dataset.hpp"
#include "ptet/session.hpp"

#include <memory>
#include <span>

namespace ptet::python {

/// An opened file. Closing it may wait for its thread, which may wait for the GIL, so that it is given up meanwhile.
class OpenFile {
public:
  OpenFile(std::shared_ptr<const Dataset> data, std::shared_ptr<PendingError> pending)
      : data_(std::move(data)), pending_(std::move(pending)) {}
  ~OpenFile() {
    const GilReleased released;
    data_.reset();
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  [[nodiscard]] const std::shared_ptr<const Dataset>& data() const { return data_; }
  /// Where its source leaves exceptions that are not about reading.
  [[nodiscard]] PendingError& pending() const { return *pending_; }

private:
  std::shared_ptr<const Dataset> data_;
  std::shared_ptr<PendingError> pending_;
};

/// (block, byte offset, whether reading it may be tried again, message) each.
inline py::list failures_as_list(std::span<const BlockFailure> failures) {
  py::list list;
  for (const BlockFailure& failure : failures) {
    list.append(
        py::make_tuple(failure.block, failure.byte_offset, failure.code == ErrorCode::kIo, to_str(failure.message)));
  }
  return list;
}

} // namespace ptet::python
