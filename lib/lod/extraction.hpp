// From a cut to the mesh: what the splits of the cut leave in each place.
#pragma once

#include "lod/cut.hpp"

#include <optional>
#include <span>
#include <vector>

namespace ptet {

/// Fills all of Extraction but bytes_read and seconds. The lock must be held.
///
/// Vertices come in ascending file id; tets and faces base first, then with the records that bring their places: an
/// order that does not depend on what was read when.
[[nodiscard]] Extraction extract_cut(const Hierarchy& hierarchy, const Cut& cut, const ResolvedRequest& request);

/// Of a record that is not in the cut `applied` (by record): whether some version in C(r), of the kind asked for, is in
/// the cut's mesh, so that the record's errors count. Such a version is one of the base, or came with the split of a
/// parent that is in the cut. The lock must be held.
[[nodiscard]] bool has_made(const Refinement& refinement, std::uint32_t r, VersionKinds kind,
                            const std::vector<char>& applied);

/// A sum of what records raise something by (file::BlockInfo::squared_error).
class SquaredErrorSum {
public:
  void add(double x);
  SquaredErrorSum& operator+=(const SquaredErrorSum& other);
  /// Never below the true one by rounding, and not below 0.
  [[nodiscard]] double upper() const;

private:
  double sum_ = 0, magnitude_ = 0;
  std::size_t count_ = 0;
};

/// Sets `sums`, one per governing field and one of what is not covered, to what the records of a block that are not in
/// the cut contribute. A block of which some records are in the cut and some are not must be loaded. The lock must be
/// held.
void sum_squared_errors(const Hierarchy& hierarchy, const std::vector<char>& applied, std::size_t block,
                        std::span<SquaredErrorSum> sums);

/// See Extraction.
struct MeanErrors {
  std::vector<double> rms_error; ///< one per governing field, or none
  std::optional<double> covered;
};
/// Sets them for the cut that `sums`, over all blocks, are of; `field_error`: its largest errors, which bound the
/// others.
void set_mean_errors(const Hierarchy& hierarchy, std::span<const SquaredErrorSum> sums,
                     const std::vector<double>& field_error, MeanErrors& mean);
/// Of the cut in which the splits `applied` (by record) are. As for sum_squared_errors.
[[nodiscard]] MeanErrors mean_errors(const Hierarchy& hierarchy, const std::vector<char>& applied,
                                     const std::vector<double>& field_error);

} // namespace ptet
