#include "build/memory_need.hpp"

#include "build/process_memory.hpp"
#include "build/startable_threads.hpp"
#include "formats/ptet/schema.hpp"
#include "formats/ptet/writer.hpp"
#include "mesh/governing.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <oneapi/tbb/info.h>

namespace ptet::build {
namespace {

// What builds have come to, at most, of 0.2 to 10 million tets, cubes, balls and given meshes.
constexpr double kModified = 18.5;      ///< tets and boundary faces that a collapse changes
constexpr double kConsumed = 25;        ///< and takes from the star
constexpr double kPoolGrowth = 1.5;     ///< of the stars' pool
constexpr double kListGrowth = 1.5;     ///< of lists that grow with the records, and their old copies while they grow
constexpr double kParents = 14;         ///< records that a record needs
constexpr double kLink = 13.5;          ///< vertices of its link
constexpr double kSurfaceSampled = 420; ///< a boundary face in the half-edge surface and its index
constexpr double kSurfaceBound = 1100;  ///< and with the pieces that it stands for
constexpr double kPiece = 2200;         ///< a piece: what it has decided, and the same read
/// What allocation adds: while collapsing lists grow; those of the writer have their size from the start.
constexpr double kOverhead = 1.08, kWriteOverhead = 1.04;
/// The large pages at the ends of lists that are not used up; where all is little there are none.
constexpr double kPageEnds = 24e6, kPageEndsAtMost = 0.125;
/// Code, tables of libraries, small things.
constexpr double kFixed = 16e6;

constexpr double kNearLimit = 0.97;

bool measures_in_loop(const BuildOptions& options) {
  return options.prediction == Prediction::kExact ||
         (options.evaluation == Evaluation::kExact && !options.max_field_error.empty());
}

unsigned threads_of(const BuildOptions& options) {
  return options.threads != 0 ? std::min(options.threads, kMostThreads)
                              : static_cast<unsigned>(oneapi::tbb::info::default_concurrency());
}

double records_of(const BuildCounts& counts, const BuildOptions& options) {
  const auto vertices = static_cast<double>(counts.vertices);
  const double target = options.target_vertices < 1 ? options.target_vertices * vertices : options.target_vertices;
  return std::max(0.0, vertices - target);
}

/// Bytes of the original's topology that exact errors are measured on, with what each thread has.
double exact_bytes(double vertices, double tets, double faces, unsigned threads) {
  constexpr double kCell = 40, kStar = 16; // vertices, neighbours, volume; the tets of each corner
  return (kCell + kStar) * tets + 5 * vertices + 60 * faces + threads * (4 * tets + 8 * vertices);
}

std::uint64_t whole(double bytes, double overhead = kOverhead) {
  return static_cast<std::uint64_t>(
      std::ceil(overhead * bytes + std::min(kPageEnds, kPageEndsAtMost * bytes) + kFixed));
}

/// `more`: of the last digit, where that is not all.
std::string text_in_units(std::uint64_t bytes, unsigned more) {
  constexpr std::uint64_t kMega = 1000000, kGiga = 1000 * kMega;
  const auto in = [=](std::uint64_t unit) { return bytes / unit + (bytes % unit != 0 ? more : 0); };
  if (bytes < kGiga) return std::to_string(in(kMega)) + " MB";
  const std::uint64_t hundredths = in(kGiga / 100);
  return std::to_string(hundredths / 100) + "." + std::to_string(100 + hundredths % 100).substr(1) + " GB";
}

} // namespace

std::string bytes_text(std::uint64_t needed) {
  return text_in_units(needed, 1);
}

std::string limit_text(std::uint64_t limit) {
  constexpr std::uint64_t kMega = 1000000;
  return limit < kMega ? std::to_string(limit) + " bytes" : text_in_units(limit, 0);
}

BuildCounts count(const TetMesh& mesh, const BuildOptions& options) {
  BuildCounts counts;
  counts.vertices = mesh.vertex_count();
  counts.tets = mesh.tets.size();
  counts.row_bytes = mesh.positions.row_bytes();
  file::Header header;
  header.position_type = mesh.positions.type;
  header.has_squared_errors = options.prediction == Prediction::kExact || options.evaluation == Evaluation::kExact;
  std::vector<file::Precisions> precisions{file::Precisions(3)};
  const std::vector<std::uint32_t> by_default = governing_by_default(mesh.point_arrays);
  for (std::uint32_t i = 0; i < mesh.point_arrays.size(); ++i) {
    const PointArray& array = mesh.point_arrays[i];
    const bool governs = options.fields.empty() ? std::find(by_default.begin(), by_default.end(), i) != by_default.end()
                                                : std::find(options.fields.begin(), options.fields.end(), array.name) !=
                                                      options.fields.end();
    counts.row_bytes += array.row_bytes();
    if (governs) {
      ++counts.fields;
      counts.channels += array.components;
    }
    header.arrays.push_back({array.name, array.type, array.components, governs, 0});
    precisions.emplace_back(array.components);
  }
  counts.contexts = file::Schema(header, precisions).context_count();
  return counts;
}

BuildCounts count(const PreparedMesh& prepared, const BuildOptions& options) {
  BuildCounts counts = count(prepared.mesh, options);
  counts.boundary_faces = prepared.boundary_faces.size();
  return counts;
}

std::uint64_t MemoryNeed::most() const {
  return std::max({prepare, collapse, write});
}

MemoryNeed memory_need(const BuildCounts& counts, const BuildOptions& options) {
  const auto vertices = static_cast<double>(counts.vertices), tets = static_cast<double>(counts.tets),
             faces = static_cast<double>(counts.boundary_faces), row = static_cast<double>(counts.row_bytes),
             fields = static_cast<double>(counts.fields), channels = static_cast<double>(counts.channels);
  const double slots = tets + faces, records = records_of(counts, options);
  const double modified = kModified * records, consumed = kConsumed * records;
  const bool is_exact = options.evaluation == Evaluation::kExact;
  const unsigned threads = threads_of(options);
  const double rows = row * vertices, given = options.keep_order ? 16 * tets + 4 * vertices : 0;

  MemoryNeed need;
  // The mesh given, a copy of the tets, the table of faces with what is sorted for it, marks; positions as doubles.
  need.prepare = whole(16 * tets + rows + given + (16 + 5 + 16 + 48) * tets + (24 + 40) * vertices + 120 * faces);

  const double prepared = rows + given + (24 + 5 + 16 * channels) * vertices + 12 * faces;
  const double of_records = (46 + 8 * fields + (is_exact ? kListGrowth * 8 * (2 * fields + 1) : 0)) * records;
  const double stream = 4 * consumed + of_records;
  const double complex = 32 * slots + (12 + 4) * vertices + kPoolGrowth * (16 * tets + 12 * faces) +
                         (is_exact ? kSurfaceBound : kSurfaceSampled) * faces;
  const double quadrics = (12 + 112 * channels) * vertices + 100 * faces;
  const double candidates = 80 * vertices + threads * 4 * vertices;
  const double samples = options.evaluation == Evaluation::kSamples ? (24 + 8 + 9 + 8 * channels) * tets : 0;
  const double measuring = is_exact ? exact_bytes(vertices, tets, faces, threads) : 0;
  const double integrals = options.prediction == Prediction::kExact ? 8 * (fields + 1) * (slots + vertices) : 0;
  const double looping = prepared + complex + stream + 9 * vertices + quadrics + candidates + samples + integrals +
                         (measures_in_loop(options) ? measuring : 0);
  // The complex is gone. What the slots hold in the end and at first; parents and faces, where crossing cuts are looked
  // for; who consumed what, where errors are measured then.
  const double parents = (4 * kParents + 8) * records + 4 * slots;
  const double afterwards = prepared + 16 * tets + stream + 2 * 16 * slots +
                            std::max(parents + 200 * faces, measuring + 4 * (modified + slots));
  need.collapse = whole(std::max(looping, afterwards) + (options.pieces > 1 ? kPiece * options.pieces : 0));

  // Records in their order, what they reach, cells.
  const double order = 2 * rows + stream + 16 * slots + given + parents + 150 * records;
  // Places of slots both ways; the refinement: what stands in them, places and triangles of splits, parents, links.
  const double refinement = 8 * slots + 36 * slots + (4 + 2) * modified + (5 * kParents + 4 * kLink + 32) * records;
  const double per_record = 52 + 4 * (fields + 1) + (is_exact ? 12 * (fields + 1) : 0);
  // As the stars of blocks are let go, what their coding was told grows.
  const double stars = 4 * modified + 12 * (consumed - modified) + 20 * records;
  const double told = 2 * (35 + 40 * fields + 2.8 * row) * records;
  constexpr double kTold = 256e6 * 1.05, kPacked = 1 / 2.2;
  const double counting = 16 * (1 + std::min<double>(threads, file::kMaxCounters)), of_coders = 4 * threads;
  const double coding = std::max(counting, of_coders) * static_cast<double>(counts.contexts) + rows + 30 * records +
                        given + refinement + per_record * records + 24 * vertices +
                        1.1 * std::max(stars, told < kTold ? told : kTold + kPacked * (told - kTold));
  // Sorted, numbered, as bytes and as a zstd frame with what level 19 works in.
  constexpr double kPacking = 20e6; // its window too
  const double raw_order = 5 * tets + 4 * vertices;
  const double input_order =
      options.keep_order ? (16 + 8) * tets + 8 * vertices + 3 * raw_order + std::min(kPacking, 24 * raw_order) : 0;
  need.write =
      whole(std::max({order, coding, rows + of_records + given + per_record * records + input_order}), kWriteOverhead);
  return need;
}

MemoryWatch::MemoryWatch(const TetMesh& mesh, const BuildOptions& options) : options_(options) {
  release_freed_memory();
  std::uint64_t own = 16 * mesh.tets.size() + mesh.positions.bytes.size();
  for (const PointArray& array : mesh.point_arrays)
    own += array.bytes.size();
  const std::uint64_t resident = resident_bytes();
  others_ = resident > own ? resident - own : 0;
}

std::uint64_t MemoryWatch::check(const BuildCounts& counts) const {
  const std::uint64_t limit = options_.memory_limit;
  const auto need_of = [&](const BuildCounts& some, const BuildOptions& options) {
    return memory_need(some, options).most() + others_;
  };
  const std::uint64_t need = need_of(counts, options_);
  if (limit == 0 || need <= limit) return need;
  const std::string extent = counts.boundary_faces == 0 ? "" : "up to ";
  std::string message = "the build of " + std::to_string(counts.tets) + " tets is foreseen to take " + extent +
                        bytes_text(need) + " of memory, and the limit is " + limit_text(limit);
  constexpr double kWorthSaying = 0.97;
  std::vector<std::string> ways;
  const auto offer = [&](const BuildCounts& some, const BuildOptions& options, const std::string& how) {
    const std::uint64_t less = need_of(some, options);
    if (static_cast<double>(less) < kWorthSaying * static_cast<double>(need))
      ways.push_back(bytes_text(less) + " " + how);
  };
  BuildOptions quick = options_;
  quick.prediction = Prediction::kQuadric;
  quick.evaluation = Evaluation::kNone;
  if (options_.prediction != Prediction::kQuadric || options_.evaluation != Evaluation::kNone)
    offer(counts, quick, "with method QN");
  BuildCounts one_field = counts;
  one_field.fields = one_field.channels = std::min<std::uint64_t>(1, counts.channels);
  if (counts.channels > 1) offer(one_field, options_, "with one governing field of one component");
  BuildOptions one_thread = options_;
  one_thread.threads = 1;
  if (threads_of(options_) > 1) offer(counts, one_thread, "with one thread");
  BuildOptions one_piece = options_;
  one_piece.pieces = 1;
  if (options_.pieces > 1) offer(counts, one_piece, "in one piece");
  for (std::size_t i = 0; i < ways.size(); ++i)
    message += (i == 0 ? "; it would take " + extent : i + 1 == ways.size() ? " or " : ", ") + ways[i];
  throw Error(ErrorCode::kLimit, message);
}

bool near_memory_limit(const BuildOptions& options) {
  return options.memory_limit != 0 &&
         static_cast<double>(resident_bytes()) > kNearLimit * static_cast<double>(options.memory_limit);
}

} // namespace ptet::build
