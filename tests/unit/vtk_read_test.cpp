#include "formats/vtk/read.hpp"
#include "formats/vtk/write.hpp"
#include "mesh/scalar_dispatch.hpp"
#include "ptet/build.hpp"
#include "ptet/dataset.hpp"
#include "ptet/error.hpp"
#include "support/mesh_checks.hpp"
#include "support/meshes.hpp"
#include "support/temp_folder.hpp"
#include "vtk_fixture.hpp"

#include <algorithm>
#include <sstream>

#include <catch2/catch.hpp>
#include <unistd.h>

using namespace ptet;
using namespace ptet::test;

/// VTK's readers leak an array or two when they refuse a file.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libvtk";
}

TEST_CASE("the cube of other people's writers is read", "[vtk]") {
  const std::string name =
      GENERATE("meshio_zlib.vtu", "meshio_lzma.vtu", "meshio_ascii.vtu", "meshio_42.vtk", "vtk_51.vtk",
               "vtk_42_all.vtk", "vtk_51_all.vtk", "vtk_appended_base64_lz4.vtu", "two_blocks.ex2", "two_pieces.pvtu");
  INFO(name);
  ReadReport report;
  const TetMesh mesh = read_mesh(fixture(name), &report);
  const bool exodus = name == "two_blocks.ex2";
  const bool pieces = name == "two_pieces.pvtu";
  CHECK(mesh.positions.type == ScalarType::kFloat64);
  CHECK(mesh.vertex_count() == (pieces ? 16 : 8));
  CHECK(mesh.tets.size() == 5);
  CHECK(examine(mesh).volume == Approx(1));
  REQUIRE(mesh.find("f"));
  REQUIRE(mesh.find("v"));
  CHECK(mesh.find("f")->type == ScalarType::kFloat64);
  CHECK(mesh.find("v")->type == (exodus ? ScalarType::kFloat64 : ScalarType::kFloat32));
  CHECK(mesh.find("v")->components == 3);
  CHECK((mesh.find("id") != nullptr) == !exodus);
  for (std::uint32_t i = 0; i < mesh.vertex_count(); ++i) {
    const Point p = mesh.position(VertexId(i));
    CHECK(mesh.find("f")->value(i, 0) == p[0] + 2 * p[1] + 4 * p[2]);
    for (std::uint32_t axis = 0; axis < 3; ++axis)
      CHECK(mesh.find("v")->value(i, axis) == p[axis]);
    if (!exodus) CHECK(mesh.find("id")->value(i, 0) == 10 * mesh.find("f")->value(i, 0));
  }
  if (!exodus) CHECK(mesh.find("id")->type == ScalarType::kInt32);

  const auto noted = [&](const std::string& part) {
    return std::any_of(report.notes.begin(), report.notes.end(),
                       [&](const std::string& note) { return note.find(part) != std::string::npos; });
  };
  if (name.starts_with("meshio")) CHECK(noted("cell array 'c' is not carried"));
  if (name.ends_with("_all.vtk")) {
    CHECK(noted("cell array 'colours' is not carried"));
    REQUIRE(mesh.find("normals"));
    CHECK(mesh.find("normals")->value(7, 2) == 1);
    REQUIRE(mesh.find("tensors"));
    CHECK(mesh.find("tensors")->components == 9);
  }
  if (exodus) CHECK(noted("last of 2 time steps (time 1.5)"));
  if (exodus) CHECK(noted("2 element blocks ("));
  if (pieces) CHECK(noted("joined 2 pieces"));
  if (pieces) CHECK(noted("unless these points are welded"));
  if (pieces) CHECK(noted("skipped 1 ghost cell"));
}

TEST_CASE("the real meshes are read whole", "[vtk][data]") {
  struct Expected {
    const char* name;
    std::size_t vertices, tets, arrays;
  };
  const auto expected =
      GENERATE(Expected{"fire_ug.vtu", 12323, 62772, 6}, Expected{"pulley.vtu", 14762, 63767, 2},
               Expected{"fea_bracket.vtu", 16468, 56786, 1}, Expected{"seamount.vtu", 20004, 100450, 3},
               Expected{"bluntfin.vtu", 40921, 187356, 6}, Expected{"motorbike.vtu", 455682, 2573753, 4});
  const auto path = data_file(expected.name);
  if (!path) {
    WARN(expected.name << " is not in " << data_dir() << ": skipped");
    return;
  }
  ReadReport report;
  const TetMesh mesh = read_mesh(*path, &report);
  CHECK(mesh.vertex_count() == expected.vertices);
  CHECK(mesh.tets.size() == expected.tets);
  CHECK(mesh.point_arrays.size() == expected.arrays);
  CHECK(report.notes.empty());
}

TEST_CASE("several pieces of one file are joined, each with its own numbering", "[vtk]") {
  VtuText first;
  first.point_data = array_text("Name=\"f\"", "1 2 3 4");
  VtuText second = first;
  second.point_data = array_text("Name=\"f\"", "5 6 7 8");
  SECTION("like arrays") {
    const TetMesh mesh = read_text(first.file(second.piece()));
    CHECK(mesh.vertex_count() == 8);
    REQUIRE(mesh.tets.size() == 2);
    CHECK(mesh.tets[1][0] == VertexId(4));
    CHECK(mesh.find("f")->value(7, 0) == 8);
  }
  SECTION("an id that would reach into the next piece") {
    first.connectivity = "0 1 2 4";
    CHECK(failure_of_text(first.file(second.piece())).message.find("cell 0 uses point 4, and there are 4 points") !=
          std::string::npos);
  }
  SECTION("arrays of other names") {
    second.point_data = array_text("Name=\"g\"", "5 6 7 8");
    CHECK(failure_of_text(first.file(second.piece())).message.find("other point arrays") != std::string::npos);
  }
  SECTION("positions of another type") {
    second.points =
        R"(<DataArray type="Float64" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 0 1 0 0 0 1</DataArray>)";
    CHECK(failure_of_text(first.file(second.piece())).code == ErrorCode::kBadInput);
  }
}

TEST_CASE("an empty first piece has no say about arrays", "[vtk]") {
  VtuText whole;
  whole.point_data = array_text("Name=\"f\"", "1 2 3 4");
  VtuText empty;
  empty.counts = R"(NumberOfPoints="0" NumberOfCells="0")";
  empty.points = R"(<DataArray type="Float64" NumberOfComponents="3" format="ascii"></DataArray>)";
  empty.connectivity = empty.offsets = empty.types = "";
  const TetMesh mesh = read_text(empty.file(empty.piece() + whole.piece() + empty.piece() + whole.piece()));
  CHECK(mesh.positions.type == ScalarType::kFloat32);
  REQUIRE(mesh.find("f"));
  CHECK(mesh.find("f")->value(7, 0) == 4);
  CHECK(mesh.tets.size() == 2);
}

TEST_CASE("pieces of a PVTU that hold nothing, or are there already, are passed over", "[vtk]") {
  const TempFolder folder;
  const std::string empty =
      "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">"
      "<UnstructuredGrid><Piece NumberOfPoints=\"0\" NumberOfCells=\"0\"><PointData></PointData></Piece>"
      "</UnstructuredGrid></VTKFile>";
  write_bytes(folder / "empty.vtu", empty);
  write_bytes(folder / "full.vtu", VtuText().file());
  const auto parallel = [&](const std::string& pieces) {
    write_bytes(folder / "mesh.pvtu", "<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\">"
                                      "<PUnstructuredGrid>" +
                                          pieces + "</PUnstructuredGrid></VTKFile>");
    return folder / "mesh.pvtu";
  };
  const std::string none = "<Piece Source=\"empty.vtu\"/>", one = "<Piece Source=\"full.vtu\"/>";
  CHECK(read_mesh(parallel(none + one + none)).tets.size() == 1);
  // Nor those that are named again.
  ReadReport report;
  CHECK(read_mesh(parallel(one + one), &report).tets.size() == 1);
  CHECK(report.more_files.size() == 1);
  REQUIRE(report.notes.size() == 1);
  CHECK_THAT(report.notes[0], Catch::EndsWith("full.vtu' is named more than once, and was read once"));
  CHECK_THAT(failure_of(parallel(none + none)).message, Catch::Contains("all of its pieces are empty"));
}

TEST_CASE("of several time steps in one VTU the last is taken, and that is said", "[vtk]") {
  // As VTK's writer puts them, in all modes but the appended one: every array once a step, all called step 0.
  const bool counted = GENERATE(true, false);
  const auto step = [&](int number) { return " TimeStep=\"" + std::to_string(counted ? number : 0) + "\""; };
  VtuText text;
  text.point_data = array_text("Name=\"f\"" + step(0), "1 2 3 4") + array_text("Name=\"still\"", "9 9 9 9") +
                    array_text("Name=\"f\"" + step(1), "5 6 7 8");
  const auto points = [&](int number, const std::string& rows) {
    return "<DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\"" + step(number) + ">" + rows +
           "</DataArray>";
  };
  text.points = points(0, "0 0 0 1 0 0 0 1 0 0 0 1") + points(1, "0 0 0 2 0 0 0 2 0 0 0 2");
  std::string file = text.file();
  const std::string types = "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\"";
  file.insert(file.find(types), types + step(0) + ">10</DataArray>");
  file.replace(file.rfind(types), types.size(), types + step(1));
  ReadReport report;
  const TetMesh mesh = read_text(file, &report);
  REQUIRE(mesh.point_arrays.size() == 2);
  REQUIRE(mesh.find("f"));
  CHECK(mesh.find("f")->value(3, 0) == 8);
  CHECK(mesh.find("still")->value(3, 0) == 9);
  CHECK(mesh.position(VertexId(1))[0] == 2);
  REQUIRE(report.notes.size() == 1);
  CHECK(report.notes[0] == "the values are those of the last of 2 time steps");

  // A piece a step, which VTK reads as one mesh of all of them.
  file = text.file(text.piece());
  file.insert(file.find("<UnstructuredGrid>") + 17, " TimeValues=\"0 1 2\"");
  CHECK_THAT(failure_of_text(file).message, Catch::Contains("is not there for the last of 3 time steps"));
}

TEST_CASE("arrays without a name of their own get one", "[vtk]") {
  VtuText text;
  text.point_data = array_text("Name=\"f\"", "1 2 3 4") + array_text("Name=\"f\"", "5 6 7 8") +
                    array_text("", "9 10 11 12") + array_text("Name=\"g\"", "13 14 15 16");
  ReadReport report;
  const TetMesh mesh = read_text(text.file(), &report);
  REQUIRE(mesh.point_arrays.size() == 4);
  CHECK(mesh.point_arrays[0].name == "f");
  CHECK(mesh.point_arrays[1].name == "f_2");
  CHECK(mesh.point_arrays[2].name == "array_2");
  CHECK(mesh.point_arrays[3].name == "g");
  for (std::size_t i = 0; i < 4; ++i)
    CHECK(mesh.point_arrays[i].value(0, 0) == 4 * static_cast<double>(i) + 1);
  CHECK(report.notes == std::vector<std::string>{"a second point array 'f' is called 'f_2'",
                                                 "a point array without a name is called 'array_2'"});
}

TEST_CASE("names of components and flags of points are not carried, and that is said", "[vtk]") {
  VtuText text;
  text.point_data =
      array_text(R"(Name="s" NumberOfComponents="2" ComponentName0="XX" ComponentName1="YZ")", "1 2 3 4 5 6 7 8") +
      R"(<DataArray type="UInt8" Name="vtkGhostType" format="ascii">0 1 0 2</DataArray>)";
  ReadReport report;
  const TetMesh mesh = read_text(text.file(), &report);
  CHECK(mesh.point_arrays.size() == 1);
  REQUIRE(report.notes.size() == 2);
  CHECK_THAT(report.notes[0], Catch::Contains("point array 's' (XX, YZ)"));
  CHECK_THAT(report.notes[1], Catch::Contains("mark 2 points"));
}

TEST_CASE("ghost cells are skipped, whatever type their flags have, and the levels of old files are such flags",
          "[vtk]") {
  VtuText text;
  text.counts = R"(NumberOfPoints="5" NumberOfCells="2")";
  text.points =
      R"(<DataArray type="Float32" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 0 1 0 0 0 1 0 0 -1</DataArray>)";
  text.connectivity = "0 1 2 3 0 2 1 4";
  text.offsets = "4 8";
  text.types = "10 10";
  struct Flags {
    const char *version, *type, *name;
    bool count;
  };
  const auto flags = GENERATE(values<Flags>({{"1.0", "UInt8", "vtkGhostType", true},
                                             {"1.0", "Int8", "vtkGhostType", true},
                                             {"2.0", "Int32", "vtkGhostType", true},
                                             {"0.1", "UInt8", "vtkGhostLevels", true},
                                             {"1.0", "UInt8", "vtkGhostLevels", true},
                                             {"1.0", "Int32", "vtkGhostLevels", false},
                                             {"2.0", "UInt8", "vtkGhostLevels", false}}));
  INFO(flags.version << " " << flags.type << " " << flags.name);
  text.version = flags.version;
  text.cell_data = std::string("<DataArray type=\"") + flags.type + "\" Name=\"" + flags.name +
                   "\" format=\"ascii\">0 1</DataArray>";
  ReadReport report;
  const TetMesh mesh = read_text(text.file(), &report);
  CHECK(mesh.tets.size() == (flags.count ? 1 : 2));
  REQUIRE(report.notes.size() == 1);
  CHECK_THAT(report.notes[0],
             Catch::Contains(flags.count ? "skipped 1 ghost cell" : "cell array 'vtkGhostLevels' is not carried"));
}

TEST_CASE("ghost flags of several pieces: all have them, but for those without cells", "[vtk]") {
  VtuText with, without, empty;
  with.cell_data = R"(<DataArray type="UInt8" Name="vtkGhostType" format="ascii">1</DataArray>)";
  empty.counts = R"(NumberOfPoints="0" NumberOfCells="0")";
  empty.points = R"(<DataArray type="Float32" NumberOfComponents="3" format="ascii"></DataArray>)";
  empty.connectivity = empty.offsets = empty.types = "";
  VtuText plain = with;
  plain.cell_data = R"(<DataArray type="UInt8" Name="vtkGhostType" format="ascii">0</DataArray>)";
  for (const std::string& text : {empty.file(with.piece() + plain.piece()), plain.file(with.piece() + empty.piece())}) {
    ReadReport report;
    CHECK(read_text(text, &report).tets.size() == 1);
    CHECK(std::any_of(report.notes.begin(), report.notes.end(),
                      [](const std::string& note) { return note.find("skipped 1 ghost cell") != std::string::npos; }));
  }
  VtuText carried;
  carried.cell_data = R"(<DataArray type="Float32" Name="density" format="ascii">1</DataArray>)";
  ReadReport report;
  CHECK(read_text(empty.file(carried.piece() + carried.piece()), &report).tets.size() == 2);
  CHECK(std::count(report.notes.begin(), report.notes.end(), "cell array 'density' is not carried") == 1);
  for (const std::string& text : {with.file(without.piece()), without.file(with.piece())})
    CHECK_THAT(failure_of_text(text).message,
               Catch::Contains("other ghost flags or degrees of cells than those before it"));
}

TEST_CASE("point arrays that are not numeric are left out and said", "[vtk]") {
  VtuText text;
  text.point_data = R"(<Array type="String" Name="label" format="ascii">65 0 66 0 67 0 68 0</Array>)" +
                    array_text("Name=\"f\"", "1 2 3 4");
  ReadReport report;
  const TetMesh mesh = read_text(text.file(), &report);
  CHECK(mesh.point_arrays.size() == 1);
  CHECK(mesh.find("f")->value(3, 0) == 4);
  REQUIRE(report.notes.size() == 1);
  CHECK_THAT(report.notes[0], Catch::Contains("'label' is not numeric"));
}

TEST_CASE("text in a VTU may be shorter than it should be, or stand where other things do", "[vtk]") {
  const std::string two = R"( format="ascii">65 0 66 0</Array>)"; // VTK's own reader looks for four
  VtuText text;
  text.point_data = R"(<Array type="String" Name="label")" + two + array_text("Name=\"f\"", "1 2 3 4") +
                    R"(<Array type="String" Name="vtkGhostType")" + two;
  ReadReport report;
  const TetMesh mesh = read_text(text.file(), &report);
  CHECK(mesh.point_arrays.size() == 1);
  CHECK(mesh.find("f")->value(3, 0) == 4);
  CHECK(report.notes ==
        std::vector<std::string>{"point array 'label' is not numeric (string) and is not carried",
                                 "point array 'vtkGhostType' is not numeric (string) and is not carried"});
  std::string no_points = text.file();
  const std::size_t points = no_points.find("<Points>");
  no_points.replace(no_points.find("Float", points), 7, "String");
  CHECK_THAT(failure_of_text(no_points).message, Catch::Contains("points of piece 0 are text"));
}

TEST_CASE("cells of lower dimension are skipped beside volume cells", "[vtk]") {
  VtuText text;
  text.counts = R"(NumberOfPoints="4" NumberOfCells="5")";
  text.connectivity = "0 1 2  0 1 2 3  0 1  2  0 1 2";
  text.offsets = "3 7 9 10 13";
  text.types = "5 10 3 1 5";
  ReadReport report;
  const TetMesh mesh = read_text(text.file(), &report);
  CHECK(mesh.tets.size() == 1);
  CHECK(report.notes == std::vector<std::string>{"skipped 1 vertex, 1 line and 2 triangles"});
}

TEST_CASE("what kind of data a VTK file holds is read as XML has it", "[vtk]") {
  std::string file = VtuText().file();
  const std::string type = R"( type="UnstructuredGrid")";
  const std::size_t at = file.find(type);
  REQUIRE(at != std::string::npos);
  const auto other =
      GENERATE(as<std::string>{}, "\n  type = 'UnstructuredGrid'", " header='' type\t=\"UnstructuredGrid\"");
  file.replace(at, type.size(), other);
  CHECK(read_text(file).tets.size() == 1);
  CHECK(read_text(R"(<?xml version="1.0"?><!-- <VTKFile type="PolyData"> -->)" + file).tets.size() == 1);
}

TEST_CASE("what is not a tetrahedral mesh is refused by name", "[vtk]") {
  VtuText text;
  SECTION("triangles only") {
    text.counts = R"(NumberOfPoints="4" NumberOfCells="1234")";
    text.connectivity = text.offsets = text.types = "";
    for (int i = 1; i <= 1234; ++i) {
      text.connectivity += "0 1 2 ";
      text.offsets += std::to_string(3 * i) + " ";
      text.types += "5 ";
    }
    const Failure failure = failure_of_text(text.file());
    CHECK(failure.code == ErrorCode::kBadInput);
    CHECK_THAT(failure.message, Catch::EndsWith("holds 1,234 triangles and no volume cells: ptet needs tetrahedra"));
  }
  SECTION("a cell that cannot be split") {
    text.counts = R"(NumberOfPoints="4" NumberOfCells="2")";
    text.connectivity = "0 1 2 3 0 1 2 3";
    text.offsets = "4 8";
    text.types = "10 41";
    CHECK_THAT(failure_of_text(text.file()).message,
               Catch::EndsWith("holds 1 cell of vtkConvexPointSet (first: cell 1), which ptet cannot split into "
                               "tetrahedra: do so first, as ParaView's Tetrahedralize does"));
  }
  SECTION("a cell type that nobody knows") {
    text.types = "200";
    CHECK_THAT(failure_of_text(text.file()).message, Catch::Contains("unknown type 200"));
  }
  SECTION("a surface dataset") {
    CHECK_THAT(failure_of_text("<VTKFile type=\"PolyData\" version=\"0.1\"><PolyData/></VTKFile>", "mesh.vtp").message,
               Catch::Contains("holds a surface"));
    CHECK_THAT(failure_of_text("# vtk DataFile Version 4.2\nsurface\nASCII\nDATASET POLYDATA\n", "mesh.vtk").message,
               Catch::Contains("holds a surface"));
    CHECK_THAT(failure_of_text("<VTKFile type=\"vtkMultiBlockDataSet\" version=\"1.0\"/>", "m.vtm").message,
               Catch::Contains("is a list of files (VTM)"));
    CHECK_THAT(failure_of_text("# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\n", "mesh.vtk").message,
               Catch::Contains("holds a dataset of type 'structured_points'"));
  }
  SECTION("something else") {
    CHECK_THAT(failure_of_text("hello").message, Catch::Contains("is no mesh that ptet reads"));
    CHECK_THAT(failure_of_text("").message, Catch::EndsWith("is empty"));
  }
}

TEST_CASE("paths that cannot be read are named with the system's reason", "[vtk]") {
  const TempFolder folder;
  CHECK(failure_of(folder / "none.vtu").code == ErrorCode::kIo);
  CHECK_THAT(failure_of(folder / "none.vtu").message,
             Catch::EndsWith("none.vtu: cannot read: No such file or directory"));
  CHECK_THAT(failure_of(folder / "").message, Catch::EndsWith("cannot read: it is a folder"));
  CHECK_THAT(failure_of("/dev/null").message, Catch::EndsWith("it is not a regular file"));
  CHECK_THROWS_AS(hash_input(folder / "none.vtu"), Error);
  write_bytes(folder / "closed.vtu", VtuText().file());
  std::filesystem::permissions(folder / "closed.vtu", std::filesystem::perms::none);
  if (::geteuid() != 0) CHECK(failure_of(folder / "closed.vtu").code == ErrorCode::kIo);
  write_bytes(folder / "pieces.pvtu", "<VTKFile type=\"PUnstructuredGrid\" version=\"0.1\"><PUnstructuredGrid>"
                                      "<Piece Source=\"gone.vtu\"/></PUnstructuredGrid></VTKFile>");
  CHECK(failure_of(folder / "pieces.pvtu").code == ErrorCode::kIo);
  CHECK_THAT(failure_of(folder / "pieces.pvtu").message, Catch::Contains("gone.vtu: cannot read: No such file"));
}

TEST_CASE("all attributes of a legacy file are read, not the first of each kind", "[vtk]") {
  const TempFolder folder;
  write_bytes(folder / "m.vtk",
              legacy_text("CELLS 1 5\n4 0 1 2 3", "CELL_TYPES 1\n10",
                          "POINT_DATA 4\nSCALARS a float\nLOOKUP_TABLE default\n1 2 3 4\n"
                          "SCALARS b short 2\nLOOKUP_TABLE default\n1 2 3 4 5 6 7 8\n"
                          "VECTORS c double\n1 2 3 1 2 3 1 2 3 1 2 3\nVECTORS d float\n1 2 3 1 2 3 1 2 3 1 2 3\n"
                          "FIELD more 1\ne 1 4 unsigned_char\n9 8 7 6\n"));
  const TetMesh mesh = read_mesh(folder / "m.vtk");
  CHECK(mesh.point_arrays.size() == 5);
  REQUIRE(mesh.find("b"));
  CHECK(mesh.find("b")->type == ScalarType::kInt16);
  CHECK(mesh.find("b")->components == 2);
  REQUIRE(mesh.find("e"));
  CHECK(mesh.find("e")->value(3, 0) == 6);
}

TEST_CASE("of arrays of one name in a legacy file the last is read, and that is said", "[vtk]") {
  const TempFolder folder;
  write_bytes(folder / "m.vtk", legacy_text("CELLS 1 5\n4 0 1 2 3", "CELL_TYPES 1\n10",
                                            "POINT_DATA 4\nSCALARS a float\nLOOKUP_TABLE default\n1 2 3 4\n"
                                            "SCALARS A float\nLOOKUP_TABLE default\n1 2 3 4\n"
                                            "FIELD more 1\na 1 4 float\n9 8 7 6\n"
                                            "CELL_DATA 1\nSCALARS A float\nLOOKUP_TABLE default\n1\n"));
  ReadReport report;
  const TetMesh mesh = read_mesh(folder / "m.vtk", &report);
  CHECK(mesh.point_arrays.size() == 2);
  REQUIRE(mesh.find("a"));
  CHECK(mesh.find("a")->value(0, 0) == 9);
  const std::string about = "several point arrays are called ";
  CHECK(std::count(report.notes.begin(), report.notes.end(), about + "'a': only the last of them is read") == 1);
  CHECK(std::none_of(report.notes.begin(), report.notes.end(),
                     [&](const std::string& note) { return note.starts_with(about + "'A'"); }));
}

TEST_CASE("an Exodus file without time steps has no values", "[vtk]") {
  std::string bytes = read_bytes(fixture("two_blocks.ex2"));
  bytes.replace(4, 4, std::string(4, '\0')); // the steps, in the classic format
  const TempFolder folder;
  write_bytes(folder / "mesh.ex2", bytes);
  ReadReport report;
  const TetMesh mesh = read_mesh(folder / "mesh.ex2", &report);
  CHECK(mesh.tets == read_mesh(fixture("two_blocks.ex2")).tets);
  CHECK(mesh.point_arrays.empty());
  CHECK(std::count(report.notes.begin(), report.notes.end(),
                   "nodal variables have no values: the file has no time steps") == 1);
}

TEST_CASE("numbers of an Exodus file are of its type", "[vtk]") {
  ReadReport report;
  const TetMesh doubles = read_mesh(fixture("two_blocks.ex2"));
  const TetMesh floats = read_mesh(fixture("two_blocks_of_floats.ex2"), &report);
  CHECK(floats.tets == doubles.tets);
  CHECK(floats.positions.type == ScalarType::kFloat32);
  REQUIRE(floats.point_arrays.size() == doubles.point_arrays.size());
  const auto same = [](const PointArray& a, const PointArray& b) {
    for (std::size_t i = 0; i < 8; ++i)
      for (std::uint32_t c = 0; c < a.components; ++c)
        if (a.value(i, c) != b.value(i, c)) return false;
    return a.components == b.components;
  };
  CHECK(same(floats.positions, doubles.positions));
  for (const PointArray& array : floats.point_arrays) {
    INFO(array.name);
    CHECK(array.type == ScalarType::kFloat32);
    REQUIRE(doubles.find(array.name));
    CHECK(same(array, *doubles.find(array.name)));
  }

  // A file that says so of doubles.
  std::string bytes = read_bytes(fixture("two_blocks.ex2"));
  const std::string name = "floating_point_word_size";
  const std::size_t at = bytes.find(name) + name.size() + 8; // after its type and length
  REQUIRE(bytes.substr(at, 4) == std::string("\0\0\0\x08", 4));
  bytes[at + 3] = 4;
  const std::size_t value = bytes.rfind(std::string("\x3f\xf0\0\0\0\0\0\0", 8)); // a 1 among the last values
  REQUIRE(value != std::string::npos);
  bytes[value + 7] = 1;
  const TempFolder folder;
  write_bytes(folder / "mesh.ex2", bytes);
  const TetMesh mixed = read_mesh(folder / "mesh.ex2");
  CHECK(mixed.positions.type == ScalarType::kFloat32);
  CHECK(mixed.find("f")->type == ScalarType::kFloat32);
  CHECK(mixed.find("v")->type == ScalarType::kFloat64);
  CHECK(mixed.find("v")->value(7, 2) == 1 + 0x1p-52);
}

TEST_CASE("the blocks of an Exodus file come in its order, whatever their ids", "[vtk]") {
  const TetMesh ascending = read_mesh(fixture("two_blocks.ex2"));
  std::string bytes = read_bytes(fixture("two_blocks.ex2"));
  const std::string ids("\0\0\0\1\0\0\0\2", 8);
  const std::size_t at = bytes.rfind(ids); // of the blocks; their status has the same numbers before
  REQUIRE(at != std::string::npos);
  bytes.replace(at, ids.size(), std::string("\0\0\0\7\0\0\0\3", 8));
  const TempFolder folder;
  write_bytes(folder / "mesh.ex2", bytes);
  CHECK(read_mesh(folder / "mesh.ex2").tets == ascending.tets);
}

TEST_CASE("reading can be watched and cancelled", "[vtk]") {
  const TempFolder folder;
  write_mesh(folder / "mesh.vtu", grid({}));
  int calls = 0;
  (void)read_mesh(folder / "mesh.vtu", nullptr, [&](const Progress& progress) {
    CHECK(progress.done <= progress.total);
    return ++calls > 0;
  });
  CHECK(calls > 0);
  try {
    (void)read_mesh(folder / "mesh.vtu", nullptr, [](const Progress&) { return false; });
    FAIL("nothing was thrown");
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::kCancelled);
  }
}

TEST_CASE("the hash of an input is the XXH64 of its files", "[vtk]") {
  const TempFolder folder;
  write_bytes(folder / "empty", "");
  write_bytes(folder / "abc", "abc");
  CHECK(hash_input(folder / "empty") == "xxh64:ef46db3751d8e999");
  CHECK(hash_input(folder / "abc") == "xxh64:44bc2cf5ad770999");
  write_bytes(folder / "a", "a");
  write_bytes(folder / "bc", "bc");
  CHECK(hash_input(folder / "a", {folder / "bc"}) == hash_input(folder / "abc"));
  CHECK_THROWS_AS(hash_input(folder / "a", {folder / "none"}), Error);
}

TEST_CASE("names of arrays that are not UTF-8 are read as Latin-1, and no file is built with others", "[vtk]") {
  ReadReport report;
  TetMesh mesh = read_text(legacy_text("CELLS 1 5\n4 0 1 2 3", "CELL_TYPES 1\n10",
                                       "POINT_DATA 4\nSCALARS Temp\xE9rature float\nLOOKUP_TABLE default\n1 2 3 4\n"),
                           &report);
  CHECK(mesh.point_arrays.front().name == "Temp\xC3\xA9rature");
  CHECK(has_note(report, "not UTF-8, and was read as Latin-1"));
  mesh.point_arrays.front().name = "Temp\xE9rature";
  CHECK_THROWS_WITH(build_memory(mesh, {}), Catch::Contains("Temp\xC3\xA9rature' is not text in UTF-8"));
  mesh.point_arrays.front().name = "t";
  const auto dataset = Dataset::open_memory(build_memory(mesh, {}, nullptr, "caf\xE9.vtu"));
  CHECK(dataset->info().provenance_json.find("caf\xC3\xA9.vtu") != std::string::npos);
}
