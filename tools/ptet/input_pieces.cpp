#include "input_pieces.hpp"

#include "formats/vtk/read.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <vector>

namespace ptet::cli {

bool is_piece(const std::string& file, const std::string& mesh) {
  std::error_code status;
  if (!std::filesystem::exists(file, status)) return false;
  const std::vector<std::string> pieces = piece_files(mesh);
  return std::any_of(pieces.begin(), pieces.end(),
                     [&](const std::string& piece) { return std::filesystem::equivalent(file, piece, status); });
}

void refuse_piece(const std::string& option, const std::string& target, const std::string& mesh) {
  if (!is_piece(target, mesh)) return;
  throw Error(ErrorCode::kBadArgument,
              option + " '" + target + "': this is a piece of '" + mesh + "'; give the output another name");
}

} // namespace ptet::cli
