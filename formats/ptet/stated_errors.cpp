#include "formats/ptet/stated_errors.hpp"

#include "error/exact_field_error.hpp"
#include "error/field_values.hpp"
#include "error/surface_distance.hpp"
#include "error/tolerances.hpp"
#include "formats/ptet/version_table.hpp"
#include "mesh/prepare.hpp"
#include "mesh/vec3.hpp"
#include "ptet/error.hpp"
#include "record/ghost.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

namespace ptet::file {
namespace {

/// Rounding in the integral over a version, relative, times (its length)^3 / its volume, which is large for a flat one;
/// but no more than kMostFlatRounding.
constexpr double kFlatRounding = 16 * std::numeric_limits<double>::epsilon();
constexpr double kMostFlatRounding = 1e-6;
/// A squared error is a difference of two sums, and may be off by this part of their terms. Not of the field's range: a
/// huge value elsewhere in the mesh, such as one that stands for "no value", must not hide errors here.
constexpr double kSquaredRelative = 1e-7;
/// The distance of a face to the original boundary is measured to this relative accuracy.
constexpr double kDistanceRelative = 0.02;
/// Records between two reports of progress.
constexpr std::size_t kMeasureBatch = 1024;

/// The records that are looked at, ascending.
std::vector<std::uint32_t> chosen(std::uint32_t records, std::uint64_t samples) {
  std::vector<std::uint32_t> all(records);
  std::iota(all.begin(), all.end(), 0U);
  if (samples == 0 || samples >= records) return all;
  std::mt19937_64 random(1);
  for (std::uint32_t i = 0; i < samples; ++i)
    std::swap(all[i], all[i + random() % (records - i)]);
  all.resize(samples);
  std::sort(all.begin(), all.end());
  return all;
}

/// What was measured of one record.
struct Measured {
  std::vector<double> errors; ///< one a field, fractions of the range
  std::vector<double> rise;   ///< of the integral of the square, one a field, then of the uncovered volume; so the next
  std::vector<double> terms;  ///< sum of the magnitudes that it is the difference of
  double distance = 0;        ///< of the faces to the original boundary: attained
  double rounding = 0;        ///< of the terms, relative
  double volume_rounding = 0; ///< of the volumes of versions, together
  std::uint64_t versions = 0;
};

class Measurer {
public:
  explicit Measurer(const Verified& verified)
      : content_(*verified.content), versions_(content_.refinement), header_(verified.reader->header()),
        prepared_(prepare(finest_mesh(content_))), id_(content_.positions.size()),
        boundary_(triangles_of(prepared_.points, prepared_.boundary_faces)) {
    for (std::uint32_t v = 0; v < prepared_.original_vertex.size(); ++v)
      id_[prepared_.original_vertex[v].index()] = VertexId{v};
    for (std::uint32_t a = 0; a < header_.arrays.size(); ++a)
      if (header_.arrays[a].governing) add_field(a);
    values_ = FieldValues(prepared_.mesh, array_, range_, prepared_.used_vertex_count);
    exact_.emplace(prepared_, values_.view());
  }

  [[nodiscard]] std::size_t field_count() const { return range_.size(); }
  [[nodiscard]] double range(std::size_t f) const { return range_[f]; }
  [[nodiscard]] const ExactFieldError& exact() const { return *exact_; }

  [[nodiscard]] Measured measure(RecordId r, ExactFieldError::Workspace& workspace) const {
    const Refinement& refinement = content_.refinement;
    const std::size_t fields = field_count();
    Measured measured{std::vector<double>(fields), std::vector<double>(fields + 1), std::vector<double>(fields + 1)};
    std::vector<double> squared(fields + 1), ignored(fields);
    const auto add_volume = [&](const Tet& tet, double sign) {
      const double volume = tet_volume(corners_of(tet));
      measured.rise[fields] -= sign * volume;
      measured.terms[fields] += volume;
      measured.volume_rounding += kFlatRounding * cube_of_lengths(corners_of(tet));
    };
    const auto add = [&](const Tet& tet, std::vector<double>& errors, double sign) {
      std::fill(squared.begin(), squared.end(), 0.0);
      exact_->measure(numbered(tet), workspace, errors, squared);
      measured.rounding = std::max(measured.rounding, rounding_of(tet));
      ++measured.versions;
      for (std::size_t f = 0; f <= fields; ++f) {
        measured.rise[f] += sign * squared[f];
        measured.terms[f] += std::abs(squared[f]);
      }
      add_volume(tet, sign);
    };
    const double enough =
        decode_error(content_.own[(r.index() + std::size_t{1}) * content_.errors_per_record - 1], header_.diagonal) +
        distance_rounding();
    for (std::uint32_t k = 0; k < refinement.modified(r).size(); ++k) {
      const auto [a, b, c] = refinement.link_triangle(r, k);
      const Tet coarse{refinement.target(r), a, b, c};
      if (is_ghost(coarse))
        measured.distance = std::max(measured.distance, distance_of(coarse, enough));
      else
        add(coarse, measured.errors, 1);
    }
    if (!header_.has_squared_errors) return measured;
    bool moves_boundary = false;
    std::uint32_t number = versions_.number(r, 0);
    for (const Tet& fine : refinement.fine_tets(r)) {
      const RecordId creator = versions_.creator(number++);
      if (is_ghost(fine))
        moves_boundary = true;
      else if (creator.is_none()) // an original one: no error, all covered
        add_volume(fine, -1);
      else
        add(fine, ignored, -1);
    }
    if (!moves_boundary) measured.rise.back() = 0;
    return measured;
  }

  /// Distances up to this are rounding.
  [[nodiscard]] double distance_rounding() const { return kDistanceRounding * header_.diagonal; }

private:
  void add_field(std::uint32_t array) {
    range_.push_back(header_.arrays[array].range > 0 ? header_.arrays[array].range : 1);
    array_.push_back(array);
  }
  [[nodiscard]] Tet numbered(const Tet& tet) const {
    Tet result;
    for (std::size_t i = 0; i < 4; ++i)
      result[i] = id_[tet[i].index()];
    return result;
  }
  [[nodiscard]] std::array<Point, 4> corners_of(const Tet& version) const {
    const auto at = [&](std::size_t i) -> const Point& { return prepared_.points[id_[version[i].index()].index()]; };
    return {at(0), at(1), at(2), at(3)};
  }
  /// How far a version's integral may be off by rounding, relative: barycentric coordinates are quotients by the
  /// volume, which is little in a flat version.
  [[nodiscard]] double rounding_of(const Tet& version) const {
    const std::array<Point, 4> at = corners_of(version);
    const double volume = 6 * tet_volume(at);
    if (!(volume > 0)) return 0;
    return std::min(kFlatRounding * cube_of_lengths(at) / volume, kMostFlatRounding);
  }
  /// Of the edges from corner 0, their sum.
  [[nodiscard]] static double cube_of_lengths(const std::array<Point, 4>& at) {
    using namespace vec;
    const double length = norm(at[1] - at[0]) + norm(at[2] - at[0]) + norm(at[3] - at[0]);
    return length * length * length;
  }
  /// A distance to the original boundary that some point of the face has: the greatest one to kDistanceRelative, or
  /// any less than `enough` once it is clear that none is beyond it.
  [[nodiscard]] double distance_of(const Tet& ghost, double enough) const {
    Triangle face;
    std::size_t i = 0;
    for (const VertexId v : ghost)
      if (v != kDummyVertex) face[i++] = prepared_.points[id_[v.index()].index()];
    return boundary_.farthest(face, kDistanceRelative, enough).lower;
  }

  const Content& content_;
  VersionTable versions_;
  const Header& header_;
  PreparedMesh prepared_;
  std::vector<VertexId> id_; ///< of a vertex of the file in prepared_
  TriangleSurface boundary_;
  std::vector<double> range_;        ///< by field
  std::vector<std::uint32_t> array_; ///< by field
  FieldValues values_;
  std::optional<ExactFieldError> exact_;
};

/// What the file states of one record against what was measured.
class Judge {
public:
  Judge(const Verified& verified, const Measurer& measurer, StatedErrors& result, const Violations& violations)
      : content_(*verified.content), reader_(*verified.reader), measurer_(measurer), result_(result),
        violations_(violations), block_of_(blocks_by_record(reader_.blocks())) {
    for (const ArrayInfo& array : reader_.header().arrays)
      if (array.governing) result.errors.push_back({array.name, 0, 0, 0});
    result.errors.push_back({"domain", 0, 0, 0});
  }

  void judge(std::uint32_t r, const Measured& measured) {
    const std::size_t codes = content_.errors_per_record;
    const ErrorCode16* const own = content_.own.data() + r * codes;
    for (std::size_t f = 0; f + 1 < codes; ++f) {
      const double range = measurer_.range(f);
      compare(r, f, measured.errors[f] * range, decode_error(own[f], range), 0,
              "its error of '" + result_.errors[f].name + "' is above the stated one");
      if (reader_.header().has_squared_errors)
        compare_sums(r, f, measured, "its squared error of '" + result_.errors[f].name + "' is not the one stated");
    }
    if (reader_.header().has_squared_errors)
      compare_sums(r, codes - 1, measured, "what it uncovers is not the volume stated");
    const double diagonal = reader_.header().diagonal;
    compare(r, codes - 1, measured.distance, decode_error(own[codes - 1], diagonal), measurer_.distance_rounding(),
            "its domain error is above the stated one");
    ++result_.records;
    result_.versions += measured.versions;
  }

private:
  void wrong(std::uint32_t r, const std::string& what) {
    if (result_.are_bounds) violations_({what, reader_.blocks()[block_of_[r]].offset, block_of_[r], r, {}});
  }
  void compare(std::uint32_t r, std::size_t i, double measured, double stated, double rounding,
               const std::string& what) {
    StatedError& error = result_.errors[i];
    error.most = std::max(error.most, measured);
    if (measured <= std::max(stated * (1 + kErrorSlack), stated + rounding)) return;
    ++error.above;
    error.most_above =
        std::max(error.most_above, stated > 0 ? measured / stated : std::numeric_limits<double>::infinity());
    wrong(r, what);
  }
  void compare_sums(std::uint32_t r, std::size_t i, const Measured& measured, const std::string& what) {
    const double volume = reader_.header().volume;
    const SquaredErrorCode code = content_.squared_error[r * content_.errors_per_record + i];
    const double rise = measured.rise[i] / volume;
    double slack = std::max(kSquaredRelative, 64 * measured.rounding) * measured.terms[i] / volume;
    if (i + 1 == content_.errors_per_record) slack += measured.volume_rounding / volume;
    const double upper = decode_sum(reader_.header(), i, content_.errors_per_record, code);
    const double lower =
        decode_sum(reader_.header(), i, content_.errors_per_record, static_cast<SquaredErrorCode>(code - 1));
    if (rise <= upper + slack && rise >= lower - slack) return;
    wrong(r, what);
  }

  const Content& content_;
  const Reader& reader_;
  const Measurer& measurer_;
  StatedErrors& result_;
  const Violations& violations_;
  std::vector<std::uint32_t> block_of_;
};

} // namespace

StatedErrors check_stated_errors(const Verified& verified, std::uint64_t samples, const Violations& violations,
                                 const ProgressCallback& progress) {
  const auto go_on = [&](std::uint64_t done, std::uint64_t total) {
    if (progress && !progress({"measuring errors", done, total}))
      throw Error(ErrorCode::kCancelled, "the verification was cancelled");
  };
  StatedErrors result;
  result.are_bounds = verified.reader->manifest().states_bounds();
  go_on(0, 0);
  const Measurer measurer(verified);
  Judge judge(verified, measurer, result, violations);
  const auto records = chosen(verified.content->refinement.record_count(), samples);

  // A thread's takes some bytes for each tet and vertex of the original: only those that measure have one.
  oneapi::tbb::enumerable_thread_specific<ExactFieldError::Workspace> workspaces(
      [&] { return ExactFieldError::Workspace(measurer.exact()); });
  std::vector<Measured> measured;
  for (std::size_t begin = 0; begin < records.size(); begin += kMeasureBatch) {
    go_on(begin, records.size());
    const std::size_t end = std::min(begin + kMeasureBatch, records.size());
    measured.assign(end - begin, {});
    oneapi::tbb::parallel_for(begin, end, [&](std::size_t i) {
      measured[i - begin] = measurer.measure(RecordId{records[i]}, workspaces.local());
    });
    for (std::size_t i = begin; i < end; ++i)
      judge.judge(records[i], measured[i - begin]);
  }
  return result;
}

} // namespace ptet::file
