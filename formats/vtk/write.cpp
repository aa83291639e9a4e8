#include "formats/vtk/write.hpp"

#include "formats/file_names.hpp"
#include "formats/vtk/messages.hpp"
#include "formats/vtk/scalar_types.hpp"
#include "formats/whole_file.hpp"
#include "mesh/utf8.hpp"

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <limits>
#include <set>
#include <string_view>

#include <oneapi/tbb/task_arena.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDataSetAttributes.h>
#include <vtkErrorCode.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>
#include <vtkTypeInt32Array.h>
#include <vtkTypeInt64Array.h>
#include <vtkUnstructuredGrid.h>
#include <vtkUnstructuredGridWriter.h>
#include <vtkXMLUnstructuredGridWriter.h>

namespace ptet {
namespace {

using vtkio::vtk_type;

void check(const std::string& path, const TetMesh& mesh, const WriteOptions& options) {
  const auto bad_input = [&](const std::string& reason) {
    throw Error(ErrorCode::kBadInput, "cannot write " + path + ": " + reason);
  };
  const std::size_t vertices = mesh.vertex_count();
  if (mesh.positions.components != 3 || mesh.positions.bytes.size() != vertices * mesh.positions.row_bytes())
    bad_input("positions are not rows of three");
  std::set<std::string> names;
  for (const PointArray& array : mesh.point_arrays) {
    if (array.components == 0 || array.bytes.size() != vertices * array.row_bytes())
      bad_input("point array '" + array.name + "' does not have one row for each vertex");
    if (!names.insert(array.name).second) bad_input("two point arrays are called '" + array.name + "'");
  }
  for (std::size_t i = 0; i < mesh.tets.size(); ++i) {
    for (const VertexId v : mesh.tets[i]) {
      if (v.index() >= vertices) bad_input("tet " + std::to_string(i) + " names a vertex that is not there");
    }
  }
  for (const CellArray& array : options.cell_arrays) {
    if (std::visit([](const auto& values) { return values.size(); }, array.values) != mesh.tets.size())
      throw Error(ErrorCode::kBadArgument,
                  path + ": cell array '" + array.name + "' does not have one value for each tet");
  }
}

/// A name as the value of an XML attribute, which VTK's writer takes it for already.
std::string escaped(const std::string& path, const std::string& name) {
  std::string text;
  for (std::size_t i = 0; i < name.size();) {
    const std::string_view rest = std::string_view(name).substr(i);
    const std::size_t length = utf8_length(rest);
    const char c = name[i];
    const bool is_control = static_cast<unsigned char>(c) < 0x20;
    const bool is_forbidden = (is_control && c != '\t' && c != '\n' && c != '\r') || rest.starts_with("\xEF\xBF\xBE") ||
                              rest.starts_with("\xEF\xBF\xBF"); // U+FFFE and U+FFFF
    if (length == 0 || is_forbidden)
      throw Error(ErrorCode::kBadInput, "cannot write " + path + ": the name of array '" + name + "' " +
                                            (is_forbidden ? "has a character that XML cannot hold"
                                                          : "is not text in UTF-8, which a VTU has") +
                                            "; a .vtk file may have it");
    if (is_control || c == '<' || c == '>' || c == '&' || c == '"' || c == '\'')
      text += "&#" + std::to_string(static_cast<int>(c)) + ";";
    else
      text.append(name, i, length);
    i += length;
  }
  return text;
}

/// A VTK array over memory that stays ours. VTK's writers read it only.
vtkSmartPointer<vtkDataArray> view(const void* data, std::size_t rows, std::size_t components, ScalarType type,
                                   const std::string& name) {
  vtkSmartPointer<vtkDataArray> array;
  array.TakeReference(vtkDataArray::CreateDataArray(vtk_type(type)));
  array->SetNumberOfComponents(static_cast<int>(components));
  array->SetName(name.c_str());
  static constexpr int kKeepOwnership = 1;
  array->SetVoidArray(const_cast<void*>(data), static_cast<vtkIdType>(rows * components), kKeepOwnership);
  return array;
}

vtkSmartPointer<vtkDataArray> view(const PointArray& array) {
  return view(array.bytes.data(), array.size(), array.components, array.type, array.name);
}

vtkSmartPointer<vtkDataArray> view(const CellArray& array) {
  return std::visit(
      [&]<class T>(const std::vector<T>& values) {
        const ScalarType type = std::is_same_v<T, float>    ? ScalarType::kFloat32
                                : std::is_same_v<T, double> ? ScalarType::kFloat64
                                                            : ScalarType::kUInt32;
        return view(values.data(), values.size(), 1, type, array.name);
      },
      array.values);
}

template <class Array>
void set_cells(const TetMesh& mesh, vtkUnstructuredGrid& grid) {
  vtkNew<Array> offsets;
  vtkNew<Array> ids;
  offsets->SetNumberOfValues(static_cast<vtkIdType>(mesh.tets.size() + 1));
  ids->SetNumberOfValues(static_cast<vtkIdType>(4 * mesh.tets.size()));
  using Index = typename Array::ValueType;
  Index* next_offset = offsets->GetPointer(0);
  Index* next_id = ids->GetPointer(0);
  for (std::size_t i = 0; i <= mesh.tets.size(); ++i)
    *next_offset++ = static_cast<Index>(4 * i);
  for (const Tet& tet : mesh.tets) {
    for (const VertexId v : tet)
      *next_id++ = static_cast<Index>(v.index());
  }
  vtkNew<vtkCellArray> cells;
  cells->SetData(offsets, ids);
  grid.SetCells(VTK_TETRA, cells);
}

vtkSmartPointer<vtkUnstructuredGrid> grid_of(const TetMesh& mesh, const WriteOptions& options) {
  auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  vtkNew<vtkPoints> points;
  points->SetData(view(mesh.positions));
  grid->SetPoints(points);
  constexpr std::uint64_t kMax32 = std::numeric_limits<std::int32_t>::max();
  if (4 * static_cast<std::uint64_t>(mesh.tets.size()) > kMax32 || mesh.vertex_count() > kMax32)
    set_cells<vtkTypeInt64Array>(mesh, *grid);
  else
    set_cells<vtkTypeInt32Array>(mesh, *grid);
  for (const PointArray& array : mesh.point_arrays)
    grid->GetPointData()->AddArray(view(array));
  for (const CellArray& array : options.cell_arrays)
    grid->GetCellData()->AddArray(view(array));
  return grid;
}

/// Bytes of the largest array that is written.
std::uint64_t largest_array(const TetMesh& mesh) {
  std::uint64_t bytes = std::max<std::uint64_t>(mesh.positions.bytes.size(), 32 * mesh.tets.size());
  for (const PointArray& array : mesh.point_arrays)
    bytes = std::max<std::uint64_t>(bytes, array.bytes.size());
  return bytes;
}

/// A file that takes everything it is given, room or no room, and remembers the first refusal of the system: VTK's XML
/// writer frees memory that it does not own when its stream fails.
class EnduringFile : public std::filebuf {
public:
  explicit EnduringFile(const std::string& path) { note(open(path, std::ios::out | std::ios::binary) != nullptr); }

  /// 0, or the system's reason.
  int finish() {
    note(close() != nullptr);
    return error_number_;
  }

protected:
  // After a refusal the base class is not to be called again: its buffer has no room for another byte.
  std::streamsize xsputn(const char* bytes, std::streamsize count) override {
    if (error_number_ == 0) note(std::filebuf::xsputn(bytes, count) == count);
    return count;
  }
  int_type overflow(int_type byte) override {
    if (error_number_ == 0) note(!traits_type::eq_int_type(std::filebuf::overflow(byte), traits_type::eof()));
    return traits_type::not_eof(byte);
  }
  int sync() override {
    if (error_number_ == 0) note(std::filebuf::sync() == 0);
    return 0;
  }
  pos_type seekoff(off_type offset, std::ios::seekdir from, std::ios::openmode mode) override {
    return error_number_ == 0 ? endured(std::filebuf::seekoff(offset, from, mode)) : pos_type(0);
  }
  pos_type seekpos(pos_type position, std::ios::openmode mode) override {
    return error_number_ == 0 ? endured(std::filebuf::seekpos(position, mode)) : pos_type(0);
  }

private:
  void note(bool good) {
    if (!good && error_number_ == 0) error_number_ = errno != 0 ? errno : EIO;
  }
  pos_type endured(pos_type position) {
    const bool good = position != pos_type(off_type(-1));
    note(good);
    return good ? position : pos_type(0);
  }

  int error_number_ = 0;
};

class XmlWriter : public vtkXMLUnstructuredGridWriter {
public:
  static XmlWriter* New() { VTK_STANDARD_NEW_BODY(XmlWriter); }

  /// VTK's writer opens its file itself only when it has no stream.
  void set_stream(std::ostream& stream) { Stream = &stream; }
};

void escape_names(const std::string& path, vtkFieldData& data) {
  for (int i = 0; i < data.GetNumberOfArrays(); ++i) {
    vtkAbstractArray& array = *data.GetAbstractArray(i);
    array.SetName(escaped(path, array.GetName()).c_str());
  }
}

void write_vtu(const WholeFile& file, vtkUnstructuredGrid& grid, const TetMesh& mesh, const WriteOptions& options,
               const vtkio::Messages& messages, const ProgressCallback& progress) {
  vtkNew<XmlWriter> writer;
  writer->SetInputData(&grid);
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  switch (options.compressor) {
  case Compressor::kNone: writer->SetCompressorTypeToNone(); break;
  case Compressor::kZlib: writer->SetCompressorTypeToZLib(); break;
  }
  if (largest_array(mesh) > std::numeric_limits<std::uint32_t>::max())
    writer->SetHeaderTypeToUInt64();
  else
    writer->SetHeaderTypeToUInt32();
  EnduringFile buffer(file.temporary_path());
  std::ostream stream(&buffer);
  writer->set_stream(stream);
  writer->SetFileName(file.temporary_path().c_str());
  const vtkio::ProgressWatch watch(*writer, "writing", progress);
  const int written = writer->Write();
  const int error_number = buffer.finish();
  watch.throw_on_cancel();
  if (error_number != 0) file.fail(error_number);
  if (!messages.errors().empty()) file.fail(messages.errors().front());
  if (!written) file.fail("VTK gave up");
}

/// As a word of the file, of which VTK's reader takes no more: there all but plain letters and marks are three.
void check_legacy_names(const std::string& path, vtkDataSetAttributes& data) {
  constexpr std::size_t kLongestWord = 255;
  for (int i = 0; i < data.GetNumberOfArrays(); ++i) {
    const std::string name = data.GetArrayName(i);
    std::size_t length = 0;
    for (const char c : name)
      length += c < '!' || c > '~' || c == '"' || c == '%' ? 3 : 1;
    if (length > kLongestWord)
      throw Error(ErrorCode::kBadInput, "cannot write " + path + ": the name of array '" + name.substr(0, 40) +
                                            "...' is too long for legacy VTK; a .vtu file may have it");
  }
}

void write_legacy(const WholeFile& file, vtkUnstructuredGrid& grid, const vtkio::Messages& messages,
                  const ProgressCallback& progress) {
  vtkNew<vtkUnstructuredGridWriter> writer;
  writer->SetInputData(&grid);
  writer->SetFileTypeToBinary();
  writer->SetHeader("tetrahedral mesh written by ptet");
  writer->SetFileName(file.temporary_path().c_str());
  const vtkio::ProgressWatch watch(*writer, "writing", progress);
  errno = 0;
  const int written = writer->Write();
  const int error_number = errno;
  watch.throw_on_cancel();
  if (written && writer->GetErrorCode() == vtkErrorCode::NoError && messages.errors().empty()) return;
  // VTK calls every failure of its stream a full disk and deletes the file, so the system's word comes first.
  for (const int known : {ENOSPC, EDQUOT, EFBIG, EIO}) {
    if (error_number == known) file.fail(known);
  }
  if (!messages.errors().empty()) file.fail(messages.errors().front());
  file.fail(std::string(vtkErrorCode::GetStringFromErrorCode(writer->GetErrorCode())));
}

void write(const std::string& path, const WholeFile& file, const TetMesh& mesh, bool is_vtu,
           const WriteOptions& options, const vtkio::Messages& messages, const ProgressCallback& progress) {
  const vtkSmartPointer<vtkUnstructuredGrid> grid = grid_of(mesh, options);
  if (is_vtu) {
    escape_names(path, *grid->GetPointData());
    escape_names(path, *grid->GetCellData());
    write_vtu(file, *grid, mesh, options, messages, progress);
  } else {
    check_legacy_names(path, *grid->GetPointData());
    check_legacy_names(path, *grid->GetCellData());
    write_legacy(file, *grid, messages, progress);
  }
}

} // namespace

bool is_mesh_name(const std::string& path) {
  const std::string ending = ending_of(path);
  return ending == ".vtu" || ending == ".vtk";
}

void write_mesh(const std::string& path, const TetMesh& mesh, const WriteOptions& options,
                const ProgressCallback& progress) {
  if (!is_mesh_name(path))
    throw Error(ErrorCode::kBadArgument, "cannot write " + path + ": a mesh is written as .vtu or .vtk");
  const bool is_vtu = ending_of(path) == ".vtu";
  check(path, mesh, options);

  WholeFile file(path);
  const vtkio::Messages messages;
  // VTK's loops begin threads without asking whether the system lets them; here they are short.
  oneapi::tbb::task_arena(1).execute([&] { write(path, file, mesh, is_vtu, options, messages, progress); });
  file.commit();
}

} // namespace ptet
