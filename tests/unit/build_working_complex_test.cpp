// The working complex against sets of sets.
#include "build_fixture.hpp"
#include "support/meshes.hpp"

#include <algorithm>
#include <map>
#include <random>

#include <catch2/catch.hpp>

using namespace ptet;
using namespace ptet::build;
using build::test::Fixture;

namespace {

using Cells = std::set<std::set<Vertex>>;

/// Collapses without a check: what holds vs and vd goes, in the rest vd stands for vs.
Cells collapsed(const Cells& cells, Vertex vs, Vertex vd) {
  Cells result;
  for (std::set<Vertex> cell : cells) {
    if (cell.erase(vs) != 0 && !cell.insert(vd).second) continue;
    result.insert(cell);
  }
  return result;
}

void check_stars(const WorkingComplex& complex, const Cells& expected) {
  REQUIRE(complex.validate() == "");
  for (Vertex v = 0; v < complex.vertex_count(); ++v) {
    Cells star;
    for (const SlotId s : complex.star(v))
      star.emplace(complex.slot(s).v.begin(), complex.slot(s).v.end());
    CHECK(star.size() == complex.star(v).size());
    Cells wanted;
    for (const auto& cell : expected)
      if (cell.count(v) != 0) wanted.insert(cell);
    CHECK(star == wanted);
    CHECK(complex.alive(v) == !wanted.empty());
  }
}

Fixture fixture(const TetMesh& mesh) {
  std::vector<Point> points;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
    points.push_back(mesh.position(VertexId{v}));
  std::vector<std::array<Vertex, 4>> tets;
  for (const Tet& tet : mesh.tets)
    tets.push_back({tet[0].index(), tet[1].index(), tet[2].index(), tet[3].index()});
  return {points, tets};
}

} // namespace

TEST_CASE("working complex: tets first, then ghosts that are oriented like them", "[build][complex]") {
  const Fixture f = fixture(ptet::test::single_tet());
  const WorkingComplex& c = f.complex;
  REQUIRE(c.slot_count() == 5);
  CHECK(c.dummy() == 4);
  CHECK_FALSE(c.is_ghost(c.slot(0)));
  CHECK(f.cells() == Cells{{0, 1, 2, 3}, {0, 1, 2, 4}, {0, 1, 3, 4}, {0, 2, 3, 4}, {1, 2, 3, 4}});
  for (SlotId s = 1; s < 5; ++s) {
    REQUIRE(c.is_ghost(c.slot(s)));
    CHECK(c.slot(s).v[3] == c.dummy());
    // The fourth corner of the tet lies on the inner side of the outward face.
    const auto& v = c.slot(s).v;
    const Vertex opposite = 0 + 1 + 2 + 3 - v[0] - v[1] - v[2];
    CHECK(orientation(f.points[v[0]], f.points[v[1]], f.points[v[2]], f.points[opposite]) < 0);
  }
  CHECK(c.validate() == "");
}

TEST_CASE("working complex: a collapse of six_cycle", "[build][complex]") {
  Fixture f = fixture(ptet::test::six_cycle());
  CollapseCheck check(f.complex, f.points, 0, 64);
  REQUIRE(check.examine(3, 2) == CollapseStatus::kAccepted);
  const std::vector<SlotId> deleted(check.deleted().begin(), check.deleted().end());
  const std::vector<SlotId> modified(check.modified().begin(), check.modified().end());
  CHECK(deleted.size() == 3);  // the tet 2 3 and its two boundary faces
  CHECK(modified.size() == 3); // the tet 3 4 and its two boundary faces
  const std::vector<std::array<Vertex, 4>> before = {f.complex.slot(modified[0]).v, f.complex.slot(modified[1]).v,
                                                     f.complex.slot(modified[2]).v};
  const Cells expected = collapsed(f.cells(), 3, 2);
  f.complex.collapse(3, 2, deleted, modified);
  check_stars(f.complex, expected);
  CHECK_FALSE(f.complex.alive(3));
  // A modified tet keeps its slot and the places of its other corners.
  for (std::size_t m = 0; m < 3; ++m) {
    std::array<Vertex, 4> wanted = before[m];
    std::replace(wanted.begin(), wanted.end(), 3U, 2U);
    CHECK(f.complex.slot(modified[m]).v == wanted);
  }
}

TEST_CASE("working complex: stars stay exact to the last collapse", "[build][complex]") {
  for (const unsigned seed : {1U, 2U, 3U}) {
    Fixture f = fixture(ptet::test::grid({{3, 3, 3}, [](int x, int y, int) { return x != 1 || y != 1; }, 2, seed}));
    CollapseCheck check(f.complex, f.points, 0, 64);
    std::mt19937 random(seed);
    Cells cells = f.cells();
    int collapses = 0;
    for (int tries = 0; tries < 4000; ++tries) {
      const Vertex vs = random() % f.complex.vertex_count();
      if (!f.complex.alive(vs)) continue;
      const auto star = f.complex.star(vs);
      const Vertex vd = f.complex.slot(star[random() % star.size()]).v[random() % 4];
      if (vd == vs || vd == f.complex.dummy() || check.examine(vs, vd) != CollapseStatus::kAccepted) continue;
      cells = collapsed(cells, vs, vd);
      f.complex.collapse(vs, vd, check.deleted(), check.modified());
      check_stars(f.complex, cells);
      ++collapses;
    }
    CHECK(collapses > 30);
  }
}

TEST_CASE("working complex: validate tells a wrong corner", "[build][complex]") {
  Fixture f = fixture(ptet::test::two_tets_sharing_a_face());
  REQUIRE(f.complex.validate() == "");
  const std::array<Vertex, 4> good = f.complex.slot(0).v;
  *std::find(f.complex.slot(0).v.begin(), f.complex.slot(0).v.end(), 0U) = 4;
  CHECK(f.complex.validate() != "");
  f.complex.slot(0).v = good;
  f.complex.slot(0).v[0] = f.complex.slot(0).v[1];
  CHECK(f.complex.validate() != "");
  f.complex.slot(0).v = good;
  CHECK(f.complex.validate() == "");
}
