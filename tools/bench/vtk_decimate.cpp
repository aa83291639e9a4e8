// The peer: VTK's quadric decimation of a tetrahedral mesh, timed, and nothing else.
//
//   vtk_decimate MESH.vtu FRACTION [FIELD] [-o OUT.vtu]   to that fraction of the tets; prints one JSON object
//
// The filter compares with absolute tolerances, and on small numbers it stops early. So it is given the mesh with a
// diagonal, and the field with a range, of 1000; in OUT they are the mesh's own again.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include <vtkDataArray.h>
#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkUnstructuredGrid.h>
#include <vtkUnstructuredGridQuadricDecimation.h>
#include <vtkXMLUnstructuredGridReader.h>
#include <vtkXMLUnstructuredGridWriter.h>

namespace {

constexpr double kSize = 1000;

/// x -> (x - low) scale, or back.
struct Scaling {
  double low[3] = {0, 0, 0};
  double scale = 1;
  bool back = false;

  [[nodiscard]] double operator()(double x, int axis) const {
    return back ? x / scale + low[axis] : (x - low[axis]) * scale;
  }
  [[nodiscard]] Scaling inverse() const {
    Scaling other = *this;
    other.back = !back;
    return other;
  }
};

Scaling to_size(const double* low, double length) {
  Scaling scaling;
  for (int i = 0; i < 3; ++i)
    scaling.low[i] = low[i];
  if (length > 0) scaling.scale = kSize / length;
  return scaling;
}

vtkNew<vtkUnstructuredGrid> scaled(vtkUnstructuredGrid* mesh, vtkDataArray* field, const char* name,
                                   const Scaling& position, const Scaling& value) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(mesh->GetNumberOfPoints());
  vtkNew<vtkDoubleArray> values;
  values->SetName(name);
  values->SetNumberOfTuples(mesh->GetNumberOfPoints());
  for (vtkIdType v = 0; v < mesh->GetNumberOfPoints(); ++v) {
    double x[3];
    mesh->GetPoint(v, x);
    points->SetPoint(v, position(x[0], 0), position(x[1], 1), position(x[2], 2));
    values->SetValue(v, value(field->GetComponent(v, 0), 0));
  }
  vtkNew<vtkUnstructuredGrid> result;
  result->SetPoints(points);
  result->SetCells(VTK_TETRA, mesh->GetCells());
  result->GetPointData()->SetScalars(values);
  return result;
}

int fail(const char* message) {
  std::fprintf(stderr, "vtk_decimate: %s\n", message);
  return 1;
}

} // namespace

int main(int argc, char** argv) {
  std::vector<const char*> arguments;
  const char* output = nullptr;
  for (int i = 1; i < argc; ++i) {
    if (std::string(argv[i]) == "-o" && i + 1 < argc)
      output = argv[++i];
    else
      arguments.push_back(argv[i]);
  }
  if (arguments.size() != 2 && arguments.size() != 3) {
    std::fprintf(stderr, "usage: vtk_decimate MESH.vtu FRACTION [FIELD] [-o OUT.vtu]\n");
    return 2;
  }
  const double fraction = std::atof(arguments[1]);
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  reader->SetFileName(arguments[0]);
  reader->Update();
  vtkUnstructuredGrid* mesh = reader->GetOutput();
  if (mesh->GetNumberOfCells() == 0 || !(fraction > 0 && fraction < 1))
    return fail("no cells, or a fraction that is not between 0 and 1");
  for (vtkIdType c = 0; c < mesh->GetNumberOfCells(); ++c)
    if (mesh->GetCellType(c) != VTK_TETRA) return fail("a cell that is no tetrahedron");
  const char* name = arguments.size() == 3 ? arguments[2] : mesh->GetPointData()->GetArrayName(0);
  vtkDataArray* field = name == nullptr ? nullptr : mesh->GetPointData()->GetArray(name);
  if (field == nullptr || field->GetNumberOfComponents() != 1) return fail("no such point array of one component");

  const double* box = mesh->GetBounds();
  const double corner[3] = {box[0], box[2], box[4]};
  const Scaling place = to_size(corner, std::hypot(box[1] - box[0], box[3] - box[2], box[5] - box[4]));
  const double* range = field->GetRange(0);
  const double lowest[3] = {range[0], 0, 0};
  const Scaling size = to_size(lowest, range[1] - range[0]);

  const auto input = scaled(mesh, field, name, place, size);
  vtkNew<vtkUnstructuredGridQuadricDecimation> decimation;
  decimation->SetInputData(input);
  decimation->SetScalarsName(name);
  decimation->SetTargetReduction(1 - fraction);
  const auto start = std::chrono::steady_clock::now();
  const std::clock_t processor_start = std::clock();
  decimation->Update();
  const double processor_seconds = static_cast<double>(std::clock() - processor_start) / CLOCKS_PER_SEC;
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  vtkUnstructuredGrid* result = decimation->GetOutput();
  if (output != nullptr) {
    // The filter's array has another name.
    vtkDataArray* values = result->GetPointData()->GetArray(0);
    if (values == nullptr) return fail("the filter gives no field");
    const auto restored = scaled(result, values, name, place.inverse(), size.inverse());
    vtkNew<vtkXMLUnstructuredGridWriter> writer;
    writer->SetFileName(output);
    writer->SetInputData(restored);
    if (writer->Write() == 0) return fail("cannot write the output");
  }
  std::printf("{\"seconds\": %.6f, \"processor_seconds\": %.6f, \"tets\": %lld, \"vertices\": %lld}\n", took.count(),
              processor_seconds, static_cast<long long>(result->GetNumberOfCells()),
              static_cast<long long>(result->GetNumberOfPoints()));
  return 0;
}
