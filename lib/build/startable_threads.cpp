#include "build/startable_threads.hpp"

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdlib>
#include <new>
#include <system_error>
#include <thread>
#include <vector>

#include <sys/mman.h>

namespace ptet::build {

namespace {

/// A thread's first allocation may reserve much address space, for good.
void allocate_once() {
  void* volatile memory = std::malloc(1);
  std::free(memory);
}

/// Address space that nobody else gets while this is there: where it is limited, what threads take for their
/// allocations, for good, would leave none for the work.
class Reserved {
public:
  Reserved() : begin_(::mmap(nullptr, kBytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0)) {}
  ~Reserved() {
    if (is_there()) ::munmap(begin_, kBytes);
  }
  Reserved(const Reserved&) = delete;
  Reserved& operator=(const Reserved&) = delete;
  [[nodiscard]] bool is_there() const { return begin_ != MAP_FAILED; }

private:
  static constexpr std::size_t kBytes = std::size_t{1} << 28;
  void* begin_;
};

} // namespace

unsigned startable_threads(unsigned wanted) {
  const Reserved reserved;
  if (!reserved.is_there()) return 1;
  std::atomic<bool> may_end{false};
  std::vector<std::thread> started;
  bool is_refused = false;
  started.reserve(wanted);
  try {
    while (started.size() + 1 < wanted)
      started.emplace_back([&may_end] {
        allocate_once();
        may_end.wait(false);
      });
  } catch (const std::system_error&) {
    is_refused = true;
  } catch (const std::bad_alloc&) {
    is_refused = true;
  }
  may_end = true;
  may_end.notify_all();
  for (std::thread& thread : started)
    thread.join();
  if (!is_refused) return static_cast<unsigned>(started.size()) + 1;
  std::this_thread::sleep_for(std::chrono::milliseconds(10)); // threads that have ended count for a moment still
  return static_cast<unsigned>(started.size() / 4) + 1;
}

} // namespace ptet::build
