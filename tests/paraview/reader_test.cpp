// vtkPtetReader against the library's own answers, in plain VTK.
#include "ptet/dataset.hpp"
#include "vtkPtetReader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <vtkCallbackCommand.h>
#include <vtkCellArray.h>
#include <vtkCellType.h>
#include <vtkCommand.h>
#include <vtkDataArray.h>
#include <vtkErrorCode.h>
#include <vtkFieldData.h>
#include <vtkIdTypeArray.h>
#include <vtkInformation.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkStringArray.h>
#include <vtkUnstructuredGrid.h>

using namespace ptet;

namespace {

std::string golden(const char* name) {
  return std::string(PTET_SOURCE_DIR "/tests/golden/") + name + ".ptet";
}

/// Calls back while it lives.
class Observer {
public:
  Observer(vtkObject& subject, unsigned long event, std::function<void(void*)> heard)
      : subject_(&subject), heard_(std::move(heard)) {
    command_->SetClientData(this);
    command_->SetCallback(
        [](vtkObject*, unsigned long, void* self, void* data) { static_cast<Observer*>(self)->heard_(data); });
    tag_ = subject.AddObserver(event, command_);
  }
  ~Observer() { subject_->RemoveObserver(tag_); }
  Observer(const Observer&) = delete;
  Observer& operator=(const Observer&) = delete;

private:
  vtkSmartPointer<vtkObject> subject_;
  std::function<void(void*)> heard_;
  vtkNew<vtkCallbackCommand> command_;
  unsigned long tag_ = 0;
};

/// The error events of an update, joined; they are not printed.
std::string errors_of(vtkPtetReader& reader) {
  std::string text;
  const auto note = [&](void* data) { text += static_cast<const char*>(data); };
  const Observer by_reader(reader, vtkCommand::ErrorEvent, note);
  const Observer by_pipeline(*reader.GetExecutive(), vtkCommand::ErrorEvent, note);
  reader.Update();
  return text;
}

double scalar(vtkUnstructuredGrid& grid, const std::string& name) {
  vtkDataArray* const array = grid.GetFieldData()->GetArray(name.c_str());
  INFO(name);
  REQUIRE(array != nullptr);
  REQUIRE(array->GetNumberOfTuples() == 1);
  return array->GetComponent(0, 0);
}

std::string limited_by(vtkUnstructuredGrid& grid) {
  auto* const array = vtkStringArray::SafeDownCast(grid.GetFieldData()->GetAbstractArray("limited by"));
  REQUIRE(array != nullptr);
  return array->GetValue(0);
}

/// Four ids in the file, ascending but for an even permutation: one name for all ways to write a tet.
using NamedTet = std::array<std::uint64_t, 4>;
NamedTet named(NamedTet tet) {
  int swaps = 0;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t k = 0; k + 1 < 4 - i; ++k)
      if (tet[k] > tet[k + 1]) {
        std::swap(tet[k], tet[k + 1]);
        ++swaps;
      }
  if (swaps % 2 == 1) std::swap(tet[0], tet[1]);
  return tet;
}

/// The grid is the extraction: the same vertices with the same bits, the same oriented tets, the same errors.
void check_same(vtkUnstructuredGrid& grid, const Extraction& expected, const DatasetInfo& info) {
  REQUIRE(static_cast<std::size_t>(grid.GetNumberOfPoints()) == expected.mesh.vertex_count());
  REQUIRE(static_cast<std::size_t>(grid.GetNumberOfCells()) == expected.mesh.tets.size());
  auto* const ids = vtkIdTypeArray::SafeDownCast(grid.GetPointData()->GetGlobalIds());
  REQUIRE(ids != nullptr);

  std::map<std::uint64_t, std::size_t> row_of;
  for (std::size_t v = 0; v < expected.mesh.vertex_count(); ++v)
    row_of[expected.vertex_in_file[v].index()] = v;
  const auto check_array = [&](const PointArray& array, vtkDataArray* given) {
    INFO(array.name);
    REQUIRE(given != nullptr);
    REQUIRE(static_cast<std::size_t>(given->GetNumberOfComponents()) == array.components);
    REQUIRE(static_cast<std::size_t>(given->GetDataTypeSize()) == size_of(array.type));
    const auto* bytes = static_cast<const std::byte*>(given->GetVoidPointer(0));
    std::size_t different = 0;
    for (std::size_t v = 0; v < expected.mesh.vertex_count(); ++v) {
      const auto at = row_of.find(static_cast<std::uint64_t>(ids->GetValue(static_cast<vtkIdType>(v))));
      REQUIRE(at != row_of.end());
      if (std::memcmp(bytes + v * array.row_bytes(), array.bytes.data() + at->second * array.row_bytes(),
                      array.row_bytes()) != 0)
        ++different;
    }
    CHECK(different == 0);
  };
  check_array(expected.mesh.positions, grid.GetPoints()->GetData());
  for (const PointArray& array : expected.mesh.point_arrays)
    check_array(array, grid.GetPointData()->GetArray(array.name.c_str()));

  std::set<NamedTet> asked, given;
  for (const Tet& tet : expected.mesh.tets) {
    NamedTet name{};
    for (std::size_t i = 0; i < 4; ++i)
      name[i] = expected.vertex_in_file[tet[i].index()].index();
    asked.insert(named(name));
  }
  for (vtkIdType cell = 0; cell < grid.GetNumberOfCells(); ++cell) {
    REQUIRE(grid.GetCellType(cell) == VTK_TETRA);
    vtkIdType count = 0;
    const vtkIdType* corners = nullptr;
    grid.GetCellPoints(cell, count, corners);
    REQUIRE(count == 4);
    NamedTet name{};
    for (std::size_t i = 0; i < 4; ++i)
      name[i] = static_cast<std::uint64_t>(ids->GetValue(corners[i]));
    given.insert(named(name));
  }
  CHECK(asked == given);

  std::size_t governing = 0;
  for (const FieldInfo& field : info.fields) {
    if (!field.governing) continue;
    CHECK(scalar(grid, "error of " + field.name) == expected.field_error[governing]);
    if (!expected.rms_error.empty())
      CHECK(scalar(grid, "RMS error of " + field.name) == Approx(expected.rms_error[governing]).epsilon(1e-9));
    ++governing;
  }
  CHECK(scalar(grid, "domain error") == expected.domain_error);
  if (expected.covered) CHECK(scalar(grid, "covered") == Approx(*expected.covered).epsilon(1e-9));
  CHECK(limited_by(grid) == name_of(expected.limited_by));
  CHECK(scalar(grid, "complete") == 1);
  CHECK(scalar(grid, "tets of the original") == static_cast<double>(info.tets));
  CHECK(scalar(grid, "points of the original") == static_cast<double>(info.vertices));
}

vtkSmartPointer<vtkPtetReader> reader_of(const std::string& path) {
  auto reader = vtkSmartPointer<vtkPtetReader>::New();
  reader->SetFileName(path.c_str());
  reader->GiveFileIdsOn();
  return reader;
}

Point middle(const DatasetInfo& info) {
  Point point{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    point[axis] = (info.box_min[axis] + info.box_max[axis]) / 2;
  return point;
}

} // namespace

TEST_CASE("the reader's meshes and errors are those of the library") {
  for (const char* name : {"tiny", "fields", "double", "no_squared_errors", "pinched", "sheets", "real"}) {
    INFO(name);
    const auto data = Dataset::open(golden(name));
    const DatasetInfo& info = data->info();
    const auto reader = reader_of(golden(name));
    const auto check = [&](const Request& request) {
      REQUIRE(errors_of(*reader).empty());
      const Extraction expected = data->extract(request);
      check_same(*reader->GetOutput(), expected, info);
      return expected.mesh.tets.size();
    };
    // More than there are: the original.
    Request request;
    CHECK(check({}) == info.tets);
    reader->LimitTetsOff();
    check({});

    reader->BoundFieldErrorsOn();
    reader->SetFieldError(20);
    for (const FieldInfo& field : info.fields)
      if (field.governing) request.field_error.push_back({field.name, {0.2, true}});
    CHECK(check(request) < info.tets);

    reader->BoundDomainErrorOn();
    reader->SetDomainError(4);
    request.domain_error = Bound{0.04, true};
    check(request);

    // A bound by name goes before the one on all fields.
    const auto first =
        std::find_if(info.fields.begin(), info.fields.end(), [](const FieldInfo& field) { return field.governing; });
    REQUIRE(first != info.fields.end());
    reader->SetFieldErrorBound(first->name.c_str(), 2);
    for (FieldBound& bound : request.field_error)
      if (bound.field == first->name) bound.bound.value = 0.02;
    check(request);
    reader->ClearFieldErrorBounds();
    reader->BoundFieldErrorsOff();
    reader->BoundDomainErrorOff();

    reader->LimitTetsOn();
    reader->SetMaximumTets(static_cast<vtkIdType>(info.tets / 2));
    request = {};
    request.max_tets = info.tets / 2;
    CHECK(check(request) <= info.tets / 2);

    // Around the focus as little as there is.
    reader->SetMaximumTets(0);
    request.max_tets = 0;
    const Point centre = middle(info);
    reader->SetFocusShape(vtkPtetReader::SPHERE);
    reader->SetSphereCenter(centre[0], centre[1], centre[2]);
    reader->SetSphereRadius(info.diagonal / 8);
    request.focus = {{Sphere{centre, info.diagonal / 8}}};
    check(request);

    reader->SetFocusShape(vtkPtetReader::BOX);
    Box box{centre, centre};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.min[axis] -= 0.125 * info.diagonal;
      box.max[axis] = box.min[axis] + 0.25 * info.diagonal;
    }
    reader->SetBoxPosition(box.min[0], box.min[1], box.min[2]);
    reader->SetBoxLength(0.25 * info.diagonal, 0.25 * info.diagonal, 0.25 * info.diagonal);
    request.focus = {{box}};
    check(request);
    // From the other corner.
    reader->SetBoxPosition(box.max[0], box.min[1], box.min[2]);
    reader->SetBoxLength(box.min[0] - box.max[0], 0.25 * info.diagonal, 0.25 * info.diagonal);
    check(request);
    reader->SetBoxPosition(box.min[0], box.min[1], box.min[2]);
    reader->SetBoxLength(0.25 * info.diagonal, 0.25 * info.diagonal, 0.25 * info.diagonal);

    reader->SetFocusError(3);
    reader->UseFalloffOn();
    reader->SetFalloff(60);
    reader->LimitTetsOff();
    request.max_tets.reset();
    request.focus[0].error = {0.03, true};
    request.focus[0].falloff = Bound{0.6, true};
    check(request);
    reader->LimitTetsOn();
  }
}

TEST_CASE("a turned focus box is where ParaView's box widget has it") {
  const auto data = Dataset::open(golden("real"));
  const DatasetInfo& info = data->info();
  const Point centre = middle(info);
  const auto reader = reader_of(golden("real"));
  reader->SetMaximumTets(0);
  reader->SetFocusShape(vtkPtetReader::BOX);
  const double long_side = info.diagonal / 3, short_side = info.diagonal / 30;
  reader->SetBoxPosition(centre[0], centre[1], centre[2]);
  reader->SetBoxLength(long_side, short_side, 2 * short_side);
  Request request;
  request.max_tets = 0;
  const auto expect = [&](const Point& x, const Point& y, const Point& z) {
    OrientedBox box;
    box.half_axes = {x, y, z};
    for (std::size_t axis = 0; axis < 3; ++axis)
      box.centre[axis] = centre[axis] + x[axis] + y[axis] + z[axis];
    request.focus = {{box}};
    REQUIRE(errors_of(*reader).empty());
    check_same(*reader->GetOutput(), data->extract(request), info);
    return reader->GetOutput()->GetNumberOfCells();
  };
  const double a = long_side / 2, b = short_side / 2, c = short_side;
  // Turned by what leaves no doubt: a third of a quarter turn about z, a quarter about y then x, and so on.
  reader->SetBoxRotation(0, 0, 30);
  const double cosine = std::sqrt(3.0) / 2, sine = 0.5;
  const auto turned = expect({a * cosine, a * sine, 0}, {-b * sine, b * cosine, 0}, {0, 0, c});
  reader->SetBoxRotation(0, 0, 0);
  REQUIRE(errors_of(*reader).empty());
  CHECK(reader->GetOutput()->GetNumberOfCells() != turned);
  // About y: x -> -z, z -> x; then about x: y -> z, z -> -y.
  reader->SetBoxRotation(90, 90, 0);
  expect({0, a, 0}, {0, 0, b}, {c, 0, 0});
  // And then about z: x -> y, y -> -x.
  reader->SetBoxRotation(90, 90, 90);
  expect({-a, 0, 0}, {0, 0, b}, {0, c, 0});
}

TEST_CASE("the same request gives the same grid, bit for bit, whatever came before") {
  const auto ask = [](vtkPtetReader& reader) {
    reader.SetMaximumTets(700);
    reader.SetFocusShape(vtkPtetReader::SPHERE);
    reader.Update();
    auto copy = vtkSmartPointer<vtkUnstructuredGrid>::New();
    copy->DeepCopy(reader.GetOutput());
    return copy;
  };
  const auto bytes_of = [](vtkDataArray* array) {
    const auto* begin = static_cast<const char*>(array->GetVoidPointer(0));
    return std::string(begin, static_cast<std::size_t>(array->GetNumberOfValues() * array->GetDataTypeSize()));
  };
  const auto first = reader_of(golden("real")), second = reader_of(golden("real"));
  first->UpdateInformation();
  const double* range = first->GetSphereCenterRange();
  for (vtkPtetReader* reader : {first.Get(), second.Get()}) {
    reader->SetSphereCenter(range[0], range[2], range[4]);
    reader->SetSphereRadius(first->GetSphereRadiusRange()[1] / 2);
  }
  const auto one = ask(*first);
  second->LimitTetsOff();
  second->Update();
  second->LimitTetsOn();
  second->SetMaximumTets(1500);
  second->Update();
  const auto other = ask(*second);
  REQUIRE(one->GetNumberOfCells() == other->GetNumberOfCells());
  CHECK(bytes_of(one->GetPoints()->GetData()) == bytes_of(other->GetPoints()->GetData()));
  CHECK(bytes_of(one->GetCells()->GetConnectivityArray()) == bytes_of(other->GetCells()->GetConnectivityArray()));
  CHECK(bytes_of(one->GetPointData()->GetArray("t")) == bytes_of(other->GetPointData()->GetArray("t")));
}

TEST_CASE("the arrays that are selected are read") {
  const auto data = Dataset::open(golden("fields"));
  const auto reader = reader_of(golden("fields"));
  reader->GiveFileIdsOff();
  reader->UpdateInformation();
  const auto& fields = data->info().fields;
  REQUIRE(fields.size() >= 2);
  REQUIRE(static_cast<std::size_t>(reader->GetNumberOfPointArrays()) == fields.size());
  for (int i = 0; i < reader->GetNumberOfPointArrays(); ++i)
    CHECK(reader->GetPointArrayName(i) == fields[static_cast<std::size_t>(i)].name);
  CHECK(reader->GetPointArrayName(reader->GetNumberOfPointArrays()) == nullptr);
  CHECK(reader->GetPointArrayName(-1) == nullptr);

  reader->Update();
  const vtkIdType cells = reader->GetOutput()->GetNumberOfCells();
  CHECK(static_cast<std::size_t>(reader->GetOutput()->GetPointData()->GetNumberOfArrays()) == fields.size());
  CHECK(reader->GetOutput()->GetPointData()->GetGlobalIds() == nullptr);
  for (const FieldInfo& off : fields) {
    reader->SetPointArrayStatus(off.name.c_str(), 0);
    CHECK(reader->GetPointArrayStatus(off.name.c_str()) == 0);
    reader->Update();
    vtkPointData& arrays = *reader->GetOutput()->GetPointData();
    CHECK(static_cast<std::size_t>(arrays.GetNumberOfArrays()) == fields.size() - 1);
    CHECK(arrays.GetAbstractArray(off.name.c_str()) == nullptr);
    CHECK(reader->GetOutput()->GetNumberOfCells() == cells);
    reader->SetPointArrayStatus(off.name.c_str(), 1);
  }
  // What is as it was is not read again.
  reader->Update();
  const auto before = reader->GetMTime();
  reader->SetPointArrayStatus(fields[0].name.c_str(), 1);
  CHECK(reader->GetMTime() == before);
}

TEST_CASE("progress is told, and an abort leaves a coarser mesh that the next update finishes") {
  const auto data = Dataset::open(golden("real"));
  const Extraction whole = data->extract({});
  double last = 0;
  std::size_t told = 0;
  bool abort = true, is_stopped = false;
  // Blocks are read by another thread: where all have come before the first look there is nothing left to stop, and the
  // mesh is the whole one.
  for (int attempt = 0; attempt < 100 && !is_stopped; ++attempt) {
    abort = true;
    last = 0;
    told = 0;
    const auto reader = reader_of(golden("real"));
    const Observer progress(*reader, vtkCommand::ProgressEvent, [&](void* part) {
      const double now = *static_cast<double*>(part);
      CHECK(now >= last);
      CHECK(now <= 1);
      last = now;
      ++told;
      if (abort) reader->AbortExecuteOn();
    });
    CHECK(errors_of(*reader).empty());
    CHECK(told > 0);
    vtkUnstructuredGrid& grid = *reader->GetOutput();
    is_stopped = scalar(grid, "complete") == 0;
    if (is_stopped) {
      CHECK(grid.GetNumberOfCells() == static_cast<vtkIdType>(data->info().base_tets));
      CHECK(limited_by(grid) == "loading");
      CHECK(scalar(grid, "error of t") == data->info().max_field_error.at(0));
    } else {
      check_same(grid, whole, data->info());
    }

    abort = false;
    last = 0;
    reader->AbortExecuteOff();
    CHECK(errors_of(*reader).empty());
    check_same(grid, whole, data->info());
  }
  CHECK(is_stopped);
}

TEST_CASE("one piece has it all, the others nothing") {
  const auto reader = reader_of(golden("real"));
  const auto cells = [&](int piece) {
    reader->UpdateInformation();
    reader->UpdatePiece(piece, 3, 0);
    return reader->GetOutput()->GetNumberOfCells();
  };
  CHECK(cells(1) == 0);
  CHECK(reader->GetOutput()->GetNumberOfPoints() == 0);
  CHECK(cells(0) == 2869);
  CHECK(cells(2) == 0);
}

TEST_CASE("what cannot be read or asked is an error event and no mesh") {
  const auto reader = vtkSmartPointer<vtkPtetReader>::New();
  CHECK(errors_of(*reader).find("no file name") != std::string::npos);
  reader->SetFileName("no such file.ptet");
  CHECK(errors_of(*reader).find("cannot open no such file.ptet: No such file") != std::string::npos);
  CHECK(reader->GetErrorCode() == vtkErrorCode::CannotOpenFileError);
  CHECK(reader->GetOutput()->GetNumberOfCells() == 0);
  reader->SetFileName(PTET_SOURCE_DIR "/CMakeLists.txt");
  CHECK(errors_of(*reader).find("CMakeLists.txt") != std::string::npos);
  CHECK(reader->GetErrorCode() == vtkErrorCode::FileFormatError);
  CHECK(reader->CanReadFile(PTET_SOURCE_DIR "/CMakeLists.txt") == 0);
  CHECK(reader->CanReadFile("no such file.ptet") == 0);
  CHECK(reader->CanReadFile(golden("tiny").c_str()) == 1);

  reader->SetFileName(golden("tiny").c_str());
  CHECK(errors_of(*reader).empty());
  CHECK(reader->GetOutput()->GetNumberOfCells() == 48);
  reader->SetFieldErrorBound("no such field", 1);
  CHECK(errors_of(*reader).find("no such field") != std::string::npos);
  CHECK(reader->GetErrorCode() == vtkErrorCode::UserError);
  CHECK(reader->GetOutput()->GetNumberOfCells() == 0);
  reader->ClearFieldErrorBounds();
  reader->SetFocusShape(vtkPtetReader::SPHERE);
  reader->SetSphereRadius(-1);
  CHECK_FALSE(errors_of(*reader).empty());
  reader->SetSphereRadius(1);
  CHECK(errors_of(*reader).empty());
  CHECK(reader->GetOutput()->GetNumberOfCells() == 48);
}

TEST_CASE("a damaged block is an error event and a coarser mesh") {
  std::ifstream whole(golden("real"), std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(whole)), std::istreambuf_iterator<char>());
  const std::string path = (std::filesystem::temp_directory_path() / "ptet-damaged-reader-test.ptet").string();
  // Each place in turn: where it matters to opening there is no mesh, in a block a coarser one.
  std::size_t refused = 0, coarser = 0;
  for (std::size_t at = 64; at < bytes.size(); at += bytes.size() / 40) {
    bytes[at] = static_cast<char>(bytes[at] ^ 0x55);
    std::ofstream(path, std::ios::binary) << bytes;
    bytes[at] = static_cast<char>(bytes[at] ^ 0x55);
    const auto reader = reader_of(path);
    const std::string errors = errors_of(*reader);
    INFO(at);
    CHECK_FALSE(errors.empty());
    CHECK(reader->GetErrorCode() == vtkErrorCode::FileFormatError);
    vtkUnstructuredGrid& grid = *reader->GetOutput();
    if (grid.GetNumberOfCells() == 0) {
      ++refused;
      continue;
    }
    ++coarser;
    CHECK(grid.GetNumberOfCells() < 2869);
    CHECK(scalar(grid, "complete") == 0);
    CHECK(limited_by(grid) == "unreadable");
    CHECK(errors.find("coarser") != std::string::npos);
  }
  std::filesystem::remove(path);
  CHECK(refused > 0);
  CHECK(coarser > 0);
}

TEST_CASE("the reader tells the ranges that the interface begins with, and describes itself") {
  const auto data = Dataset::open(golden("real"));
  const DatasetInfo& info = data->info();
  const auto reader = reader_of(golden("real"));
  reader->UpdateInformation();
  double least = info.diagonal;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double length = info.box_max[axis] - info.box_min[axis];
    CHECK(reader->GetBoxPositionRange()[2 * axis] == info.box_min[axis]);
    CHECK(reader->GetBoxPositionRange()[2 * axis + 1] == Approx(info.box_max[axis] - length / 2));
    CHECK(reader->GetBoxLengthRange()[2 * axis] == 0);
    CHECK(reader->GetBoxLengthRange()[2 * axis + 1] == length);
    CHECK(reader->GetSphereCenterRange()[2 * axis] == info.box_min[axis]);
    CHECK(reader->GetSphereCenterRange()[2 * axis + 1] == info.box_max[axis]);
    least = std::min(least, length);
  }
  CHECK(reader->GetSphereRadiusRange()[1] == least / 2);
  reader->SetFieldErrorBound("t", 2.5);
  std::ostringstream text;
  reader->Print(text);
  CHECK(text.str().find("FieldErrorBound: t 2.5") != std::string::npos);
  CHECK(text.str().find("PointArray: t\n") != std::string::npos);
}
