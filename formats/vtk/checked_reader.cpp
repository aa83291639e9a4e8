#include "formats/vtk/checked_reader.hpp"

#include "formats/vtk/guarded_parser.hpp"
#include "formats/vtk/number_text.hpp"
#include "formats/vtk/scalar_types.hpp"
#include "mesh/number_text.hpp"

#include <algorithm>
#include <numeric>
#include <set>
#include <span>
#include <sstream>

#include <vtkCallbackCommand.h>
#include <vtkCellType.h>
#include <vtkCommand.h>
#include <vtkDataArray.h>
#include <vtkDataArraySelection.h>
#include <vtkDataSetAttributes.h>
#include <vtkNew.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

namespace ptet::vtkio {
namespace {

/// As VTK's reader tells.
bool is_text(vtkXMLDataElement& array) {
  return !array.GetAttribute("offset") && attribute(array, "format") != "binary";
}

} // namespace

void CheckedReader::CreateXMLParser() {
  Superclass::CreateXMLParser();
  // The superclass has made a plain parser and hung its observers on it; a guarded one takes its place.
  vtkNew<GuardedParser> parser;
  parser->file_bytes = file_bytes;
  parser->AddObserver(vtkCommand::ProgressEvent, DataProgressObserver);
  XMLParser->Delete();
  XMLParser = parser;
  XMLParser->Register(nullptr);
}

int CheckedReader::ReadVTKFile(vtkXMLDataElement* file) {
  if (count_of(*file, GetDataSetName()) <= 1) return Superclass::ReadVTKFile(file);
  vtkErrorMacro("holds more than one " << GetDataSetName() << " element; write one mesh to a file.");
  return 0;
}

int CheckedReader::ReadPiece(vtkXMLDataElement* piece) {
  for (const char* part : {"Points", "Cells", "PointData"}) {
    if (count_of(*piece, part) <= 1) continue;
    vtkErrorMacro("piece " << Piece << " has more than one " << part << " element.");
    return 0;
  }
  for (int i = 0; i < piece->GetNumberOfNestedElements(); ++i)
    if (!keep_last_step(*piece->GetNestedElement(i))) return 0;
  if (!Superclass::ReadPiece(piece)) return 0;
  vtkXMLDataElement* points = PointElements[Piece];
  vtkXMLDataElement* point_data = PointDataElements[Piece];
  vtkXMLDataElement* cell_data = CellDataElements[Piece];
  if (cell_data) leave_out(*cell_data);
  leave_out_field_data();
  if (point_data) {
    leave_out_text(*point_data);
    name_apart(*point_data);
  }
  for (vtkXMLDataElement* arrays : {points, point_data, CellElements[Piece]}) {
    // Ranges and other remarks on an array, which VTK's writer writes and its reader cannot always read.
    for (int i = 0; arrays && i < arrays->GetNumberOfNestedElements(); ++i)
      arrays->GetNestedElement(i)->RemoveAllNestedElements();
  }

  for (vtkXMLDataElement* arrays : {points, point_data})
    if (arrays && !has_components(*arrays)) return 0;
  const auto point_count = static_cast<double>(NumberOfPoints[Piece]);
  const auto cell_count = static_cast<double>(NumberOfCells[Piece]);
  const double bytes = point_count * (point_row_bytes(points) + point_row_bytes(point_data)) + 2 * cell_count;
  if (point_count < 0 || cell_count < 0 || !is_true_size(bytes, file_bytes)) {
    vtkErrorMacro("piece " << Piece << " announces " << NumberOfPoints[Piece] << " points and " << NumberOfCells[Piece]
                           << " cells, more than the file can hold.");
    return 0;
  }
  const std::string layout = layout_of(points) + layout_of(point_data);
  if (point_count > 0 && attribute(*points->GetNestedElement(0), "NumberOfComponents") != "3") {
    vtkErrorMacro("points of piece " << Piece << " do not have three coordinates.");
    return 0;
  }
  if (point_count > 0 && attribute(*points->GetNestedElement(0), "type") == "String") {
    vtkErrorMacro("points of piece " << Piece << " are text.");
    return 0;
  }
  if (point_count > 0 && !first_layout_) {
    first_layout_ = layout;
    // VTK asks the first piece, which may be empty, without arrays.
    for (int empty = 0; empty < Piece; ++empty) {
      PointElements[empty] = points;
      PointDataElements[empty] = point_data;
    }
  }
  if (point_count > 0 && layout != *first_layout_) {
    vtkErrorMacro("piece " << Piece << " has other point arrays than those before it: " << layout << " instead of "
                           << *first_layout_ << ".");
    return 0;
  }
  if (!check_cell_flags(cell_data)) return 0;
  take_face_arrays();
  announced +=
      {static_cast<std::uint64_t>(NumberOfPoints[Piece]), static_cast<std::uint64_t>(NumberOfCells[Piece]),
       ids_of_cells(), point_count * (point_row_bytes(points) + point_row_bytes(point_data)), corners_of_faces()};
  return 1;
}

int CheckedReader::ReadArrayValues(vtkXMLDataElement* element, vtkIdType array_index, vtkAbstractArray* array,
                                   vtkIdType start, vtkIdType values, FieldType type) {
  if (!can_hold(*element, values, *array)) return 0;
  // Of pieces that are empty, the arrays of another may stand for theirs.
  if (values == 0) return Superclass::ReadArrayValues(element, array_index, array, start, values, type);
  if (is_text(*element)) return read_text(element, array_index, array, start, values, type);
  auto& parser = *static_cast<GuardedParser*>(XMLParser);
  parser.array_bytes = 0;
  if (!Superclass::ReadArrayValues(element, array_index, array, start, values, type)) {
    vtkErrorMacro("array '" << attribute(*element, "Name")
                            << "' does not hold the values that it announces: its data is cut short or damaged, or "
                               "its base64 text has line ends or spaces, which VTK does not read.");
    return 0;
  }
  const auto value_bytes = static_cast<std::uint64_t>(array->GetDataTypeSize());
  const auto bytes = static_cast<std::uint64_t>(values) * value_bytes;
  const bool is_plain_text = !element->GetAttribute("offset") && !parser.GetRootElement()->GetAttribute("compressor");
  if (parser.array_bytes != bytes && is_plain_text && parser.inline_bytes(*element) == bytes) {
    notes.push_back("array '" + attribute(*element, "Name") +
                    "' says that it has another length than it has (files of GetFEM do): what is there was read");
    return 1;
  }
  return value_bytes == 0 || // bits
         has_all(*element, parser.array_bytes / value_bytes, values, type);
}

bool CheckedReader::can_hold(vtkXMLDataElement& element, std::int64_t values, vtkAbstractArray& array) {
  if (values >= 0 && is_true_size(static_cast<double>(values) * array.GetDataTypeSize(), file_bytes)) return true;
  vtkErrorMacro("array '" << attribute(element, "Name") << "' should have " << values
                          << " values, more than the file can hold.");
  return false;
}

int CheckedReader::read_text(vtkXMLDataElement* element, vtkIdType array_index, vtkAbstractArray* array,
                             vtkIdType start, vtkIdType values, FieldType type) {
  const std::optional<ScalarType> scalar = scalar_type(array->GetDataType());
  if (!scalar) return Superclass::ReadArrayValues(element, array_index, array, start, values, type);
  std::uint64_t words = 0;
  const bool good = static_cast<GuardedParser*>(XMLParser)->each_word(*element, [&](const std::string& word) {
    ++words;
    const char* const fault = unfitness(word, *scalar);
    if (fault)
      vtkErrorMacro("value " << words - 1 << " of array '" << attribute(*element, "Name") << "', '"
                             << word.substr(0, 32) << "', " << fault << " (" << attribute(*element, "type") << ").");
    return fault == nullptr;
  });
  return good && has_all(*element, words, values, type) &&
         Superclass::ReadArrayValues(element, array_index, array, start, values, type);
}

bool CheckedReader::has_all(vtkXMLDataElement& array, std::uint64_t there, vtkIdType values, FieldType type) {
  if (there == static_cast<std::uint64_t>(values)) return true;
  vtkErrorMacro("array '" << attribute(array, "Name") << "' holds " << there << " values where " << values << " belong"
                          << (type == POINT_DATA ? "; is its NumberOfComponents right?" : "."));
  return false;
}

bool CheckedReader::keep_last_step(vtkXMLDataElement& data) {
  struct Step {
    int number = -1;
    vtkXMLDataElement* array = nullptr;
    int count = 0;
  };
  std::map<std::string, Step> last;
  std::vector<vtkXMLDataElement*> gone;
  for (int i = 0; i < data.GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* const array = data.GetNestedElement(i);
    const int number = last_step_of(*array);
    if (number < 0) continue;
    Step& step = last[attribute(*array, "Name")];
    ++step.count;
    gone.push_back(number < step.number ? array : step.array);
    if (number < step.number) continue;
    step.number = number;
    step.array = array;
  }
  int steps = 0;
  for (const auto& [name, step] : last) {
    if (std::max(step.number + 1, step.count) < GetNumberOfTimeSteps()) {
      vtkErrorMacro("array '" << name << "' is not there for the last of " << GetNumberOfTimeSteps()
                              << " time steps. (VTK's writer leaves such files unless it appends its data; write one "
                                 "file a step.)");
      return false;
    }
    step.array->RemoveAttribute("TimeStep");
    steps = std::max(steps, step.count);
  }
  for (vtkXMLDataElement* const array : gone)
    if (array) data.RemoveNestedElement(array);
  if (steps >= 2)
    notes.push_back("the values are those of the last of " + grouped(static_cast<std::uint64_t>(steps)) +
                    " time steps");
  return true;
}

int CheckedReader::last_step_of(vtkXMLDataElement& array) {
  std::istringstream steps(attribute(array, "TimeStep"));
  int last = -1;
  for (int step = 0; steps >> step;)
    last = std::max(last, step);
  return last;
}

bool CheckedReader::tells_of_cells(vtkXMLDataElement& cell_data, vtkXMLDataElement& array) {
  const std::string name = attribute(array, "Name");
  const bool has_degrees = !name.empty() && name == attribute(cell_data, "HigherOrderDegrees");
  return has_degrees || name == vtkDataSetAttributes::GhostArrayName() ||
         (name == "vtkGhostLevels" && GetFileMajorVersion() < 2 && attribute(array, "type") == "UInt8" &&
          components_of(array) == "1");
}

std::string CheckedReader::components_of(vtkXMLDataElement& array) {
  const std::string components = attribute(array, "NumberOfComponents");
  return components.empty() ? "1" : components;
}

std::string CheckedReader::layout_of_cell_flags(vtkXMLDataElement* cell_data) {
  std::string layout;
  for (int i = 0; cell_data && i < cell_data->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement& array = *cell_data->GetNestedElement(i);
    if (tells_of_cells(*cell_data, array))
      layout += "[" + attribute(array, "Name") + " " + attribute(array, "type") + " " + components_of(array) + "]";
  }
  return layout;
}

bool CheckedReader::check_cell_flags(vtkXMLDataElement* cell_data) {
  if (NumberOfCells[Piece] == 0) return true;
  const std::string layout = layout_of_cell_flags(cell_data);
  if (!first_flag_layout_) {
    first_flag_layout_ = layout;
    std::fill_n(CellDataElements, Piece, cell_data);
  }
  if (layout == *first_flag_layout_) return true;
  const auto named = [](const std::string& flags) { return flags.empty() ? std::string("none") : flags; };
  vtkErrorMacro("piece " << Piece << " has other ghost flags or degrees of cells than those before it: "
                         << named(layout) << " instead of " << named(*first_flag_layout_) << ".");
  return false;
}

void CheckedReader::leave_out(vtkXMLDataElement& data) {
  std::set<std::string> taken;
  for (int i = 0; i < data.GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement& array = *data.GetNestedElement(i);
    const std::string name = unique_name(attribute(array, "Name"), static_cast<std::size_t>(i), taken);
    array.SetAttribute("Name", name.c_str());
    if (tells_of_cells(data, array)) continue;
    CellDataArraySelection->AddArray(name.c_str(), false);
    cell_arrays.push_back(name);
  }
}

void CheckedReader::leave_out_field_data() {
  if (!FieldDataElement) return;
  for (int i = 0; i < FieldDataElement->GetNumberOfNestedElements(); ++i)
    notes.push_back("field data '" + attribute(*FieldDataElement->GetNestedElement(i), "Name") + "' is not carried");
  FieldDataElement = nullptr;
}

void CheckedReader::leave_out_text(vtkXMLDataElement& data) {
  for (int i = 0; i < data.GetNumberOfNestedElements();) {
    vtkXMLDataElement* const array = data.GetNestedElement(i);
    if (attribute(*array, "type") != "String") {
      ++i;
      continue;
    }
    notes.push_back("point array '" + attribute(*array, "Name") + "' is not numeric (string) and is not carried");
    data.RemoveNestedElement(array);
  }
}

void CheckedReader::name_apart(vtkXMLDataElement& data) {
  std::set<std::string> taken;
  for (int i = 0; i < data.GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement& array = *data.GetNestedElement(i);
    const std::string given = attribute(array, "Name");
    const std::string name = unique_name(given, static_cast<std::size_t>(i), taken);
    if (name == given) continue;
    array.SetAttribute("Name", name.c_str());
    notes.push_back(given.empty() ? "a point array without a name is called '" + name + "'"
                                  : "a second point array '" + given + "' is called '" + name + "'");
  }
}

bool CheckedReader::has_components(vtkXMLDataElement& data) {
  for (int i = 0; i < data.GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement& array = *data.GetNestedElement(i);
    const char* const components = array.GetAttribute("NumberOfComponents");
    if (!components || (!unfitness(components, ScalarType::kInt32) && std::stoi(components) > 0)) continue;
    vtkErrorMacro("array '" << attribute(array, "Name") << "' has '" << components
                            << "' for its NumberOfComponents, which is not a number of at least 1.");
    return false;
  }
  return true;
}

double CheckedReader::point_row_bytes(vtkXMLDataElement* data) {
  double bytes = 0;
  for (int i = 0; data && i < data->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement& array = *data->GetNestedElement(i);
    const std::string type = attribute(array, "type");
    int components = 1;
    array.GetScalarAttribute("NumberOfComponents", components);
    const double scalar_bytes = type.ends_with("64")   ? 8
                                : type.ends_with("32") ? 4
                                : type.ends_with("16") ? 2
                                : type == "Bit"        ? 0.125
                                                       : 1;
    bytes += scalar_bytes * std::max(1, components);
  }
  return bytes;
}

std::string CheckedReader::layout_of(vtkXMLDataElement* data) {
  std::string layout;
  for (int i = 0; data && i < data->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement& array = *data->GetNestedElement(i);
    layout += "[" + (std::string(data->GetName()) == "Points" ? "Points" : attribute(array, "Name")) + " " +
              attribute(array, "type") + " " + attribute(array, "NumberOfComponents") + "]";
  }
  return layout;
}

std::uint64_t CheckedReader::ids_of_cells() {
  const std::uint64_t of_tets = 4 * static_cast<std::uint64_t>(NumberOfCells[Piece]);
  vtkXMLDataElement* const cells = CellElements[Piece];
  vtkXMLDataElement* const ids =
      cells ? cells->FindNestedElementWithNameAndAttribute("DataArray", "Name", "connectivity") : nullptr;
  return of_tets == 0 || !ids ? of_tets : length_of(*ids).value_or(of_tets);
}

std::optional<std::uint64_t> CheckedReader::length_of(vtkXMLDataElement& array) {
  int type = 0;
  if (!array.GetWordTypeAttribute("type", type)) return std::nullopt;
  auto& parser = *static_cast<GuardedParser*>(XMLParser);
  const std::size_t value_bytes = parser.GetWordTypeSize(type);
  parser.array_bytes = 0;
  double value = 0; // has room for one of any type
  if (vtkTypeInt64 offset = 0; array.GetScalarAttribute("offset", offset))
    parser.ReadAppendedData(offset, &value, 0, 1, type);
  else if (attribute(array, "format") == "binary")
    parser.ReadInlineData(&array, 0, &value, 0, 1, type);
  if (value_bytes == 0 || parser.array_bytes == 0) return std::nullopt;
  return parser.array_bytes / value_bytes;
}

void CheckedReader::take_face_arrays() {
  face_arrays_.resize(static_cast<std::size_t>(Piece) + 1);
  vtkXMLDataElement* const cells = CellElements[Piece];
  if (!cells) return;
  std::map<std::string, vtkSmartPointer<vtkXMLDataElement>>& taken = face_arrays_.back();
  for (int i = 0; i < cells->GetNumberOfNestedElements();) {
    vtkXMLDataElement* const array = cells->GetNestedElement(i);
    const std::string name = attribute(*array, "Name");
    if (std::find(kFaceArrays.begin(), kFaceArrays.end(), name) == kFaceArrays.end()) {
      ++i;
      continue;
    }
    taken.try_emplace(name, array);
    cells->RemoveNestedElement(array);
  }
}

std::uint64_t CheckedReader::corners_of_faces() {
  const auto length = [&](const char* name) -> double {
    const auto array = face_arrays_.back().find(name);
    return array == face_arrays_.back().end() ? 0 : static_cast<double>(length_of(*array->second).value_or(0));
  };
  if (const double stream = length("faces"); stream > 0) return static_cast<std::uint64_t>(stream);
  const double in_all = length("face_connectivity"), each = length("face_offsets"),
               used = length("polyhedron_to_faces");
  // No face is used more than twice.
  return each > 0 ? static_cast<std::uint64_t>(in_all * std::clamp(used / each, 1.0, 2.0) + each + used) : 0;
}

bool CheckedReader::read_faces() {
  faces = {};
  auto* const grid = vtkUnstructuredGrid::SafeDownCast(GetCurrentOutput());
  const auto count = static_cast<std::size_t>(NumberOfCells[Piece]);
  if (count == 0) return true;
  const std::span types(grid->GetCellTypesArray()->GetPointer(StartCell), count);
  if (std::find(types.begin(), types.end(), VTK_POLYHEDRON) == types.end()) return true;
  const auto& arrays = face_arrays_[static_cast<std::size_t>(Piece)];
  const auto cells = static_cast<std::int64_t>(count);
  const PieceCells piece{
      types, static_cast<std::uint64_t>(std::accumulate(NumberOfCells, NumberOfCells + Piece, vtkIdType{0}))};
  std::string fault;
  if (arrays.contains("faces") && arrays.contains("faceoffsets")) {
    FaceStream stream;
    if (!read_integers("faceoffsets", cells, stream.faceoffsets) ||
        !read_integers("faces", length_of_faces(stream.faceoffsets), stream.faces))
      return false;
    fault = faces_of(piece, stream, faces);
  } else if (std::all_of(kFaceArrays.begin() + 2, kFaceArrays.end(),
                         [&](const char* name) { return arrays.contains(name); })) {
    FaceTables tables;
    if (!read_integers("polyhedron_offsets", cells, tables.polyhedron_offsets) ||
        !read_integers("polyhedron_to_faces", length_by(tables.polyhedron_offsets), tables.polyhedron_to_faces) ||
        !read_integers("face_offsets", count_values("face_offsets"), tables.face_offsets) ||
        !read_integers("face_connectivity", length_by(tables.face_offsets), tables.face_connectivity))
      return false;
    fault = faces_of(piece, tables, faces);
  } else {
    fault = "piece " + std::to_string(Piece) + " has polyhedra, and not the arrays of their faces";
  }
  if (!fault.empty()) vtkErrorMacro(<< fault << ".");
  return fault.empty();
}

std::int64_t CheckedReader::count_values(const std::string& name) {
  vtkXMLDataElement& element = *face_arrays_[static_cast<std::size_t>(Piece)].at(name);
  if (const std::optional<std::uint64_t> length = length_of(element)) return static_cast<std::int64_t>(*length);
  std::int64_t words = 0;
  if (is_text(element))
    static_cast<GuardedParser*>(XMLParser)->each_word(element, [&](const std::string&) { return ++words > 0; });
  return words;
}

bool CheckedReader::read_integers(const std::string& name, std::int64_t count, Integers& to) {
  vtkXMLDataElement& element = *face_arrays_[static_cast<std::size_t>(Piece)].at(name);
  vtkSmartPointer<vtkAbstractArray> any;
  any.TakeReference(CreateArray(&element));
  auto* const array = vtkDataArray::SafeDownCast(any);
  if (!array || array->GetNumberOfComponents() != 1) {
    vtkErrorMacro("array '" << name << "' is not one of single numbers.");
    return false;
  }
  if (!can_hold(element, count, *array)) return false;
  array->SetNumberOfTuples(count);
  if (!ReadArrayValues(&element, 0, array, 0, count, OTHER)) return false;
  to.resize(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < to.size(); ++i) {
    const double value = array->GetComponent(static_cast<vtkIdType>(i), 0);
    if (!(value >= -1 && value < 0x1p53)) {
      vtkErrorMacro("value " << i << " of array '" << name << "' is neither a point, a face nor a place.");
      return false;
    }
    to[i] = static_cast<std::int64_t>(value);
  }
  return true;
}

} // namespace ptet::vtkio
