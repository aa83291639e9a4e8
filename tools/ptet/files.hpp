// Looks at paths before the work starts, so that what is bound to fail fails at once and nothing is replaced by
// mistake.
#pragma once

#include "formats/vtk/read.hpp"
#include "ptet/dataset.hpp"
#include "ptet/error.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace ptet::cli {

/// Whether the file begins with the magic of a .ptet file, whatever its name.
/// Throws Error(kIo) with the system's reason when it cannot be opened or is a folder.
[[nodiscard]] bool is_ptet_file(const std::string& path);

/// 0 when the size cannot be had.
[[nodiscard]] std::uint64_t size_of_file(const std::string& path);

/// What to do where values are wanted that only cells have.
inline constexpr const char* kCellsToPoints =
    "give them to the points first, as ParaView's 'Cell Data to Point Data' does (VTK's vtkCellDataToPointData)";
/// Notes that where only cells have any.
void note_values_of_cells(const TetMesh& mesh, ReadReport& read);

/// Of a file that was read, and of the pieces that it names.
[[nodiscard]] std::uint64_t bytes_of(const std::string& path, const ReadReport& read);

/// Where to write when the user asked `option` for `path`: links are followed, for writers replace what stands under
/// the name. Throws Error: kIo when there is something other than a file, when it is write-protected, or the folder is
/// missing or not writable; kBadArgument when it is the file `input`.
[[nodiscard]] std::string checked_output(const std::string& option, const std::string& path, const std::string& input);

/// Of a .ptet file where the user sets no limit: it may take as much memory as the machine has, and no less than
/// without being told.
[[nodiscard]] Limits machine_limits();
/// Opens a .ptet file. It may take `memory_limit` bytes, or without one what machine_limits() says. Throws what
/// Dataset::open throws.
[[nodiscard]] std::shared_ptr<const Dataset> open_dataset(const std::string& path,
                                                          std::optional<std::uint64_t> memory_limit = {});

/// Calls `f` for the .ptet file `path`, and puts the path before what it says when the file is corrupt.
template <class F>
decltype(auto) about_file(const std::string& path, F&& f) {
  try {
    return f();
  } catch (const Error& error) {
    const std::string name = "'" + path + "': ";
    if (error.code() != ErrorCode::kCorruptFile || std::string_view(error.what()).starts_with(name)) throw;
    throw Error(error.code(), name + error.what());
  }
}

} // namespace ptet::cli
