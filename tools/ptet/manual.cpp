// ptet manual: man pages and shell completion out of the program's own options, so that they say what it does. Not
// shown in the help; tools/manual/ has what it writes.
#include "commands.hpp"
#include "console.hpp"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <memory>
#include <sstream>
#include <utility>
#include <vector>

namespace ptet::cli {
namespace {

/// Text as roff takes it literally.
std::string roff(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else if (c == '\'' || c == '.')
      out += "\\&" + std::string(1, c);
    else
      out += c == '\n' ? ' ' : c;
  }
  return out;
}

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

std::vector<const CLI::App*> commands_of(const CLI::App& program) {
  return program.get_subcommands([](const CLI::App* command) { return !command->get_group().empty(); });
}

/// The options with a name; but for the help's, in the order of the help.
std::vector<const CLI::Option*> named_options(const CLI::App& app) {
  return app.get_options([](const CLI::Option* option) { return !option->get_positional(); });
}

std::string value_of(const CLI::Option& option) {
  if (option.get_expected_max() == 0) return "";
  return option.get_option_text().empty() ? " " + option.get_type_name() : " " + option.get_option_text();
}

/// A footer: a word and a colon alone head a section, indented lines are kept as they are, the rest is filled and has a
/// section of its own after such a heading.
void put_footer(std::ostream& out, const std::string& footer) {
  std::istringstream lines(footer);
  bool is_kept = false, is_in_text = false;
  for (std::string line; std::getline(lines, line);) {
    const bool is_heading = line.size() > 1 && line.back() == ':' && line.find(' ') == std::string::npos;
    const bool is_indented = line.starts_with("  ");
    if (is_kept && !is_indented) out << ".EE\n.RE\n";
    if (is_indented && !is_kept) out << ".RS 2\n.EX\n";
    is_kept = is_indented;
    if (is_heading) {
      out << ".SH " << upper(line.substr(0, line.size() - 1)) << '\n';
      is_in_text = false;
    } else if (line.empty()) {
      out << ".PP\n";
    } else if (is_indented) {
      out << roff(line.substr(2)) << '\n';
    } else {
      if (!std::exchange(is_in_text, true)) out << ".SH NOTES\n";
      out << roff(line) << '\n';
    }
  }
  if (is_kept) out << ".EE\n.RE\n";
}

void put_page(std::ostream& out, const CLI::App& app, const std::string& name, const CLI::App* program) {
  std::string words = name;
  std::replace(words.begin(), words.end(), '-', ' ');
  const std::string description = app.get_description();
  out << ".\\\" Written by ptet manual; change the program's options instead.\n.TH " << upper(roff(name))
      << " 1 \"\" \"ptet " PTET_VERSION "\" \"ptet\"\n.SH NAME\n"
      << roff(name) << " \\- " << roff(description) << "\n.SH SYNOPSIS\n.B " << words << '\n';
  if (program == nullptr) out << ".I COMMAND\n";
  out << "[\\fIOPTION\\fR]...\n";
  for (const CLI::Option* option : app.get_options([](const CLI::Option* o) { return o->get_positional(); })) {
    const bool is_optional = !option->get_required();
    out << (is_optional ? "[" : "") << "\\fI" << option->get_name() << "\\fR" << (is_optional ? "]" : "") << '\n';
  }
  if (program == nullptr) {
    out << ".SH COMMANDS\n";
    for (const CLI::App* command : commands_of(app))
      out << ".TP\n.B " << command->get_name() << '\n' << roff(command->get_description()) << ".\n";
  }
  out << ".SH OPTIONS\n";
  for (const CLI::Option* option : named_options(app)) {
    out << ".TP\n.B " << roff(option->get_name(false, true)) << roff(value_of(*option)) << '\n'
        << roff(option->get_description()) << '\n';
  }
  put_footer(out, app.get_footer());
  out << ".SH SEE ALSO\n";
  if (program != nullptr) {
    out << ".BR ptet (1)\n";
    return;
  }
  std::string separator;
  for (const CLI::App* command : commands_of(app)) {
    if (command->get_name() == "help") continue;
    out << separator << ".BR ptet\\-" << command->get_name() << " (1)";
    separator = ",\n";
  }
  out << '\n';
}

/// Every way to write the options, with spaces between.
std::string completions(const CLI::App& app) {
  std::string words;
  for (const CLI::Option* option : named_options(app)) {
    for (const std::string& name : option->get_lnames())
      words += (words.empty() ? "--" : " --") + name;
    for (const std::string& name : option->get_snames())
      words += (words.empty() ? "-" : " -") + name;
  }
  return words;
}

void put_completion(std::ostream& out, const CLI::App& program) {
  std::string names;
  for (const CLI::App* command : commands_of(program))
    names += (names.empty() ? "" : " ") + command->get_name();
  out << "# Completion of ptet for bash, written by ptet manual.\n"
         "_ptet() {\n"
         "  local current=${COMP_WORDS[COMP_CWORD]} words=\n"
         "  if [[ $COMP_CWORD -eq 1 || ${COMP_WORDS[1]} == help ]]; then\n"
         "    words=\""
      << names << ' ' << completions(program)
      << "\"\n"
         "  else\n"
         "    case ${COMP_WORDS[1]} in\n";
  for (const CLI::App* command : commands_of(program))
    out << "      " << command->get_name() << ") words=\"" << completions(*command) << "\" ;;\n";
  out << "    esac\n"
         "    [[ $current == -* ]] || words= # then it is a file, or a value\n"
         "  fi\n"
         "  mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$current\")\n"
         "}\n"
         "complete -o default -F _ptet ptet\n";
}

template <class Put>
void write(const std::string& path, Put&& put) {
  std::ofstream file(path, std::ios::binary);
  put(file);
  if (!file.flush()) throw Error(ErrorCode::kIo, "cannot write '" + path + "'");
}

void run(const CLI::App& program, const std::string& folder) {
  write(folder + "/ptet.1", [&](std::ostream& out) { put_page(out, program, "ptet", nullptr); });
  for (const CLI::App* command : commands_of(program)) {
    if (command->get_name() == "help") continue;
    const std::string name = "ptet-" + command->get_name();
    write(folder + "/" + name + ".1", [&](std::ostream& out) { put_page(out, *command, name, &program); });
  }
  write(folder + "/ptet.bash", [&](std::ostream& out) { put_completion(out, program); });
}

} // namespace

void add_manual(CLI::App& program) {
  CLI::App* const command = program.add_subcommand("manual", "Write man pages and shell completion");
  const auto folder = std::make_shared<std::string>();
  command->add_option("FOLDER", *folder, "where to")->required()->option_text(" ");
  command->group("");
  command->callback([&program, folder] { run(program, *folder); });
}

} // namespace ptet::cli
