#include "virtual_display.hpp"

#include "ptet/error.hpp"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <utility>
#include <vector>

#include <X11/Xlib.h>
#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

namespace ptet::view {
namespace {

constexpr int kPatienceMs = 20000;

/// What comes through the pipe up to a line end, or less when nothing more comes.
std::string line_from(int pipe) {
  std::string line;
  char c = 0;
  pollfd waiting{pipe, POLLIN, 0};
  while (poll(&waiting, 1, kPatienceMs) > 0 && read(pipe, &c, 1) == 1 && c != '\n')
    line += c;
  return line;
}

} // namespace

// The connection is kept: a server whose last client has gone starts anew, and is away for a moment.
bool has_display() {
  static Display* display = nullptr;
  static std::string answers;
  const char* const name = std::getenv("DISPLAY");
  if (name == nullptr) return false;
  if (display == nullptr || answers != name) {
    display = XOpenDisplay(name);
    answers = name;
  }
  return display != nullptr;
}

VirtualDisplay::VirtualDisplay() {
  std::array<int, 2> pipe_ends{};
  if (pipe2(pipe_ends.data(), O_CLOEXEC) != 0)
    throw Error(ErrorCode::kIo, std::string("cannot start Xvfb: ") + std::strerror(errno));
  // It ends by itself when its last client has gone (-terminate), however this process ends: see connection_.
  // The server writes the number of the display to its standard output, where it has no other use for that.
  posix_spawn_file_actions_t actions{};
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, pipe_ends[1], 1);
  posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
  std::vector<std::string> words = {"Xvfb",         "-displayfd", "1",   "-screen",   "0",
                                    "1280x1024x24", "-nolisten",  "tcp", "-terminate"};
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words)
    arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const int status = posix_spawnp(&server_, "Xvfb", &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(pipe_ends[1]);
  const std::string number = status == 0 ? line_from(pipe_ends[0]) : "";
  close(pipe_ends[0]);
  if (status != 0) {
    server_ = -1;
    throw Error(ErrorCode::kIo,
                "there is no display, and none can be made: Xvfb: " + std::string(std::strerror(status)) +
                    "; install xvfb (Debian: apt-get install xvfb), or set DISPLAY");
  }
  if (number.empty()) {
    stop();
    throw Error(ErrorCode::kIo, "there is no display, and Xvfb did not start; does it run by itself?");
  }
  name_ = ":" + number;
  setenv("DISPLAY", name_.c_str(), 1);
  connection_ = XOpenDisplay(name_.c_str());
  if (connection_ == nullptr) {
    stop();
    throw Error(ErrorCode::kIo, "there is no display, and the one that Xvfb made cannot be used");
  }
}

VirtualDisplay::~VirtualDisplay() {
  stop();
}

void VirtualDisplay::stop() {
  if (connection_ != nullptr) {
    XCloseDisplay(std::exchange(connection_, nullptr));
    unsetenv("DISPLAY");
  }
  if (server_ <= 0) return;
  kill(server_, SIGTERM);
  int status = 0;
  while (waitpid(server_, &status, 0) == -1 && errno == EINTR) {
  }
  server_ = -1;
}

} // namespace ptet::view
