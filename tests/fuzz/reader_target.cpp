#include "fuzz/checks.hpp"
#include "fuzz/targets.hpp"

#include <algorithm>
#include <exception>
#include <functional>

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

/// Whoever asks for the order of the input gets it, or is told; what is in it is anything.
void check_input_order(const Dataset& data, Request request) {
  request.input_order = true;
  try {
    const Extraction ordered = data.extract(request);
    const std::vector<std::uint32_t>& ids = ordered.input_vertex;
    if (ids.size() != ordered.mesh.vertex_count() || ids.size() != ordered.vertex_in_file.size())
      fail("the order of the input has another number of vertices");
    if (!std::is_sorted(ids.begin(), ids.end(), std::less_equal<>()) ||
        (!ids.empty() && ids.back() >= data.info().vertices))
      fail("the order of the input is none");
    request.input_order = false;
    if (data.extract(request).mesh.tets.size() != ordered.mesh.tets.size())
      fail("the order of the input has another number of tets");
    for (const Tet& tet : ordered.mesh.tets)
      for (const VertexId v : tet)
        if (v.index() >= ids.size()) fail("a corner in the order of the input is no vertex");
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kBadArgument && !data.info().has_input_order) return;
    check_refusal(error);
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
    check_input_order(*data, {});
    check_input_order(*data, coarsest);
  } catch (const Error& error) {
    check_refusal(error);
  }
}

void mutate_decoded(Bytes& input, std::size_t most_bytes, Mutator& mutator) {
  mutate_file(input, most_bytes, mutator);
}

} // namespace ptet::fuzz
