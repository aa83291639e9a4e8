// Without MPI there is but one process.
#include "ptet/error.hpp"
#include "ranks.hpp"

namespace ptet::cli {

struct Ranks::Impl {};

bool can_meet() {
  return false;
}

void tell_first(int /*exit_code*/, const std::string& /*message*/) {}

Ranks::Ranks() {
  if (const int count = started_processes().count; count > 1)
    throw Error(ErrorCode::kBadArgument, std::to_string(count) +
                                             " processes were started together, but this program was built without "
                                             "MPI (the CMake option PTET_BUILD_MPI): start one");
}
Ranks::~Ranks() = default;

int Ranks::count() const {
  return 1;
}

unsigned Ranks::threads_afterwards(unsigned threads) const {
  return threads;
}

ProgressCallback Ranks::watching(ProgressCallback progress) const {
  return progress;
}

int Ranks::rank() const {
  return 0;
}

std::vector<Decided> Ranks::gather(std::vector<Decided> own, std::uint32_t /*piece_count*/) {
  return own;
}

} // namespace ptet::cli
