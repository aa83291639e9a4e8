#include "source.hpp"

#include <cstring>
#include <mutex>
#include <utility>
#include <vector>

namespace ptet::python {
namespace {

class BufferSource final : public ByteSource {
public:
  explicit BufferSource(const py::buffer& buffer) {
    if (PyObject_GetBuffer(buffer.ptr(), &view_, PyBUF_SIMPLE) != 0) throw py::error_already_set();
  }
  ~BufferSource() override {
    const GilTaken taken;
    PyBuffer_Release(&view_);
  }
  BufferSource(const BufferSource&) = delete;
  BufferSource& operator=(const BufferSource&) = delete;

  std::uint64_t size() override { return static_cast<std::uint64_t>(view_.len); }
  void read(std::uint64_t offset, std::span<std::byte> into) override {
    if (!into.empty()) std::memcpy(into.data(), static_cast<const std::byte*>(view_.buf) + offset, into.size());
  }

private:
  Py_buffer view_{};
};

/// "ValueError: what it says", without the traceback that pybind11 would add.
std::string brief(const py::error_already_set& error) {
  std::string text = error.type().attr("__name__").cast<std::string>();
  try {
    const auto message = py::str(error.value()).attr("encode")("utf-8", "backslashreplace").cast<std::string>();
    if (!message.empty()) text += ": " + message;
  } catch (const py::error_already_set&) {
    text += " (whose text cannot be had)";
  }
  return text;
}

class ReaderSource final : public ByteSource {
public:
  ReaderSource(const py::object& read, std::uint64_t size, std::shared_ptr<PendingError> pending)
      : read_(read), size_(size), pending_(std::move(pending)) {}
  ~ReaderSource() override {
    if (is_shut_) {
      (void)read_.release(); // left to the end of the process
    } else {
      const GilTaken taken;
      read_ = py::object();
    }
  }
  ReaderSource(const ReaderSource&) = delete;
  ReaderSource& operator=(const ReaderSource&) = delete;

  std::uint64_t size() override { return size_; }

  void read(std::uint64_t offset, std::span<std::byte> into) override {
    const std::lock_guard guard(reading_);
    if (is_shut_) {
      let_fail_until_end_of_gil();
      throw Error(ErrorCode::kIo, "Python is about to end", offset);
    }
    if (pending_->is_there()) throw Error(ErrorCode::kIo, "reading was stopped", offset);
    const GilTaken taken;
    try {
      fill(read_(offset, into.size()), into);
    } catch (py::error_already_set& error) {
      const std::string what = brief(error);
      if (!error.matches(PyExc_Exception)) pending_->keep(std::move(error));
      throw Error(ErrorCode::kIo, "the source's read raised " + what, offset);
    }
  }

  void shut() {
    const std::lock_guard guard(reading_);
    is_shut_ = true;
  }

private:
  static void fill(const py::object& answer, std::span<std::byte> into) {
    Py_buffer view{};
    if (PyObject_GetBuffer(answer.ptr(), &view, PyBUF_SIMPLE) != 0) throw py::error_already_set();
    const auto size = static_cast<std::size_t>(view.len);
    if (size == into.size() && size > 0) std::memcpy(into.data(), view.buf, size);
    PyBuffer_Release(&view);
    if (size == into.size()) return;
    const std::string what = std::to_string(size) + " bytes where " + std::to_string(into.size()) + " were asked for";
    PyErr_SetString(PyExc_EOFError, what.c_str());
    throw py::error_already_set();
  }

  py::object read_;
  std::uint64_t size_;
  std::shared_ptr<PendingError> pending_;
  std::mutex reading_; ///< taken before the GIL
  bool is_shut_ = false;
};

/// Those that may be alive.
struct Readers {
  std::mutex mutex;
  std::vector<std::weak_ptr<ReaderSource>> all;
};
Readers& readers() {
  static auto* const kReaders = new Readers; // outlives every thread
  return *kReaders;
}

} // namespace

std::shared_ptr<ByteSource> over_buffer(const py::buffer& buffer) {
  return std::make_shared<BufferSource>(buffer);
}

std::shared_ptr<ByteSource> over_reader(const py::object& read, std::uint64_t size,
                                        std::shared_ptr<PendingError> pending) {
  auto source = std::make_shared<ReaderSource>(read, size, std::move(pending));
  const std::lock_guard guard(readers().mutex);
  std::erase_if(readers().all, [](const auto& other) { return other.expired(); });
  readers().all.push_back(source);
  return source;
}

void shut_readers() {
  const GilReleased released;
  std::vector<std::weak_ptr<ReaderSource>> all;
  {
    const std::lock_guard guard(readers().mutex);
    all.swap(readers().all);
  }
  for (const auto& reader : all)
    if (const auto alive = reader.lock()) alive->shut();
}

} // namespace ptet::python
