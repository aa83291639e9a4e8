#include "formats/vtk/number_text.hpp"
#include "formats/vtk/polyhedron_faces.hpp"
#include "formats/vtk/scalar_types.hpp"
#include "formats/vtk/sources.hpp"
#include "mesh/number_text.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <numeric>
#include <optional>
#include <span>
#include <sstream>
#include <utility>

#include <vtkBase64InputStream.h>
#include <vtkCallbackCommand.h>
#include <vtkCellType.h>
#include <vtkCommand.h>
#include <vtkDataArraySelection.h>
#include <vtkDataSetAttributes.h>
#include <vtkInputStream.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLDataParser.h>
#include <vtkXMLUnstructuredGridReader.h>

namespace ptet::vtkio {
namespace {

bool is_true_size(double bytes, std::uint64_t file_bytes) {
  return bytes <= static_cast<double>(kMaxCompression) * static_cast<double>(file_bytes);
}

/// A stream of VTK's that gives all that is asked for or nothing: the parser takes a part of an array for the whole,
/// and leaves the rest as it finds it in memory. Of compressed data it looks at the header before the parser does,
/// which divides by the block size and indexes by the block count as they stand in the file. Says how many bytes the
/// header announces: the parser takes as many as it needs, and is silent on the rest.
template <class Base>
class GuardedStream : public Base {
public:
  static GuardedStream* New() { VTK_STANDARD_NEW_BODY(GuardedStream); }

  // The parser reads a compressed array in two goes: the header's three words and block sizes, then the blocks. Others
  // in one, and first the word that is their length.
  void StartReading() override {
    at_start_ = true;
    Base::StartReading();
  }
  void EndReading() override {
    in_header_ = !in_header_;
    Base::EndReading();
  }

  std::size_t Read(void* to, std::size_t length) override {
    const std::size_t got = Base::Read(to, length);
    if (got < length) return 0;
    const bool is_first = at_start_;
    const bool is_head = in_header_ && is_first;
    at_start_ = false;
    if (!compressed_ && is_first) *array_bytes_ = word(static_cast<const unsigned char*>(to));
    if (!compressed_ || !in_header_) return got;
    if (!is_head) return are_block_sizes(static_cast<const unsigned char*>(to), got) ? got : 0;
    const auto* data = static_cast<const unsigned char*>(to);
    const std::uint64_t blocks = word(data);
    const std::uint64_t block_bytes = word(data + word_bytes_);
    const std::uint64_t last_bytes = word(data + 2 * word_bytes_);
    const bool sound = (blocks == 0 && last_bytes == 0) ||
                       (blocks != 0 && block_bytes != 0 && last_bytes <= block_bytes && blocks <= file_bytes_ &&
                        is_true_size(static_cast<double>(blocks) * static_cast<double>(block_bytes), file_bytes_));
    if (!sound) return 0;
    *array_bytes_ = (last_bytes == 0 ? blocks : blocks - 1) * block_bytes + last_bytes;
    return got;
  }

  void guard(bool compressed, std::size_t word_bytes, bool big_endian, std::uint64_t file_bytes,
             std::uint64_t& array_bytes) {
    compressed_ = compressed;
    word_bytes_ = word_bytes;
    big_endian_ = big_endian;
    file_bytes_ = file_bytes;
    array_bytes_ = &array_bytes;
  }

private:
  [[nodiscard]] bool are_block_sizes(const unsigned char* data, std::size_t length) const {
    for (std::size_t at = 0; at + word_bytes_ <= length; at += word_bytes_) {
      if (word(data + at) > file_bytes_) return false;
    }
    return true;
  }

  [[nodiscard]] std::uint64_t word(const unsigned char* data) const {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < word_bytes_; ++i)
      value |= static_cast<std::uint64_t>(data[i]) << 8 * (big_endian_ ? word_bytes_ - 1 - i : i);
    return value;
  }

  bool compressed_ = false;
  bool in_header_ = true;
  bool at_start_ = false;
  std::size_t word_bytes_ = 4;
  bool big_endian_ = false;
  std::uint64_t file_bytes_ = 0;
  std::uint64_t* array_bytes_ = nullptr; ///< of the array whose header was read last
};

class GuardedParser : public vtkXMLDataParser {
public:
  static GuardedParser* New() { VTK_STANDARD_NEW_BODY(GuardedParser); }
  using Superclass = vtkXMLDataParser;

  int Parse() override {
    const int result = Superclass::Parse();
    if (!result || !RootElement) return result;
    guard<vtkBase64InputStream>(InlineDataStream);
    if (vtkBase64InputStream::SafeDownCast(AppendedDataStream))
      guard<vtkBase64InputStream>(AppendedDataStream);
    else
      guard<vtkInputStream>(AppendedDataStream);
    return result;
  }

  /// Calls `visit(text)` with each word of an array that is text; stops and returns false when it does.
  template <class Visit>
  bool each_word(vtkXMLDataElement& array, Visit&& visit) {
    SeekInlineDataPosition(&array);
    std::string word;
    for (std::istreambuf_iterator<char> at(*GetStream()), end;; ++at) {
      const bool is_over = at == end || *at == '<';
      if (!is_over && std::isspace(static_cast<unsigned char>(*at)) == 0) {
        word += *at;
        continue;
      }
      if (!word.empty() && !visit(std::as_const(word))) return false;
      word.clear();
      if (is_over) return true;
    }
  }

  std::uint64_t file_bytes = 0;
  std::uint64_t array_bytes = 0; ///< that the array read last has, whatever it should have; not of text

private:
  template <class Base>
  void guard(vtkInputStream*& stream) {
    auto* guarded = GuardedStream<Base>::New();
    guarded->guard(RootElement->GetAttribute("compressor") != nullptr, HeaderType == 64 ? 8 : 4, ByteOrder == BigEndian,
                   file_bytes, array_bytes);
    stream->Delete();
    stream = guarded;
  }
};

std::string attribute(vtkXMLDataElement& element, const char* name) {
  const char* value = element.GetAttribute(name);
  return value ? value : "";
}

int count_of(vtkXMLDataElement& parent, const std::string& name) {
  int count = 0;
  for (int i = 0; i < parent.GetNumberOfNestedElements(); ++i)
    count += parent.GetNestedElement(i)->GetName() == name ? 1 : 0;
  return count;
}

/// VTK's reader of VTU, with what it takes on trust checked first, and arrays named apart: it finds an array by its
/// place among the enabled ones, and takes type and size of every piece's arrays from the first piece.
class CheckedReader : public vtkXMLUnstructuredGridReader {
public:
  static CheckedReader* New() { VTK_STANDARD_NEW_BODY(CheckedReader); }
  using Superclass = vtkXMLUnstructuredGridReader;

  using vtkXMLUnstructuredGridReader::GetNumberOfPieces;

  std::uint64_t file_bytes = 0;
  AnnouncedMesh announced;              ///< by every piece
  std::vector<std::string> cell_arrays; ///< of every piece: those left out
  std::vector<std::string> notes;       ///< of every piece
  PolyhedronFaces faces;                ///< of the piece that was read last

protected:
  void CreateXMLParser() override {
    Superclass::CreateXMLParser();
    // The superclass has made a plain parser and hung its observers on it; a guarded one takes its place.
    vtkNew<GuardedParser> parser;
    parser->file_bytes = file_bytes;
    parser->AddObserver(vtkCommand::ProgressEvent, DataProgressObserver);
    XMLParser->Delete();
    XMLParser = parser;
    XMLParser->Register(nullptr);
  }

  /// VTK's reader takes the first grid, and says nothing of others.
  int ReadVTKFile(vtkXMLDataElement* file) override {
    if (count_of(*file, GetDataSetName()) <= 1) return Superclass::ReadVTKFile(file);
    vtkErrorMacro("holds more than one " << GetDataSetName() << " element; write one mesh to a file.");
    return 0;
  }

  using vtkXMLUnstructuredGridReader::ReadPiece;
  int ReadPiece(vtkXMLDataElement* piece) override {
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
      vtkErrorMacro("piece " << Piece << " announces " << NumberOfPoints[Piece] << " points and "
                             << NumberOfCells[Piece] << " cells, more than the file can hold.");
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
    if (!check_ghosts(cell_data)) return 0;
    take_face_arrays();
    announced +=
        {static_cast<std::uint64_t>(NumberOfPoints[Piece]), static_cast<std::uint64_t>(NumberOfCells[Piece]),
         ids_of_cells(), point_count * (point_row_bytes(points) + point_row_bytes(point_data)), corners_of_faces()};
    return 1;
  }

  using vtkXMLUnstructuredGridReader::ReadPieceData;
  int ReadPieceData() override { return Superclass::ReadPieceData() && read_faces() ? 1 : 0; }

  /// The length of the connectivity is what the offsets say. One so long that its bytes cannot be counted would be read
  /// into a buffer that is too small.
  int ReadArrayValues(vtkXMLDataElement* element, vtkIdType array_index, vtkAbstractArray* array, vtkIdType start,
                      vtkIdType values, FieldType type) override {
    if (values < 0 || !is_true_size(static_cast<double>(values) * array->GetDataTypeSize(), file_bytes)) {
      vtkErrorMacro("array '" << attribute(*element, "Name") << "' should have " << values
                              << " values, more than the file can hold.");
      return 0;
    }
    // Of pieces that are empty, the arrays of another may stand for theirs.
    if (values == 0) return Superclass::ReadArrayValues(element, array_index, array, start, values, type);
    // As the superclass tells text.
    if (!element->GetAttribute("offset") && attribute(*element, "format") != "binary")
      return read_text(element, array_index, array, start, values, type);
    auto& parser = *static_cast<GuardedParser*>(XMLParser);
    parser.array_bytes = 0;
    if (!Superclass::ReadArrayValues(element, array_index, array, start, values, type)) {
      vtkErrorMacro("array '" << attribute(*element, "Name")
                              << "' does not hold the values that it announces: its data is cut short or damaged, or "
                                 "its base64 text has line ends or spaces, which VTK does not read.");
      return 0;
    }
    const auto value_bytes = static_cast<std::uint64_t>(array->GetDataTypeSize());
    return value_bytes == 0 || // bits
           has_all(*element, parser.array_bytes / value_bytes, values, type);
  }

private:
  /// VTK's reader takes numbers out of the range of some types for others, and of what it cannot read it says only that
  /// there is too little.
  int read_text(vtkXMLDataElement* element, vtkIdType array_index, vtkAbstractArray* array, vtkIdType start,
                vtkIdType values, FieldType type) {
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

  /// More than an array should have is not to be told from values that belong elsewhere, as when their number of
  /// components is missing.
  bool has_all(vtkXMLDataElement& array, std::uint64_t there, vtkIdType values, FieldType type) {
    if (there == static_cast<std::uint64_t>(values)) return true;
    vtkErrorMacro("array '" << attribute(array, "Name") << "' holds " << there << " values where " << values
                            << " belong" << (type == POINT_DATA ? "; is its NumberOfComponents right?" : "."));
    return false;
  }

  /// VTK's writer puts the arrays of all time steps side by side, under the same names; in some modes all are called
  /// step 0. VTK's reader then takes the first of a name, or leaves what is not of its step as it finds it in memory.
  bool keep_last_step(vtkXMLDataElement& data) {
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

  /// The last of the steps that an array is for; -1 when it is for all of them.
  static int last_step_of(vtkXMLDataElement& array) {
    std::istringstream steps(attribute(array, "TimeStep"));
    int last = -1;
    for (int step = 0; steps >> step;)
      last = std::max(last, step);
    return last;
  }

  /// Of files before version 2 the reader makes ghost flags of levels, where they are bytes.
  bool is_ghost_array(vtkXMLDataElement& array) {
    const std::string name = attribute(array, "Name");
    return name == vtkDataSetAttributes::GhostArrayName() ||
           (name == "vtkGhostLevels" && GetFileMajorVersion() < 2 && attribute(array, "type") == "UInt8" &&
            components_of(array) == "1");
  }
  static std::string components_of(vtkXMLDataElement& array) {
    const std::string components = attribute(array, "NumberOfComponents");
    return components.empty() ? "1" : components;
  }
  /// Of what a piece says of its ghost cells, that which has to be the same for all.
  std::string ghost_layout_of(vtkXMLDataElement* cell_data) {
    std::string layout;
    for (int i = 0; cell_data && i < cell_data->GetNumberOfNestedElements(); ++i) {
      vtkXMLDataElement& array = *cell_data->GetNestedElement(i);
      if (is_ghost_array(array))
        layout += "[" + attribute(array, "Name") + " " + attribute(array, "type") + " " + components_of(array) + "]";
    }
    return layout;
  }

  /// VTK asks the first piece, which may be empty, what arrays there are, and leaves what another piece has not as it
  /// finds it in memory.
  bool check_ghosts(vtkXMLDataElement* cell_data) {
    if (NumberOfCells[Piece] == 0) return true;
    const std::string layout = ghost_layout_of(cell_data);
    if (!first_ghost_layout_) {
      first_ghost_layout_ = layout;
      std::fill_n(CellDataElements, Piece, cell_data);
    }
    if (layout == *first_ghost_layout_) return true;
    const auto named = [](const std::string& flags) { return flags.empty() ? std::string("none") : flags; };
    vtkErrorMacro("piece " << Piece << " has other ghost flags of cells than those before it: " << named(layout)
                           << " instead of " << named(*first_ghost_layout_) << ".");
    return false;
  }

  void leave_out(vtkXMLDataElement& data) {
    std::set<std::string> taken;
    for (int i = 0; i < data.GetNumberOfNestedElements(); ++i) {
      vtkXMLDataElement& array = *data.GetNestedElement(i);
      const std::string name = unique_name(attribute(array, "Name"), static_cast<std::size_t>(i), taken);
      array.SetAttribute("Name", name.c_str());
      if (is_ghost_array(array)) continue;
      CellDataArraySelection->AddArray(name.c_str(), false);
      cell_arrays.push_back(name);
    }
  }

  void leave_out_field_data() {
    if (!FieldDataElement) return;
    for (int i = 0; i < FieldDataElement->GetNumberOfNestedElements(); ++i)
      notes.push_back("field data '" + attribute(*FieldDataElement->GetNestedElement(i), "Name") + "' is not carried");
    FieldDataElement = nullptr;
  }

  /// VTK's reader puts as many strings as the file has where there is room for as many as it should have.
  void leave_out_text(vtkXMLDataElement& data) {
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

  void name_apart(vtkXMLDataElement& data) {
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

  /// VTK takes what is not a number for one.
  bool has_components(vtkXMLDataElement& data) {
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

  /// Least bytes of a row of all arrays of the element; types that are not numeric count as one byte.
  static double point_row_bytes(vtkXMLDataElement* data) {
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

  static std::string layout_of(vtkXMLDataElement* data) {
    std::string layout;
    for (int i = 0; data && i < data->GetNumberOfNestedElements(); ++i) {
      vtkXMLDataElement& array = *data->GetNestedElement(i);
      layout += "[" + (std::string(data->GetName()) == "Points" ? "Points" : attribute(array, "Name")) + " " +
                attribute(array, "type") + " " + attribute(array, "NumberOfComponents") + "]";
    }
    return layout;
  }

  std::uint64_t ids_of_cells() {
    const std::uint64_t of_tets = 4 * static_cast<std::uint64_t>(NumberOfCells[Piece]);
    vtkXMLDataElement* const cells = CellElements[Piece];
    vtkXMLDataElement* const ids =
        cells ? cells->FindNestedElementWithNameAndAttribute("DataArray", "Name", "connectivity") : nullptr;
    return of_tets == 0 || !ids ? of_tets : length_of(*ids).value_or(of_tets);
  }

  /// As the head of an array tells, of which one value is read. Nothing of text.
  std::optional<std::uint64_t> length_of(vtkXMLDataElement& array) {
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

  /// VTK's reader follows faces through their table without a look at where that ends, and that of 9.1 does not know
  /// the layout of 9.4. So it gets to see neither.
  void take_face_arrays() {
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
  /// Of all polyhedra, as the heads of the arrays tell, and what else they take as if it were corners.
  std::uint64_t corners_of_faces() {
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

  bool read_faces() {
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

  /// What an array has: not all faces need be used.
  std::int64_t count_values(const std::string& name) {
    vtkXMLDataElement& element = *face_arrays_[static_cast<std::size_t>(Piece)].at(name);
    if (const std::optional<std::uint64_t> length = length_of(element)) return static_cast<std::int64_t>(*length);
    std::int64_t words = 0;
    const bool is_text = !element.GetAttribute("offset") && attribute(element, "format") != "binary";
    if (is_text)
      static_cast<GuardedParser*>(XMLParser)->each_word(element, [&](const std::string&) { return ++words > 0; });
    return words;
  }

  bool read_integers(const std::string& name, std::int64_t count, Integers& to) {
    vtkXMLDataElement& element = *face_arrays_[static_cast<std::size_t>(Piece)].at(name);
    vtkSmartPointer<vtkAbstractArray> any;
    any.TakeReference(CreateArray(&element));
    auto* const array = vtkDataArray::SafeDownCast(any);
    if (!array || array->GetNumberOfComponents() != 1) {
      vtkErrorMacro("array '" << name << "' is not one of single numbers.");
      return false;
    }
    if (count < 0 || !is_true_size(static_cast<double>(count) * array->GetDataTypeSize(), file_bytes)) {
      vtkErrorMacro("array '" << name << "' should have " << count << " values, more than the file can hold.");
      return false;
    }
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

  /// First those of VTK up to 9.3, then those of later versions.
  static constexpr std::array<const char*, 6> kFaceArrays = {
      "faceoffsets", "faces", "polyhedron_offsets", "polyhedron_to_faces", "face_offsets", "face_connectivity"};
  std::vector<std::map<std::string, vtkSmartPointer<vtkXMLDataElement>>> face_arrays_; ///< by piece
  std::optional<std::string> first_layout_;       ///< of the first piece that has points
  std::optional<std::string> first_ghost_layout_; ///< of the first piece that has cells
};

std::uint64_t file_size(const std::string& path) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) throw Error(ErrorCode::kIo, path + ": cannot read: " + error.message());
  return size;
}

/// Appended data come last, and VTK looks no further: arrays of a file that was cut short would be zero from there on.
bool is_whole(const std::string& path, std::uint64_t file_bytes) {
  static constexpr std::uint64_t kTailBytes = 4096;
  std::ifstream file(path, std::ios::binary);
  std::string tail; // with the one before it: the words may lie across
  for (std::uint64_t end = file_bytes; end != 0;) {
    std::string part(std::min(end, kTailBytes), '\0');
    end -= part.size();
    file.seekg(static_cast<std::streamoff>(end));
    file.read(part.data(), static_cast<std::streamsize>(part.size()));
    const bool was_blank = tail.find_first_not_of(" \t\r\n") == std::string::npos;
    tail = part + tail;
    if (!file || tail.find("</VTKFile") != std::string::npos) return true;
    if (!was_blank) return false;
    tail.resize(std::min<std::size_t>(tail.size(), 2 * kTailBytes));
  }
  return false;
}

/// A reader that knows the head of the file.
vtkSmartPointer<CheckedReader> opened(const Source& source) {
  auto reader = vtkSmartPointer<CheckedReader>::New();
  reader->file_bytes = file_size(source.path);
  reader->SetFileName(source.path.c_str());
  reader->UpdateInformation();
  source.messages.throw_on_error(source.path);
  if (!is_whole(source.path, reader->file_bytes))
    throw Error(ErrorCode::kBadInput, source.path + ": is cut short: it does not end with </VTKFile>");
  return reader;
}

/// The parser reads the file, and keeps what it returns; null where it cannot.
vtkXMLDataElement* root_of(vtkXMLDataParser& parser, const std::string& path) {
  parser.SetFileName(path.c_str());
  return parser.Parse() != 0 ? parser.GetRootElement() : nullptr;
}

/// Whether a file of a PVTU is that of a process that had nothing: VTK writes it without points, and refuses it.
bool is_empty(const std::string& path) {
  vtkNew<vtkXMLDataParser> parser;
  vtkXMLDataElement* const root = root_of(*parser, path);
  vtkXMLDataElement* const grid = root ? root->FindNestedElementWithName("UnstructuredGrid") : nullptr;
  if (!grid || count_of(*root, "UnstructuredGrid") > 1) return false; // the reader refuses the latter
  for (int i = 0; i < grid->GetNumberOfNestedElements(); ++i) {
    int points = -1;
    grid->GetNestedElement(i)->GetScalarAttribute("NumberOfPoints", points);
    if (points != 0) return false;
  }
  return true;
}

/// By the pieces that an element of a PVTU has; empty of one without a name.
std::vector<std::string> named_pieces(vtkXMLDataElement& grid, const std::string& path) {
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  std::vector<std::string> files;
  for (int i = 0; i < grid.GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement& element = *grid.GetNestedElement(i);
    if (std::string(element.GetName()) != "Piece") continue;
    const std::string name = attribute(element, "Source");
    files.push_back(name.empty() ? name : (folder / name).string()); // an absolute name replaces the folder
  }
  return files;
}

/// Calls `visit(Source)` with each piece of a PVTU that holds anything; returns how many there are.
template <class Visit>
int each_piece(const Source& source, const Assembler& assembler, Visit&& visit) {
  vtkNew<vtkXMLDataParser> parser;
  vtkXMLDataElement* const root = root_of(*parser, source.path);
  source.messages.throw_on_error(source.path);
  vtkXMLDataElement* grid = root ? root->FindNestedElementWithName("PUnstructuredGrid") : nullptr;
  if (!grid) assembler.fail("has no PUnstructuredGrid element");
  if (count_of(*root, "PUnstructuredGrid") > 1) assembler.fail("holds more than one PUnstructuredGrid element");

  int pieces = 0;
  int full_pieces = 0;
  for (const std::string& path : named_pieces(*grid, source.path)) {
    if (path.empty()) assembler.fail("piece " + std::to_string(pieces) + " has no Source");
    check_readable(path);
    ++pieces;
    if (is_empty(path)) continue;
    visit(Source{path, source.messages, source.progress, source.report}); // the limit is for all of them
    ++full_pieces;
  }
  if (pieces == 0) assembler.fail("names no pieces");
  if (full_pieces == 0) assembler.fail("holds no cells: all of its pieces are empty");
  return full_pieces;
}

} // namespace

std::vector<std::string> pieces_of_pvtu(const std::string& path) {
  vtkNew<vtkXMLDataParser> parser;
  vtkXMLDataElement* const root = root_of(*parser, path);
  vtkXMLDataElement* const grid = root ? root->FindNestedElementWithName("PUnstructuredGrid") : nullptr;
  return grid ? named_pieces(*grid, path) : std::vector<std::string>{};
}

void read_vtu(const Source& source, Assembler& assembler) {
  const vtkSmartPointer<CheckedReader> reader = opened(source);
  check_memory(source, reader->announced);
  for (const std::string& name : reader->cell_arrays)
    assembler.note_cell_array(name);
  for (const std::string& note : reader->notes)
    assembler.note_once(note);

  // Piece by piece: so an id can be told from the next piece's, and only one is held twice in memory.
  const ProgressWatch watch(*reader, "reading", source.progress);
  const int pieces = static_cast<int>(reader->GetNumberOfPieces());
  for (int piece = 0; piece < pieces; ++piece) {
    const bool good = reader->UpdatePiece(piece, pieces, 0);
    watch.throw_on_cancel();
    source.messages.throw_on_error(source.path);
    if (!good) assembler.fail("the contents do not make a mesh");
    assembler.add_points(*reader->GetOutput());
    assembler.add_cells(*reader->GetOutput(), reader->faces);
  }
}

void read_pvtu(const Source& source, Assembler& assembler) {
  if (source.memory_limit != 0) {
    AnnouncedMesh all;
    each_piece(source, assembler, [&](const Source& piece) { all += opened(piece)->announced; });
    check_memory(source, all);
  }
  const int pieces = each_piece(source, assembler, [&](const Source& piece) {
    source.report.more_files.push_back(piece.path);
    read_vtu(piece, assembler);
  });
  if (pieces > 1)
    source.report.notes.push_back(
        "joined " + grouped(static_cast<std::uint64_t>(pieces)) +
        " pieces; points that they share stand in each of them, as in the files: where pieces touch "
        "is boundary and cannot get much coarser, unless these points are welded (ptet build --weld)");
}

} // namespace ptet::vtkio
