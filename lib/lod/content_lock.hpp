// The lock of what is in memory: any number of readers, or one who changes it a little at a time.
//
// It is taken through a gate. Who waits at the gate comes before the next change, so that a stream of changes keeps no
// reader waiting; and a change that has waited for long closes it, so that no stream of readers keeps changes waiting.
#pragma once

#include <mutex>
#include <shared_mutex>

namespace ptet {

/// Thread rule: any number of threads; none may take it twice.
class ContentLock {
public:
  [[nodiscard]] std::shared_lock<std::shared_mutex> shared() const;
  [[nodiscard]] std::unique_lock<std::shared_mutex> alone();

private:
  mutable std::mutex gate_;
  mutable std::shared_mutex content_;
};

} // namespace ptet
