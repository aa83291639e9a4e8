// Long calls of the library as Python wants them: other threads run meanwhile, Ctrl-C stops them, and an exception that
// Python code raised in between comes out as it went in.
#pragma once

#include "gil.hpp"
#include "ptet/error.hpp"
#include "ptet/progress.hpp"

#include <chrono>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

namespace ptet::python {

/// A Python exception on its way through code that knows nothing of Python. From any thread.
class PendingError {
public:
  /// The first one counts. The GIL must be held.
  void keep(py::error_already_set&& error) {
    const std::lock_guard guard(mutex_);
    if (!error_) error_.emplace(std::move(error));
  }
  [[nodiscard]] bool is_there() const {
    const std::lock_guard guard(mutex_);
    return error_.has_value();
  }
  /// Throws the exception if there is one, and forgets it. The GIL must be held.
  void raise() {
    std::unique_lock guard(mutex_);
    if (!error_) return;
    py::error_already_set error = std::move(*error_);
    error_.reset();
    guard.unlock();
    throw error;
  }

private:
  mutable std::mutex mutex_;
  std::optional<py::error_already_set> error_;
};

/// The library's progress callback: looks for signals, and calls `progress(stage, done, total)` unless it is None.
/// It takes the GIL some 20 times a second, whatever the library does.
class Watch {
public:
  /// `reading`: where a source leaves what must stop the call.
  Watch(const py::object& progress, const PendingError& reading) : progress_(progress), reading_(reading) {}

  bool operator()(const Progress& now) {
    if (raised_.is_there() || reading_.is_there() || is_gil_lost()) return false;
    const auto time = std::chrono::steady_clock::now();
    if (now.stage == stage_ && time - last_ < std::chrono::milliseconds(50)) return true;
    last_ = time;
    stage_ = now.stage;
    const GilTaken taken;
    try {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (progress_.is_none()) return true;
      const py::object answer = progress_(py::str(now.stage.data(), now.stage.size()), now.done, now.total);
      py::detail::make_caster<bool> is_to_go_on; // of a bool, also of numpy's; other answers mean nothing
      return !is_to_go_on.load(answer, false) || static_cast<bool>(is_to_go_on);
    } catch (py::error_already_set& error) {
      raised_.keep(std::move(error));
      return false;
    }
  }
  /// What signals or `progress` raised, if they did.
  [[nodiscard]] PendingError& raised() { return raised_; }

private:
  const py::object& progress_;
  const PendingError& reading_;
  PendingError raised_;
  std::string stage_;
  std::chrono::steady_clock::time_point last_{};
};

/// Runs `call(callback)` without the GIL. What Python code raised meanwhile, in `progress` or in a source that leaves
/// it in `reading`, goes before whatever the library makes of it.
template <class Call>
auto without_gil(const py::object& progress, PendingError& reading, Call&& call) {
  Watch watch(progress, reading);
  const ProgressCallback callback = std::ref(watch);
  const auto raise = [&] {
    watch.raised().raise();
    reading.raise();
  };
  using Result = std::invoke_result_t<Call, const ProgressCallback&>;
  try {
    if constexpr (std::is_void_v<Result>) {
      {
        const GilReleased released;
        call(callback);
      }
      raise();
    } else {
      Result result = [&] {
        const GilReleased released;
        return call(callback);
      }();
      raise();
      return result;
    }
  } catch (const Error&) {
    raise();
    throw;
  }
}

/// The same of a call that reads through no source.
template <class Call>
auto without_gil(const py::object& progress, Call&& call) {
  PendingError none;
  return without_gil(progress, none, std::forward<Call>(call));
}

} // namespace ptet::python
