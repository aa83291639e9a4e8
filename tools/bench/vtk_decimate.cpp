// The peer: VTK's quadric decimation of a tetrahedral mesh, timed, and nothing else.
//
//   vtk_decimate MESH.vtu FRACTION [FIELD]      to that fraction of the tets; prints one JSON object
#include <chrono>
#include <cstdio>
#include <cstdlib>

#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkUnstructuredGrid.h>
#include <vtkUnstructuredGridQuadricDecimation.h>
#include <vtkXMLUnstructuredGridReader.h>

int main(int argc, char** argv) {
  if (argc != 3 && argc != 4) {
    std::fprintf(stderr, "usage: vtk_decimate MESH.vtu FRACTION [FIELD]\n");
    return 2;
  }
  const double fraction = std::atof(argv[2]);
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  reader->SetFileName(argv[1]);
  reader->Update();
  vtkUnstructuredGrid* mesh = reader->GetOutput();
  if (mesh->GetNumberOfCells() == 0 || !(fraction > 0 && fraction < 1)) {
    std::fprintf(stderr, "vtk_decimate: no cells, or a fraction that is not between 0 and 1\n");
    return 1;
  }
  const char* field = argc == 4 ? argv[3] : mesh->GetPointData()->GetArrayName(0);

  vtkNew<vtkUnstructuredGridQuadricDecimation> decimation;
  decimation->SetInputData(mesh);
  decimation->SetScalarsName(field);
  decimation->SetTargetReduction(1 - fraction);
  const auto start = std::chrono::steady_clock::now();
  decimation->Update();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  vtkUnstructuredGrid* result = decimation->GetOutput();
  std::printf("{\"seconds\": %.6f, \"tets\": %lld, \"vertices\": %lld}\n", took.count(),
              static_cast<long long>(result->GetNumberOfCells()), static_cast<long long>(result->GetNumberOfPoints()));
  return 0;
}
