#include "console.hpp"

#include "plain_output.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <new>
#include <utility>

#include <sys/ioctl.h>
#include <unistd.h>

namespace ptet::cli {
namespace {

std::atomic<bool> interrupt_flag{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may touch only lock-free atomics");

extern "C" void note_interrupt(int) {
  interrupt_flag.store(true, std::memory_order_relaxed);
}

constexpr auto kRewriteEvery = std::chrono::milliseconds(100);
/// The rate is taken over the last one to two of these.
constexpr auto kRateOver = std::chrono::seconds(3);
/// A rate over less says nothing.
constexpr double kLeastRateSeconds = 0.5;
/// Totals below this are shares of the work, not things that a rate can count.
constexpr std::uint64_t kLeastCounted = 10'000;

/// A line that is wrapped cannot be written over: on a terminal with fewer columns each would stay.
void cut_to_terminal(std::string& line) {
  struct winsize size {};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1)
    line.resize(std::min<std::size_t>(line.size(), size.ws_col - 1));
}

std::string minutes(double seconds) {
  const auto whole = static_cast<long>(std::ceil(std::min(seconds, 1e6)));
  char text[32];
  std::snprintf(text, sizeof text, "%ld:%02ld", whole / 60, whole % 60);
  return text;
}

} // namespace

ExitCode exit_code_of(ErrorCode code) {
  switch (code) {
  case ErrorCode::kBadArgument: return kExitUsage;
  case ErrorCode::kBadInput: return kExitBadInput;
  case ErrorCode::kCorruptFile: return kExitCorruptFile;
  case ErrorCode::kLimit: return kExitLimit;
  case ErrorCode::kIo: return kExitIo;
  case ErrorCode::kCancelled: return kExitInterrupted;
  }
  return kExitInternal;
}

int fail(ExitCode code, const std::string& message) {
  std::cerr << "ptet: error: " << plain_text(message, false) << '\n';
  return code;
}

int guarded(const std::function<int()>& run) {
  try {
    return run();
  } catch (const Interrupted& error) {
    std::cerr << "ptet: interrupted; " << plain_text(error.what(), false) << '\n';
    return kExitInterrupted;
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kCancelled) {
      std::cerr << "ptet: interrupted; nothing was written\n";
      return kExitInterrupted;
    }
    return fail(exit_code_of(error.code()), error.what());
  } catch (const std::bad_alloc&) {
    return fail(kExitLimit, "there is not enough memory for this");
  } catch (const std::exception& error) {
    return fail(kExitInternal, std::string("this is a fault of ptet: ") + error.what());
  }
}

void catch_interrupts() {
  struct sigaction action {};
  action.sa_handler = note_interrupt;
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  sigemptyset(&action.sa_mask);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    // Who started us may have asked for the signal to be ignored (nohup, a shell's background job): leave it so.
    struct sigaction before {};
    if (sigaction(signal, nullptr, &before) == 0 && before.sa_handler != SIG_IGN) sigaction(signal, &action, nullptr);
  }
}

void let_interrupts_end() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction action {};
    if (sigaction(signal, nullptr, &action) != 0 || action.sa_handler != note_interrupt) continue;
    action.sa_handler = SIG_DFL;
    sigaction(signal, &action, nullptr);
  }
  stop_if_interrupted(); // by one that came before
}

bool interrupted() {
  return interrupt_flag.load(std::memory_order_relaxed);
}

void stop_if_interrupted() {
  if (interrupted()) throw Error(ErrorCode::kCancelled, "interrupted");
}

ProgressLine::ProgressLine(bool quiet) {
  const char* const terminal = std::getenv("TERM");
  enabled_ = !quiet && isatty(STDERR_FILENO) == 1 && terminal != nullptr && std::string_view(terminal) != "dumb";
}

ProgressCallback ProgressLine::callback() {
  return [this](const Progress& progress) {
    show(progress);
    return !interrupted();
  };
}

void ProgressLine::stage(std::string_view stage) {
  stop_if_interrupted();
  last_shown_ = {};
  show({stage, 0, 0});
}

double ProgressLine::rate(const Sample& now) {
  if (now.done < recent_.done) before_ = recent_ = now;
  if (now.time - recent_.time >= kRateOver) before_ = std::exchange(recent_, now);
  const double seconds = std::chrono::duration<double>(now.time - before_.time).count();
  return seconds < kLeastRateSeconds ? 0 : static_cast<double>(now.done - before_.done) / seconds;
}

void ProgressLine::show(const Progress& progress) {
  if (!enabled_) return;
  const auto now = Clock::now();
  if (progress.stage != stage_) {
    stage_ = progress.stage;
    before_ = recent_ = {now, progress.done};
  } else if (now - last_shown_ < kRewriteEvery) {
    return;
  }
  last_shown_ = now;

  std::string line = stage_;
  if (progress.total > 0) {
    const std::uint64_t done = std::min(progress.done, progress.total);
    char share[16];
    std::snprintf(share, sizeof share, " %3.0f%%",
                  100 * static_cast<double>(done) / static_cast<double>(progress.total));
    line += share;
    if (const double per_second = rate({now, done}); per_second > 0) {
      if (progress.total >= kLeastCounted) line += "  " + grouped(static_cast<std::uint64_t>(per_second)) + "/s";
      line += "  " + minutes(static_cast<double>(progress.total - done) / per_second) + " left";
    }
  }
  cut_to_terminal(line);
  std::fprintf(stderr, "\r%s\x1b[K", line.c_str());
  std::fflush(stderr);
  shown_ = true;
}

void ProgressLine::erase() {
  if (!shown_) return;
  std::fputs("\r\x1b[K", stderr);
  std::fflush(stderr);
  shown_ = false;
}

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

std::string counted(std::uint64_t number, std::string_view noun) {
  std::string text = grouped(number) + " ";
  if (number != 1 && noun == "vertex") return text + "vertices";
  return text + std::string(noun) + (number == 1 ? "" : "s");
}

std::string brief(double number, int digits) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*g", digits, number);
  return text;
}

std::optional<double> percentage(double part, double whole) {
  if (!(whole > 0) || !std::isfinite(whole) || !std::isfinite(part / whole)) return std::nullopt;
  return 100 * (part / whole);
}

std::string percent(double part, double whole) {
  const std::optional<double> share = percentage(part, whole);
  return share ? brief(*share, 3) + "%" : std::string{};
}

std::string percent_up(double part, double whole) {
  const std::optional<double> share = percentage(part, whole);
  return share ? brief_up(*share, 3) + "%" : std::string{};
}

std::string placed(double number, double extent) {
  const double told = std::abs(number) / (1e-5 * extent);
  const bool is_told = extent > 0 && std::isfinite(told);
  return brief(number, is_told ? std::clamp(static_cast<int>(std::ceil(std::log10(told))), 6, 17) : 6);
}

std::string placed(const Point& point, double extent) {
  return "(" + placed(point[0], extent) + ", " + placed(point[1], extent) + ", " + placed(point[2], extent) + ")";
}

std::string as_given(double number) {
  constexpr double kMostWritten = 1e15; // beyond, with an exponent
  const double size = std::abs(number);
  int digits = size >= 1 && size < kMostWritten ? std::max(6, 1 + static_cast<int>(std::log10(size))) : 6;
  std::string text = brief(number, digits);
  while (digits < 17 && std::strtod(text.c_str(), nullptr) != number)
    text = brief(number, ++digits);
  return text;
}

std::string as_given(const Point& point) {
  return "(" + as_given(point[0]) + ", " + as_given(point[1]) + ", " + as_given(point[2]) + ")";
}

void print(const Json& json) {
  std::cout << escaped_json(json.dump(2, ' ', false, nlohmann::detail::error_handler_t::replace)) << '\n';
}

} // namespace ptet::cli
