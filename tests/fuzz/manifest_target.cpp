#include "formats/ptet/layout.hpp"
#include "fuzz/checks.hpp"
#include "fuzz/targets.hpp"
#include "lod/provenance.hpp"

namespace ptet::fuzz {

void run_manifest(Input input) {
  file::ByteReader in(input, "manifest", 0);
  file::Manifest manifest;
  try {
    manifest = file::parse_manifest(in);
  } catch (const Error& error) {
    check_refusal(error);
    return;
  }
  if (to_json(manifest).size() < 2) fail("a manifest without JSON");
  file::ByteWriter out;
  file::put_manifest(out, manifest);
  file::ByteReader again(out.bytes(), "manifest", 0);
  if (!(file::parse_manifest(again) == manifest)) fail("a manifest is another one when it was written and read");
}

std::vector<Bytes> manifest_seeds() {
  std::vector<Bytes> seeds;
  for (const file::Manifest& manifest : {file::Manifest{}, file::Manifest{"0.1.0",
                                                                          "wing.vtu",
                                                                          "xxh64:0123456789abcdef",
                                                                          {{"field", "p"}, {"rho", ".02"}},
                                                                          {"2 unused points", "\x01\"\\\xFF"}}}) {
    file::ByteWriter out;
    file::put_manifest(out, manifest);
    seeds.push_back(out.take());
  }
  return seeds;
}

} // namespace ptet::fuzz
