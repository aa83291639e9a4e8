// All that can be found wrong with a .ptet file, at once: PTET.md walked rule by rule.
//
//   layout     header, footer, directory, every section and every block: constraints and hashes
//   records    all blocks decoded, but those that cannot be and those that need them: what a reader checks, and
//              what it need not: that monotone errors and generations are exactly those that the specification says,
//              and records in their order
//   geometry   every version that is a tet positively oriented (exact predicate); box and volume of the header
//
// A violation that only makes what it says wrong is told and passed over; one that leaves no way to go on is told, and
// what lies behind it is not looked at: the header, footer or table as a whole, or a block and what needs it.
#pragma once

#include "formats/ptet/reader.hpp"
#include "formats/ptet/violation.hpp"
#include "ptet/progress.hpp"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace ptet::file {

/// A file as far as it could be read.
struct Verified {
  std::unique_ptr<Reader> reader;     ///< null when there is no way to the table
  std::optional<Content> content;     ///< with the records of `decoded`; none when there is no way to the base
  std::vector<std::uint32_t> decoded; ///< blocks, ascending
  bool is_oriented = false;           ///< no version that was looked at is inverted
  std::vector<std::string> notes;     ///< what is right, or was not looked at, and is worth knowing

  /// Whether all was looked at that there is.
  [[nodiscard]] bool is_whole() const { return content && decoded.size() == reader->blocks().size(); }
};

/// Looks at everything; tells each violation once, in the order of the list above. `limits`: of what is loaded, which
/// is all of the file. Throws Error: kIo, kLimit, kCancelled. Cost: that of loading all, and of one exact predicate a
/// version.
[[nodiscard]] Verified verify(const std::shared_ptr<ByteSource>& source, const Violations& violations,
                              const ProgressCallback& progress = {}, const Limits& limits = {});

/// The mesh of all that is finest in `content`, vertices in the file's order.
[[nodiscard]] TetMesh finest_mesh(const Content& content);

} // namespace ptet::file
