// From a mesh in memory to a cut, with and without a file between.
#include "ptet/build.hpp"
#include "ptet/dataset.hpp"
#include "support/meshes.hpp"
#include "support/temp_folder.hpp"

#include <cstring>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

BuildOptions quick() {
  BuildOptions options;
  options.prediction = Prediction::kQuadric;
  options.evaluation = Evaluation::kVertices;
  options.target_vertices = 0.2;
  return options;
}

std::string text_of(const std::vector<std::byte>& bytes) {
  std::string text(bytes.size(), '\0');
  std::memcpy(text.data(), bytes.data(), bytes.size());
  return text;
}

} // namespace

TEST_CASE("built in memory: the bytes are those of the file") {
  const TetMesh mesh = test::grid({});
  const test::TempFolder folder;
  const BuildReport of_file = build_file(mesh, folder / "mesh.ptet", quick(), "mesh", "hash");
  BuildReport of_memory;
  of_memory.notes = {"of an earlier build"};
  const std::vector<std::byte> bytes = build_memory(mesh, quick(), &of_memory, "mesh", "hash");
  CHECK(text_of(bytes) == test::read_bytes(folder / "mesh.ptet"));
  CHECK(of_memory.file_bytes == bytes.size());
  CHECK(of_memory.file_bytes == of_file.file_bytes);
  CHECK(of_memory.records == of_file.records);
  CHECK(of_memory.base_vertices < of_memory.input_vertices);
  CHECK(of_memory.notes == of_file.notes);
  CHECK(text_of(build_memory(mesh, quick(), nullptr, "other")) != text_of(bytes));
}

TEST_CASE("built in memory: cut without a file") {
  const TetMesh mesh = test::grid({});
  const auto data = Dataset::open_memory(build_memory(mesh, quick()));
  CHECK(data->extract({}).mesh.tets.size() == mesh.tets.size());
  Request request;
  request.max_tets = mesh.tets.size() / 2;
  const Extraction cut = data->extract(request);
  CHECK(cut.mesh.tets.size() <= mesh.tets.size() / 2);
  CHECK(cut.mesh.tets.size() > data->info().base_tets);
}

TEST_CASE("built in memory: cancelled at any stage, and refused") {
  const TetMesh mesh = test::grid({});
  int calls = 0;
  (void)build_memory(mesh, quick(), nullptr, {}, {}, [&](const Progress&) { return ++calls > 0; });
  REQUIRE(calls > 2);
  for (const int last : {1, calls / 2, calls}) {
    int left = last;
    const auto cancel = [&](const Progress&) { return --left > 0; };
    CHECK_THROWS_AS(build_memory(mesh, quick(), nullptr, {}, {}, cancel), Error);
  }
  CHECK_THROWS_AS(build_memory({}), Error);
}
