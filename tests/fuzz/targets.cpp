#include "fuzz/targets.hpp"

#include "fuzz/sample_files.hpp"

#include <algorithm>

namespace ptet::fuzz {
namespace {

std::vector<Bytes> file_seeds() {
  return sample_files();
}

constexpr Target kTargets[] = {
    {"reader", run_reader, file_seeds},
    {"decoded", run_reader, file_seeds, mutate_decoded},
    {"manifest", run_manifest, manifest_seeds},
    {"block", run_block, block_seeds},
    {"cut", run_cut, cut_seeds, mutate_cut},
    {"differential", run_differential, cut_seeds, mutate_cut},
    {"dump", run_dump, file_seeds, mutate_decoded},
#ifdef PTET_FUZZ_IMPORT
    {"import", run_import, import_seeds},
#endif
};

} // namespace

std::span<const Target> targets() {
  return kTargets;
}

const Target* find_target(std::string_view name) {
  const auto* const found =
      std::find_if(std::begin(kTargets), std::end(kTargets), [&](const Target& t) { return t.name == name; });
  return found == std::end(kTargets) ? nullptr : found;
}

} // namespace ptet::fuzz
