// The program's side of the conversation: exit codes, progress, interrupts, numbers as people read them, JSON.
#pragma once

#include "mesh/number_text.hpp"
#include "ptet/dataset.hpp"
#include "ptet/error.hpp"
#include "ptet/progress.hpp"
#include "tools/brief_up.hpp"

#include <chrono>
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <optional>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

namespace ptet::cli {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

/// The exit codes, as `ptet --help` documents them.
enum ExitCode : int {
  kExitOk = 0,
  kExitInternal = 1,
  kExitUsage = 2,
  kExitBadInput = 3,
  kExitCorruptFile = 4,
  kExitLimit = 5,
  kExitIo = 6,
  kExitInterrupted = 130,
};
[[nodiscard]] ExitCode exit_code_of(ErrorCode code);
/// One line on standard error. Returns `code`.
int fail(ExitCode code, const std::string& message);
/// What `run` returns; what it throws becomes a line on standard error and its exit code.
int guarded(const std::function<int()>& run);

/// From here on SIGINT, SIGTERM and SIGHUP set a flag that progress callbacks look at; a second one of the same kind
/// kills.
void catch_interrupts();
/// For what only reads and prints, and so leaves nothing behind wherever it ends: from here on the first one kills.
void let_interrupts_end();
[[nodiscard]] bool interrupted();
/// Throws Error(kCancelled) after an interrupt.
void stop_if_interrupted();
/// An interrupt that left something of use; the message says what, where it is otherwise said that there is nothing.
class Interrupted : public Error {
public:
  explicit Interrupted(const std::string& left) : Error(ErrorCode::kCancelled, left) {}
};

/// One line on a terminal, rewritten in place with stage, share done, rate and remaining time; erased at the end.
/// Silent where standard error is no terminal.
class ProgressLine {
public:
  explicit ProgressLine(bool quiet = false);
  ~ProgressLine() { erase(); }
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// For the library: shows the progress, and is false after an interrupt. Must not outlive this object.
  [[nodiscard]] ProgressCallback callback();
  /// Says what is being done when the library cannot report on it.
  void stage(std::string_view stage);
  void erase();

private:
  struct Sample {
    Clock::time_point time;
    std::uint64_t done = 0;
  };
  void show(const Progress& progress);
  /// Things done per second lately; 0 while nothing can be said.
  [[nodiscard]] double rate(const Sample& now);

  bool enabled_;
  bool shown_ = false;
  std::string stage_;
  Sample before_, recent_; ///< the rate is since `before_`, which follows at a distance: work may slow down
  Clock::time_point last_shown_;
};

[[nodiscard]] double seconds_since(Clock::time_point begin);

/// "1 tet", "2,000 tets"
[[nodiscard]] std::string counted(std::uint64_t number, std::string_view noun);
/// `digits` significant digits.
[[nodiscard]] std::string brief(double number, int digits = 4);
/// 100 part / whole; nothing where there is no whole, or none that a share can be told of.
[[nodiscard]] std::optional<double> percentage(double part, double whole);
/// The same as "12.3%", or empty.
[[nodiscard]] std::string percent(double part, double whole);
/// The same for a bound: rounded up.
[[nodiscard]] std::string percent_up(double part, double whole);
/// With digits enough to tell a hundred-thousandth of `extent` there, and 6 at least: places far from 0, values that
/// differ by little.
[[nodiscard]] std::string placed(double number, double extent);
[[nodiscard]] std::string placed(const Point& point, double extent);
/// With the fewest digits that give the number back, from 6 on: what the user has asked for.
[[nodiscard]] std::string as_given(double number);
[[nodiscard]] std::string as_given(const Point& point);

/// Where DatasetInfo::errors_are_bounds is false.
inline constexpr const char* kNoBounds = "errors are what the build has seen, and the true ones may be larger: "
                                         "ptet build --evaluate exact makes them bounds";

/// Where DatasetInfo::overlaps_itself is true.
inline constexpr const char* kOverlaps =
    "tets of the original lie in one another: a point there has several values, and "
    "errors are those of each part by itself";

/// One object on standard output. Text that is not UTF-8 is replaced, numbers that are not finite become null.
void print(const Json& json);

} // namespace ptet::cli
