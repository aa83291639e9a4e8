#include "formats/vtk/read.hpp"

#include "formats/ptet/running_hash.hpp"
#include "formats/vtk/sources.hpp"
#include "formats/vtk/split_cell.hpp"
#include "mesh/number_text.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <regex>
#include <span>

#include <sys/stat.h>

namespace ptet {
namespace vtkio {
namespace {

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

[[noreturn]] void fail_to_read(const std::string& path, const std::string& reason) {
  throw Error(ErrorCode::kIo, path + ": cannot read: " + reason);
}

/// Opens a regular file for reading.
File open_file(const std::string& path) {
  // Before opening: a pipe would wait for its other end.
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) fail_to_read(path, std::strerror(errno));
  if (S_ISDIR(status.st_mode)) fail_to_read(path, "it is a folder");
  if (!S_ISREG(status.st_mode)) fail_to_read(path, "it is not a regular file");
  File file(std::fopen(path.c_str(), "rbe"), &std::fclose);
  if (!file) fail_to_read(path, std::strerror(errno));
  return file;
}

std::string read_head(const std::string& path) {
  static constexpr std::size_t kHeadBytes = 65536;
  const File file = open_file(path);
  std::string head(kHeadBytes, '\0');
  head.resize(std::fread(head.data(), 1, kHeadBytes, file.get()));
  if (std::ferror(file.get())) fail_to_read(path, std::strerror(errno));
  return head;
}

std::string without_comments(std::string xml) {
  for (std::size_t from = xml.find("<!--"); from != std::string::npos; from = xml.find("<!--", from)) {
    const std::size_t end = xml.find("-->", from + 4);
    xml.erase(from, end == std::string::npos ? end : end + 3 - from);
  }
  return xml;
}

/// The attribute `type` of the element VTKFile, which is there.
std::string xml_dataset_type(const std::string& head) {
  static const std::regex kType(R"re(<VTKFile(?:\s[^<>]*)?\stype\s*=\s*(?:"([^"<>]*)"|'([^'<>]*)'))re");
  std::smatch found;
  const std::string start = head.substr(head.find("<VTKFile"), 4096); // std::regex takes stack for every character
  if (!std::regex_search(start, found, kType)) return {};
  return found[1].matched ? found[1] : found[2];
}

/// What a file is that may well hold a mesh, but not as it stands; empty where nothing is known of it.
std::string what_to_do(const std::string& head) {
  if (head.starts_with("\x1F\x8B")) return "is compressed with gzip: unpack it first";
  if (head.starts_with("\x28\xB5\x2F\xFD")) return "is compressed with zstd: unpack it first";
  if (head.starts_with("PK\x03\x04")) return "is a ZIP archive: unpack it first";
  if (head.starts_with("$MeshFormat")) return "is a mesh of Gmsh: let Gmsh export it as .vtk";
  return {};
}

void read_any(const Source& source, Assembler& assembler) {
  const std::string head = read_head(source.path);
  if (head.empty()) assembler.fail("is empty");
  if (head.starts_with("# vtk DataFile")) {
    if (head.find('\n') == std::string::npos && head.find('\r') != std::string::npos)
      assembler.fail("has carriage returns for line ends, which VTK does not read: write it with line feeds");
    source.report.format = "legacy VTK";
    read_legacy(source, assembler);
  } else if (head.starts_with("CDF") || head.starts_with("\x89HDF")) {
    source.report.format = "Exodus";
    read_exodus(source, assembler);
  } else if (const std::string xml = without_comments(head); xml.find("<VTKFile") != std::string::npos) {
    const std::string type = xml_dataset_type(xml);
    if (type == "vtkMultiBlockDataSet" || type == "vtkPartitionedDataSetCollection")
      assembler.fail("is a list of files (VTM): name one of them, as internal.vtu of OpenFOAM");
    if (type == "Collection") assembler.fail("is a list of files (PVD): name one of them");
    if (type == "PolyData" || type == "PPolyData")
      assembler.fail("holds a surface (a dataset of type " + type + "): ptet needs a volume of tetrahedra");
    if (type != "UnstructuredGrid" && type != "PUnstructuredGrid")
      assembler.fail("holds a dataset of " + (type.empty() ? "unknown type" : "type " + type) +
                     ": ptet needs an UnstructuredGrid or PUnstructuredGrid, which ParaView's Append Datasets makes");
    source.report.format = type == "UnstructuredGrid" ? "VTU" : "PVTU";
    (type == "UnstructuredGrid" ? read_vtu : read_pvtu)(source, assembler);
  } else if (const std::string hint = what_to_do(head); !hint.empty()) {
    assembler.fail(hint);
  } else {
    assembler.fail("is no mesh that ptet reads (VTU, PVTU, legacy VTK, Exodus)");
  }
}

} // namespace

void check_readable(const std::string& path) {
  (void)open_file(path);
}

std::uint64_t AnnouncedMesh::bytes_to_read() const {
  constexpr double kIdBytes = 8, kGridCellBytes = 9, kTetBytes = 16; // 64-bit ids; an offset and a type
  constexpr double kPointsOfHexahedron = 8, kTetsOfHexahedron = 6;
  const auto all_cells = static_cast<double>(cells), all_ids = static_cast<double>(ids);
  // A hexahedron has four points more than a tet, and gives five tets or six.
  // Of more points than quadratic ones have (Lagrange's), a cell has one with eight points for each at most.
  const bool is_of_high_order = all_ids > static_cast<double>(kMaxCellPoints) * all_cells;
  const double to_split = is_of_high_order ? all_ids : std::min(all_cells, std::max(0.0, all_ids - 4 * all_cells) / 4);
  const double waiting_ids =
      is_of_high_order ? kPointsOfHexahedron * all_ids : std::max(0.0, all_ids - 4 * (all_cells - to_split));
  const double waiting = to_split * static_cast<double>(CellSplitting::bytes_of_cell()) +
                         waiting_ids * static_cast<double>(sizeof(VertexId));
  const double grid = kIdBytes * all_ids + kGridCellBytes * all_cells;
  // Polyhedra: faces as they are read and as they are kept, then tets or pyramids to be split, one of them for a corner
  // at most; and a point in each, which has twelve corners and more.
  constexpr double kFaceBytes = 22, kPartBytes = 26, kFewestCorners = 12;
  const auto all_corners = static_cast<double>(corners);
  const double of_middles =
      points == 0 ? 0 : all_corners / kFewestCorners * (point_bytes / static_cast<double>(points));
  const double reading = 2 * point_bytes + of_middles + grid + kTetBytes * std::max(0.0, all_cells - to_split) +
                         waiting + kFaceBytes * all_corners;
  // Of more than eight points, as quadratic cells have, up to half as many again, and twice as many of 27.
  const double of_tets = std::max(0.0, all_ids - 3 * all_cells);
  const double tets = is_of_high_order                            ? kTetsOfHexahedron * all_ids
                      : all_ids > kPointsOfHexahedron * all_cells ? 1.5 * of_tets
                                                                  : of_tets;
  const double splitting = point_bytes + of_middles + waiting + kTetBytes * tets + kPartBytes * all_corners;
  constexpr double kMost = 0x1p63; // whatever a damaged file announces
  return static_cast<std::uint64_t>(std::min(std::max(reading, splitting), kMost));
}

void check_memory(const Source& source, const AnnouncedMesh& announced) {
  const std::uint64_t needed = source.memory_limit == 0 ? 0 : announced.bytes_to_read();
  if (needed <= source.memory_limit) return;
  throw Error(ErrorCode::kLimit, source.path + ": reading " + grouped(announced.cells) + " cells and " +
                                     grouped(announced.points) + " points takes some " + grouped(needed) +
                                     " bytes of memory, and the limit is " + grouped(source.memory_limit));
}

} // namespace vtkio

namespace {

/// Whether a text, but for the tags of XML, holds a number that is none. VTK takes it in a legacy file for an
/// attribute, and at the end of an array of a VTU for what comes after it.
bool holds_no_number(const std::string& path) {
  static constexpr std::size_t kLongest = 8; // "infinity"
  std::ifstream file(path, std::ios::binary);
  std::string word;
  bool in_tag = false;
  for (std::istreambuf_iterator<char> at(file), end; at != end; ++at) {
    const auto c = static_cast<unsigned char>(*at);
    if (std::isalnum(c) != 0 || c == '_') {
      if (word.size() <= kLongest) word += static_cast<char>(std::tolower(c));
      continue;
    }
    if (!in_tag && (word == "nan" || word == "inf" || word == "infinity")) return true;
    word.clear();
    if (c == '<' || c == '>') in_tag = c == '<';
  }
  return false;
}

bool is_text(const std::string& path) {
  const std::string head = vtkio::read_head(path);
  return head.find("ASCII") != std::string::npos || head.find("\"ascii\"") != std::string::npos;
}

/// What `read(messages)` returns; what goes wrong in it, VTK's own exceptions too, becomes an Error.
template <class Read>
auto reading(const std::string& path, Read&& read) {
  try {
    vtkio::Messages messages;
    return read(messages);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kBadInput && is_text(path) && holds_no_number(path))
      throw Error(error.code(), std::string(error.what()) +
                                    "; there is a 'nan' or 'inf' in it, which cannot always be read "
                                    "from text: write the file in binary");
    throw;
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::kLimit, path + ": not enough memory for what the file announces");
  } catch (const std::exception& error) {
    // VTK's readers use standard containers on what they find in the file.
    throw Error(ErrorCode::kBadInput, path + ": is damaged (" + error.what() + ")");
  }
}

} // namespace

TetMesh read_mesh(const std::string& path, ReadReport* report, const ProgressCallback& progress,
                  std::uint64_t memory_limit) {
  ReadReport own_report;
  ReadReport& notes = report ? *report : own_report;
  notes = {};
  return reading(path, [&](vtkio::Messages& messages) {
    vtkio::Assembler assembler(path, notes, progress);
    vtkio::read_any({path, messages, progress, notes, memory_limit}, assembler);
    TetMesh mesh = assembler.finish();
    for (const std::string& warning : messages.warnings())
      notes.notes.push_back("VTK warns: " + warning);
    return mesh;
  });
}

std::vector<std::string> piece_files(const std::string& path) {
  try {
    vtkio::Messages messages; // of a damaged file: nobody asked for them
    const std::string head = vtkio::read_head(path);
    const bool is_pvtu = head.find("<VTKFile") != std::string::npos &&
                         vtkio::xml_dataset_type(vtkio::without_comments(head)) == "PUnstructuredGrid";
    return is_pvtu ? vtkio::pieces_of_pvtu(path) : std::vector<std::string>{};
  } catch (const std::exception&) {
    return {};
  }
}

std::string hash_input(const std::string& path, const std::vector<std::string>& more_files,
                       const ProgressCallback& progress) {
  static constexpr std::size_t kChunkBytes = 1 << 20;
  file::RunningHash hash;
  std::vector<std::byte> chunk(kChunkBytes);
  std::uint64_t done = 0;
  const auto add = [&](const std::string& part) {
    const vtkio::File input = vtkio::open_file(part);
    while (const std::size_t got = std::fread(chunk.data(), 1, chunk.size(), input.get())) {
      hash.add(std::span(chunk).first(got));
      done += got;
      if (progress && !progress({"hashing", done, 0})) throw Error(ErrorCode::kCancelled, "hashing was cancelled");
    }
    if (std::ferror(input.get())) vtkio::fail_to_read(part, std::strerror(errno));
  };
  add(path);
  for (const std::string& more : more_files)
    add(more);
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "xxh64:%016llx", static_cast<unsigned long long>(hash.value()));
  return text.data();
}

} // namespace ptet
