// The worked example of formats/ptet/PTET.md: two tetrahedra and one collapse. Its bytes and their explanation are
// compared with what the writer and the dump make today, so that document and code cannot disagree.
//
// After a change that is meant, run the test with PTET_UPDATE_GOLDEN=1 in the environment and look at the difference.
#include "formats/ptet/dump.hpp"
#include "formats/ptet/reader.hpp"
#include "formats/ptet/writer.hpp"
#include "support/meshes.hpp"
#include "support/naive_simplifier.hpp"

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>

#include <catch2/catch.hpp>

using namespace ptet;
using namespace ptet::test;

namespace {

const std::string kExample = PTET_SOURCE_DIR "/formats/ptet/example";

std::string contents(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

std::string make_example() {
  TetMesh mesh = make_mesh({{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {1, 1, 3}, {1, 1, -2}}, {{0, 1, 2, 3}, {0, 2, 1, 4}});
  add_array(mesh, "pressure", ScalarType::kFloat32, 1, [](const Point& at) { return std::vector<double>{1 + at[2]}; });
  NaiveOptions options;
  options.target_vertices = 4;
  RecordStream records = simplify_naively(mesh, options);
  REQUIRE(records.size() == 1);
  // The field is linear: wherever the domain is still covered the mesh has it exactly. One of the two tets is gone.
  records.volume = 40.0 / 3;
  records.squared_error = {0};
  records.uncovered_volume = {records.removed.front().index() == 4 ? 16.0 / 3 : 8};
  const auto bytes = file::encode(mesh, records, {"0.1.0", "example.vtu", "", {{"field", "pressure"}}, {}});
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void compare(const std::string& path, const std::string& made) {
  if (std::getenv("PTET_UPDATE_GOLDEN") != nullptr) std::ofstream(path, std::ios::binary) << made;
  INFO("the golden file is " << path);
  CHECK(contents(path) == made);
}

} // namespace

TEST_CASE("the worked example is what the writer makes") {
  compare(kExample + ".ptet", make_example());
}

TEST_CASE("the annotation of the worked example is what the dump says") {
  std::ostringstream text;
  file::dump(text, kExample + ".ptet", true);
  compare(kExample + ".txt", text.str());
}

TEST_CASE("the worked example is read") {
  file::Reader reader(file::open_file(kExample + ".ptet"));
  CHECK(reader.header().record_count == 1);
  file::Content content = reader.read_base();
  CHECK(content.refinement.base_tet_count() == 1);
  reader.load(std::array<std::uint32_t, 1>{0}, content);
  CHECK(content.refinement.added_tet_count(RecordId{0}) == 1);
  CHECK(content.refinement.validate().empty());
}

TEST_CASE("the short dump names what is in a file") {
  std::ostringstream text;
  file::dump(text, kExample + ".ptet", false);
  CHECK(text.str().find("array           pressure: float32 x 1, governing, range 5") != std::string::npos);
  CHECK(text.str().find("example.vtu") != std::string::npos);
}
