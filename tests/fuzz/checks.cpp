#include "fuzz/checks.hpp"

#include "fuzz/targets.hpp"
#include "support/mesh_checks.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

namespace ptet::fuzz {

void fail(const std::string& what) {
  std::fprintf(stderr, "broken promise: %s\n", what.c_str());
  std::abort();
}

OpenOptions small_limits() {
  OpenOptions options;
  options.limits = {std::uint64_t{48} << 20, 1 << 20, 1 << 20};
  return options;
}

void check_refusal(const Error& error) {
  if (error.code() == ErrorCode::kLimit) return;
  if (error.code() != ErrorCode::kCorruptFile) fail(std::string("another error than that of a file: ") + error.what());
  if (!error.byte_offset()) fail(std::string("an error without a place: ") + error.what());
}

void check_mesh(const Extraction& extraction) {
  const TetMesh& mesh = extraction.mesh;
  const std::size_t vertices = mesh.vertex_count();
  if (extraction.vertex_in_file.size() != vertices) fail("not every vertex has an id");
  for (const PointArray& array : mesh.point_arrays)
    if (array.size() != vertices) fail("an array has not a row for each vertex");
  std::vector<test::Face> faces, boundary;
  faces.reserve(4 * mesh.tets.size());
  for (const Tet& tet : mesh.tets) {
    for (std::size_t i = 0; i < 4; ++i) {
      if (tet[i].index() >= vertices) fail("a tet has a vertex that is not there");
      test::Face face = {tet[(i + 1) % 4], tet[(i + 2) % 4], tet[(i + 3) % 4]};
      std::sort(face.begin(), face.end());
      if (face[0] == face[1] || face[1] == face[2]) fail("a tet has a vertex twice");
      faces.push_back(face);
    }
  }
  std::sort(faces.begin(), faces.end());
  for (std::size_t i = 0; i < faces.size();) {
    std::size_t next = i + 1;
    while (next < faces.size() && faces[next] == faces[i])
      ++next;
    if (next - i > 2) fail("a face has more than two tets");
    if (next - i == 1) boundary.push_back(faces[i]);
    i = next;
  }
  std::vector<test::Face> told(extraction.boundary_faces.begin(), extraction.boundary_faces.end());
  for (test::Face& face : told)
    std::sort(face.begin(), face.end());
  std::sort(told.begin(), told.end());
  if (told != boundary) fail("the boundary faces are not those of one tet");
}

file::Content load_all(file::Reader& reader) {
  file::Content content = reader.read_base();
  std::vector<std::uint32_t> every(reader.blocks().size());
  for (std::uint32_t b = 0; b < every.size(); ++b)
    every[b] = b;
  reader.load(every, content);
  if (std::string broken = content.refinement.validate(); !broken.empty()) fail(broken);
  return content;
}

} // namespace ptet::fuzz
