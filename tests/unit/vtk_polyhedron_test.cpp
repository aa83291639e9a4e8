// Polyhedra, in both layouts that VTK has for them.
#include "formats/vtk/read.hpp"
#include "support/mesh_checks.hpp"
#include "vtk_fixture.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <sstream>

#include <catch2/catch.hpp>

using namespace ptet;
using namespace ptet::test;

namespace {

constexpr int kHexahedron = 12, kPolyhedron = 42;

using Corners = std::vector<std::int64_t>;
struct Cell {
  int type = kPolyhedron;
  Corners points;             ///< of a hexahedron
  std::vector<Corners> faces; ///< of a polyhedron
};
struct Cells {
  std::vector<Point> points;
  std::vector<Cell> cells;
};

enum class Layout { kStream, kTables };

template <class T>
std::string array_of(const std::string& type, const std::string& name, const std::vector<T>& values,
                     const std::string& more = {}) {
  std::ostringstream text;
  text.precision(17);
  text << "<DataArray type=\"" << type << "\" Name=\"" << name << "\" " << more << " format=\"ascii\">";
  for (const T& value : values)
    text << value << ' ';
  text << "</DataArray>\n";
  return text.str();
}

std::string vtu_text(const Cells& mesh, Layout layout, const std::string& point_data = {},
                     const std::string& point_type = "Float64") {
  Corners connectivity, offsets, types, stream, stream_ends, corners, corner_ends, faces_of_cells, faces_of_cell_ends;
  for (const Cell& cell : mesh.cells) {
    std::set<std::int64_t> points(cell.points.begin(), cell.points.end());
    for (const Corners& face : cell.faces)
      points.insert(face.begin(), face.end());
    if (cell.type == kPolyhedron)
      connectivity.insert(connectivity.end(), points.begin(), points.end());
    else
      connectivity.insert(connectivity.end(), cell.points.begin(), cell.points.end());
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
    types.push_back(cell.type);
    if (cell.type == kPolyhedron) stream.push_back(static_cast<std::int64_t>(cell.faces.size()));
    for (const Corners& face : cell.faces) {
      stream.push_back(static_cast<std::int64_t>(face.size()));
      stream.insert(stream.end(), face.begin(), face.end());
      corners.insert(corners.end(), face.begin(), face.end());
      faces_of_cells.push_back(static_cast<std::int64_t>(corner_ends.size()));
      corner_ends.push_back(static_cast<std::int64_t>(corners.size()));
    }
    stream_ends.push_back(cell.type == kPolyhedron ? static_cast<std::int64_t>(stream.size()) : -1);
    faces_of_cell_ends.push_back(static_cast<std::int64_t>(faces_of_cells.size()));
  }
  std::vector<double> coordinates;
  for (const Point& p : mesh.points)
    coordinates.insert(coordinates.end(), p.begin(), p.end());
  return "<VTKFile type=\"UnstructuredGrid\" version=\"2.2\" byte_order=\"LittleEndian\" header_type=\"UInt64\">"
         "<UnstructuredGrid><Piece NumberOfPoints=\"" +
         std::to_string(mesh.points.size()) + "\" NumberOfCells=\"" + std::to_string(mesh.cells.size()) +
         "\"><PointData>" + point_data + "</PointData><Points>" +
         array_of(point_type, "Points", coordinates, "NumberOfComponents=\"3\"") + "</Points><Cells>" +
         array_of("Int64", "connectivity", connectivity) + array_of("Int64", "offsets", offsets) +
         array_of("UInt8", "types", types) +
         (layout == Layout::kStream
              ? array_of("Int64", "faces", stream) + array_of("Int64", "faceoffsets", stream_ends)
              : array_of("Int64", "face_connectivity", corners) + array_of("Int64", "face_offsets", corner_ends) +
                    array_of("Int64", "polyhedron_to_faces", faces_of_cells) +
                    array_of("Int64", "polyhedron_offsets", faces_of_cell_ends)) +
         "</Cells></Piece></UnstructuredGrid></VTKFile>\n";
}

/// A box of n^3 cells, two units wide; those near one corner are split into eight. Cells beside these have more faces
/// than six, and points on their edges. Others are hexahedra, half of them.
Cells refined_box(int n, unsigned seed) {
  std::mt19937 random(seed);
  using Place = std::array<int, 3>;
  const auto is_fine = [n](int i, int j, int k) {
    return i >= 0 && j >= 0 && k >= 0 && i < n && j < n && k < n && i + j + k < n;
  };
  struct Box {
    Place at;
    int width;
  };
  std::vector<Box> boxes;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k) {
        if (!is_fine(i, j, k)) boxes.push_back({{2 * i, 2 * j, 2 * k}, 2});
        for (int part = 0; is_fine(i, j, k) && part < 8; ++part)
          boxes.push_back({{2 * i + part % 2, 2 * j + part / 2 % 2, 2 * k + part / 4}, 1});
      }
  std::set<Place> places;
  for (const Box& box : boxes)
    for (int corner = 0; corner < 8; ++corner)
      places.insert({box.at[0] + corner % 2 * box.width, box.at[1] + corner / 2 % 2 * box.width,
                     box.at[2] + corner / 4 * box.width});
  std::vector<Place> shuffled(places.begin(), places.end());
  std::shuffle(shuffled.begin(), shuffled.end(), random);
  Cells made;
  std::map<Place, std::int64_t> ids;
  for (const Place& place : shuffled) {
    ids[place] = static_cast<std::int64_t>(made.points.size());
    made.points.push_back({place[0] * 1.0, place[1] * 1.0, place[2] * 1.0});
  }

  for (const Box& box : boxes) {
    Cell cell;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (const int side : {0, 1}) {
        const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
        Place beyond = {box.at[0] / 2, box.at[1] / 2, box.at[2] / 2};
        beyond[axis] += side == 1 ? 1 : -1;
        const bool is_split = box.width == 2 && is_fine(beyond[0], beyond[1], beyond[2]);
        const int width = is_split ? 1 : box.width;
        for (int part = 0; part < (is_split ? 4 : 1); ++part) {
          Place first = box.at;
          first[axis] += side * box.width;
          first[u] += part % 2;
          first[v] += part / 2;
          std::array<Place, 4> square = {first, first, first, first};
          square[1][u] += width;
          square[2][u] += width;
          square[2][v] += width;
          square[3][v] += width;
          Corners face;
          for (std::size_t i = 0; i < 4; ++i) {
            const Place &from = square[i], &to = square[(i + 1) % 4];
            face.push_back(ids.at(from));
            const Place middle = {(from[0] + to[0]) / 2, (from[1] + to[1]) / 2, (from[2] + to[2]) / 2};
            if (width == 2 && places.contains(middle)) face.push_back(ids.at(middle));
          }
          if (random() % 2 == 0) std::reverse(face.begin(), face.end()); // either way round
          std::rotate(face.begin(), face.begin() + static_cast<std::ptrdiff_t>(random() % face.size()), face.end());
          cell.faces.push_back(face);
        }
      }
    }
    const bool is_plain = cell.faces.size() == 6 && std::all_of(cell.faces.begin(), cell.faces.end(),
                                                                [](const Corners& face) { return face.size() == 4; });
    if (is_plain && random() % 2 == 0) {
      cell = {kHexahedron, {}, {}};
      for (const Place& corner :
           {Place{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}})
        cell.points.push_back(ids.at(
            {box.at[0] + corner[0] * box.width, box.at[1] + corner[1] * box.width, box.at[2] + corner[2] * box.width}));
    }
    made.cells.push_back(cell);
  }
  return made;
}

/// Over a polygon in the plane z = 0, one unit high.
Cells prism_over(const std::vector<std::array<double, 2>>& polygon) {
  Cells made;
  const auto n = static_cast<std::int64_t>(polygon.size());
  for (const double z : {0.0, 1.0})
    for (const auto& [x, y] : polygon)
      made.points.push_back({x, y, z});
  Cell cell;
  Corners low(polygon.size()), high(polygon.size());
  std::iota(low.rbegin(), low.rend(), 0);
  std::iota(high.begin(), high.end(), n);
  cell.faces = {low, high};
  for (std::int64_t i = 0; i < n; ++i)
    cell.faces.push_back({i, (i + 1) % n, n + (i + 1) % n, n + i});
  made.cells.push_back(cell);
  return made;
}

const std::vector<std::array<double, 2>> kSquare = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};

/// In VTK's older layout, which a test may want wrong.
std::string vtu_of_faces(const std::string& faces, const std::string& faceoffsets) {
  VtuText text;
  text.types = "42";
  std::string made = text.file();
  made.insert(made.find("</Cells>"),
              "<DataArray type=\"Int64\" Name=\"faces\" format=\"ascii\">" + faces +
                  "</DataArray><DataArray type=\"Int64\" Name=\"faceoffsets\" format=\"ascii\">" + faceoffsets +
                  "</DataArray>");
  return made;
}

std::string vtu_of_tables(const std::string& corners, const std::string& corner_ends, const std::string& faces,
                          const std::string& face_ends) {
  VtuText text;
  text.types = "42";
  std::string made = text.file();
  std::string arrays;
  for (const auto& [name, values] :
       {std::pair{"face_connectivity", corners}, std::pair{"face_offsets", corner_ends},
        std::pair{"polyhedron_to_faces", faces}, std::pair{"polyhedron_offsets", face_ends}})
    arrays +=
        "<DataArray type=\"Int64\" Name=\"" + std::string(name) + "\" format=\"ascii\">" + values + "</DataArray>";
  made.insert(made.find("</Cells>"), arrays);
  return made;
}

} // namespace

TEST_CASE("polyhedra with points on their edges are split so that neighbours agree", "[vtk]") {
  const auto seed = GENERATE(1U, 2U, 3U);
  const auto layout = GENERATE(Layout::kStream, Layout::kTables);
  const Cells cells = refined_box(4, seed);
  std::vector<double> linear, constant;
  std::vector<int> numbers;
  for (const Point& p : cells.points) {
    linear.push_back(1 + p[0] - 2 * p[1] + 3 * p[2]);
    constant.push_back(0.1);
    numbers.push_back(static_cast<int>(numbers.size()) % 2);
  }
  ReadReport report;
  const TetMesh mesh =
      read_text(vtu_text(cells, layout,
                         array_of("Float64", "linear", linear) + array_of("Float64", "constant", constant) +
                             array_of("UInt8", "numbers", numbers)),
                &report);
  const auto polyhedra = static_cast<std::size_t>(
      std::count_if(cells.cells.begin(), cells.cells.end(), [](const Cell& cell) { return cell.type == kPolyhedron; }));
  REQUIRE(polyhedra > 100);
  REQUIRE(polyhedra < cells.cells.size());
  CHECK(mesh.vertex_count() == cells.points.size() + polyhedra);
  CHECK(has_note(report, "split " + std::to_string(cells.cells.size() - polyhedra) + " hexahedra and " +
                             std::to_string(polyhedra) + " polyhedra into tetrahedra"));
  CHECK(has_note(report, "added " + std::to_string(polyhedra) + " points in the middle of cells"));

  check_fills_cube(mesh, 8);

  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const Point p = mesh.position(VertexId(static_cast<std::uint32_t>(v)));
    if (v < cells.points.size() && p != cells.points[v]) FAIL("vertex " << v << " has moved");
    CHECK(mesh.find("linear")->value(v, 0) == Approx(1 + p[0] - 2 * p[1] + 3 * p[2]));
    if (mesh.find("constant")->value(v, 0) != 0.1) FAIL("of equal values " << v << " has another mean");
    if (mesh.find("numbers")->value(v, 0) > 1) FAIL("the mean at " << v << " is beyond the values");
  }
}

TEST_CASE("polyhedra that VTK has written beside a tet are read", "[vtk]") {
  ReadReport report;
  const TetMesh mesh = read_mesh(fixture("vtk_polyhedra.vtu"), &report);
  CHECK(mesh.vertex_count() == 12);
  CHECK(mesh.tets.size() == 4 * 4 + 1);
  CHECK(examine(mesh).volume == Approx(1));
  CHECK(examine(mesh).inverted_tets == 0);
  for (std::uint32_t i = 0; i < mesh.vertex_count(); ++i) {
    const Point p = mesh.position(VertexId(i));
    CHECK(mesh.find("f")->value(i, 0) == Approx(p[0] + 2 * p[1] + 4 * p[2]));
  }
  CHECK(mesh.find("id")->type == ScalarType::kInt32);
  CHECK(has_note(report, "split 4 polyhedra into tetrahedra"));
}

TEST_CASE("a triangle with a point on a side is cut at that point, in line with the others or not quite", "[vtk]") {
  // Two tets with a common face, and a point in the middle of a side of it: off the line by rounding at least.
  const auto seed = GENERATE(range(0U, 40U));
  const double off = GENERATE(0.0, 1e-16, 1e-12, 1e-3);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> anywhere(0, 1);
  Cells cells;
  for (int i = 0; i < 3; ++i)
    cells.points.push_back({anywhere(random), anywhere(random), anywhere(random)});
  Point low{}, high{}, middle{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double sum = cells.points[0][axis] + cells.points[1][axis] + cells.points[2][axis];
    low[axis] = sum / 3;
    middle[axis] = (cells.points[0][axis] + cells.points[1][axis]) / 2 + off * anywhere(random);
  }
  const Point a = cells.points[0], b = cells.points[1], c = cells.points[2];
  for (std::size_t axis = 0; axis < 3; ++axis) { // away from the face on both sides
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    const double normal = (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u]);
    high[axis] = low[axis] + normal;
    low[axis] -= normal;
  }
  cells.points.insert(cells.points.end(), {low, high, middle});
  enum : std::int64_t { kA, kB, kC, kLow, kHigh, kMiddle };
  for (const std::int64_t tip : {std::int64_t{kLow}, std::int64_t{kHigh}})
    cells.cells.push_back(
        {kPolyhedron, {}, {{kA, kMiddle, kB, kC}, {kA, kMiddle, kB, tip}, {kB, kC, tip}, {kC, kA, tip}}});
  ReadReport report;
  const TetMesh mesh = read_text(vtu_text(cells, Layout::kStream), &report);
  // Of each tet two faces are cut in two.
  CHECK(mesh.tets.size() == 2 * 6);
  const MeshFacts facts = examine(mesh);
  CHECK(facts.inverted_tets == 0);
  CHECK(facts.repeated_tets == 0);
  CHECK(facts.folded_faces == 0);
  CHECK(facts.components == 1);
  CHECK(report.notes.size() == 2);
}

TEST_CASE("a warped face of a polyhedron gets the diagonal that its middle sees", "[vtk]") {
  // A cube whose upper side sinks along one of its diagonals, or along the other.
  const bool is_turned = GENERATE(false, true);
  Cells cells = prism_over(kSquare);
  for (const std::size_t corner : {std::size_t{4}, std::size_t{6}})
    cells.points[corner + (is_turned ? 1 : 0)][2] = 0.1;
  for (const std::size_t corner : {std::size_t{5}, std::size_t{7}})
    cells.points[corner - (is_turned ? 1 : 0)][2] = 2;
  ReadReport report;
  const TetMesh mesh = read_text(vtu_text(cells, Layout::kStream), &report);
  CHECK(examine(mesh).inverted_tets == 0);
  CHECK(examine(mesh).folded_faces == 0);
  CHECK_FALSE(has_note(report, "turning"));
}

TEST_CASE("the mean in a polyhedron is right for integers of 64 bits and for infinities", "[vtk]") {
  const Cells cells = prism_over(kSquare);
  const auto mean = [&](const std::string& type, const std::string& values) {
    const TetMesh mesh =
        read_text(vtu_text(cells, Layout::kStream,
                           "<DataArray type=\"" + type + "\" Name=\"v\" format=\"ascii\">" + values + "</DataArray>"));
    std::array<std::byte, 8> row{};
    std::copy_n(mesh.find("v")->bytes.end() - 8, 8, row.begin());
    return row;
  };
  const auto of_signed = [&](const std::string& values) { return std::bit_cast<std::int64_t>(mean("Int64", values)); };
  const auto of_unsigned = [&](const std::string& values) {
    return std::bit_cast<std::uint64_t>(mean("UInt64", values));
  };
  const auto of_float = [&](const std::string& values) { return std::bit_cast<double>(mean("Float64", values)); };
  const auto eight = [](const std::string& number) {
    std::string all;
    for (int i = 0; i < 8; ++i)
      all += number + " ";
    return all;
  };
  CHECK(of_signed(eight("9007199254740993")) == 9007199254740993);
  CHECK(of_signed(eight("-9223372036854775807")) == -9223372036854775807);
  CHECK(of_unsigned(eight("18446744073709551613")) == 18446744073709551613U);
  CHECK(of_signed("1000000000000000000 1000000000000000001 1000000000000000002 1000000000000000003 1000000000000000004 "
                  "1000000000000000005 1000000000000000006 1000000000000000009") == 1000000000000000004);
  CHECK(of_unsigned("0 18446744073709551615 0 18446744073709551615 0 18446744073709551615 0 18446744073709551615") ==
        9223372036854775808U);
  CHECK(of_float("1.7e308 -1.7e308 1.7e308 -1.7e308 1.7e308 -1.7e308 1.7e308 -1.7e308") == 0);
}

TEST_CASE("both layouts of polyhedra give the same mesh", "[vtk]") {
  const Cells cells = refined_box(3, 7);
  const TetMesh one = read_text(vtu_text(cells, Layout::kStream)), other = read_text(vtu_text(cells, Layout::kTables));
  CHECK(one.positions == other.positions);
  CHECK(one.tets == other.tets);
}

TEST_CASE("a face of many corners is cut without flat or turned triangles", "[vtk]") {
  // Concave, with several points on its edges.
  const std::vector<std::array<double, 2>> angle = {{0, 0}, {1, 0}, {2, 0}, {3, 0}, {3, 1}, {2, 1},
                                                    {1, 1}, {1, 2}, {1, 3}, {0, 3}, {0, 2}, {0, 1}};
  const TetMesh mesh = read_text(vtu_text(prism_over(angle), Layout::kStream));
  const MeshFacts facts = examine(mesh);
  CHECK(facts.volume == Approx(5));
  CHECK(facts.folded_faces == 0);
  // 10 triangles each below and above, and 12 squares.
  CHECK(mesh.tets.size() == 2 * 10 + 12 * 2);
  for (const Face& face : facts.boundary) {
    std::set<double> x, y;
    for (const VertexId v : face) {
      x.insert(mesh.position(v)[0]);
      y.insert(mesh.position(v)[1]);
    }
    const double z = mesh.position(face[0])[2];
    const bool is_level = std::all_of(face.begin(), face.end(), [&](VertexId v) { return mesh.position(v)[2] == z; });
    if (is_level) CHECK((x.size() > 1 && y.size() > 1)); // a flat one is in a line
  }
}

TEST_CASE("two polyhedra cut the face between them alike, however it is given", "[vtk]") {
  // Of a regular polygon many ways to cut it are as good as one another.
  const auto seed = GENERATE(range(0U, 20U));
  std::mt19937 random(seed);
  constexpr std::int64_t kSides = 8;
  Cells cells;
  for (const double z : {0.0, 1.0, 2.0})
    for (int i = 0; i < kSides; ++i)
      cells.points.push_back(
          {std::cos(2 * 3.14159265358979 * i / kSides), std::sin(2 * 3.14159265358979 * i / kSides), z});
  Corners between(kSides);
  std::iota(between.begin(), between.end(), kSides);
  for (const std::int64_t low : {std::int64_t{0}, kSides}) {
    Cell cell;
    for (const std::int64_t level : {low, low + kSides}) {
      Corners face(kSides);
      std::iota(face.begin(), face.end(), level);
      std::rotate(face.begin(), face.begin() + random() % kSides, face.end());
      if (random() % 2 == 0) std::reverse(face.begin(), face.end());
      cell.faces.push_back(face);
    }
    for (std::int64_t i = 0; i < kSides; ++i)
      cell.faces.push_back({low + i, low + (i + 1) % kSides, low + kSides + (i + 1) % kSides, low + kSides + i});
    cells.cells.push_back(cell);
  }
  const TetMesh mesh = read_text(vtu_text(cells, Layout::kStream));
  const MeshFacts facts = examine(mesh);
  CHECK(facts.folded_faces == 0);
  CHECK(facts.components == 1);
  // Six triangles below and above each, and two for each side of the prisms.
  CHECK(mesh.tets.size() == 2 * (2 * 6 + 2 * 8));
  CHECK(facts.boundary.size() == 2 * 6 + 2 * 2 * 8);
}

TEST_CASE("the middle of a polyhedron may be that of its surface", "[vtk]") {
  // A square with a short arm, and nearly all points at the end of it: their mean is in the arm, and sees the sides of
  // the square beside it from behind.
  std::vector<std::array<double, 2>> square_with_arm = {{10, 5.5}, {10, 10}, {0, 10}, {0, 0}, {10, 0}, {10, 4.5}};
  for (int i = 0; i <= 30; ++i)
    square_with_arm.push_back({12, 4.5 + i / 30.0});
  ReadReport report;
  const TetMesh mesh = read_text(vtu_text(prism_over(square_with_arm), Layout::kStream), &report);
  const Point middle = mesh.position(VertexId(static_cast<std::uint32_t>(mesh.vertex_count() - 1)));
  CHECK(middle[0] < 10);
  CHECK(examine(mesh).volume == Approx(102));
  CHECK(examine(mesh).inverted_tets == 0);
  CHECK_FALSE(has_note(report, "turning"));
}

TEST_CASE("the middle of a polyhedron sees all of its faces where any point does", "[vtk]") {
  // Two arms, and only what lies in both of them sees both; the arms are of a width that leaves little.
  const double width = GENERATE(1.0, 0.3);
  const std::vector<std::array<double, 2>> angle = {{0, 0}, {9, 0}, {9, width}, {width, width}, {width, 9}, {0, 9}};
  ReadReport report;
  const TetMesh mesh = read_text(vtu_text(prism_over(angle), Layout::kStream), &report);
  const Point middle = mesh.position(VertexId(static_cast<std::uint32_t>(mesh.vertex_count() - 1)));
  CHECK(std::max(middle[0], middle[1]) < width);
  CHECK(examine(mesh).volume == Approx(18 * width - width * width));
  CHECK(examine(mesh).inverted_tets == 0);
  CHECK_FALSE(has_note(report, "turning"));
}

TEST_CASE("a polyhedron of which no point sees all faces is named", "[vtk]") {
  const std::vector<std::array<double, 2>> three_sides = {{0, 0}, {9, 0}, {9, 9}, {8, 9},
                                                          {8, 1}, {1, 1}, {1, 9}, {0, 9}};
  ReadReport report;
  const TetMesh mesh = read_text(vtu_text(prism_over(three_sides), Layout::kStream), &report);
  CHECK(examine(mesh).volume == Approx(25));
  CHECK(has_note(report, "1 cell (0) cannot be split without turning tetrahedra over: no point was found"));
}

TEST_CASE("what two faces of a polyhedron cut alike at a point that no other face has is nothing", "[vtk]") {
  // Cells of snappyHexMesh, whose pentagon and quadrilateral have three points together, and of polyDualMesh.
  const Cells of_snappy{{{-180.643, 20.0, -182.426},
                         {-189.728, 10.652, -178.099},
                         {-179.977, 10.771, -182.743},
                         {-183.031, 20.0, -181.288},
                         {-189.127, 20.0, -178.386},
                         {-181.326, 11.891, -177.782}},
                        {{kPolyhedron, {}, {{0, 3, 5, 2}, {4, 3, 0, 2, 1}, {2, 5, 1}, {3, 4, 1, 5}}}}};
  const TetMesh mesh = read_text(vtu_text(of_snappy, Layout::kStream));
  CHECK(mesh.tets.size() == 8);
  CHECK(examine(mesh).inverted_tets == 0);
  CHECK(examine(mesh).repeated_tets == 0);

  const Cells of_dual{{{84.16, 20, -228.375},
                       {79.731, 15.476, -223.817},
                       {78.728, 13.95, -230.052},
                       {86.917, 15.702, -222.702},
                       {79.975, 20, -224.075},
                       {86.908, 20, -222.575},
                       {79.739, 15.059, -230.481},
                       {87.557, 15.489, -226.757},
                       {87.633, 20, -226.721},
                       {81.279, 20, -229.748},
                       {84.399, 15.265, -228.261},
                       {83.48, 20, -223.45}},
                      {{kPolyhedron,
                        {},
                        {{9, 6, 2, 1, 4},
                         {8, 5, 3, 7},
                         {7, 3, 1, 2, 6, 10},
                         {4, 1, 3, 5, 11},
                         {0, 9, 4, 11},
                         {0, 11, 5, 8},
                         {0, 8, 7, 10},
                         {0, 10, 6, 9}}}}};
  ReadReport report;
  const TetMesh other = read_text(vtu_text(of_dual, Layout::kStream), &report);
  CHECK(examine(other).inverted_tets == 0);
  CHECK(examine(other).repeated_tets == 0);
  CHECK(examine(other).folded_faces == 0);
  CHECK(has_note(report, "left out 2 tetrahedra"));
  CHECK_FALSE(has_note(report, "turning"));
}

TEST_CASE("polyhedra whose faces do not close are refused", "[vtk]") {
  Cells cells = prism_over(kSquare);
  SECTION("one is missing") {
    cells.cells[0].faces.pop_back();
    CHECK_THAT(failure_of_text(vtu_text(cells, Layout::kStream)).message,
               Catch::Contains("cell 0, a polyhedron, is not closed"));
  }
  SECTION("one is there twice") {
    cells.cells[0].faces.push_back(cells.cells[0].faces.back());
    CHECK_THAT(failure_of_text(vtu_text(cells, Layout::kTables)).message, Catch::Contains("is not closed"));
  }
  SECTION("none is there") {
    cells.cells[0].faces.clear();
    CHECK_THAT(failure_of_text(vtu_text(cells, Layout::kStream)).message, Catch::Contains("is not closed"));
  }
  SECTION("corners that repeat are no fault") {
    cells.cells[0].faces[0].push_back(cells.cells[0].faces[0].back());
    cells.cells[0].faces.push_back({0, 1, 0});
    cells.cells[0].faces.back().resize(2);
    CHECK(examine(read_text(vtu_text(cells, Layout::kStream))).volume == Approx(1));
  }
  SECTION("nor is a face that is nothing but an edge there and back") {
    cells.cells[0].faces.push_back({0, 1, 2, 1});
    ReadReport report;
    CHECK(read_text(vtu_text(cells, Layout::kStream), &report).tets.size() == 12);
    CHECK_FALSE(has_note(report, "left out"));
  }
  SECTION("a face with too many corners") {
    std::vector<std::array<double, 2>> round;
    for (int i = 0; i < 257; ++i)
      round.push_back({std::cos(2 * 3.14159265358979 * i / 257), std::sin(2 * 3.14159265358979 * i / 257)});
    CHECK_THAT(failure_of_text(vtu_text(prism_over(round), Layout::kStream)).message,
               Catch::Contains("has a face of 257 points"));
    round.pop_back();
    CHECK(read_text(vtu_text(prism_over(round), Layout::kStream)).tets.size() == 2 * 254 + 2 * 256);
  }
  SECTION("coordinates that have no middle") {
    CHECK_THAT(failure_of_text(vtu_text(cells, Layout::kStream, {}, "Int32")).message,
               Catch::Contains("(int32) may not have"));
  }
}

TEST_CASE("tables of faces that lie are bad input", "[vtk]") {
  const std::string tet = "4 3 0 2 1 3 0 1 3 3 1 2 3 3 2 0 3";
  CHECK(examine(read_text(vtu_of_faces(tet, "17"))).volume == Approx(1.0 / 6));
  const auto message_of = [](const std::string& faces, const std::string& faceoffsets) {
    const Failure failure = failure_of_text(vtu_of_faces(faces, faceoffsets));
    CHECK(failure.code == ErrorCode::kBadInput);
    return failure.message;
  };
  CHECK_THAT(message_of(tet, "-1"), Catch::Contains("the faces of cell 0, a polyhedron, are not there"));
  CHECK_THAT(message_of(tet, "18"), Catch::Contains("holds 17 values where 18 belong"));
  CHECK_THAT(message_of(tet, "9000000000000000"), Catch::Contains("more than the file can hold"));
  CHECK_THAT(message_of("5" + tet.substr(1), "17"), Catch::Contains("run past the end of their table"));
  CHECK_THAT(message_of("3" + tet.substr(1), "17"), Catch::Contains("do not end where their offset says"));
  CHECK_THAT(message_of("900000000000 3 0 2 1", "5"), Catch::Contains("run past the end of their table"));
  CHECK_THAT(message_of("4 900000000000 0 2 1", "5"), Catch::Contains("run past the end of their table"));
  CHECK_THAT(message_of("4 -1 0 2 1", "5"), Catch::Contains("run past the end of their table"));
  CHECK_THAT(message_of("4 3 0 2 4 3 0 1 3 3 1 2 3 3 2 0 3", "17"), Catch::Contains("cell 0 uses point 4"));
  CHECK_THAT(message_of("4 3 0 2 -1 3 0 1 3 3 1 2 3 3 2 0 3", "17"), Catch::Contains("use point -1"));
  CHECK_THAT(message_of("4 3 0 2 5000000000 3 0 1 3 3 1 2 3 3 2 0 3", "17"), Catch::Contains("use point 5000000000"));
  CHECK_THAT(message_of("-9 3 0 2 1", "5"), Catch::Contains("is neither a point, a face nor a place"));

  // Cells are counted over all pieces of a file.
  VtuText sound;
  std::string second = vtu_of_faces(tet, "-1");
  second = second.substr(second.find("<Piece"), second.find("</Piece>") + 8 - second.find("<Piece"));
  CHECK_THAT(failure_of_text(sound.file(second)).message, Catch::Contains("the faces of cell 1, a polyhedron"));

  VtuText without;
  without.types = "42";
  CHECK_THAT(failure_of_text(without.file()).message,
             Catch::Contains("has polyhedra, and not the arrays of their faces"));

  const std::string corners = "0 2 1 0 1 3 1 2 3 2 0 3", corner_ends = "3 6 9 12";
  CHECK(examine(read_text(vtu_of_tables(corners, corner_ends, "3 0 1 2", "4"))).volume == Approx(1.0 / 6));
  const auto message_of_tables = [&](const std::string& ends, const std::string& faces, const std::string& face_ends) {
    return failure_of_text(vtu_of_tables(corners, ends, faces, face_ends)).message;
  };
  CHECK_THAT(message_of_tables(corner_ends, "0 1 2 3", "5"), Catch::Contains("holds 4 values where 5 belong"));
  CHECK_THAT(message_of_tables(corner_ends, "0 1 2 4", "4"), Catch::Contains("are not there"));
  CHECK_THAT(message_of_tables(corner_ends, "0 1 2 3 0 0", "6"), Catch::Contains("are those of two others, too"));
  // A face that no cell has is no fault.
  CHECK(read_text(vtu_of_tables(corners + " 0 1 2", corner_ends + " 15", "3 0 1 2", "4")).tets.size() == 4);
  CHECK_THAT(message_of_tables("6 3 9 12", "0 1 2 3", "4"), Catch::Contains("do not go up from 0"));
  CHECK_THAT(message_of_tables("-1 3 9 12", "0 1 2 3", "4"), Catch::Contains("do not go up from 0"));
  CHECK_THAT(message_of_tables(corner_ends, "0 1 -1 3", "4"), Catch::Contains("are not there"));
  CHECK_THAT(message_of_tables(corner_ends, "0 1 2 3", "-1"), Catch::Contains("should have -1 values"));
}

TEST_CASE("prisms over polygons are split as polyhedra are, and agree with these", "[vtk]") {
  const int sides = GENERATE(5, 6);
  std::vector<std::array<double, 2>> polygon;
  for (int i = 0; i < sides; ++i)
    polygon.push_back({std::cos(6.283185307179586 * i / sides), std::sin(6.283185307179586 * i / sides)});
  Cells cells = prism_over(polygon);
  const Cells upper = cells;
  for (const Point& p : upper.points)
    if (p[2] == 1) cells.points.push_back({p[0], p[1], 2});
  Cell prism{sides == 5 ? 15 : 16, Corners(static_cast<std::size_t>(2 * sides)), {}};
  std::iota(prism.points.begin(), prism.points.end(), sides);
  cells.cells.push_back(prism);
  ReadReport report;
  const TetMesh mesh = read_text(vtu_text(cells, Layout::kStream), &report);
  const MeshFacts facts = examine(mesh);
  CHECK(mesh.vertex_count() == cells.points.size() + 2);
  CHECK(facts.volume == Approx(sides * std::sin(6.283185307179586 / sides)));
  CHECK(facts.inverted_tets == 0);
  CHECK(facts.folded_faces == 0);
  CHECK(facts.components == 1);
  CHECK(has_note(report, sides == 5 ? "split 1 pentagonal prism and 1 polyhedron into tetrahedra"
                                    : "split 1 hexagonal prism and 1 polyhedron into tetrahedra"));
}

TEST_CASE("polyhedra of a legacy file are refused, with what to do", "[vtk]") {
  CHECK_THAT(failure_of_text("# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n"
                             "0 0 0 1 0 0 0 1 0 0 0 1\nCELLS 1 18\n17 4 3 0 2 1 3 0 1 3 3 1 2 3 3 2 0 3\n"
                             "CELL_TYPES 1\n42\n",
                             "m.vtk")
                 .message,
             Catch::Contains("cell 0 is a polyhedron, which ptet reads from .vtu files only"));
}
