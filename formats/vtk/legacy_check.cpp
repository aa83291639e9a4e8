#include "formats/vtk/number_text.hpp"
#include "formats/vtk/scalar_types.hpp"
#include "formats/vtk/sources.hpp"
#include "mesh/number_text.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <set>

#include <vtkCellType.h>

namespace ptet::vtkio {
namespace {

/// The numbers of a type of the legacy format, as VTK reads them; nothing: not numbers of a known size.
std::optional<ScalarType> number_type(const std::string& type) {
  static const std::map<std::string, int> kTypes = {{"char", VTK_CHAR},
                                                    {"signed_char", VTK_SIGNED_CHAR},
                                                    {"unsigned_char", VTK_UNSIGNED_CHAR},
                                                    {"short", VTK_SHORT},
                                                    {"unsigned_short", VTK_UNSIGNED_SHORT},
                                                    {"int", VTK_INT},
                                                    {"unsigned_int", VTK_UNSIGNED_INT},
                                                    {"long", VTK_LONG},
                                                    {"unsigned_long", VTK_UNSIGNED_LONG},
                                                    {"long_long", VTK_LONG_LONG},
                                                    {"unsigned_long_long", VTK_UNSIGNED_LONG_LONG},
                                                    {"vtktypeint64", VTK_TYPE_INT64},
                                                    {"vtktypeuint64", VTK_TYPE_UINT64},
                                                    {"vtkidtype", VTK_INT},
                                                    {"float", VTK_FLOAT},
                                                    {"double", VTK_DOUBLE}};
  const auto found = kTypes.find(type);
  return found == kTypes.end() ? std::nullopt : scalar_type(found->second);
}

// VTK asks for as much memory as a count says and puts there what it finds, without a look at whether the file holds as
// much, or whether the count is negative. This goes through the file before VTK does, and looks.
class LegacyWalk {
public:
  explicit LegacyWalk(const std::string& path)
      : path_(path), bytes_(std::filesystem::file_size(path)), stream_(path, std::ios::binary) {}

  void check() {
    read_head();
    while (true) {
      const std::string keyword = word();
      if (keyword.empty()) break;
      if (keyword == "points") {
        points_ = count();
        read_now_ = "the points";
        skip_point_values(3, word());
      } else if (keyword == "cells") {
        read_cells();
      } else if (keyword == "cell_types") {
        read_cell_types();
      } else if (keyword == "field") {
        skip_fields();
      } else if (keyword == "metadata") {
        skip_metadata();
      } else if (keyword == "point_data") {
        begin_attributes(points_, "points");
        of_points_ = true;
      } else if (keyword == "cell_data") {
        begin_attributes(cells_, "cells");
        of_points_ = false;
      } else if (!rows_ || !skip_attribute(keyword)) {
        fail("unknown keyword " + quoted(keyword));
      }
    }
    if (cells_ != cell_types_) fail("has " + grouped(cells_) + " cells and " + grouped(cell_types_) + " cell types");
  }
  /// Names that several arrays at the points have: VTK's reader keeps the last of them, and says nothing.
  [[nodiscard]] const std::set<std::string>& lost() const { return lost_; }
  /// After check().
  [[nodiscard]] AnnouncedMesh announced() const { return {points_, cells_, ids_, point_bytes_}; }
  /// Whether the last number may go on where the file ends: a text that was cut short is whole but for that.
  [[nodiscard]] bool may_lack_digits() {
    if (binary_ || bytes_ == 0) return false;
    stream_.clear();
    stream_.seekg(-1, std::ios::end);
    return std::isspace(stream_.get()) == 0;
  }

private:
  [[noreturn]] void fail(const std::string& reason) const { throw Error(ErrorCode::kBadInput, path_ + ": " + reason); }

  static std::string quoted(const std::string& text) {
    std::string shown = text.substr(0, 32);
    std::replace_if(
        shown.begin(), shown.end(), [](unsigned char c) { return !std::isprint(c); }, '?');
    return '\'' + shown + '\'';
  }

  /// The next word; empty at the end of the file. VTK's own words are at most 255 long.
  std::string plain_word() {
    std::string text;
    stream_ >> std::ws;
    for (int c = stream_.peek(); c != std::ifstream::traits_type::eof() && !std::isspace(c); c = stream_.peek()) {
      if (text.size() == 255) fail("a word is too long to be one of a VTK file");
      text += static_cast<char>(stream_.get());
    }
    return text;
  }
  static std::string lower(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
    return text;
  }
  std::string word() { return lower(plain_word()); }

  std::uint64_t count() { return count(word()); }
  std::uint64_t count(const std::string& text) {
    if (text.empty()) fail("ends early");
    const bool digits = std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c); });
    if (!digits || text.size() > 18) fail(quoted(text) + " is not a count");
    const std::uint64_t value = std::stoull(text);
    // The smallest value takes a byte (binary), or a digit and a space.
    if (value > bytes_) fail("announces " + grouped(value) + " values, more than the file can hold");
    return value;
  }

  std::uint64_t multiplied(std::uint64_t a, std::uint64_t b) const {
    if (a != 0 && b > bytes_ / a) fail("announces more values than the file can hold");
    return a * b;
  }

  void skip_line_end() {
    std::string rest;
    std::getline(stream_, rest);
  }

  /// Of the attributes that were begun last.
  void skip_rows(std::uint64_t components, const std::string& type) {
    if (of_points_)
      skip_point_values(components, type);
    else
      skip_values(multiplied(*rows_, components), type);
  }
  void skip_point_values(std::uint64_t components, const std::string& type) {
    const std::uint64_t values = multiplied(points_, components);
    if (const std::optional<ScalarType> number = number_type(type))
      point_bytes_ += static_cast<double>(values) * static_cast<double>(size_of(*number));
    skip_values(values, type);
  }
  void skip_values(std::uint64_t values, const std::string& type) {
    if (type == "string" || type == "utf8_string") return skip_strings(values);
    const bool is_bits = type == "bit";
    const std::optional<ScalarType> number = number_type(type);
    if (type == "variant") {
      skip_words(multiplied(values, 2)); // a number for its type each, and the value
    } else if (!number && !is_bits) {
      fail("holds values of the unknown type " + quoted(type));
    } else if (binary_) {
      skip_line_end();
      skip_bytes(is_bits ? (values + 7) / 8 : multiplied(values, size_of(*number)));
    } else if (is_bits) {
      skip_words(values);
    } else {
      skip_numbers(values, *number, type);
    }
  }
  // VTK takes numbers out of the range of some types for others, and stops at what it cannot read.
  void skip_numbers(std::uint64_t values, ScalarType number, const std::string& type) {
    for (std::uint64_t i = 0; i < values; ++i) {
      const std::string text = plain_word();
      if (text.empty()) fail("is cut short");
      const char* fault = unfitness(text, number);
      const bool is_float = number == ScalarType::kFloat32 || number == ScalarType::kFloat64;
      if (!fault && is_float && text.find_first_of("nN") != std::string::npos) fault = "cannot be read from text";
      if (!fault) continue;
      fail("value " + grouped(i) + " of " + read_now_ + ", " + quoted(text) + " of type " + type + ", " + fault);
    }
  }
  void skip_bytes(std::uint64_t length) {
    if (length > bytes_ - position()) fail("is cut short");
    stream_.seekg(static_cast<std::streamoff>(length), std::ios::cur);
  }
  void skip_words(std::uint64_t words) {
    for (std::uint64_t i = 0; i < words; ++i)
      if (word().empty()) fail("is cut short");
  }
  // A line each, or bytes after their number, of which the first two bits say how many bytes it has itself.
  void skip_strings(std::uint64_t strings) {
    skip_line_end();
    for (std::uint64_t i = 0; i < strings; ++i) {
      if (!binary_) {
        skip_line_end();
      } else {
        const int first = stream_.peek();
        if (first < 0) fail("is cut short");
        const int bytes = 8 >> (first >> 6);
        std::uint64_t length = 0;
        for (int byte = 0; byte < bytes; ++byte) {
          const int next = stream_.get();
          if (next < 0) fail("is cut short");
          length = length << 8 | static_cast<std::uint64_t>(byte == 0 ? next & 0x3F : next);
        }
        skip_bytes(length);
      }
      if (!stream_) fail("is cut short");
    }
  }

  std::uint64_t position() {
    const auto at = stream_.tellg();
    return at < 0 ? bytes_ : static_cast<std::uint64_t>(at);
  }

  void read_head() {
    std::string line;
    std::getline(stream_, line);
    // As VTK looks for it: other files it would take for the oldest version.
    int major = 0;
    int minor = 0;
    if (std::sscanf(line.c_str(), "# vtk DataFile Version %d.%d", &major, &minor) != 2)
      fail("has no version in its first line");
    has_offsets_ = major >= 5;
    std::getline(stream_, line);
    if (line.size() > 255) fail("has a title of more than 255 characters");
    const std::string encoding = word();
    if (encoding != "ascii" && encoding != "binary") fail("is neither ASCII nor BINARY");
    binary_ = encoding == "binary";
    const std::string keyword = word();
    if (keyword != "dataset") fail("holds no dataset");
    const std::string dataset = word();
    if (dataset == "polydata")
      fail("holds a surface (a dataset of type 'polydata'): ptet needs a volume of tetrahedra");
    if (dataset != "unstructured_grid")
      fail("holds a dataset of type " + quoted(dataset) +
           ": ptet needs an unstructured_grid, which ParaView's Append Datasets makes");
  }

  void read_cells() {
    if (has_offsets_) {
      const std::uint64_t offsets = count();
      ids_ = count();
      cells_ = offsets == 0 ? 0 : offsets - 1;
      read_now_ = "the table of cells";
      if (offsets == 0) return;
      if (word() != "offsets") fail("has no offsets of its cells");
      skip_values(offsets, word());
      if (word() != "connectivity") fail("has no connectivity of its cells");
      skip_values(ids_, word());
      return;
    }
    cells_ = count();
    const std::uint64_t size = count();
    if (binary_) {
      skip_line_end();
      if (multiplied(size, 4) > bytes_ - position()) fail("is cut short");
    }
    std::uint64_t used = 0;
    for (std::uint64_t cell = 0; cell < cells_; ++cell) {
      const std::int64_t points = next_int();
      if (points < 0 || static_cast<std::uint64_t>(points) >= size - used)
        fail("cell " + std::to_string(cell) + " does not fit in the table of cells");
      used += static_cast<std::uint64_t>(points) + 1;
      for (std::int64_t i = 0; i < points; ++i)
        next_int();
      if (used == size && cell + 1 < cells_) fail("has fewer cells than it says");
    }
    if (used != size) fail("has a table of cells of another size than it says");
    ids_ = size - cells_;
  }

  // VTK follows the faces of a polyhedron through the table of cells without a look at where that ends, and takes the
  // lowest byte of a type.
  void read_cell_types() {
    cell_types_ = count();
    if (binary_) {
      skip_line_end();
      if (multiplied(cell_types_, 4) > bytes_ - position()) fail("is cut short");
    }
    for (std::uint64_t cell = 0; cell < cell_types_; ++cell) {
      const std::int64_t type = next_int();
      if (type < 0 || type > 255)
        fail("cell " + std::to_string(cell) + " has the type " + std::to_string(type) + ", and there is none such");
      if (type == VTK_POLYHEDRON)
        fail("cell " + std::to_string(cell) +
             " is a polyhedron, which ptet reads from .vtu files only: save the mesh as one, as ParaView does");
    }
  }

  std::int64_t next_int() {
    if (binary_) {
      std::array<unsigned char, 4> raw{};
      stream_.read(reinterpret_cast<char*>(raw.data()), 4);
      if (!stream_) fail("is cut short");
      return static_cast<std::int32_t>(static_cast<std::uint32_t>(raw[0]) << 24 |
                                       static_cast<std::uint32_t>(raw[1]) << 16 |
                                       static_cast<std::uint32_t>(raw[2]) << 8 | raw[3]);
    }
    const std::string text = word();
    if (text.empty()) fail("is cut short");
    if (unfitness(text, ScalarType::kInt32)) fail(quoted(text) + " is not a point id or cell type");
    return std::stoi(text);
  }

  void begin_attributes(std::uint64_t rows, const std::string& what) {
    const std::uint64_t stated = count();
    if (stated != rows) fail("has " + grouped(rows) + ' ' + what + " and data of " + grouped(stated) + ' ' + what);
    rows_ = rows;
  }

  void read_name() { add_name(plain_word()); }
  void add_name(const std::string& name) {
    read_now_ = "array " + quoted(name);
    if (of_points_ && !names_.insert(name).second) lost_.insert(name);
  }

  /// Of the points or the cells, whichever were begun last. Returns whether there is such an attribute.
  bool skip_attribute(const std::string& keyword) {
    static const std::map<std::string, std::uint64_t> kComponents = {
        {"vectors", 3},    {"normals", 3},      {"tensors", 9},   {"tensors6", 6},
        {"global_ids", 1}, {"pedigree_ids", 1}, {"edge_flags", 1}};
    if (const auto found = kComponents.find(keyword); found != kComponents.end()) {
      read_name();
      skip_rows(found->second, word());
    } else if (keyword == "scalars") {
      read_name();
      const std::string type = word();
      std::string next = word();
      std::uint64_t components = 1;
      if (next != "lookup_table") {
        components = count(next);
        next = word();
      }
      if (next != "lookup_table") fail("has scalars without a LOOKUP_TABLE");
      word();
      skip_rows(components, type);
    } else if (keyword == "color_scalars") {
      read_name();
      skip_rows(count(), binary_ ? "unsigned_char" : "float");
    } else if (keyword == "texture_coordinates") {
      read_name();
      const std::uint64_t components = count();
      skip_rows(components, word());
    } else if (keyword == "lookup_table") {
      read_now_ = "lookup table " + quoted(word());
      skip_values(multiplied(count(), 4), binary_ ? "unsigned_char" : "float");
    } else {
      return false;
    }
    return true;
  }

  void skip_fields() {
    word();
    const std::uint64_t arrays = count();
    for (std::uint64_t i = 0; i < arrays; ++i) {
      std::string name = plain_word();
      if (i > 0 && lower(name) == "metadata") { // of the array before
        skip_metadata();
        name = plain_word();
      }
      if (lower(name) == "null_array") continue;
      add_name(name);
      const std::uint64_t components = count();
      const std::uint64_t rows = count();
      if (of_points_ && rows == points_)
        skip_point_values(components, word());
      else
        skip_values(multiplied(components, rows), word());
    }
  }

  // Names and numbers, until a line is empty: which one that begins with a 0 byte is to VTK, too.
  void skip_metadata() {
    skip_line_end();
    std::string line;
    while (std::getline(stream_, line) && line.find_first_not_of(" \r\t") != std::string::npos)
      if (line.size() > 255 || line.find('\0') != std::string::npos) fail("has metadata that are no text");
  }

  std::string path_;
  std::uint64_t bytes_;
  std::ifstream stream_;
  bool binary_ = false;
  bool has_offsets_ = false; ///< from version 5 on: cells as offsets and connectivity
  std::uint64_t points_ = 0;
  double point_bytes_ = 0;
  std::uint64_t cells_ = 0;
  std::uint64_t ids_ = 0;
  std::uint64_t cell_types_ = 0;
  std::optional<std::uint64_t> rows_; ///< of the attributes that follow
  bool of_points_ = false;            ///< they are
  std::string read_now_;              ///< what the numbers belong to, for messages
  std::set<std::string> names_, lost_;
};

} // namespace

AnnouncedMesh check_legacy(const Source& source) {
  LegacyWalk walk(source.path);
  walk.check();
  for (const std::string& name : walk.lost())
    source.report.notes.push_back("several point arrays are called '" + name + "': only the last of them is read");
  if (walk.may_lack_digits())
    source.report.notes.emplace_back(
        "the last line has no end: if the file was cut short, its last number lacks digits");
  return walk.announced();
}

} // namespace ptet::vtkio
