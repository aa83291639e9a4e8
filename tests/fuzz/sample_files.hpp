// Small .ptet files to begin with, of every kind that the writer can make: the golden ones are of the version they are
// of, these of the writer as it is now.
#pragma once

#include "fuzz/mutate_file.hpp"

namespace ptet::fuzz {

/// From 800 bytes up; the same in every run.
[[nodiscard]] const std::vector<Bytes>& sample_files();

} // namespace ptet::fuzz
