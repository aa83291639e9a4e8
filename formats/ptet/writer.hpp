// The .ptet writer: orders the records from coarse to fine, codes them in blocks and writes the file whole or not.
#pragma once

#include "formats/ptet/input_order.hpp"
#include "formats/ptet/manifest.hpp"
#include "ptet/mesh.hpp"
#include "ptet/progress.hpp"
#include "record/stream.hpp"

#include <string>

namespace ptet::file {

/// What a file can hold.
inline constexpr std::uint64_t kMaxFileVertices = 0x7FFFFFEF, kMaxFileTets = 0x3FFFFFFE, kMaxFileVersions = 0xFFFFFFFD;

/// So many threads at most count what each context of the range coder is told.
inline constexpr std::size_t kMaxCounters = 4;

/// Throws Error for a mesh that no .ptet file can hold: kLimit of too many vertices, tets, point arrays or components
/// of one, kBadInput of an array without a name, of two of one name, and of a name with a zero byte. write() and
/// encode() throw the same; this says it before a build.
void check_storable(const TetMesh& mesh);

/// Writes `mesh` (full resolution, in the numbering of `records`; its tets are taken from these) with its records to
/// `path`, through a temporary file in the same folder, synced and renamed. Returns the size of the file in bytes.
/// The memory of both is given back as they are written. `records`: valid, see RecordStream::validate().
/// Unused vertices are kept as base vertices without tets. `given`: the input's ids, where its order is to be kept;
/// null: it is not. Throws Error: kIo (message names the path and the system's reason), kLimit, kCancelled. Nothing is
/// left behind.
std::uint64_t write(const std::string& path, TetMesh mesh, RecordStream records, const Manifest& manifest,
                    const ProgressCallback& progress = {}, const GivenIds* given = nullptr);

/// The same bytes, in memory.
[[nodiscard]] std::vector<std::byte> encode(TetMesh mesh, RecordStream records, const Manifest& manifest,
                                            const ProgressCallback& progress = {}, const GivenIds* given = nullptr);

} // namespace ptet::file
