// The files that a mesh consists of besides the one that the user names.
#pragma once

#include <string>

namespace ptet::cli {

/// Whether `file` is there, and is one that the PVTU `mesh` names.
[[nodiscard]] bool is_piece(const std::string& file, const std::string& mesh);

/// Throws Error(kBadArgument) when `target`, where the user asked `option` to write, is a piece of `mesh`.
void refuse_piece(const std::string& option, const std::string& target, const std::string& mesh);

} // namespace ptet::cli
