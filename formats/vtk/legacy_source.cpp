#include "formats/vtk/sources.hpp"

#include <vtkCellData.h>
#include <vtkDataSetAttributes.h>
#include <vtkFieldData.h>
#include <vtkNew.h>
#include <vtkUnstructuredGrid.h>
#include <vtkUnstructuredGridReader.h>

namespace ptet::vtkio {

void read_legacy(const Source& source, Assembler& assembler) {
  check_memory(source, check_legacy(source));
  vtkNew<vtkUnstructuredGridReader> reader;
  reader->SetFileName(source.path.c_str());
  reader->ReadAllScalarsOn();
  reader->ReadAllVectorsOn();
  reader->ReadAllNormalsOn();
  reader->ReadAllTensorsOn();
  reader->ReadAllColorScalarsOn();
  reader->ReadAllTCoordsOn();
  reader->ReadAllFieldsOn();
  const ProgressWatch watch(*reader, "reading", source.progress);
  reader->Update();
  watch.throw_on_cancel();
  source.messages.throw_on_error(source.path);
  // Of an array that ends before its time VTK only warns, and leaves the rest to chance.
  for (const std::string& warning : source.messages.warnings())
    if (warning.find("Error reading") != std::string::npos)
      assembler.fail("is cut short, or an array in it has fewer values than it says");

  vtkUnstructuredGrid& grid = *reader->GetOutput();
  const auto each_left_out = [&](vtkFieldData& data, const auto& note) {
    for (int i = 0; i < data.GetNumberOfArrays(); ++i) {
      const char* given = data.GetArrayName(i);
      const std::string name = given ? given : "";
      if (name != vtkDataSetAttributes::GhostArrayName()) note(name);
    }
  };
  each_left_out(*grid.GetCellData(), [&](const std::string& name) { assembler.note_cell_array(name); });
  each_left_out(*grid.GetFieldData(),
                [&](const std::string& name) { assembler.note_once("field data '" + name + "' is not carried"); });
  assembler.add_points(grid);
  assembler.add_cells(grid);
}

} // namespace ptet::vtkio
