// The offline wing: from a mesh to a .ptet file.
#pragma once

#include "ptet/bounds.hpp"
#include "ptet/mesh.hpp"
#include "ptet/progress.hpp"
#include "ptet/validate.hpp"

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace ptet {

/// What became of one half-edge collapse that was tried. Every refusal is counted in the build report.
enum class CollapseStatus : std::uint8_t {
  kAccepted,
  kFrozenVertex,        ///< the vertex lies where the mesh is not a manifold, or beside a defect
  kBoundaryVertex,      ///< a boundary vertex may only move along an edge of the boundary
  kLinkCondition,       ///< Lk(vs) n Lk(vd) != Lk(e), boundary closed by the dummy vertex
  kStarTooLarge,        ///< the star of the target would pass the cap, BuildOptions::max_star
  kRemovedStarTooLarge, ///< the star of the removed vertex is larger than the builder takes apart, whatever the cap
  kInverted,            ///< a modified tet would not be positively oriented (exact predicate)
  kQuality,             ///< a modified tet would be below the floor and worse than the worst of the old star
  kSurfaceTopology,     ///< the boundary surface would stop being a manifold
  kSelfIntersection,    ///< the boundary would meet another part of itself
  kDomainError,         ///< the domain error would pass its hard limit
  kFieldError,          ///< a field error would pass its limit
};
inline constexpr std::size_t kCollapseStatusCount = 12;
[[nodiscard]] std::string_view name_of(CollapseStatus status);

/// What tells which collapse comes next. The letters are those of Cignoni et al. 2000, section 5.
enum class Prediction {
  kLocal,       ///< L: the error at the removed vertex, added up over the collapses (5.1)
  kGradient,    ///< G: how much the gradient of the field differs along the edge (5.2)
  kQuadric,     ///< Q: quadrics of field and domain (5.3)
  kWeightedSum, ///< gradient, volume and edge length terms added up (Staadt and Gross 1998)
  kPerTet,      ///< deviations added up tet by tet (Trotts et al. 1999)
  kSimulate,    ///< BF: every half-edge is simulated and its error measured where `evaluation` looks (4.4)
  kExact,       ///< the best few by quadrics are simulated, the best of these measured everywhere, and put back if
                ///< they are not the best any more
};

/// Where the recorded errors are measured: those of fields, and how far the domain moves.
enum class Evaluation {
  kNone,     ///< nowhere: what the prediction believes
  kVertices, ///< at removed vertices: fast; between them the true error may be larger. The domain's: at samples
  kSamples,  ///< at removed vertices and samples in the original tets. The domain's: at samples
  kExact,    ///< everywhere: the exact maximum over each tet and the domain; a bound on that of the domain
};

/// Which field error is kept small, where collapses are simulated.
enum class Objective {
  kMaximum,        ///< the greatest
  kRootMeanSquare, ///< the mean square over the domain
  /// Both together, by the root of the sum of their squares: the greatest as a fraction of the field's range, the mean
  /// square as one of its standard deviation over the domain.
  kBoth,
};

/// As in options and reports: "quadric", "vertices", "max".
[[nodiscard]] std::string_view name_of(Prediction prediction);
[[nodiscard]] std::string_view name_of(Evaluation evaluation);
[[nodiscard]] std::string_view name_of(Objective objective);

/// Where a long build keeps what it has done, so that it can go on after an interruption. The build that goes on makes
/// the same file, byte for byte, as one that was not interrupted, on any number of threads. A checkpoint belongs to a
/// mesh, options (but for the threads) and a program: with others it is refused. It is trusted: damage is found by its
/// hash, but a forged one is not, so go on only from those that you wrote.
struct CheckpointOptions {
  /// The file, written whole or not at all; empty: none. Removed by build_file() once its own file is there. Its folder
  /// must be there: else Error(kIo), before anything is done. Where it cannot be written later the build goes on and
  /// BuildReport tells, unless the build ends there.
  std::string path;
  /// Seconds between two checkpoints, at least: one is written when the next round of collapses (or, after these, the
  /// next batch of certified records) is done; besides, when all collapses are done and when the build is cancelled.
  double every_seconds = 300;
  /// true: go on from the checkpoint at `path`, which must be there. false: begin anew; nothing may be there.
  bool resume = false;
};

/// The largest mesh that a build takes.
inline constexpr std::uint64_t kMostVerticesToBuild = 0x7FFFFFEF;
inline constexpr std::uint64_t kMostTetsToBuild = std::uint64_t{1} << 28;
/// The ranges of BuildOptions::max_star and BuildOptions::pieces.
inline constexpr std::uint32_t kLeastMaxStar = 8, kGreatestMaxStar = 4096;
inline constexpr std::uint32_t kMostPieces = 65536;

struct BuildOptions {
  /// Names of the point arrays whose errors are measured, recorded and kept small; empty: every floating-point array,
  /// and if there is none every array. The other arrays are carried along, bit for bit.
  std::vector<std::string> fields;
  /// Hard limits on the field errors of a collapse: one that would pass its field's is refused. Each names a governing
  /// field, or none for all of them. Empty: no limit.
  std::vector<FieldBound> max_field_error;
  /// Hard limit on the domain error of a collapse: one that would pass it is refused. Infinity: no limit.
  Bound max_domain_error{0.02, true};
  /// Stop at this number of vertices, of those that tets use, or at this fraction of them when < 1. The build also
  /// stops when nothing more can be collapsed; the report says which.
  double target_vertices = 0.01;
  /// Floor of the shape measure 6 sqrt(2) V / Lmax^3 (1: regular, 0: flat). A modified tet below it is refused unless
  /// it is no worse than the worst of the star it comes from. In [0, 1). None: 1e-3, or less for meshes with flat
  /// parts, so that plates, shells and layers along walls can get coarser, too, which makes their tets flatter: a
  /// twentieth of what all tets have but the flattest twentieth (of some 20,000), or of a thousandth of their median
  /// where that is more.
  std::optional<double> min_quality;
  /// Not every pair goes together: kExact needs Evaluation::kExact, kSimulate any but Evaluation::kNone. Whoever wants
  /// less evaluation has to name another prediction.
  Prediction prediction = Prediction::kExact;
  Evaluation evaluation = Evaluation::kExact;
  Objective objective = Objective::kBoth;
  /// Cap on the number of tets and boundary faces around a vertex after a collapse; a star that is larger already may
  /// stay so. In kLeastMaxStar .. kGreatestMaxStar.
  std::uint32_t max_star = 64;
  /// Collapses are made in rounds. Each looks at this part of the candidates, the best ones, in (0, 1], and makes those
  /// whose stars no other collapse of the round has touched. The smaller, the nearer to collapsing strictly by error;
  /// the larger, the fewer rounds, and the fewer splits depend on one another. Half as large, where costs are measured
  /// (Prediction::kExact), has some 3% smaller errors and takes a fifth more time.
  double round_fraction = 0.3;
  /// In 1 .. kMostPieces. More than 1: the mesh is cut in so many pieces of equally many vertices. In a first pass each
  /// piece is collapsed by itself, one after the other, with its seams frozen; that takes memory for the mesh and for
  /// one piece's collapsing. In a second pass the seams and all that is left are collapsed together. The file depends
  /// on the number of pieces, not on where they were collapsed (ptet/pieces_build.hpp). A checkpoint besides is
  /// refused.
  std::uint32_t pieces = 1;
  /// First make one point of those that are alike in place and all values, within what is given (ptet/weld.hpp; 0: bit
  /// for bit): the mesh that is built from, and comes back, is the welded one; so are the counts of the report, and the
  /// order that is kept. None: all points stay.
  std::optional<Bound> weld;
  /// Also keep in what order vertices, tets and their corners stood, so that the original comes back in that order
  /// where it is asked for (Request::input_order). Takes some 2 bytes a vertex and up to 3 a tet, 4 of very large
  /// meshes.
  bool keep_order = false;
  /// Worker threads, 1024 at most; 0: as many as the machine has. The file does not depend on it.
  unsigned threads = 0;
  /// The most resident memory that the process may come to, in bytes; 0: no limit. A build that is foreseen to take
  /// more is refused with kLimit: before anything is allocated, by the counts of the mesh, and again when its boundary
  /// is known. It also ends so between two rounds when the process, with whatever else it does, comes near the limit.
  /// The file does not depend on it.
  std::uint64_t memory_limit = 0;
  CheckpointOptions checkpoint;
};

/// How far a build had come at the end of a round: a point of its walk in error space (Cignoni et al. 2000, 4.3).
struct RoundReport {
  std::uint64_t vertices = 0; ///< that are left, of those that tets use
  double cost = 0;            ///< the most that a collapse of this round might cost
  double field_error = 0;     ///< largest recorded so far, of any field, as a fraction of its range
  double domain_error = 0;    ///< largest recorded so far, as a fraction of the diagonal
};

struct BuildReport {
  std::uint64_t input_vertices = 0;
  std::uint64_t input_tets = 0;
  std::uint64_t base_vertices = 0; ///< that tets of the base mesh use
  std::uint64_t base_tets = 0;
  std::uint64_t records = 0;
  std::uint32_t rounds = 0;
  std::uint32_t depth = 0; ///< longest chain of records that depend on one another
  double min_quality = 0;  ///< BuildOptions::min_quality, or what it was taken to be
  /// How many tries came to each CollapseStatus; under kFrozenVertex the number of vertices that were never tried.
  std::array<std::uint64_t, kCollapseStatusCount> collapses{};
  /// Why the build ended: "target", or "no candidate left" and what kept the half-edges that are left from being
  /// collapsed.
  std::string stopped_by;
  /// By CollapseStatus: how often each stood against a half-edge when all that were left had been tried in vain; zeros
  /// when the target was reached.
  std::array<std::uint64_t, kCollapseStatusCount> last_refusals{};
  std::uint64_t simulations = 0;       ///< half-edges that were simulated at the removed vertices
  std::uint64_t exact_evaluations = 0; ///< half-edges whose exact errors were measured before they were taken
  /// By governing field its name and the largest error recorded, in field units; errors at removed vertices outside of
  /// the mesh count, too.
  std::vector<std::pair<std::string, double>> field_error;
  double domain_error = 0;            ///< largest recorded, mesh units
  std::vector<RoundReport> walk;      ///< one for each of `rounds`
  std::vector<std::string> notes;     ///< what was found in the input and done about it
  std::uint64_t cut_dependencies = 0; ///< between records, added so that the boundary of no cut crosses itself
  std::uint64_t file_bytes = 0;
  double collapse_seconds = 0; ///< wall time of the collapse loop, candidates and checks included
  double certify_seconds = 0;  ///< wall time of an exact evaluation after the collapses; 0 when there was none
  double total_seconds = 0;
  /// Collapses taken over from a checkpoint and made again, without a search. All other counts are of the whole build,
  /// seconds of this run.
  std::uint64_t resumed_records = 0;
  double resume_seconds = 0;          ///< wall time of that
  std::uint32_t checkpoints = 0;      ///< written in this run
  std::uint64_t checkpoint_bytes = 0; ///< of the last one
  double checkpoint_seconds = 0;      ///< wall time that writing them took
  /// That could not be written, and why the last of them could not; the build went on.
  std::uint32_t checkpoints_failed = 0;
  std::string checkpoint_failure;
  std::uint32_t pieces = 1;        ///< that the mesh was cut in
  std::uint64_t piece_records = 0; ///< collapses decided in pieces
  /// Decided in a piece, but not possible in the whole mesh, or after one that was not: left to the second pass.
  std::uint64_t piece_records_dropped = 0;
  double piece_seconds = 0;  ///< wall time of collapsing the pieces, where that was done by this call
  double follow_seconds = 0; ///< wall time of making their collapses in the whole mesh
  /// The most resident memory that the process had by the end of the build, whatever had it; 0 where the system does
  /// not tell.
  std::uint64_t peak_memory_bytes = 0;
  /// What was foreseen of it when the boundary was known, see BuildOptions::memory_limit.
  std::uint64_t foreseen_memory_bytes = 0;
};

/// Simplifies `mesh` and writes all its levels to `path`, through a temporary file beside it that is synced and then
/// renamed: under `path` there is the old file or the whole new one.
///
/// Returns the report of the build.
/// `source_name` and `source_hash` go into the manifest as provenance; either may be empty. Bytes in them that are not
/// UTF-8 are read as Latin-1.
/// Throws Error: kBadArgument (options, a checkpoint of another build), kBadInput (mesh, fields), kCorruptFile (the
/// checkpoint), kIo, kLimit, kCancelled. Nothing is left behind but a checkpoint that was asked for.
/// Thread rule: uses options.threads threads. Same input and options: same bytes.
/// Source: Cignoni et al., Simplification of Tetrahedral Meshes with Accurate Error Evaluation, IEEE Vis 2000,
/// sections 4 and 5.
BuildReport build_file(TetMesh mesh, const std::string& path, const BuildOptions& options = {},
                       const std::string& source_name = {}, const std::string& source_hash = {},
                       const ProgressCallback& progress = {});

/// The same without a file: returns the bytes that build_file would write, which Dataset::open_memory opens. With the
/// same source_name and source_hash they are equal, byte for byte.
///
/// `report`: where the report of the build goes, or nullptr. Throws Error as build_file does, kIo only for the
/// checkpoint; when it throws, `*report` may hold a part of a report.
[[nodiscard]] std::vector<std::byte> build_memory(TetMesh mesh, const BuildOptions& options = {},
                                                  BuildReport* report = nullptr, const std::string& source_name = {},
                                                  const std::string& source_hash = {},
                                                  const ProgressCallback& progress = {});

} // namespace ptet
