#include "formats/vtk/sources.hpp"
#include "mesh/number_text.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include <vtkDoubleArray.h>
#include <vtkExodusIIReader.h>
#include <vtkFloatArray.h>
#include <vtkInformation.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkUnstructuredGrid.h>
#include <vtk_exodusII.h>
#include <vtk_netcdf.h>

namespace ptet::vtkio {
namespace {

/// The first block of the output is that of the element blocks, one child each.
constexpr unsigned kElementBlocks = 0;

void note_time(vtkExodusIIReader& reader, int steps, ReadReport& report) {
  vtkInformation& info = *reader.GetOutputInformation(0);
  std::string note =
      "the values are those of the last of " + grouped(static_cast<std::uint64_t>(steps)) + " time steps";
  if (info.Has(vtkStreamingDemandDrivenPipeline::TIME_STEPS()) &&
      info.Length(vtkStreamingDemandDrivenPipeline::TIME_STEPS()) == steps)
    note += " (time " + number_text(info.Get(vtkStreamingDemandDrivenPipeline::TIME_STEPS())[steps - 1]) + ")";
  report.notes.push_back(note);
}

/// The least that a file of netCDF's classic formats takes: its header, and all of its tables, written or not. Reading
/// beyond the end gives zeros.
///
/// Source: NetCDF Classic Format Specification (header, vsize, recsize).
std::uint64_t classic_bytes(int file, int format) {
  const std::uint64_t count = format == NC_FORMAT_CDF5 ? 8 : 4, offset = format == NC_FORMAT_CLASSIC ? 4 : 8;
  const auto padded = [](std::uint64_t bytes) { return (bytes + 3) / 4 * 4; };
  const auto size_of_type = [&](nc_type type) {
    std::size_t bytes = 0;
    nc_inq_type(file, type, nullptr, &bytes);
    return std::uint64_t{bytes};
  };
  const auto name_bytes = [&](const char* name) { return count + padded(std::strlen(name)); };
  std::array<char, NC_MAX_NAME + 1> name{};
  int dimensions = 0, attributes = 0, variables = 0, unlimited = -1;
  nc_inq(file, &dimensions, &variables, &attributes, &unlimited);
  const auto bytes_of_attributes = [&](int variable, int number) {
    std::uint64_t bytes = 4 + count;
    for (int i = 0; i < number; ++i) {
      nc_type type = NC_BYTE;
      std::size_t length = 0;
      if (nc_inq_attname(file, variable, i, name.data()) != NC_NOERR ||
          nc_inq_att(file, variable, name.data(), &type, &length) != NC_NOERR)
        continue;
      bytes += name_bytes(name.data()) + 4 + count + padded(length * size_of_type(type));
    }
    return bytes;
  };

  std::uint64_t header = 4 + count + 4 + count + bytes_of_attributes(NC_GLOBAL, attributes) + 4 + count;
  std::vector<std::uint64_t> lengths(static_cast<std::size_t>(dimensions));
  for (int i = 0; i < dimensions; ++i) {
    std::size_t length = 0;
    nc_inq_dim(file, i, name.data(), &length);
    lengths[static_cast<std::size_t>(i)] = length;
    header += name_bytes(name.data()) + count;
  }
  double tables = 0, step = 0; // products of what a damaged header says
  std::vector<int> along(NC_MAX_VAR_DIMS);
  for (int i = 0; i < variables; ++i) {
    nc_type type = NC_BYTE;
    int rank = 0;
    if (nc_inq_var(file, i, name.data(), &type, &rank, along.data(), &attributes) != NC_NOERR) continue;
    header += name_bytes(name.data()); // before the names of attributes take its place
    header +=
        count + static_cast<std::uint64_t>(rank) * count + bytes_of_attributes(i, attributes) + 4 + count + offset;
    double bytes = static_cast<double>(size_of_type(type));
    for (int d = 0; d < rank; ++d)
      if (along[static_cast<std::size_t>(d)] != unlimited)
        bytes *= static_cast<double>(lengths[static_cast<std::size_t>(along[static_cast<std::size_t>(d)])]);
    (rank > 0 && along[0] == unlimited ? step : tables) += bytes;
  }
  const double steps = unlimited < 0 ? 0 : static_cast<double>(lengths[static_cast<std::size_t>(unlimited)]);
  const double all = static_cast<double>(header) + tables + steps * step;
  return all < 0x1p63 ? static_cast<std::uint64_t>(all) : std::uint64_t{1} << 63;
}

/// Opens the file as what it is underneath, and looks at the sizes of its tables. The Exodus library prints when this
/// fails, and counts to whatever a damaged size says.
void check_netcdf(const Source& source, const Assembler& assembler) {
  int file = 0;
  if (const int status = nc_open(source.path.c_str(), NC_NOWRITE, &file); status != NC_NOERR)
    assembler.fail(std::string("is not an Exodus file, or is damaged: ") + nc_strerror(status));
  const std::shared_ptr<void> closing(nullptr, [file](void*) { nc_close(file); });

  int format = 0;
  int dimensions = 0;
  nc_inq_format(file, &format);
  nc_inq_ndims(file, &dimensions);
  const bool compressed = format == NC_FORMAT_NETCDF4 || format == NC_FORMAT_NETCDF4_CLASSIC;
  const std::uint64_t file_bytes = std::filesystem::file_size(source.path);
  const std::uint64_t largest = (compressed ? kMaxCompression : 1) * file_bytes;
  for (int i = 0; i < dimensions; ++i) {
    std::array<char, NC_MAX_NAME + 1> name{};
    std::size_t length = 0;
    if (nc_inq_dim(file, i, name.data(), &length) != NC_NOERR || length > largest)
      assembler.fail(std::string("is damaged: its dimension '") + name.data() + "' is " + grouped(length) +
                     ", more than the file can hold");
  }
  if (compressed) return;
  if (const std::uint64_t needed = classic_bytes(file, format); needed > file_bytes)
    assembler.fail("is cut short: it has " + grouped(file_bytes) + " bytes, and what it says that it holds takes " +
                   grouped(needed) + " at least");
}

/// Says what of an open file's parts does not come through: which element blocks there were, and all sets.
void note_parts(int file, const ex_init_params& sizes, const std::vector<std::int64_t>& blocks, ReadReport& report) {
  constexpr std::size_t kMostBlockNames = 8;
  if (blocks.size() > 1) {
    std::string names;
    for (std::size_t i = 0; i < std::min(blocks.size(), kMostBlockNames); ++i) {
      std::array<char, 256> name{}; // a name is up to 32 characters where nobody asks for more
      if (ex_get_name(file, EX_ELEM_BLOCK, blocks[i], name.data()) < 0) name[0] = '\0';
      names += (i == 0 ? "" : ", ") + (name[0] != '\0' ? std::string(name.data()) : std::to_string(blocks[i]));
    }
    if (blocks.size() > kMostBlockNames) names += ", ...";
    report.notes.push_back(grouped(blocks.size()) + " element blocks (" + names +
                           ") are joined; which cell was in which is not carried");
  }
  const auto note_sets = [&](std::int64_t count, const char* kind) {
    if (count > 0)
      report.notes.push_back(grouped(static_cast<std::uint64_t>(count)) + " " + kind +
                             (count == 1 ? " set is" : " sets are") + " not carried");
  };
  note_sets(sizes.num_node_sets, "node");
  note_sets(sizes.num_side_sets, "side");
}

struct ElementBlock {
  std::int64_t id;
  std::string type;   ///< "TETRA", "HEX20", ...
  std::int64_t nodes; ///< of an element, but for polygons and polyhedra
};

/// The nodes that VTK's reader takes for an element of a kind when it does not know their number; 0 for other kinds.
std::int64_t least_nodes(const std::string& type) {
  static const std::map<std::string, std::int64_t> kLeast = {{"BAR", 2}, {"TRU", 2}, {"BEA", 2}, {"EDG", 2},
                                                             {"TRI", 3}, {"QUA", 4}, {"TET", 4}, {"PYR", 5},
                                                             {"WED", 6}, {"HEX", 8}};
  std::string kind = type.substr(0, 3);
  std::transform(kind.begin(), kind.end(), kind.begin(), [](unsigned char c) { return std::toupper(c); });
  const auto found = kLeast.find(kind);
  return found != kLeast.end() ? found->second : 0;
}

[[noreturn]] void fail_at_nodes(const ElementBlock& block, const Assembler& assembler) {
  assembler.fail("block " + std::to_string(block.id) + " holds elements '" + block.type + "' of " +
                 std::to_string(block.nodes) +
                 " nodes, which VTK's reader does not know: write them as TETRA4, TETRA10, HEX8, HEX20, HEX27, WEDGE6, "
                 "WEDGE15, PYRAMID5 or PYRAMID13");
}

/// Reads the values of the last step, which VTK's reader leaves as it finds them in memory where that fails. Returns
/// how many variables there are.
int check_variables(int file, std::int64_t nodes, const Assembler& assembler) {
  int variables = 0;
  if (ex_get_variable_param(file, EX_NODAL, &variables) != EX_NOERR)
    assembler.fail("is damaged: it does not say how many nodal variables it has");
  const int step = static_cast<int>(ex_inquire_int(file, EX_INQ_TIME));
  std::vector<double> values(variables > 0 && step > 0 ? static_cast<std::size_t>(nodes) : 0);
  for (int i = 1; i <= variables; ++i) {
    std::array<char, NC_MAX_NAME + 1> name{};
    if (ex_get_variable_name(file, EX_NODAL, i, name.data()) != EX_NOERR)
      assembler.fail("is damaged: its nodal variable " + std::to_string(i) + " has no name");
    if (step > 0 && ex_get_var(file, step, EX_NODAL, i, 1, nodes, values.data()) != EX_NOERR)
      assembler.fail("the values of its nodal variable '" + std::string(name.data()) +
                     "' cannot be read: the file is damaged, or its writer left out what Exodus asks for (files of "
                     "meshio 5.0 lack the attribute 'file_size')");
  }
  int of_elements = 0;
  if (ex_get_variable_param(file, EX_ELEM_BLOCK, &of_elements) != EX_NOERR) of_elements = 0;
  for (int i = 1; i <= of_elements; ++i) {
    std::array<char, NC_MAX_NAME + 1> name{};
    if (ex_get_variable_name(file, EX_ELEM_BLOCK, i, name.data()) != EX_NOERR)
      assembler.fail("is damaged: its element variable " + std::to_string(i) + " has no name");
  }
  return variables;
}

/// VTK's reader makes one array of scalars whose names differ in the last letter only, as ux, uy and uz.
void note_joined(vtkExodusIIReader& reader, int variables, ReadReport& report) {
  const int arrays = reader.GetNumberOfPointResultArrays();
  if (arrays >= variables) return;
  std::string names;
  for (int i = 0; i < arrays; ++i)
    if (reader.GetNumberOfObjectArrayComponents(vtkExodusIIReader::NODAL, i) > 1)
      names += (names.empty() ? "'" : ", '") + std::string(reader.GetPointResultArrayName(i)) + "'";
  report.notes.push_back(grouped(static_cast<std::uint64_t>(variables)) + " nodal variables are read as " +
                         grouped(static_cast<std::uint64_t>(arrays)) +
                         " arrays: those of one name but for its end are " + "components of one vector (" + names +
                         ")");
}

/// Gives the floats back that VTK's reader made doubles of. An array with a value that no float has stays as it is.
void narrow(vtkPoints& points, vtkPointData& arrays) {
  const auto narrowed = [](vtkDataArray* from) -> vtkSmartPointer<vtkFloatArray> {
    auto* const doubles = vtkDoubleArray::FastDownCast(from);
    if (doubles == nullptr) return nullptr;
    auto floats = vtkSmartPointer<vtkFloatArray>::New();
    floats->DeepCopy(doubles); // names of components, too
    const double* const first = doubles->GetPointer(0);
    const bool same = std::equal(first, first + doubles->GetNumberOfValues(), floats->GetPointer(0),
                                 [](double x, float y) { return x == y || (std::isnan(x) && std::isnan(y)); });
    return same ? floats : nullptr;
  };
  if (const auto floats = narrowed(points.GetData())) points.SetData(floats);
  for (int i = 0; i < arrays.GetNumberOfArrays(); ++i) // one of the same name takes the place of the old one
    if (const auto floats = narrowed(arrays.GetArray(i))) arrays.AddArray(floats);
}

struct Contents {
  std::vector<ElementBlock> blocks; ///< in the order of the file
  int nodal_variables = 0;
  bool are_floats = false; ///< its numbers
  AnnouncedMesh announced;
};

/// Asks for what VTK's reader will ask for: it goes on after a refusal, with tables that it has not filled.
Contents check_exodus(const Source& source, const Assembler& assembler) {
  int word_bytes = sizeof(double);
  int file_word_bytes = 0;
  float version = 0;
  const int file = ex_open(source.path.c_str(), EX_READ, &word_bytes, &file_word_bytes, &version);
  if (file < 0) assembler.fail("is not an Exodus file, or is damaged");
  const std::shared_ptr<void> closing(nullptr, [file](void*) { ex_close(file); });
  ex_set_int64_status(file, EX_ALL_INT64_API);

  ex_init_params sizes{};
  if (ex_get_init_ext(file, &sizes) < 0) assembler.fail("is damaged: its sizes cannot be read");
  if (sizes.num_dim != 3) assembler.fail("does not have three coordinates");
  if (sizes.num_nodes < 1 || sizes.num_elem_blk < 1) assembler.fail("holds no cells: ptet needs tetrahedra");
  std::vector<std::int64_t> ids(static_cast<std::size_t>(sizes.num_elem_blk));
  if (ex_get_ids(file, EX_ELEM_BLOCK, ids.data()) < 0) assembler.fail("is damaged: its blocks have no ids");
  std::int64_t cells = 0;
  Contents contents;
  for (const std::int64_t id : ids) {
    ex_block block{};
    block.id = id;
    block.type = EX_ELEM_BLOCK;
    if (ex_get_block_param(file, &block) < 0 || block.num_entry < 0)
      assembler.fail("is damaged: block " + std::to_string(id) + " cannot be read");
    cells += block.num_entry;
    contents.announced.ids += static_cast<std::uint64_t>(block.num_entry) *
                              static_cast<std::uint64_t>(std::max<std::int64_t>(0, block.num_nodes_per_entry));
    contents.blocks.push_back({id, block.topology, block.num_nodes_per_entry});
    if (block.num_entry > 0 && block.num_nodes_per_entry < least_nodes(block.topology))
      fail_at_nodes(contents.blocks.back(), assembler);
  }
  if (std::set<std::int64_t>(ids.begin(), ids.end()).size() != ids.size())
    assembler.fail("is damaged: two blocks have one id");
  if (cells != sizes.num_elem) assembler.fail("is damaged: its blocks do not hold as many cells as it says");
  contents.nodal_variables = check_variables(file, sizes.num_nodes, assembler);
  contents.announced.points = static_cast<std::uint64_t>(sizes.num_nodes);
  contents.announced.cells = static_cast<std::uint64_t>(cells);
  contents.announced.point_bytes =
      static_cast<double>(sizes.num_nodes) * static_cast<double>(sizeof(double)) * (3 + contents.nodal_variables);
  note_parts(file, sizes, ids, source.report);
  contents.are_floats = file_word_bytes == sizeof(float);
  if (ex_inquire_int(file, EX_INQ_TIME) > 0) {
    int globals = 0;
    if (ex_get_variable_param(file, EX_GLOBAL, &globals) == EX_NOERR && globals > 0)
      source.report.notes.push_back(grouped(static_cast<std::uint64_t>(globals)) +
                                    (globals == 1 ? " global variable is" : " global variables are") + " not carried");
  }
  return contents;
}

} // namespace

void read_exodus(const Source& source, Assembler& assembler) {
  check_netcdf(source, assembler);
  const Contents contents = check_exodus(source, assembler);
  check_memory(source, contents.announced);
  vtkNew<vtkExodusIIReader> reader;
  reader->SetFileName(source.path.c_str());
  reader->UpdateInformation();
  source.messages.throw_on_error(source.path);

  // Points as they are in the file, all of them in every block: blocks then share their numbering.
  reader->SetApplyDisplacements(false);
  reader->SetSqueezePoints(false);
  reader->SetGenerateObjectIdCellArray(false);
  reader->SetAllArrayStatus(vtkExodusIIReader::ELEM_BLOCK, 1);
  for (int i = 0; i < reader->GetNumberOfElementResultArrays(); ++i)
    assembler.note_cell_array(reader->GetElementResultArrayName(i));
  const int steps = reader->GetNumberOfTimeSteps();
  if (steps > 0) {
    reader->SetAllArrayStatus(vtkExodusIIReader::NODAL, 1);
    note_joined(*reader, contents.nodal_variables, source.report);
  } else if (contents.nodal_variables > 0) {
    source.report.notes.emplace_back("nodal variables have no values: the file has no time steps");
  }
  if (steps > 1) note_time(*reader, steps, source.report);
  if (steps > 0) reader->SetTimeStep(steps - 1);

  const ProgressWatch watch(*reader, "reading", source.progress);
  reader->Update();
  watch.throw_on_cancel();
  source.messages.throw_on_error(source.path);

  auto* blocks = vtkMultiBlockDataSet::SafeDownCast(reader->GetOutput()->GetBlock(kElementBlocks));
  // VTK has the blocks by their ids; cells are to come in the order of the file.
  std::map<std::int64_t, vtkUnstructuredGrid*> by_id;
  for (unsigned i = 0; blocks && i < blocks->GetNumberOfBlocks(); ++i)
    by_id[reader->GetObjectId(vtkExodusIIReader::ELEM_BLOCK, static_cast<int>(i))] =
        vtkUnstructuredGrid::SafeDownCast(blocks->GetBlock(i));
  vtkIdType points = -1;
  for (const ElementBlock& block : contents.blocks) {
    const auto found = by_id.find(block.id);
    vtkUnstructuredGrid* const grid = found != by_id.end() ? found->second : nullptr;
    if (!grid) continue;
    constexpr std::int64_t kLeastOfSolids = 4;
    if (grid->GetNumberOfCells() > 0 && least_nodes(block.type) >= kLeastOfSolids &&
        grid->GetCells()->GetCellSize(0) != block.nodes)
      fail_at_nodes(block, assembler);
    if (points < 0) {
      points = grid->GetNumberOfPoints();
      if (contents.are_floats && grid->GetPoints() != nullptr) narrow(*grid->GetPoints(), *grid->GetPointData());
      assembler.add_points(*grid);
    }
    if (grid->GetNumberOfPoints() != points) assembler.fail("blocks do not share their points");
    assembler.add_cells(*grid);
  }
}

} // namespace ptet::vtkio
