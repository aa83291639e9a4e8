#include "gil.hpp"

#include <atomic>
#include <chrono>
#include <thread>

#include <pthread.h>

namespace ptet::python {
namespace {

// A thread says that it is about to take the lock before it looks whether it is lost; who makes it lost says so before
// looking who is about to. So one of the two sees the other.
std::atomic<bool> is_over{false};
std::atomic<int> about_to_take{0}, without{0};
std::thread::id ending; // set before is_over

[[noreturn]] void wait_for_the_end() {
  while (true)
    std::this_thread::sleep_for(std::chrono::hours(1));
}

void begin_to_take() {
  ++about_to_take;
  if (!is_gil_lost()) return;
  --about_to_take;
  wait_for_the_end();
}

// The other threads are gone, and with them what they were about to do.
void forget_others() {
  about_to_take = 0;
  without = 0;
}
[[maybe_unused]] const int is_registered = ::pthread_atfork(nullptr, nullptr, forget_others);

} // namespace

GilReleased::GilReleased() : state_((++without, PyEval_SaveThread())) {}

GilReleased::~GilReleased() {
  --without;
  begin_to_take();
  PyEval_RestoreThread(state_);
  --about_to_take;
}

GilTaken::GilTaken() {
  if (PyGILState_Check() == 1) return;
  begin_to_take();
  held_.emplace();
  --about_to_take;
}

bool is_gil_lost() {
  return is_over && std::this_thread::get_id() != ending;
}

void wait_for_end_of_gil() {
  while (!is_over && PyGILState_Check() == 0)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

void end_gil() {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::seconds kPatience{2};
  ending = std::this_thread::get_id();
  is_over = true;
  PyThreadState* const state = PyEval_SaveThread();
  const auto end = Clock::now() + kPatience;
  while (about_to_take > 0 || (without > 0 && Clock::now() < end))
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  PyEval_RestoreThread(state);
}

} // namespace ptet::python
