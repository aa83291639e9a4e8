// What the objects of ptet._core hold.
#pragma once

#include "interrupt.hpp"
#include "ptet/dataset.hpp"
#include "ptet/session.hpp"

#include <memory>

namespace ptet::python {

/// An opened file. Closing it may wait for its thread, which may wait for the GIL, so that it is given up meanwhile.
class OpenFile {
public:
  OpenFile(std::shared_ptr<const Dataset> data, std::shared_ptr<PendingError> pending)
      : data_(std::move(data)), pending_(std::move(pending)) {}
  ~OpenFile() {
    const py::gil_scoped_release release;
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

} // namespace ptet::python
