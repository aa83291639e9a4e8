// Requests out of any bytes, in the order of the bytes; zeros once they are used up.
#pragma once

#include "fuzz/mutate_file.hpp"
#include "ptet/dataset.hpp"

namespace ptet::fuzz {

class FuzzedRequests {
public:
  FuzzedRequests(Input bytes, const DatasetInfo& info) : bytes_(bytes), info_(info) {}

  [[nodiscard]] bool has_more() const { return !bytes_.empty(); }
  [[nodiscard]] std::uint64_t number(std::size_t width);
  /// In 0 .. 1, near 0 mostly, or any double at all.
  [[nodiscard]] double fraction();
  /// Anything that can be asked but time, which no two machines have alike.
  [[nodiscard]] Request next();
  /// One error bound for all fields, for one, for the domain; none, or no tets at all.
  [[nodiscard]] Request next_bound();

private:
  [[nodiscard]] Bound bound() { return {fraction(), true}; }
  [[nodiscard]] std::string field();
  [[nodiscard]] Point point();
  [[nodiscard]] Point vector() { return {fraction() - 0.5, fraction() - 0.5, fraction() - 0.25}; }
  [[nodiscard]] Region region();
  [[nodiscard]] View view();

  Input bytes_;
  const DatasetInfo& info_;
};

} // namespace ptet::fuzz
