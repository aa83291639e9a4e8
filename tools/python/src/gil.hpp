// The interpreter's lock, given up and taken so that Python may end while a call of the library is under way in another
// thread.
//
// When Python ends it ends every other thread that asks for the lock from then on, amid C++ code that cannot be left
// so: the process would be aborted. So no thread asks for it then; it waits for the end of the process instead.
//
//   GilReleased  for a time without the lock          GilTaken  for a time with it, in any thread
//   end_gil()    at exit, while there still is a Python to ask
#pragma once

#include <optional>

#include <pybind11/pybind11.h>

namespace ptet::python {

namespace py = pybind11;

/// Gives up the lock, which the thread must hold; takes it again at the end of the scope, or never comes back.
class GilReleased {
public:
  GilReleased();
  ~GilReleased();
  GilReleased(const GilReleased&) = delete;
  GilReleased& operator=(const GilReleased&) = delete;

private:
  PyThreadState* state_;
};

/// Holds the lock, which the thread may hold already; or never comes back.
class GilTaken {
public:
  GilTaken();
  ~GilTaken();
  GilTaken(const GilTaken&) = delete;
  GilTaken& operator=(const GilTaken&) = delete;

private:
  std::optional<py::gil_scoped_acquire> held_;
};

/// Whether calls of other threads than the one that ends Python are to come to an end, as nobody waits for them.
[[nodiscard]] bool is_gil_lost();

/// To be called at exit before anything that lets calls in other threads fail, in the thread of end_gil().
void announce_end_of_gil();
/// A call fails as Python ends, and Python would still print the error. So what comes back to it in other threads waits
/// for end_gil() from now on, some seconds at most; but not where C++ code has called that Python, and waits for it.
void let_fail_until_end_of_gil();

/// To be called at exit, with the lock held: no other thread gets it from C++ code any more. Waits for those that are
/// about to, and a moment for calls to stop.
void end_gil();

} // namespace ptet::python
