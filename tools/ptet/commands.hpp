// The commands of the program, one file each. Each function adds its command, with options and help, to the program;
// the command runs when it has been parsed and throws ptet::Error when it cannot do what was asked.
#pragma once

#include <CLI/CLI.hpp>

namespace ptet::cli {

void add_build(CLI::App& program);
void add_extract(CLI::App& program);
void add_info(CLI::App& program);
void add_measure(CLI::App& program);
void add_verify(CLI::App& program);
void add_dump(CLI::App& program);
void add_view(CLI::App& program);
/// Knows the commands that were added before.
void add_manual(CLI::App& program);

} // namespace ptet::cli
