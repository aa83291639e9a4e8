// The processes of MPI. All calls are made by the main thread: MPI_THREAD_FUNNELED.
#include "console.hpp"
#include "ptet/error.hpp"
#include "ranks.hpp"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <limits>
#include <stdexcept>
#include <thread>

#include <mpi.h>
#include <sched.h>

namespace ptet::cli {
namespace {

constexpr int kSizeTag = 1;
constexpr int kBytesTag = 2;
constexpr int kFailureTag = 3;
/// MPI counts with an int.
constexpr std::size_t kLongestMessage = std::size_t{1} << 30U;
constexpr std::chrono::milliseconds kBetweenLooks{1};

bool is_met() {
  int initialized = 0;
  int finalized = 0;
  MPI_Initialized(&initialized);
  MPI_Finalized(&finalized);
  return initialized != 0 && finalized == 0;
}

/// Whether a message is there.
bool has_come(int source, int tag, MPI_Status& status) {
  int flag = 0;
  MPI_Iprobe(source, tag, MPI_COMM_WORLD, &flag, &status);
  return flag != 0;
}

void send(const Decided& decided) {
  const std::uint64_t size = decided.size();
  MPI_Send(&size, 1, MPI_UINT64_T, 0, kSizeTag, MPI_COMM_WORLD);
  for (std::size_t begin = 0; begin < decided.size(); begin += kLongestMessage)
    MPI_Send(decided.data() + begin, static_cast<int>(std::min(kLongestMessage, decided.size() - begin)), MPI_BYTE, 0,
             kBytesTag, MPI_COMM_WORLD);
}

Decided receive(int source) {
  std::uint64_t size = 0;
  MPI_Recv(&size, 1, MPI_UINT64_T, source, kSizeTag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  Decided decided(size);
  for (std::size_t begin = 0; begin < decided.size(); begin += kLongestMessage)
    MPI_Recv(decided.data() + begin, static_cast<int>(std::min(kLongestMessage, decided.size() - begin)), MPI_BYTE,
             source, kBytesTag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  return decided;
}

/// What `guarded` makes of it is what it was made of.
[[noreturn]] void throw_again(int exit_code, std::string message, int rank, int count) {
  const std::string prefix = "ptet: error: ";
  if (message.starts_with(prefix)) message.erase(0, prefix.size());
  if (message.ends_with('\n')) message.pop_back();
  message += " (in process " + std::to_string(rank + 1) + " of " + std::to_string(count) + ")";
  for (const ErrorCode code : {ErrorCode::kBadArgument, ErrorCode::kBadInput, ErrorCode::kCorruptFile,
                               ErrorCode::kLimit, ErrorCode::kIo, ErrorCode::kCancelled})
    if (exit_code_of(code) == exit_code) throw Error(code, message);
  throw std::runtime_error(message);
}

void look_for_failures() {
  MPI_Status status;
  if (!has_come(MPI_ANY_SOURCE, kFailureTag, status)) return;
  int length = 0;
  int count = 0;
  MPI_Get_count(&status, MPI_CHAR, &length);
  MPI_Comm_size(MPI_COMM_WORLD, &count);
  std::string message(static_cast<std::size_t>(length), ' ');
  MPI_Recv(message.data(), length, MPI_CHAR, status.MPI_SOURCE, kFailureTag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  const auto code = static_cast<unsigned char>(message.at(0));
  throw_again(code, message.substr(1), status.MPI_SOURCE, count);
}

} // namespace

bool can_meet() {
  return true;
}

struct Ranks::Impl {
  int count = 1;
  int rank = 0;
  int count_here = 1; ///< processes on this machine
  cpu_set_t cores{};  ///< that they may use together

  void look_around() {
    MPI_Comm here = MPI_COMM_NULL;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &here);
    MPI_Comm_size(here, &count_here);
    cpu_set_t own;
    CPU_ZERO(&own);
    sched_getaffinity(0, sizeof own, &own);
    MPI_Allreduce(&own, &cores, static_cast<int>(sizeof cores), MPI_BYTE, MPI_BOR, here);
    MPI_Comm_free(&here);
  }
};

void tell_first(int exit_code, const std::string& message) {
  if (!is_met()) return;
  const std::string text = static_cast<char>(exit_code) + message;
  MPI_Request request;
  MPI_Isend(text.data(), static_cast<int>(text.size()), MPI_CHAR, 0, kFailureTag, MPI_COMM_WORLD, &request);
  for (int sent = 0; sent == 0 && !interrupted();) {
    MPI_Test(&request, &sent, MPI_STATUS_IGNORE);
    std::this_thread::sleep_for(kBetweenLooks);
  }
}

Ranks::Ranks() : impl_(std::make_unique<Impl>()) {
  if (started_processes().count == 1) return; // starting MPI takes a while
  int provided = 0;
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided);
  MPI_Comm_size(MPI_COMM_WORLD, &impl_->count);
  MPI_Comm_rank(MPI_COMM_WORLD, &impl_->rank);
  impl_->look_around();
}

Ranks::~Ranks() {
  // With an error on its way the process ends as it is: its starter ends the others.
  if (is_met() && std::uncaught_exceptions() == 0) MPI_Finalize();
}

int Ranks::count() const {
  return impl_->count;
}

int Ranks::rank() const {
  return impl_->rank;
}

unsigned Ranks::threads_afterwards(unsigned threads) const {
  if (impl_->count_here == 1) return threads;
  // A process is often bound to one core. Those that the others leave are of the same job.
  std::error_code status;
  for (const auto& thread : std::filesystem::directory_iterator("/proc/self/task", status))
    sched_setaffinity(static_cast<pid_t>(std::stol(thread.path().filename().string())), sizeof impl_->cores,
                      &impl_->cores);
  const auto cores = static_cast<unsigned>(CPU_COUNT(&impl_->cores));
  return threads == 0 ? cores : std::min(threads * static_cast<unsigned>(impl_->count_here), cores);
}

ProgressCallback Ranks::watching(ProgressCallback progress) const {
  if (impl_->rank != 0 || impl_->count == 1) return progress;
  return [progress = std::move(progress)](const Progress& now) {
    if (is_met()) look_for_failures();
    return progress(now);
  };
}

std::vector<Decided> Ranks::gather(std::vector<Decided> own, std::uint32_t piece_count) {
  if (impl_->count == 1) return own;
  if (!is_first()) {
    for (const Decided& decided : own)
      send(decided);
    MPI_Finalize();
    return {};
  }
  std::vector<Decided> all(piece_count);
  for (std::uint32_t p = 0; p < piece_count; ++p) {
    const auto source = static_cast<int>(p % static_cast<std::uint32_t>(impl_->count));
    if (source == 0) {
      all[p] = std::move(own[p / static_cast<std::uint32_t>(impl_->count)]);
      continue;
    }
    // Waiting takes no time from who is still at work.
    for (MPI_Status status; !has_come(source, kSizeTag, status); std::this_thread::sleep_for(kBetweenLooks)) {
      look_for_failures();
      stop_if_interrupted();
    }
    all[p] = receive(source);
  }
  MPI_Finalize();
  return all;
}

} // namespace ptet::cli
