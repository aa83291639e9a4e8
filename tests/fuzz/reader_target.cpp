#include "fuzz/checks.hpp"
#include "fuzz/targets.hpp"

#include <exception>

namespace ptet::fuzz {
namespace {

/// What the codec says of the whole file.
bool decodes(const Bytes& bytes) {
  try {
    file::Reader reader(file::over_memory(bytes), small_limits());
    static_cast<void>(load_all(reader));
    return true;
  } catch (const Error& error) {
    check_refusal(error);
    return false;
  }
}

} // namespace

void run_reader(Input input) {
  const Bytes bytes(input.begin(), input.end());
  const bool is_sound = decodes(bytes);
  try {
    const auto data = Dataset::open_memory(bytes, small_limits());
    const Extraction extraction = data->extract({});
    check_mesh(extraction);
    if (is_sound && (!extraction.complete || extraction.mesh.tets.size() != data->info().tets))
      fail("a sound file does not give all of the original");
    if (!is_sound && extraction.complete) fail("a file that cannot be decoded gives all of the original");
    Request coarsest;
    coarsest.max_tets = 0;
    check_mesh(data->extract(coarsest));
  } catch (const Error& error) {
    check_refusal(error);
  }
}

void mutate_decoded(Bytes& input, std::size_t most_bytes, Mutator& mutator) {
  mutate_file(input, most_bytes, mutator);
}

} // namespace ptet::fuzz
