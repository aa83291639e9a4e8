// The program ptet: parses, runs one command, and turns what goes wrong into one line and an exit code.
#include "arguments.hpp"
#include "closest_name.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "plain_output.hpp"
#include "ranks.hpp"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <iostream>
#include <memory>
#include <vector>

#include <fcntl.h>
#include <unistd.h>

namespace ptet::cli {
namespace {

constexpr const char* kFooter = R"(Examples:
  ptet info fire.vtu
  ptet build fire.vtu -o fire.ptet
  ptet extract fire.ptet --field-error 1% -o coarse.vtu
  ptet view fire.ptet
  ptet measure fire.vtu coarse.vtu
  ptet verify fire.ptet --original fire.vtu
  ptet help extract

Exit codes: 0 done; 2 usage; 3 bad input (mesh or field); 4 corrupt file, or verify found something wrong; 5 a limit,
such as memory; 6 reading or writing failed; 130 interrupted, with nothing left behind but the checkpoint that a build
was to keep (a second Ctrl-C kills at once; dump, and info of a .ptet file, end by the first one's signal); 1 an error
inside ptet itself. Errors are one line on standard error; then standard output holds no report, except for what verify
found and of what extract --salvage has left.
)";

/// A file that is opened must never take the number of a standard stream that is closed.
void hold_standard_streams() {
  for (int stream = 0; stream <= 2; ++stream) {
    if (fcntl(stream, F_GETFD) == -1 && errno == EBADF && open("/dev/null", O_RDONLY) != stream) _exit(kExitIo);
  }
}

/// Throws Error(kBadArgument), with the names there are.
const CLI::App& command_named(const CLI::App& program, const std::string& name) {
  std::vector<std::string> names;
  for (const CLI::App* command : program.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_name() == name) return *command;
    if (!command->get_group().empty()) names.push_back(command->get_name());
  }
  throw Error(ErrorCode::kBadArgument, "there is no command '" + name + "'; there are " + quoted_list(names));
}

/// The help of one command, or with no name of the program.
std::string help_of(const CLI::App& program, const std::string& command) {
  if (!command.empty()) return command_named(program, command).help(program.get_name());
  return program.get_formatter()->make_help(&program, program.get_name(), CLI::AppFormatMode::Normal);
}

void add_commands(CLI::App& program) {
  program.description("ptet " PTET_VERSION ": level of detail for tetrahedral meshes, with errors that are measured");
  program.set_version_flag("--version", "ptet " PTET_VERSION, "the version");
  program.set_help_flag("-h,--help", "this help");
  program.require_subcommand(0, 1);
  program.get_formatter()->label("SUBCOMMAND", "COMMAND");
  program.get_formatter()->column_width(34);
  program.footer(kFooter);
  add_build(program);
  add_extract(program);
  add_view(program);
  add_info(program);
  add_measure(program);
  add_verify(program);
  add_dump(program);
  CLI::App* const help = program.add_subcommand("help", "Explain a command");
  const auto name = std::make_shared<std::string>();
  help->add_option("COMMAND", *name, "the command")->option_text(" ");
  for (CLI::App* command : program.get_subcommands([](const CLI::App*) { return true; }))
    command->group("Commands");
  add_manual(program);
  help->callback([&program, name] { std::cout << help_of(program, *name); });
}

/// What of the arguments nothing was made of: the first one that looks like an option is likely to be at fault for
/// what follows it, too.
std::string explain_extras(const CLI::App& command, const std::vector<std::string>& extras) {
  const auto wrong =
      std::find_if(extras.begin(), extras.end(), [](const std::string& text) { return text.starts_with("--"); });
  if (wrong == extras.end()) return "'" + extras.front() + "' was not expected";
  const std::string given = wrong->substr(0, wrong->find('='));
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames())
      names.push_back("--" + name);
  const std::string meant = closest_name(given, names);
  return "there is no option '" + given + "'" + (meant.empty() ? "" : "; did you mean '" + meant + "'?");
}

/// CLI11's message in our words.
std::string explain(const CLI::ParseError& error, const CLI::App& command) {
  std::string what = error.what();
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr) {
    const std::vector<std::string> extras = command.remaining();
    if (!extras.empty()) return explain_extras(command, extras);
  }
  if (error.get_name() == "ArgumentMismatch") {
    const bool missing = what.ends_with("missing");
    return what.substr(0, what.find(':')) + (missing ? ": its value is missing" : ": given more than once");
  }
  if (what.starts_with("The ")) what.front() = 't';
  return what;
}

/// "--output=" of an empty variable would take the next argument for its value.
void refuse_empty_values(int argc, char** argv) {
  for (int i = 1; i < argc && argv[i] != std::string_view("--"); ++i) {
    const std::string_view argument = argv[i];
    if (argument.starts_with("--") && argument.find('=') == argument.size() - 1)
      throw Error(ErrorCode::kBadArgument,
                  std::string(argument.substr(0, argument.size() - 1)) + ": its value is missing");
  }
}

/// Runs what was asked; says what the user typed wrong.
int run(CLI::App& program, int argc, char** argv) {
  refuse_empty_values(argc, argv);
  if (argc > 1 && argv[1][0] != '-') (void)command_named(program, argv[1]);
  try {
    program.parse(argc, argv);
    if (program.get_subcommands().empty()) {
      std::cerr << help_of(program, {});
      return kExitUsage;
    }
  } catch (const CLI::CallForHelp&) {
    std::cout << program.help();
  } catch (const CLI::CallForVersion& version) {
    std::cout << version.what() << '\n';
  } catch (const CLI::ParseError& error) {
    const auto commands = program.get_subcommands();
    const CLI::App& command = commands.empty() ? program : *commands.front();
    const std::string name = commands.empty() ? "" : " " + command.get_name();
    const std::string what = explain(error, command);
    return fail(kExitUsage, what + (what.ends_with('?') ? " " : "; ") + "'ptet" + name + " --help' explains the usage");
  }
  errno = 0;
  if (!std::cout.flush()) {
    const std::string why = errno == 0 ? "" : std::string(": ") + std::strerror(errno);
    return fail(kExitIo, "cannot write to standard output" + why);
  }
  return kExitOk;
}

} // namespace
} // namespace ptet::cli

int main(int argc, char** argv) {
  using namespace ptet::cli;
  hold_standard_streams();
  catch_interrupts();
  // A reader that has gone, such as head, had what it wanted: end quietly, also when the parent ignores the signal.
  std::signal(SIGPIPE, SIG_DFL);
  // A file that grows beyond its limit is an error of writing like a full disk, not the end of the process.
  std::signal(SIGXFSZ, SIG_IGN);
  std::ios::sync_with_stdio(false);
  const PlainOutput plain(std::cout);
  CLI::App program("", "ptet");
  add_commands(program);
  const auto run_guarded = [&] { return guarded([&] { return run(program, argc, argv); }); };
  // Any other command does in each process of mpirun, srun and the like what it does by itself: they may have work of
  // their own.
  const bool is_together = argc > 1 && argv[1] == std::string_view("build");
  return is_together ? as_a_rank(run_guarded) : run_guarded();
}
