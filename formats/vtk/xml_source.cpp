#include "formats/vtk/checked_reader.hpp"
#include "formats/vtk/guarded_parser.hpp"
#include "formats/vtk/sources.hpp"
#include "mesh/number_text.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <utility>

#include <vtkNew.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLDataParser.h>

namespace ptet::vtkio {
namespace {

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
int each_piece(const Source& source, Assembler& assembler, Visit&& visit) {
  vtkNew<vtkXMLDataParser> parser;
  vtkXMLDataElement* const root = root_of(*parser, source.path);
  source.messages.throw_on_error(source.path);
  vtkXMLDataElement* grid = root ? root->FindNestedElementWithName("PUnstructuredGrid") : nullptr;
  if (!grid) assembler.fail("has no PUnstructuredGrid element");
  if (count_of(*root, "PUnstructuredGrid") > 1) assembler.fail("holds more than one PUnstructuredGrid element");

  int pieces = 0;
  int full_pieces = 0;
  std::set<std::string> seen;
  for (const std::string& path : named_pieces(*grid, source.path)) {
    if (path.empty()) assembler.fail("piece " + std::to_string(pieces) + " has no Source");
    check_readable(path);
    ++pieces;
    if (!seen.insert(path).second) {
      assembler.note_once("piece '" + path + "' is named more than once, and was read once");
      continue;
    }
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
  const auto pass_notes = [&] {
    for (const std::string& note : reader->notes)
      assembler.note_once(note);
  };
  pass_notes();

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
  pass_notes(); // some come while it is read
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
