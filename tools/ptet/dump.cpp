// ptet dump: what stands where in a .ptet file.
#include "formats/ptet/dump.hpp"

#include "commands.hpp"
#include "console.hpp"
#include "files.hpp"

#include <iostream>
#include <memory>

namespace ptet::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  ptet dump fire.ptet
  ptet dump small.ptet --annotate

The specification, with the dump of a small file as its worked example, is formats/ptet/PTET.md.
)";

struct Arguments {
  std::string input;
  bool annotate = false;
};

} // namespace

void add_dump(CLI::App& program) {
  CLI::App* const command = program.add_subcommand("dump", "Show the parts of a .ptet file");
  const auto arguments = std::make_shared<Arguments>();
  command->add_option("FILE", arguments->input, "the .ptet file")->required()->option_text(" ");
  command->add_flag("--annotate", arguments->annotate, "every byte, with what it means");
  command->footer(kExamples);
  command->callback([arguments] {
    let_interrupts_end();
    about_file(arguments->input, [&] { file::dump(std::cout, arguments->input, arguments->annotate); });
  });
}

} // namespace ptet::cli
