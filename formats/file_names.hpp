// The names of files, as users give them.
#pragma once

#include <algorithm>
#include <filesystem>
#include <string>
#include <system_error>

namespace ptet {

/// Whether two names are of one file, also of one that is not there yet.
[[nodiscard]] inline bool is_same_file(const std::string& a, const std::string& b) {
  namespace fs = std::filesystem;
  std::error_code status;
  if (fs::equivalent(a, b, status)) return true;
  status.clear();
  const fs::path whole_a = fs::weakly_canonical(fs::absolute(a, status), status);
  if (status) return false; // in a folder that is gone
  const fs::path whole_b = fs::weakly_canonical(fs::absolute(b, status), status);
  return !status && whole_a == whole_b;
}

/// The ending of a name, with its dot and in small letters.
[[nodiscard]] inline std::string ending_of(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + ('a' - 'A')) : c; });
  return ending;
}

} // namespace ptet
