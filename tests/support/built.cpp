#include "support/built.hpp"

#include "support/topology_checks.hpp"

#include <algorithm>
#include <random>
#include <set>

#include <catch2/catch.hpp>

namespace ptet::test {
namespace {

TetMesh with_tets(const Built& built, const CutMesh& cut) {
  TetMesh mesh;
  mesh.positions = built.prepared.mesh.positions;
  mesh.tets = cut.tets;
  return mesh;
}

/// A grid with a random shape and random, rough fields.
TetMesh random_grid(unsigned seed) {
  std::mt19937 random(seed);
  const auto side = [&] { return 3 + static_cast<int>(random() % 4); };
  const std::array<int, 3> cells = {side(), side(), side()};
  std::vector<char> is_cut(static_cast<std::size_t>(cells[0] * cells[1] * cells[2]), 0);
  for (char& cut : is_cut)
    cut = random() % 12 == 0 ? 1 : 0;
  TetMesh mesh = grid(
      {cells,
       [&](int x, int y, int z) { return is_cut[static_cast<std::size_t>((z * cells[1] + y) * cells[0] + x)] == 0; }, 3,
       seed});
  add_array(mesh, "noise", ScalarType::kFloat64, 1,
            [&](const Point&) { return std::vector<double>{static_cast<double>(random() % 1000)}; });
  add_array(mesh, "constant", ScalarType::kFloat32, 2, [](const Point&) { return std::vector<double>{7, -3}; });
  return mesh;
}

} // namespace

Built build_all(PreparedMesh prepared, const BuildOptions& options) {
  Built built{std::move(prepared), {}, {}};
  built.stream = build::build_records(built.prepared, options, built.report, {});
  return built;
}

Built build_all(const TetMesh& mesh, const BuildOptions& options) {
  return build_all(prepare(mesh), options);
}

BuildOptions to_the_end() {
  BuildOptions options;
  options.target_vertices = 0;
  options.max_domain_error = {1, true};
  return options;
}

std::vector<NamedMesh> meshes_to_build() {
  std::vector<NamedMesh> meshes = sample_meshes(21);
  for (unsigned seed = 1; seed <= 4; ++seed)
    meshes.push_back({"random grid " + std::to_string(seed), random_grid(seed)});
  return meshes;
}

CutMesh mesh_after(const Built& built, std::size_t count) {
  return cut_mesh(built.stream, after_collapses(built.stream, count));
}

std::size_t vertices_left(const Built& built) {
  return built.prepared.used_vertex_count - built.stream.size();
}

const PointArray& field_array(const Built& built, std::size_t f) {
  return built.prepared.mesh.point_arrays[built.stream.fields[f].array];
}

std::vector<Face> faces_of(const std::vector<Tet>& ghosts) {
  std::vector<Face> faces;
  for (const Tet& ghost : ghosts) {
    const Tet sorted = sorted_keeping_orientation(ghost); // the dummy has the largest id, but for the swap
    Face face =
        sorted[3] == kDummyVertex ? Face{sorted[0], sorted[1], sorted[2]} : Face{sorted[0], sorted[3], sorted[1]};
    faces.push_back(turned(face));
  }
  std::sort(faces.begin(), faces.end());
  return faces;
}

void check_sound(const Built& built, const CutMesh& cut, const MeshFacts& original) {
  const MeshFacts facts = examine(with_tets(built, cut));
  CHECK(facts.inverted_tets == original.inverted_tets);
  check_same_topology(facts, original);
  CHECK(facts.boundary == faces_of(cut.ghosts));
}

void check_rounds(const RecordStream& stream) {
  std::vector<std::uint32_t> made_in(stream.slot_count(), 0); // by slot
  std::size_t touched = 0;
  for (std::size_t i = 0; i < stream.size(); ++i) {
    REQUIRE(stream.round[i] > 0);
    for (const std::uint32_t slot : stream.star(i))
      touched += made_in[slot] == stream.round[i] ? 1 : 0;
    for (const std::uint32_t slot : stream.modified(i))
      made_in[slot] = stream.round[i];
  }
  CHECK(touched == 0);
}

bool same_collapses(const RecordStream& a, const RecordStream& b) {
  return same_bytes(a.slots, b.slots) && same_bytes(a.removed, b.removed) && same_bytes(a.target, b.target) &&
         same_bytes(a.round, b.round) && same_bytes(a.star_begin, b.star_begin) && same_bytes(a.stars, b.stars) &&
         same_bytes(a.modified_count, b.modified_count);
}

void scale(PointArray& array, double factor) {
  for (std::size_t i = 0; i < array.size() * array.components; ++i) {
    const double value = array.value(i / array.components, static_cast<std::uint32_t>(i % array.components)) * factor;
    if (array.type == ScalarType::kFloat32) {
      const auto narrow = static_cast<float>(value);
      std::memcpy(array.bytes.data() + i * sizeof narrow, &narrow, sizeof narrow);
    } else if (array.type == ScalarType::kFloat64) {
      std::memcpy(array.bytes.data() + i * sizeof value, &value, sizeof value);
    }
  }
}

} // namespace ptet::test
