// What `ptet extract` says after an extraction: what was asked and what was achieved.
#pragma once

#include "ptet/dataset.hpp"

#include <optional>
#include <string>
#include <vector>

namespace ptet::cli {

/// Everything there is to say after an extraction.
struct ExtractOutcome {
  std::string input;
  std::optional<std::string> output;
  DatasetInfo info;
  Request request;
  Extraction extraction;
  std::uint64_t bytes = 0; ///< of the extraction, as Request::max_bytes counts them
  double seconds = 0;      ///< opening and extraction
  double write_seconds = 0;
  std::vector<std::string> notes;
};

/// Of points, fields, tets and boundary faces.
[[nodiscard]] std::uint64_t bytes_of(const Extraction& extraction);

void print_json(const ExtractOutcome& outcome);
void print_text(const ExtractOutcome& outcome);

} // namespace ptet::cli
