// ptet view: starts the viewer, the program ptet-view beside this one, with the options that were given.
#include "commands.hpp"
#include "console.hpp"
#include "view_options.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <memory>

#include <unistd.h>

namespace ptet::cli {
namespace {

/// The options that were given, as a command line has them.
std::vector<std::string> words_of(const CLI::App& command) {
  std::vector<std::string> words, positional;
  for (const CLI::Option* option : command.get_options()) {
    if (option->count() == 0) continue;
    if (option->get_positional()) {
      positional = option->results();
    } else if (option->get_expected_max() == 0) {
      words.push_back(option->get_name());
    } else {
      for (const std::string& value : option->results()) {
        // The viewer would take the next word for it.
        if (value.empty()) throw Error(ErrorCode::kBadArgument, option->get_name() + ": its value is missing");
        words.push_back(option->get_name() + "=" + value);
      }
    }
  }
  words.emplace_back("--");
  words.insert(words.end(), positional.begin(), positional.end());
  return words;
}

[[noreturn]] void run(const CLI::App& command) {
  std::error_code failed;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", failed);
  const std::string viewer = (failed ? std::filesystem::path() : self.parent_path()) / "ptet-view";
  if (access(viewer.c_str(), X_OK) != 0) {
    throw Error(ErrorCode::kIo, "there is no viewer at '" + viewer +
                                    "': this ptet was built where VTK's rendering modules are missing");
  }
  std::vector<std::string> words = words_of(command);
  words.insert(words.begin(), viewer);
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words)
    arguments.push_back(word.data());
  arguments.push_back(nullptr);
  std::cout.flush();
  execv(viewer.c_str(), arguments.data());
  throw Error(ErrorCode::kIo, "cannot start '" + viewer + "': " + std::strerror(errno));
}

} // namespace

void add_view(CLI::App& program) {
  CLI::App* const command = program.add_subcommand("view", "Look at a .ptet file in a window, or make a picture of it");
  const auto arguments = std::make_shared<ViewArguments>();
  add_view_options(*command, *arguments);
  command->callback([command, arguments] { run(*command); });
}

} // namespace ptet::cli
