#include "build/piece_decisions.hpp"

#include "build/builder.hpp"
#include "build/checkpoint.hpp"
#include "build/describe_options.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace ptet::build {
namespace {

/// A piece is collapsed until this part of the vertices that may move in it is left.
constexpr double kLeftInPiece = 0.1;
/// Collapsed equally far the pieces are not equally good: of the collapses of all pieces this part is made, the
/// cheapest (each piece up to the same cost); the others are left to the second pass, to be weighed against all.
/// Without that a cut at 2% field error had 30.2% of the vertices of a graded mesh of 187 k tets, with it 24.5%,
/// whole 24.6%.
constexpr double kTaken = 0.75;

double target_part(const PreparedMesh& prepared, const BuildOptions& options) {
  return options.target_vertices < 1 ? options.target_vertices
                                     : options.target_vertices / static_cast<double>(prepared.used_vertex_count);
}

/// Of a piece: the most that a collapse might cost up to the end of a round, and where in the records it ends.
struct CostOfRound {
  double cost;
  std::size_t begin, end;
};

std::vector<CostOfRound> costs_of_rounds(const RecordStream& records, const std::vector<RoundReport>& walk) {
  std::vector<CostOfRound> costs;
  double cost = 0;
  std::size_t end = 0;
  for (const RoundReport& step : walk) {
    const std::size_t begin = end;
    while (end < records.round.size() && records.round[end] == records.round[begin])
      ++end;
    cost = std::max(cost, step.cost);
    costs.push_back({cost, begin, end});
  }
  return costs;
}

/// The cost up to which collapses are made.
double limit_of_cost(std::vector<CostOfRound> costs) {
  std::sort(costs.begin(), costs.end(), [](const CostOfRound& a, const CostOfRound& b) { return a.cost < b.cost; });
  std::size_t total = 0;
  for (const CostOfRound& round : costs)
    total += round.end - round.begin;
  std::size_t sum = 0;
  for (const CostOfRound& round : costs) {
    sum += round.end - round.begin;
    if (static_cast<double>(sum) >= kTaken * static_cast<double>(total)) return round.cost;
  }
  return 0;
}

} // namespace

/// As it is handed over.
struct PieceDecisions::OfPiece {
  BuildIdentity identity;
  std::uint32_t piece = 0;
  RecordStream records;
  std::vector<RoundReport> walk;
  std::array<std::uint64_t, kCollapseStatusCount> collapses{};
  std::uint64_t simulations = 0;
  std::uint64_t exact_evaluations = 0;

  template <class Archive>
  void serialize(Archive& archive, unsigned /*version*/) {
    archive& identity& piece& records.removed& records.target& records.round& records.field_error& records
        .outside_error& records.squared_error& records
        .uncovered_volume& walk& collapses& simulations& exact_evaluations;
  }
};

PieceDecisions::PieceDecisions(const PreparedMesh& prepared, const BuildOptions& options)
    : prepared_(prepared), options_(options), pieces_(prepared, options.pieces) {
  const NormalizedFields fields(prepared, options.fields);
  for (const GoverningField& field : fields.fields())
    arrays_.push_back(field.array);
  scales_ = scales_of(prepared, fields);
  identity_ = identity_of(prepared.mesh, describe_options(options, prepared, fields.fields()));
  if (options.evaluation == Evaluation::kSamples) samples_ = choose_samples(prepared.mesh.tets, fields);
}

/// Those of the whole mesh that lie in tets of the piece.
std::vector<Sample> PieceDecisions::samples_in(const MeshPiece& piece) const {
  std::vector<Sample> inside;
  auto sample = samples_.begin();
  for (std::uint32_t t = 0; t < piece.tet.size(); ++t) {
    sample = std::lower_bound(sample, samples_.end(), piece.tet[t],
                              [](const Sample& s, std::uint32_t tet) { return s.tet < tet; });
    for (; sample != samples_.end() && sample->tet == piece.tet[t]; ++sample)
      inside.push_back({t, sample->weight});
  }
  return inside;
}

std::vector<std::byte> PieceDecisions::decide(std::uint32_t index, const ProgressCallback& progress) const {
  OfPiece decided;
  decided.identity = identity_;
  decided.piece = index;
  const double left = std::max(kLeftInPiece, target_part(prepared_, options_));
  const auto goal_of = [left](std::uint32_t movable) {
    return static_cast<std::uint32_t>(std::floor(std::max(0.0, 1 - left) * movable));
  };
  if (progress && !progress({"collapsing", 0, 1})) throw Error(ErrorCode::kCancelled, "the build was cancelled");
  // A look at the piece takes one at all of the mesh.
  MeshPiece piece;
  if (goal_of(pieces_.vertex_count(index)) > 0) piece = pieces_.piece(index, arrays_);
  if (const std::uint32_t goal = goal_of(piece.movable_count); goal > 0) {
    BuildOptions options = options_;
    options.fields.clear();
    for (const PointArray& array : piece.prepared.mesh.point_arrays)
      options.fields.push_back(array.name);
    options.target_vertices = piece.prepared.used_vertex_count - goal;
    options.min_quality = min_quality_of(options_, prepared_); // of the whole
    BuildReport report;
    decided.records = collapse_part(piece.prepared, options, scales_, samples_in(piece), report, progress);
    for (std::vector<VertexId>* const ids : {&decided.records.removed, &decided.records.target})
      for (VertexId& v : *ids)
        v = piece.prepared.original_vertex[v.index()];
    decided.walk = std::move(report.walk);
    decided.collapses = report.collapses;
    decided.collapses[static_cast<std::size_t>(CollapseStatus::kFrozenVertex)] = 0; // counted in the whole mesh
    decided.simulations = report.simulations;
    decided.exact_evaluations = report.exact_evaluations;
  }
  file::ByteWriter bytes;
  file::OutputArchive archive(bytes);
  archive& decided;
  return bytes.take();
}

PieceDecisions::OfPiece PieceDecisions::read(std::uint32_t piece, std::span<const std::byte> bytes) const {
  const std::string place = "decisions of piece " + std::to_string(piece);
  file::ByteReader in(bytes, place, 0);
  file::InputArchive archive(in);
  OfPiece decided;
  archive& decided;
  in.finish();
  if (!(decided.identity == identity_) || decided.piece != piece)
    throw Error(ErrorCode::kBadArgument,
                "the " + place +
                    " are not of this build: mesh, options, program and number of pieces must be the same");
  const RecordStream& records = decided.records;
  const std::size_t count = records.removed.size();
  const auto fits = [&](const std::vector<double>& errors, bool are_known) {
    return errors.size() == (are_known ? count * arrays_.size() : 0);
  };
  std::set<std::uint32_t> rounds(records.round.begin(), records.round.end());
  if (records.target.size() != count || records.round.size() != count || !fits(records.field_error, true) ||
      !fits(records.outside_error, options_.evaluation == Evaluation::kExact) ||
      !fits(records.squared_error, options_.prediction == Prediction::kExact) ||
      records.uncovered_volume.size() != (options_.prediction == Prediction::kExact ? count : 0) ||
      decided.walk.size() != rounds.size() || !std::is_sorted(records.round.begin(), records.round.end()))
    throw Error(ErrorCode::kCorruptFile, "the " + place + " are damaged: their tables do not fit together");
  return decided;
}

Decisions PieceDecisions::merge(std::span<const std::vector<std::byte>> decided) const {
  if (decided.size() != piece_count())
    throw Error(ErrorCode::kBadArgument, "there are decisions of " + std::to_string(decided.size()) +
                                             " pieces; the mesh is cut in " + std::to_string(piece_count()));
  Decisions all;
  struct Source {
    OfPiece of;
    std::vector<CostOfRound> rounds{};
    std::size_t end = 0; ///< of the collapses that are made
    std::size_t next = 0, next_round = 0;
  };
  std::vector<Source> sources;
  std::vector<CostOfRound> costs;
  for (std::uint32_t p = 0; p < piece_count(); ++p) {
    Source& source = sources.emplace_back(Source{read(p, decided[p])});
    const OfPiece& of = source.of;
    source.rounds = costs_of_rounds(of.records, of.walk);
    costs.insert(costs.end(), source.rounds.begin(), source.rounds.end());
    for (std::size_t i = 0; i < all.collapses.size(); ++i)
      all.collapses[i] += of.collapses[i];
    all.simulations += of.simulations;
    all.exact_evaluations += of.exact_evaluations;
  }
  const double limit = limit_of_cost(std::move(costs));
  for (Source& source : sources)
    for (const CostOfRound& round : source.rounds)
      if (round.cost <= limit) source.end = round.end;
  for (;;) {
    constexpr std::uint32_t kNoRound = std::numeric_limits<std::uint32_t>::max();
    std::uint32_t round = kNoRound;
    for (const Source& source : sources)
      if (source.next < source.end) round = std::min(round, source.of.records.round[source.next]);
    if (round == kNoRound) break;
    double& cost = all.round_cost.emplace_back(0);
    for (std::uint32_t p = 0; p < sources.size(); ++p) {
      Source& source = sources[p];
      const RecordStream& from = source.of.records;
      if (source.next == source.end || from.round[source.next] != round) continue;
      cost = std::max(cost, source.of.walk[source.next_round++].cost);
      for (; source.next < source.end && from.round[source.next] == round; ++source.next) {
        const std::size_t i = source.next;
        all.piece.push_back(p);
        all.records.removed.push_back(from.removed[i]);
        all.records.target.push_back(from.target[i]);
        all.records.round.push_back(round);
        all.records.append_errors(from, i, arrays_.size());
      }
    }
  }
  return all;
}

} // namespace ptet::build
