// Mesh files that are damaged, or not what they say.
#include "formats/vtk/read.hpp"
#include "formats/vtk/write.hpp"
#include "ptet/error.hpp"
#include "support/meshes.hpp"
#include "support/temp_folder.hpp"
#include "vtk_fixture.hpp"

#include <algorithm>
#include <random>

#include <catch2/catch.hpp>

using namespace ptet;
using namespace ptet::test;

TEST_CASE("a VTU that lies is bad input", "[vtk]") {
  VtuText text;
  REQUIRE(read_text(text.file()).tets.size() == 1);
  std::string part;
  SECTION("more points than there are") {
    text.counts = R"(NumberOfPoints="5" NumberOfCells="1")";
  }
  SECTION("more points than any file holds") {
    text.counts = R"(NumberOfPoints="99999999999" NumberOfCells="1")";
    part = "more than the file can hold";
  }
  SECTION("more cells than any file holds") {
    text.counts = R"(NumberOfPoints="4" NumberOfCells="99999999999")";
    part = "more than the file can hold";
  }
  SECTION("a negative count") {
    text.counts = R"(NumberOfPoints="-4" NumberOfCells="1")";
  }
  SECTION("no counts") {
    text.counts = "";
  }
  SECTION("two coordinates") {
    text.points = R"(<DataArray type="Float32" NumberOfComponents="2" format="ascii">0 0 1 0 0 1 1 1</DataArray>)";
    part = "do not have three coordinates";
  }
  SECTION("positions of no type") {
    text.points =
        R"(<DataArray type="Floaty" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 0 1 0 0 0 1</DataArray>)";
  }
  SECTION("a short array") {
    text.point_data = array_text("Name=\"f\"", "1 2 3");
    part = "array 'f' holds 3 values where 4 belong";
  }
  SECTION("an array of a billion components") {
    text.point_data = array_text("Name=\"f\"", "1 2 3 4", "NumberOfComponents=\"1000000000\"");
  }
  SECTION("an array of an unknown type") {
    text.point_data = R"(<DataArray type="Float128" Name="f" format="ascii">1 2 3 4</DataArray>)";
  }
  SECTION("an element that is no array") {
    text.point_data = "<Cat Name=\"f\"/>";
  }
  SECTION("an id beyond the points") {
    text.connectivity = "0 1 2 4";
    part = "cell 0 uses point 4, and there are 4 points";
  }
  SECTION("a negative id") {
    text.connectivity = "0 1 2 -1";
    part = "cell 0 uses point -1, and there are 4 points";
  }
  SECTION("short connectivity") {
    text.connectivity = "0 1 2";
  }
  SECTION("a tet of three") {
    text.offsets = "3";
    text.connectivity = "0 1 2";
    part = "cell 0, a tetrahedron, has 3 points";
  }
  SECTION("offsets that reach for everything") {
    text.offsets = "2305843009213693953";
  }
  SECTION("negative offsets") {
    text.offsets = "-4";
  }
  SECTION("offsets that go back") {
    text.counts = R"(NumberOfPoints="4" NumberOfCells="2")";
    text.offsets = "8 4";
    text.types = "10 10";
    text.connectivity = "0 1 2 3 0 1 2 3";
  }
  SECTION("no types") {
    text.types = "";
  }
  SECTION("a type beyond a byte") {
    text.types = "266";
    part = "value 0 of array 'types', '266', is out of range (UInt8)";
  }
  SECTION("components that are no number") {
    text.point_data = array_text("Name=\"f\"", "1 2 3 4", "NumberOfComponents=\"-1\"");
    part = "array 'f' has '-1' for its NumberOfComponents";
  }
  SECTION("three times the values") {
    text.point_data = array_text("Name=\"f\"", "1 2 3 4 5 6 7 8 9 10 11 12");
    part = "array 'f' holds 12 values where 4 belong; is its NumberOfComponents right?";
  }
  SECTION("three times the values, encoded") {
    // 48 bytes, of which floats need 16.
    text.point_data =
        R"(<DataArray type="Float32" Name="f" format="binary">MAAAAAAAAAA=)" + std::string(64, 'A') + "</DataArray>";
    part = "array 'f' holds 12 values where 4 belong";
  }
  const Failure failure = failure_of_text(text.file());
  CHECK((failure.code == ErrorCode::kBadInput || failure.code == ErrorCode::kLimit));
  CHECK_THAT(failure.message, Catch::Contains(part));
}

TEST_CASE("numbers in text that their type cannot hold are refused, not wrapped", "[vtk]") {
  struct Case {
    const char* type; // in a VTU
    const char* legacy_type;
    const char* value;
    const char* part; // of what is said; null: nothing, it is as good as any
  };
  const Case one = GENERATE(values<Case>({
      {"Int8", "signed_char", "127", nullptr},
      {"Int8", "signed_char", "-129", "is out of range"},
      {"UInt8", "unsigned_char", "+255", nullptr},
      {"UInt8", "unsigned_char", "256", "is out of range"},
      {"UInt16", "unsigned_short", "-1", "is out of range"},
      {"Int16", "short", "1.5", "is not an integer"},
      {"UInt32", "unsigned_int", "-1", "is out of range"},
      {"Int32", "int", "x", "is not a number"},
      {"UInt64", "unsigned_long", "-1", "is out of range"},
      {"UInt64", "vtktypeuint64", "18446744073709551615", nullptr},
      {"Int64", "vtktypeint64", "9223372036854775808", "is out of range"},
      {"Float32", "float", "1e39", "is out of range"},
      {"Float32", "float", "1e-50", nullptr},
      {"Float64", "double", "+.5e-3", nullptr},
      {"Float64", "double", "0,5", "is not a number"},
      {"Float64", "double", "+-5", "is not a number"},
  }));
  CAPTURE(one.type, one.value);
  const std::string values = std::string("1 ") + one.value + " 3 4";
  VtuText text;
  text.point_data =
      R"(<DataArray type=")" + std::string(one.type) + R"(" Name="f" format="ascii">)" + values + "</DataArray>";
  const std::string legacy =
      legacy_text("CELLS 1 5\n4 0 1 2 3", "CELL_TYPES 1\n10",
                  "POINT_DATA 4\nSCALARS f " + std::string(one.legacy_type) + "\nLOOKUP_TABLE default\n" + values);
  if (!one.part) {
    CHECK(read_text(text.file()).point_arrays.front().value(0, 0) == 1);
    CHECK(read_text(legacy).point_arrays.front().value(0, 0) == 1);
    return;
  }
  const std::string place = "value 1 of array 'f', '" + std::string(one.value) + "'";
  CHECK_THAT(failure_of_text(text.file()).message, Catch::Contains(place) && Catch::Contains(one.part));
  CHECK_THAT(failure_of_text(legacy, "mesh.vtk").message, Catch::Contains(place) && Catch::Contains(one.part));
}

TEST_CASE("a VTU may end with as much white space as it likes", "[vtk]") {
  CHECK(read_text(VtuText().file() + std::string(10'000, '\n')).tets.size() == 1);
  CHECK_THAT(failure_of_text(VtuText().file() + "<!--" + std::string(10'000, '.') + "-->").message,
             Catch::Contains("does not end with </VTKFile>"));
}

TEST_CASE("numbers that are none cannot be read from text, and that is said", "[vtk]") {
  VtuText text;
  text.point_data = array_text("Name=\"f\"", "1 2 3 nan"); // at the end VTK does not take it
  CHECK_THAT(failure_of_text(text.file()).message, Catch::Contains("there is a 'nan' or 'inf' in it"));
  const std::string legacy = "# vtk DataFile Version 3.0\nmesh\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n"
                             "0 0 0 1 0 0 0 1 0 0 0 1\nCELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\nPOINT_DATA 4\n"
                             "SCALARS f float\nLOOKUP_TABLE default\n1 2 -Inf 4\n";
  CHECK_THAT(failure_of_text(legacy, "mesh.vtk").message, Catch::Contains("there is a 'nan' or 'inf' in it"));
  // Not of what goes by such a name.
  text.point_data = array_text("Name=\"nan\"", "1 2 3");
  CHECK_THAT(failure_of_text(text.file()).message, !Catch::Contains("'inf'"));
}

TEST_CASE("XML that is broken or of another kind is bad input", "[vtk]") {
  const std::string whole = VtuText().file();
  CHECK_THAT(failure_of_text(whole.substr(0, whole.size() - 20)).message, Catch::Contains("pars"));
  CHECK(failure_of_text("<VTKFile type=\"UnstructuredGrid\">").code == ErrorCode::kBadInput);
  CHECK(failure_of_text("<VTKFile type=\"UnstructuredGrid\"></VTKFile>").code == ErrorCode::kBadInput);
  CHECK(failure_of_text("<VTKFile type=\"UnstructuredGrid\" byte_order=\"Sideways\"></VTKFile>").code ==
        ErrorCode::kBadInput);
  CHECK_THAT(failure_of_text("<VTKFile type=\"PUnstructuredGrid\"><PUnstructuredGrid/></VTKFile>").message,
             Catch::Contains("names no pieces"));
}

TEST_CASE("a second grid in a file is not passed over", "[vtk]") {
  std::string twice = VtuText().file();
  const std::string end = "</UnstructuredGrid>";
  const std::size_t from = twice.find("<UnstructuredGrid>"), to = twice.find(end) + end.size();
  REQUIRE(from < to);
  twice.insert(to, twice.substr(from, to - from));
  CHECK_THAT(failure_of_text(twice).message, Catch::Contains("more than one UnstructuredGrid element"));
  CHECK_THAT(
      failure_of_text("<VTKFile type=\"PUnstructuredGrid\"><PUnstructuredGrid/><PUnstructuredGrid/></VTKFile>").message,
      Catch::Contains("more than one PUnstructuredGrid element"));
}

TEST_CASE("base64 text that ends early or has other characters in it is bad input", "[vtk]") {
  const auto with = [](const std::string& values) {
    VtuText text;
    text.point_data = R"(<DataArray type="Float32" Name="f" format="binary">)" + values + "</DataArray>";
    return text.file();
  };
  const std::string whole = "EAAAAAAAAAAAAIA/AAAAQAAAQEAAAIBA"; // 16 bytes: 1 2 3 4
  REQUIRE(read_text(with(whole)).find("f")->value(3, 0) == 4);
  for (const std::string& broken : {whole.substr(0, 20), whole.substr(0, 16) + "\n" + whole.substr(16),
                                    whole.substr(0, 17) + "*" + whole.substr(18)})
    CHECK_THAT(failure_of_text(with(broken)).message,
               Catch::Contains("array 'f' does not hold the values that it announces"));
}

TEST_CASE("an array whose stated length is wrong is read where all of it is there", "[vtk]") {
  const auto with = [](const std::string& values) {
    VtuText text;
    text.point_data = R"(<DataArray type="Float32" Name="f" format="binary">)" + values + "</DataArray>";
    std::string file = text.file();
    file.replace(file.find("UInt64"), 6, "UInt32");
    return file;
  };
  // In the head 20 as a float, as GetFEM writes it, and then 1 2 3 4; once with a value too many.
  ReadReport report;
  CHECK(read_text(with("AACgQQAAgD8AAABAAABAQAAAgEA="), &report).find("f")->value(3, 0) == 4);
  CHECK(std::any_of(report.notes.begin(), report.notes.end(), [](const std::string& note) {
    return note.find("array 'f' says that it has another length than it has") != std::string::npos;
  }));
  CHECK_THAT(failure_of_text(with("AACgQQAAgD8AAABAAABAQAAAgEAAAIA/")).message, Catch::Contains("array 'f' holds"));
}

TEST_CASE("a compressor that nobody knows is bad input", "[vtk]") {
  std::string text = read_bytes(fixture("meshio_zlib.vtu"));
  text.replace(text.find("vtkZLib"), 7, "vukZLib");
  const Failure failure = failure_of_text(text);
  CHECK(failure.code == ErrorCode::kBadInput);
  CHECK_THAT(failure.message, Catch::Contains("vukZLibDataCompressor"));
}

TEST_CASE("a second part of a piece is not passed over", "[vtk]") {
  VtuText text;
  text.point_data = array_text("Name=\"f\"", "1 2 3 4");
  const std::string whole = text.file();
  const auto part = GENERATE(as<std::string>{}, "Points", "Cells", "PointData");
  const std::string end = "</" + part + ">";
  const std::size_t from = whole.find("<" + part + ">"), to = whole.find(end) + end.size();
  REQUIRE(from < to);
  std::string twice = whole;
  twice.insert(to, whole.substr(from, to - from));
  CHECK_THAT(failure_of_text(twice).message, Catch::Contains("more than one " + part + " element"));
}

TEST_CASE("a legacy file that lies is bad input", "[vtk]") {
  // VTK takes a line that begins with a 0 byte for an empty one, which ends metadata, and goes on with what follows.
  const std::string hidden = std::string("METADATA\n") + '\0' + "\nFIELD FieldData 1\nf 1 4 flo";
  CHECK_THAT(failure_of_text(legacy_text(hidden, ""), "m.vtk").message, Catch::EndsWith("metadata that are no text"));
  CHECK_THAT(failure_of_text(legacy_text("CELLS 1 5\n9 0 1 2 3", "CELL_TYPES 1\n10"), "m.vtk").message,
             Catch::Contains("cell 0 does not fit"));
  CHECK_THAT(failure_of_text(legacy_text("CELLS 2 5\n4 0 1 2 3", "CELL_TYPES 2\n10 10"), "m.vtk").message,
             Catch::Contains("fewer cells"));
  CHECK_THAT(failure_of_text(legacy_text("CELLS 1 5\n4 0 1 2 3", "CELL_TYPES 0\n"), "m.vtk").message,
             Catch::Contains("has 1 cells and 0 cell types"));
  CHECK_THAT(failure_of_text(legacy_text("CELLS 1 999999999999\n4 0 1 2 3", "CELL_TYPES 1\n10"), "m.vtk").message,
             Catch::Contains("more than the file can hold"));
  CHECK_THAT(failure_of_text(legacy_text("CELLS 1 5\n4 0 1 2 7", "CELL_TYPES 1\n10"), "m.vtk").message,
             Catch::Contains("cell 0 uses point 7"));
  CHECK_THAT(failure_of_text(legacy_text("CELLS 1 5\n4 0 1", ""), "m.vtk").message, Catch::EndsWith("is cut short"));
  const auto with = [](const std::string& attributes) {
    return legacy_text("CELLS 1 5\n4 0 1 2 3", "CELL_TYPES 1\n10", attributes);
  };
  CHECK_THAT(failure_of_text(with("POINT_DATA 4\nFIELD f 1\na 1 -4 double\n1 2 3 4\n"), "m.vtk").message,
             Catch::Contains("'-4' is not a count"));
  CHECK_THAT(failure_of_text(with("POINT_DATA 4\nFIELD f 1\na 9999999 4 double\n1 2\n"), "m.vtk").message,
             Catch::Contains("more than the file can hold"));
  CHECK_THAT(failure_of_text(with("POINT_DATA 5\nSCALARS a float\nLOOKUP_TABLE default\n1 2 3 4 5\n"), "m.vtk").message,
             Catch::Contains("has 4 points and data of 5 points"));
  CHECK_THAT(failure_of_text(with("POINT_DATA 4\nSCALARS a float -1\nLOOKUP_TABLE default\n"), "m.vtk").message,
             Catch::Contains("'-1' is not a count"));
  CHECK_THAT(failure_of_text(with("POINT_DATA 4\nLOOKUP_TABLE t -2\n"), "m.vtk").message,
             Catch::Contains("'-2' is not a count"));
  CHECK_THAT(failure_of_text(with("POINT_DATA 4\nVECTORS v float\n1 2 3 4\n"), "m.vtk").message,
             Catch::EndsWith("is cut short"));
  CHECK_THAT(failure_of_text(with("VECTORS v float\n1 2 3 4\n"), "m.vtk").message,
             Catch::Contains("unknown keyword 'vectors'"));
  // By its lowest byte a polyhedron, of many faces.
  CHECK_THAT(failure_of_text(legacy_text("CELLS 1 5\n4 900000000 1 2 3", "CELL_TYPES 1\n298"), "m.vtk").message,
             Catch::Contains("cell 0 has the type 298, and there is none such"));
  CHECK_THAT(failure_of_text("# vtk DataFile Version\"5.1\nt\nASCII\n", "m.vtk").message,
             Catch::Contains("no version"));
  CHECK_THAT(failure_of_text("# vtk DataFile Version 3.0\nt\nASCII\n", "m.vtk").message,
             Catch::Contains("holds no dataset"));
}

TEST_CASE("files cut short anywhere are refused or the same", "[vtk]") {
  const TempFolder folder;
  const auto ending = GENERATE("vtu", "vtk");
  const TetMesh mesh = grid({});
  const std::string path = folder / (std::string("mesh.") + ending);
  write_mesh(path, mesh);
  const std::string bytes = read_bytes(path);
  std::vector<std::size_t> lengths = {bytes.size() - 1};
  std::mt19937 random(3);
  for (int i = 0; i < 60; ++i)
    lengths.push_back(random() % bytes.size());
  for (int i = 1; i <= 40; ++i) // in and between the last arrays
    lengths.push_back(bytes.size() - static_cast<std::size_t>(i) * 21);
  for (const std::size_t length : lengths) {
    INFO(length << " of " << bytes.size() << " bytes");
    write_bytes(path, bytes.substr(0, length));
    try {
      const TetMesh read = read_mesh(path);
      CHECK((read.tets == mesh.tets));
      CHECK((read.positions == mesh.positions));
      CHECK((read.point_arrays == mesh.point_arrays));
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::kBadInput);
    }
  }
}

TEST_CASE("flipped bits are refused or give a mesh whose ids are in range", "[vtk]") {
  const TempFolder folder;
  const auto ending = GENERATE("vtu", "vtk");
  const std::string path = folder / (std::string("mesh.") + ending);
  GridOptions small;
  small.cells = {2, 2, 1};
  write_mesh(path, grid(small));
  const std::string bytes = read_bytes(path);
  std::mt19937 random(5);
  for (int i = 0; i < 400; ++i) {
    std::string damaged = bytes;
    damaged[random() % bytes.size()] ^= static_cast<char>(1U << random() % 8);
    write_bytes(path, damaged);
    try {
      const TetMesh read = read_mesh(path);
      const bool in_range = std::all_of(read.tets.begin(), read.tets.end(), [&](const Tet& tet) {
        return std::all_of(tet.begin(), tet.end(), [&](VertexId v) { return v.index() < read.vertex_count(); });
      });
      CHECK(in_range);
      for (const PointArray& array : read.point_arrays)
        CHECK(array.size() == read.vertex_count());
    } catch (const Error& error) {
      CHECK((error.code() == ErrorCode::kBadInput || error.code() == ErrorCode::kLimit));
    }
  }
}

TEST_CASE("an Exodus file that is damaged is bad input", "[vtk]") {
  const TempFolder folder;
  const std::string path = folder / "mesh.ex2";
  const std::string whole = read_bytes(fixture("two_blocks.ex2"));
  const auto failure_with = [&](const std::string& text, const std::string& other) {
    std::string bytes = whole;
    const std::size_t at = bytes.find(text);
    REQUIRE(at != std::string::npos);
    bytes.replace(at, other.size(), other);
    write_bytes(path, bytes);
    return failure_of(path);
  };
  CHECK(failure_with("num_nodes", "num_modes").code == ErrorCode::kBadInput);
  CHECK(failure_with("num_el_blk", "num_el_bkl").code == ErrorCode::kBadInput);
  CHECK(failure_with("connect2", "connect3").code == ErrorCode::kBadInput);
  // VTK's reader would leave the values and names as it finds them in memory.
  CHECK_THAT(failure_with("vals_nod_var1", "vals_nod_vax1").message, Catch::Contains("cannot be read"));
  CHECK_THAT(failure_with("name_nod_var", "name_nod_vax").message, Catch::Contains("has no name"));
  // It would take the nodes of one element for those of others.
  CHECK_THAT(failure_with("TETRA", "HEXEL").message, Catch::Contains("holds elements 'HEXEL' of 4 nodes"));
  const std::string four("num_nod_per_el1\0\0\0\0\4", 20);
  CHECK_THAT(failure_with(four, std::string("num_nod_per_el1\0\0\0\0\3", 20)).message,
             Catch::Contains("holds elements 'TETRA' of 3 nodes"));
  CHECK_THAT(failure_of(fixture("tets_of_five_nodes.ex2")).message,
             Catch::Contains("holds elements 'TETRA' of 5 nodes"));
  const std::string eight("num_nodes\0\0\0\0\0\0\x08", 16);
  CHECK_THAT(failure_with(eight, std::string("num_nodes\0\0\0\x7F\0\0\x08", 16)).message,
             Catch::Contains("is damaged"));
  for (const std::size_t length : {std::size_t{4}, std::size_t{100}, whole.size() / 2}) {
    write_bytes(path, whole.substr(0, length));
    CHECK(failure_of(path).code == ErrorCode::kBadInput);
  }
  // What is missing of its tables would be read as zeros.
  for (std::size_t missing = 1; missing < whole.size() / 3; missing += missing < 16 ? 1 : 97) {
    write_bytes(path, whole.substr(0, whole.size() - missing));
    CHECK_THAT(failure_of(path).message, Catch::Contains("is cut short"));
  }
}
