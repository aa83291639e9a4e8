#include "formats/vtk/read.hpp"
#include "formats/vtk/write.hpp"
#include "mesh/scalar_dispatch.hpp"
#include "ptet/error.hpp"
#include "support/meshes.hpp"
#include "support/temp_folder.hpp"

#include <csignal>
#include <limits>
#include <optional>
#include <random>

#include <catch2/catch.hpp>
#include <sys/resource.h>
#include <vtkNew.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLUnstructuredGridReader.h>
#include <vtkXMLUnstructuredGridWriter.h>

using namespace ptet;
using namespace ptet::test;

namespace {

/// Every type with 1, 3 and 9 components; extremes first, then noise.
void add_arrays_of_all_types(TetMesh& mesh) {
  std::mt19937_64 random(7);
  for (int type = 0; type <= static_cast<int>(ScalarType::kFloat64); ++type) {
    for (const std::uint32_t components : {1u, 3u, 9u}) {
      PointArray array;
      array.type = static_cast<ScalarType>(type);
      array.components = components;
      array.name = std::string(name_of(array.type)) + " x" + std::to_string(components);
      array.resize(mesh.vertex_count());
      dispatch(array.type, [&]<class T>(T) {
        for (std::size_t i = 0; i * sizeof(T) < array.bytes.size(); ++i) {
          T value;
          if (i == 0)
            value = std::numeric_limits<T>::max();
          else if (i == 1)
            value = std::numeric_limits<T>::lowest();
          else if (i == 2)
            value = std::numeric_limits<T>::min();
          else if constexpr (std::is_floating_point_v<T>)
            value = std::uniform_real_distribution<T>(-1, 1)(random) * (i % 2 ? T(1) : T(1e-30));
          else
            value = static_cast<T>(random());
          store(array.bytes.data() + i * sizeof(T), value);
        }
      });
      mesh.point_arrays.push_back(std::move(array));
    }
  }
}

/// -0 becomes 0 in every floating-point array: VTK's decimal numbers have one zero.
void drop_signs_of_zeros(TetMesh& mesh) {
  for (PointArray& array : mesh.point_arrays) {
    dispatch(array.type, [&]<class T>(T) {
      for (std::size_t at = 0; at < array.bytes.size(); at += sizeof(T)) {
        if (load<T>(array.bytes.data() + at) == T(0)) store(array.bytes.data() + at, T(0));
      }
    });
  }
}

void check_same(const TetMesh& a, const TetMesh& b) {
  CHECK(a.positions.type == b.positions.type);
  CHECK((a.positions.bytes == b.positions.bytes));
  CHECK((a.tets == b.tets));
  REQUIRE(a.point_arrays.size() == b.point_arrays.size());
  for (std::size_t i = 0; i < a.point_arrays.size(); ++i) {
    INFO(a.point_arrays[i].name);
    CHECK(a.point_arrays[i].name == b.point_arrays[i].name);
    CHECK(a.point_arrays[i].type == b.point_arrays[i].type);
    CHECK(a.point_arrays[i].components == b.point_arrays[i].components);
    CHECK((a.point_arrays[i].bytes == b.point_arrays[i].bytes));
  }
}

ErrorCode code_of_writing(const std::string& path, const TetMesh& mesh, const WriteOptions& options = {},
                          const ProgressCallback& progress = {}) {
  try {
    write_mesh(path, mesh, options, progress);
  } catch (const Error& error) {
    return error.code();
  }
  FAIL("nothing was thrown");
  return {};
}

/// Writes a VTU anew by VTK: the data of each array by itself, in base64 or in decimal numbers.
void recode(const std::string& path, int data_mode) {
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  reader->SetFileName(path.c_str());
  reader->Update();
  vtkNew<vtkXMLUnstructuredGridWriter> writer;
  writer->SetInputData(reader->GetOutput());
  writer->SetFileName(path.c_str());
  writer->SetDataMode(data_mode);
  REQUIRE(writer->Write() == 1);
}

} // namespace

TEST_CASE("all types and component counts come back bit for bit from VTU", "[vtk]") {
  const auto position_type = GENERATE(ScalarType::kFloat32, ScalarType::kFloat64);
  const auto data_mode = GENERATE(vtkXMLWriter::Appended, vtkXMLWriter::Binary, vtkXMLWriter::Ascii);
  const auto compressor = GENERATE(Compressor::kNone, Compressor::kZlib);
  TetMesh mesh = grid({});
  if (position_type == ScalarType::kFloat64) {
    TetMesh wide = mesh;
    wide.positions = {"", ScalarType::kFloat64, 3, {}};
    wide.positions.resize(mesh.vertex_count());
    for (std::size_t i = 0; i < 3 * mesh.vertex_count(); ++i)
      store(wide.positions.bytes.data() + 8 * i, mesh.positions.value(i / 3, i % 3) / 3);
    mesh = wide;
  }
  add_arrays_of_all_types(mesh);
  if (data_mode == vtkXMLWriter::Ascii) drop_signs_of_zeros(mesh);
  const TempFolder folder;
  write_mesh(folder / "mesh.vtu", mesh, {compressor, {}});
  if (data_mode != vtkXMLWriter::Appended) recode(folder / "mesh.vtu", data_mode);
  ReadReport report;
  check_same(read_mesh(folder / "mesh.vtu", &report), mesh);
  CHECK(report.format == "VTU");
  CHECK(report.notes.empty());
  CHECK(folder.names().size() == 1);
}

TEST_CASE("all types and component counts come back bit for bit from legacy VTK", "[vtk]") {
  TetMesh mesh = grid({});
  add_arrays_of_all_types(mesh);
  const TempFolder folder;
  write_mesh(folder / "mesh.vtk", mesh);
  ReadReport report;
  check_same(read_mesh(folder / "mesh.vtk", &report), mesh);
  CHECK(report.format == "legacy VTK");
}

TEST_CASE("names with blanks, marks and other alphabets come back", "[vtk]") {
  const auto ending = GENERATE("vtu", "vtk");
  TetMesh mesh = single_tet();
  for (const char* name : {"two words", "<\"a\" & 'b'>", "Größe µ 温度", "%20", "a/b[c]", "tab\tnew\nline"})
    add_array(mesh, name, ScalarType::kFloat32, 1, [](const Point& p) { return std::vector<double>{p[0]}; });
  const TempFolder folder;
  const std::string path = folder / (std::string("mesh.") + ending);
  write_mesh(path, mesh);
  check_same(read_mesh(path), mesh);
}

TEST_CASE("a name that XML cannot hold is refused", "[vtk]") {
  const std::string name = GENERATE("\x01", "caf\xE9", "\xC3", "\xFF\xFE");
  TetMesh mesh = single_tet();
  add_array(mesh, name, ScalarType::kFloat32, 1, [](const Point& p) { return std::vector<double>{p[0]}; });
  const TempFolder folder;
  CHECK(code_of_writing(folder / "mesh.vtu", mesh) == ErrorCode::kBadInput);
  CHECK(folder.names().empty());
}

TEST_CASE("values that are not finite come back from binary files", "[vtk]") {
  const bool is_base64 = GENERATE(false, true);
  TetMesh mesh = single_tet();
  add_array(mesh, "f", ScalarType::kFloat64, 1, [](const Point& p) {
    return std::vector<double>{p[0] > 0   ? std::numeric_limits<double>::quiet_NaN()
                               : p[1] > 0 ? -std::numeric_limits<double>::infinity()
                                          : -0.0};
  });
  const TempFolder folder;
  write_mesh(folder / "mesh.vtu", mesh);
  if (is_base64) recode(folder / "mesh.vtu", vtkXMLWriter::Binary);
  check_same(read_mesh(folder / "mesh.vtu"), mesh);
}

TEST_CASE("headers and ids of a small mesh are 32-bit", "[vtk]") {
  const TempFolder folder;
  write_mesh(folder / "mesh.vtu", single_tet());
  const std::string text = read_bytes(folder / "mesh.vtu");
  CHECK(text.find("header_type=\"UInt32\"") != std::string::npos);
  CHECK(text.find("vtkZLibDataCompressor") != std::string::npos);
  CHECK(text.find("type=\"Int32\" Name=\"connectivity\"") != std::string::npos);
}

TEST_CASE("cell arrays are written", "[vtk]") {
  const TetMesh mesh = two_tets_sharing_a_face();
  const TempFolder folder;
  WriteOptions options;
  options.cell_arrays = {{"error", std::vector<float>{0.25F, 8}},
                         {"made_by", std::vector<std::uint32_t>{7, 4294967295U}}};
  write_mesh(folder / "mesh.vtu", mesh, options);
  recode(folder / "mesh.vtu", vtkXMLWriter::Ascii);
  const std::string text = read_bytes(folder / "mesh.vtu");
  CHECK(text.find("0.25 8") != std::string::npos);
  CHECK(text.find("7 4294967295") != std::string::npos);
  ReadReport report;
  check_same(read_mesh(folder / "mesh.vtu", &report), mesh);
  CHECK(report.notes ==
        std::vector<std::string>{"cell array 'error' is not carried", "cell array 'made_by' is not carried"});
  CHECK(report.cell_arrays == std::vector<std::string>{"error", "made_by"});
}

TEST_CASE("an empty mesh is written", "[vtk]") {
  const TempFolder folder;
  write_mesh(folder / "mesh.vtu", TetMesh{});
  CHECK_THROWS_WITH(read_mesh(folder / "mesh.vtu"), Catch::Contains("holds no cells: ptet needs tetrahedra"));
}

TEST_CASE("a mesh that does not hold together is not written", "[vtk]") {
  const TempFolder folder;
  const std::string path = folder / "mesh.vtu";
  TetMesh mesh = single_tet();
  SECTION("a vertex that is not there") {
    mesh.tets[0][2] = VertexId(4);
    CHECK(code_of_writing(path, mesh) == ErrorCode::kBadInput);
  }
  SECTION("a short array") {
    mesh.point_arrays.push_back({"f", ScalarType::kFloat64, 1, std::vector<std::byte>(31)});
    CHECK(code_of_writing(path, mesh) == ErrorCode::kBadInput);
  }
  SECTION("two arrays of one name") {
    mesh.point_arrays.assign(2, {"f", ScalarType::kFloat64, 1, std::vector<std::byte>(32)});
    CHECK(code_of_writing(path, mesh) == ErrorCode::kBadInput);
  }
  SECTION("names that no XML can hold") {
    const std::string name = GENERATE("\xED\xA0\x80", "\xE0\x80\x80", "\xF0\x80\x80\x80", "\xF4\x90\x80\x80",
                                      "\xC0\x80", "\xEF\xBF\xBE", "\xEF\xBF\xBF", "\xE2\x82", "\xFF", "\x01");
    mesh.point_arrays.push_back({"a" + name, ScalarType::kFloat64, 1, std::vector<std::byte>(32)});
    CHECK(code_of_writing(path, mesh) == ErrorCode::kBadInput);
  }
  SECTION("names that are too long for legacy VTK") {
    const auto [name, code] =
        GENERATE(table<std::string, std::optional<ErrorCode>>({{std::string(255, 'n'), std::nullopt},
                                                               {std::string(256, 'n'), ErrorCode::kBadInput},
                                                               {std::string(85, ' '), std::nullopt},
                                                               {std::string(86, ' '), ErrorCode::kBadInput}}));
    mesh.point_arrays.push_back({name, ScalarType::kFloat64, 1, std::vector<std::byte>(32)});
    if (code) {
      CHECK(code_of_writing(folder / "mesh.vtk", mesh) == *code);
    } else {
      const TempFolder other;
      write_mesh(other / "mesh.vtk", mesh);
      CHECK(read_mesh(other / "mesh.vtk").point_arrays.at(0).name == name);
    }
  }
  SECTION("a cell array of another length") {
    CHECK(code_of_writing(path, mesh, {{}, {{"e", std::vector<float>(2)}}}) == ErrorCode::kBadArgument);
  }
  SECTION("another ending") {
    CHECK(code_of_writing(folder / "mesh.xyz", mesh) == ErrorCode::kBadArgument);
  }
  CHECK(folder.names().empty());
}

TEST_CASE("what cannot be written leaves nothing behind", "[vtk]") {
  const TempFolder folder;
  const TetMesh mesh = grid({});
  const auto ending = GENERATE("vtu", "vtk");
  const std::string path = folder / (std::string("mesh.") + ending);

  SECTION("no such folder") {
    CHECK_THROWS_WITH(write_mesh(folder / "none" + "/" + "mesh.vtu", mesh), Catch::Contains("No such file"));
    CHECK(folder.names().empty());
  }
  SECTION("a folder of that name") {
    std::filesystem::create_directory(path);
    CHECK_THROWS_WITH(write_mesh(path, mesh), Catch::Contains("it is a folder"));
    CHECK(folder.names().size() == 1);
  }
  SECTION("not a regular file") {
    CHECK(code_of_writing(std::string("/dev/") + "null", mesh) == ErrorCode::kBadArgument);
    std::filesystem::create_symlink("/dev/null", path);
    CHECK_THROWS_WITH(write_mesh(path, mesh), Catch::Contains("not a regular file"));
    CHECK(std::filesystem::is_symlink(path));
  }
  SECTION("cancelled") {
    write_bytes(path, "old");
    CHECK(code_of_writing(path, mesh, {}, [](const Progress&) { return false; }) == ErrorCode::kCancelled);
    CHECK(folder.names().size() == 1);
    CHECK(read_bytes(path) == "old");
  }
}

TEST_CASE("a disk that fills up is an error at every point of the file", "[vtk]") {
  const TempFolder folder;
  const TetMesh mesh = grid({});
  const auto ending = GENERATE("vtu", "vtk");
  const std::string path = folder / (std::string("mesh.") + ending);
  write_mesh(path, mesh);
  const auto size = static_cast<rlim_t>(std::filesystem::file_size(path));
  write_bytes(path, "old");

  // A limit on the size of files stands for the end of the disk; the signal that goes with it is ignored.
  rlimit before{};
  REQUIRE(::getrlimit(RLIMIT_FSIZE, &before) == 0);
  const auto previous = std::signal(SIGXFSZ, SIG_IGN);
  for (const rlim_t room : {rlim_t{0}, rlim_t{100}, size / 2, size - 1}) {
    rlimit limit = before;
    limit.rlim_cur = room;
    REQUIRE(::setrlimit(RLIMIT_FSIZE, &limit) == 0);
    ErrorCode code{};
    try {
      write_mesh(path, mesh);
    } catch (const Error& error) {
      code = error.code();
    }
    REQUIRE(::setrlimit(RLIMIT_FSIZE, &before) == 0);
    INFO("room for " << room << " of " << size << " bytes");
    CHECK(code == ErrorCode::kIo);
    CHECK(folder.names().size() == 1);
    CHECK(read_bytes(path) == "old");
  }
  std::signal(SIGXFSZ, previous);
}
