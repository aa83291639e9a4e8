#include "ranks.hpp"

#include "console.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdlib>
#include <iostream>
#include <sstream>
#include <string_view>
#include <thread>

namespace ptet::cli {
namespace {

constexpr std::chrono::milliseconds kBetweenLooks{20};
/// A process that failed waits so long for the first one to end all; then something else is wrong.
constexpr std::chrono::seconds kLongestWait{30};

/// -1 where the variable is no number.
int number_in(const char* variable) {
  const char* const text = std::getenv(variable);
  if (text == nullptr) return -1;
  const std::string_view digits(text);
  int number = -1;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  return error == std::errc() && end == digits.data() + digits.size() ? number : -1;
}

/// What is written to a stream goes to another, while this is there.
class Redirected {
public:
  Redirected(std::ostream& from, std::ostringstream& to) : from_(from), before_(from.rdbuf(to.rdbuf())) {}
  ~Redirected() { from_.rdbuf(before_); }
  Redirected(const Redirected&) = delete;
  Redirected& operator=(const Redirected&) = delete;

private:
  std::ostream& from_;
  std::streambuf* before_;
};

} // namespace

StartedProcesses started_processes() {
  struct Names {
    const char* count;
    const char* rank;
  };
  // Open MPI; MPICH and others of its kind.
  static constexpr std::array<Names, 2> kStarters{
      {{"OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK"}, {"PMI_SIZE", "PMI_RANK"}}};
  for (const Names& names : kStarters) {
    const StartedProcesses found{number_in(names.count), number_in(names.rank)};
    if (found.count >= 1 && found.rank >= 0 && found.rank < found.count) return found;
  }
  return {};
}

std::vector<Decided> Ranks::decide(const PiecesBuild& pieces, const ProgressCallback& progress) {
  constexpr std::uint64_t kSteps = 1000; // a piece
  std::vector<Decided> own;
  const auto step = static_cast<std::uint32_t>(count());
  const std::uint32_t pieces_here = (pieces.piece_count() + step - 1) / step;
  for (auto p = static_cast<std::uint32_t>(rank()); p < pieces.piece_count(); p += step)
    own.push_back(pieces.decide(p, [&](const Progress& of_piece) {
      const std::uint64_t steps = kSteps * of_piece.done / std::max<std::uint64_t>(1, of_piece.total);
      return progress({"collapsing pieces", p / step * kSteps + steps, pieces_here * kSteps});
    }));
  return gather(std::move(own), pieces.piece_count());
}

int as_a_rank(const std::function<int()>& run) {
  if (!can_meet() || started_processes().rank == 0) return run();
  std::ostringstream unheard;
  std::ostringstream message;
  const int code = [&] {
    const Redirected out(std::cout, unheard), err(std::cerr, message);
    return run();
  }();
  if (code == kExitOk) return code;
  tell_first(code, message.str());
  // Who ends first with an error has all the others killed: this must be who speaks.
  const auto begin = Clock::now();
  while (!interrupted() && Clock::now() - begin < kLongestWait)
    std::this_thread::sleep_for(kBetweenLooks);
  if (!interrupted()) std::cerr << message.str(); // the first has not ended: nobody has heard of it
  return code;
}

} // namespace ptet::cli
