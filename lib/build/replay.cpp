#include "build/replay.hpp"

#include "build/piece_decisions.hpp"
#include "ptet/error.hpp"

#include <string_view>
#include <vector>

namespace ptet::build {
namespace {

/// Collapses made again between two reports of progress.
constexpr std::size_t kReplayBatch = 4096;

void tell(std::string_view stage, std::size_t done, std::size_t total, const ProgressCallback& progress) {
  if (done % kReplayBatch == 0 && progress && !progress({stage, done, total}))
    throw Error(ErrorCode::kCancelled, "the build was cancelled");
}

} // namespace

std::string replay(const RecordStream& decided, Collapser& collapser, const ProgressCallback& progress) {
  RecordStream& records = collapser.records();
  const std::size_t count = decided.removed.size();
  const std::size_t fields = records.fields.size();
  if (decided.target.size() != count || decided.round.size() != count || decided.domain_error.size() != count ||
      decided.field_error.size() != count * fields ||
      (!decided.outside_error.empty() && decided.outside_error.size() != count * fields) ||
      (!decided.squared_error.empty() && decided.squared_error.size() != count * fields) ||
      (!decided.uncovered_volume.empty() && decided.uncovered_volume.size() != count))
    return "its tables differ in length";
  for (std::size_t i = 0; i < count; ++i) {
    tell("going on from the checkpoint", i, count, progress);
    if (!collapser.collapse_again(decided.removed[i].index(), decided.target[i].index(), decided.round[i]))
      return "collapse " + std::to_string(i) + " is not possible";
    if (records.domain_error.back() != decided.domain_error[i])
      return "collapse " + std::to_string(i) + " has another domain error here";
  }
  records.field_error = decided.field_error;
  records.outside_error = decided.outside_error;
  records.squared_error = decided.squared_error;
  records.uncovered_volume = decided.uncovered_volume;
  return {};
}

void follow(const Decisions& decided, Collapser& collapser, BuildReport& report, const ProgressCallback& progress) {
  RecordStream& records = collapser.records();
  const RecordStream& from = decided.records;
  const std::size_t count = from.removed.size();
  std::vector<char> is_over(report.pieces);
  std::size_t round = 0;
  for (std::size_t i = 0; i < count; ++i) {
    tell("joining the pieces", i, count, progress);
    char& over = is_over[decided.piece[i]];
    if (over == 0 && collapser.collapse_again(from.removed[i].index(), from.target[i].index(), from.round[i])) {
      records.append_errors(from, i, records.fields.size());
    } else {
      over = 1;
    }
    if (i + 1 < count && from.round[i + 1] == from.round[i]) continue;
    ++report.rounds;
    report.depth = collapser.depth();
    report.walk.push_back({collapser.vertices_left(), decided.round_cost[round++]});
  }
  report.piece_records = records.size();
  report.piece_records_dropped = count - records.size();
  for (std::size_t i = 0; i < report.collapses.size(); ++i)
    report.collapses[i] += decided.collapses[i];
  report.simulations = decided.simulations;
  report.exact_evaluations = decided.exact_evaluations;
}

} // namespace ptet::build
