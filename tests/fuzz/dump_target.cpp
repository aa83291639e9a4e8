#include "formats/ptet/dump.hpp"
#include "fuzz/checks.hpp"
#include "fuzz/memory_file.hpp"
#include "fuzz/targets.hpp"

#include <sstream>

namespace ptet::fuzz {

void run_dump(Input input) {
  const MemoryFile file(input);
  std::ostringstream text;
  try {
    // What the dump would take for a large file is no matter: it is for people, and has no limits of its own.
    file::Reader(file::over_memory({input.begin(), input.end()}), small_limits());
    file::dump(text, file.path(), true);
    file::dump(text, file.path(), false);
  } catch (const Error& error) {
    check_refusal(error);
  }
}

} // namespace ptet::fuzz
