// What `ptet build` says of a build.
#pragma once

#include "formats/vtk/read.hpp"
#include "ptet/build.hpp"
#include "ptet/dataset.hpp"

#include <cstdint>
#include <string>

namespace ptet::cli {

/// Everything there is to say after a build.
struct BuildOutcome {
  std::string input, output;
  BuildOptions options;
  std::uint64_t input_bytes = 0;
  ReadReport read;
  BuildReport build;
  DatasetInfo info;
};

void print_json(const BuildOutcome& outcome);
void print_text(const BuildOutcome& outcome);

} // namespace ptet::cli
