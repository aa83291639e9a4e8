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
std::atomic<bool> is_failing{false};
std::thread::id ending; // set before is_over and is_failing
thread_local int calls_of_python = 0;

using Clock = std::chrono::steady_clock;
constexpr std::chrono::seconds kPatience{2};

[[noreturn]] void wait_for_the_end() {
  while (true)
    std::this_thread::sleep_for(std::chrono::hours(1));
}

// A moment only: Python code that the end waits for may wait for this thread.
void wait_if_failing() {
  if (!is_failing || calls_of_python > 0 || std::this_thread::get_id() == ending) return;
  const auto end = Clock::now() + kPatience;
  while (!is_over && Clock::now() < end)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
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
  wait_if_failing();
  begin_to_take();
  PyEval_RestoreThread(state_);
  --about_to_take;
}

GilTaken::GilTaken() {
  if (PyGILState_Check() == 0) {
    begin_to_take();
    held_.emplace();
    --about_to_take;
  }
  ++calls_of_python;
}

GilTaken::~GilTaken() {
  --calls_of_python;
}

bool is_gil_lost() {
  return is_over && std::this_thread::get_id() != ending;
}

void announce_end_of_gil() {
  ending = std::this_thread::get_id();
}

void let_fail_until_end_of_gil() {
  is_failing = true;
}

void end_gil() {
  is_over = true;
  PyThreadState* const state = PyEval_SaveThread();
  const auto end = Clock::now() + kPatience;
  while (about_to_take > 0 || (without > 0 && Clock::now() < end))
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  PyEval_RestoreThread(state);
}

} // namespace ptet::python
