#include "formats/ptet/verification.hpp"

#include "formats/ptet/layout.hpp"
#include "formats/ptet/ordering.hpp"
#include "formats/ptet/running_hash.hpp"
#include "formats/ptet/version_table.hpp"
#include "mesh/box_tree.hpp"
#include "mesh/governing.hpp"
#include "mesh/predicates.hpp"
#include "mesh/vec3.hpp"
#include "record/ghost.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <tuple>

namespace ptet::file {
namespace {

/// When a block cannot be decoded all are decoded once more, without it and what needs it; so often at most.
constexpr int kMostAttempts = 32;
/// Records or versions between two reports of progress.
constexpr std::uint32_t kBatch = 16384;
/// Of the diagonal, which is one rounded square root of what the box is, and of the ranges of vectors likewise.
constexpr double kDiagonalSlack = 1e-12;
/// The volume may differ from the header's by this part of it, as it is summed in another order,
constexpr double kVolumeSlack = 1e-9;
/// and besides, for each tet, by this part of the product of three edges: its vertices may come in another order, and
/// flat tets have hardly more volume than what that makes.
constexpr double kTetRounding = 2 * std::numeric_limits<double>::epsilon();

void go_on(const ProgressCallback& progress, const char* stage, std::uint64_t done, std::uint64_t total) {
  if (progress && !progress({stage, done, total})) throw Error(ErrorCode::kCancelled, "the verification was cancelled");
}

/// Hands on violations, none twice.
class Teller {
public:
  explicit Teller(const Violations& violations) : violations_(violations) {}
  void operator()(const Violation& violation) {
    if (told_.emplace(violation.what, violation.offset, violation.block, violation.record, violation.version).second)
      violations_(violation);
  }

private:
  using Number = std::optional<std::uint32_t>;
  const Violations& violations_;
  std::set<std::tuple<std::string, std::optional<std::uint64_t>, Number, Number, Number>> told_;
};

Violation violation_of(const Error& error) {
  return {std::string(error.reason()), error.byte_offset(), {}, {}, {}};
}

/// Of all errors only kCorruptFile is a finding about the file; others end the verification.
void rethrow_unless_corrupt(const Error& error) {
  if (error.code() != ErrorCode::kCorruptFile) throw Error(error);
}

/// A part of the source at a time: a section may say that it is longer than memory.
std::uint64_t hash_of_section(ByteSource& source, const Section& section) {
  constexpr std::uint64_t kAtOnce = std::uint64_t{1} << 20;
  std::vector<std::byte> bytes;
  RunningHash hash;
  for (std::uint64_t done = 0; done < section.stored_bytes; done += bytes.size()) {
    bytes.resize(std::min(kAtOnce, section.stored_bytes - done));
    source.read(section.offset + done, bytes);
    hash.add(bytes);
  }
  return hash.value();
}

/// Checks the hashes of all sections, also of those that the reader never reaches because an earlier part is wrong.
void check_section_hashes(ByteSource& source, Teller& tell) {
  const std::uint64_t size = source.size();
  if (size < kHeaderBytes + kFooterBytes) return;
  const auto bytes_at = [&](std::uint64_t offset, std::uint64_t count) {
    std::vector<std::byte> bytes(count);
    source.read(offset, bytes);
    return bytes;
  };
  const Violations told_before = [](const Violation&) {};
  std::vector<Section> sections;
  try {
    const auto footer_bytes = bytes_at(size - kFooterBytes, kFooterBytes);
    ByteReader in(footer_bytes, "footer", size - kFooterBytes);
    in.tell(&told_before);
    const Footer footer = parse_footer(in);
    const std::uint64_t bytes = footer.section_count * kSectionBytes;
    if (bytes > size - kHeaderBytes - kFooterBytes) return;
    const auto directory = bytes_at(size - kFooterBytes - bytes, bytes);
    ByteReader rows(directory, "directory", size - kFooterBytes - bytes);
    rows.tell(&told_before);
    sections = parse_directory(rows, footer.section_count);
  } catch (const Error& error) {
    rethrow_unless_corrupt(error);
    return; // told already: the reader meets it, too
  }
  for (const Section& section : sections) {
    if (section.kind == static_cast<std::uint32_t>(SectionKind::kBlocks)) continue;
    if (section.stored_bytes > size || section.offset > size - section.stored_bytes) continue;
    if (hash_of_section(source, section) == section.hash) continue;
    tell(
        {std::string("the ") + name_of(static_cast<SectionKind>(section.kind)) + " is corrupt: its hash does not match",
         section.offset,
         {},
         {},
         {}});
  }
}

void check_input_order(const Reader& reader, Teller& tell) {
  if (!reader.header().has_input_order) return;
  try {
    static_cast<void>(reader.read_input_order());
  } catch (const Error& error) {
    rethrow_unless_corrupt(error);
    tell(violation_of(error));
  }
}

// ---- decoding ----

/// Decodes what can be.
class Decoder {
public:
  Decoder(Verified& verified, Teller& tell, Violations& told_by_reader, const ProgressCallback& progress)
      : verified_(verified), tell_(tell), told_by_reader_(told_by_reader), progress_(progress),
        left_out_(verified.reader->blocks().size()) {}

  void run() {
    fetch();
    for (int attempt = 0;; ++attempt) {
      leave_out_dependents();
      std::vector<Violation> found;
      told_by_reader_ = [&](const Violation& violation) { found.push_back(violation); };
      const bool done = decode();
      told_by_reader_ = [this](const Violation& violation) { tell_(violation); };
      if (!done && attempt + 1 < kMostAttempts && verified_.content) continue;
      for (const Violation& violation : found)
        tell_(violation);
      if (!done) verified_.content.reset();
      break;
    }
    note_left_out();
  }

private:
  [[nodiscard]] const std::vector<BlockInfo>& blocks() const { return verified_.reader->blocks(); }

  void fetch() {
    std::vector<std::uint32_t> all(blocks().size());
    for (std::uint32_t b = 0; b < all.size(); ++b)
      all[b] = b;
    go_on(progress_, "checking the hashes of blocks", 0, all.size());
    fetched_ = verified_.reader->fetch(all, [&](std::uint32_t block, const Error& error) {
      rethrow_unless_corrupt(error);
      left_out_[block] = 1;
      tell_({"the hash of a block does not match", blocks()[block].offset, block, {}, {}});
    });
  }

  /// Leaves out what needs a block that is left out.
  void leave_out_dependents() {
    for (bool changed = true; changed;) {
      changed = false;
      for (std::uint32_t b = 0; b < blocks().size(); ++b) {
        if (left_out_[b] != 0) continue;
        for (const std::uint32_t needed : blocks()[b].needs)
          if (left_out_[needed] != 0) left_out_[b] = 2;
        changed |= left_out_[b] != 0;
      }
    }
  }

  /// False when something could not be decoded: a block, which is left out from now on, or the base, and then there is
  /// no content.
  bool decode() {
    verified_.content.reset();
    verified_.decoded.clear();
    std::vector<FetchedBlock> wanted;
    std::uint64_t records = 0, done = 0;
    for (const FetchedBlock& block : fetched_) {
      if (left_out_[block.block] != 0) continue;
      wanted.push_back(block);
      verified_.decoded.push_back(block.block);
      records += blocks()[block.block].record_count;
    }
    try {
      verified_.content = verified_.reader->read_base();
      Content& content = *verified_.content;
      Reader::Batch batch = verified_.reader->begin(std::move(wanted), content);
      do
        go_on(progress_, "decoding", std::min(done, records), records);
      while (done += kBatch, batch.step(content, kBatch));
      batch.check(content);
      return true;
    } catch (const BlockError& error) {
      rethrow_unless_corrupt(error);
      const auto record = error.record.is_none() ? std::nullopt : std::optional(error.record.index());
      tell_({std::string(error.reason()), error.block_offset, error.block, record, {}});
      left_out_[error.block] = 1;
    } catch (const Error& error) {
      rethrow_unless_corrupt(error);
      tell_(violation_of(error));
      verified_.content.reset();
    }
    return false;
  }

  void note_left_out() {
    if (!verified_.content) {
      verified_.notes.emplace_back("the records were not looked at");
      return;
    }
    const auto dependents = std::count(left_out_.begin(), left_out_.end(), 2);
    if (dependents > 0)
      verified_.notes.push_back(std::to_string(dependents) +
                                " blocks were not decoded, because they need blocks that cannot be");
  }

  Verified& verified_;
  Teller& tell_;
  Violations& told_by_reader_;
  const ProgressCallback& progress_;
  std::vector<char> left_out_; ///< by block: 1: cannot be decoded, 2: needs one that cannot
  std::vector<FetchedBlock> fetched_;
};

// ---- records ----

/// What the specification says of records and a reader does not check.
void check_records(const Verified& verified, Teller& tell, std::vector<std::string>& notes) {
  const Reader& reader = *verified.reader;
  const Content& content = *verified.content;
  const std::size_t codes = content.errors_per_record;
  const auto block_of = blocks_by_record(reader.blocks());
  const auto wrong = [&](std::uint32_t r, const char* what) {
    tell({what, reader.blocks()[block_of[r]].offset, block_of[r], r, {}});
  };
  // Only the domain's code, the last: those of fields may also cover differences at vertices outside of the mesh.
  const auto domain_code = [&](const std::vector<ErrorCode16>& all, std::size_t r) {
    return all[r * codes + codes - 1];
  };
  std::vector<ErrorCode16> expected(content.refinement.record_count());
  for (std::size_t r = 0; r < expected.size(); ++r)
    expected[r] = domain_code(content.own, r);
  std::vector<char> is_used(reader.blocks().size()); // by needed block, of the block at hand
  std::uint64_t superfluous = 0;
  for (const std::uint32_t b : verified.decoded) {
    const BlockInfo& block = reader.blocks()[b];
    for (std::uint32_t r = block.first_record; r < block.end_record(); ++r) {
      std::uint32_t generation = 0;
      for (const RecordId parent : content.refinement.parents(RecordId{r})) {
        generation = std::max(generation, content.generation[parent.index()] + 1);
        is_used[block_of[parent.index()]] = 1;
        expected[parent.index()] = std::max(expected[parent.index()], domain_code(content.monotone, r));
      }
      if (content.generation[r] != generation)
        wrong(r, "its generation is not one more than the greatest of its parents");
    }
    for (const std::uint32_t needed : block.needs)
      superfluous += is_used[needed] != 0 ? 0 : 1;
    std::fill(is_used.begin(), is_used.end(), 0);
  }
  if (superfluous > 0)
    notes.push_back("the table names " + std::to_string(superfluous) + " needed blocks in which there is no parent");
  if (!verified.is_whole()) return; // what depends on a record may be missing
  for (std::uint32_t r = 0; r < content.refinement.record_count(); ++r)
    if (domain_code(content.monotone, r) > expected[r])
      wrong(r, "its monotone domain error is greater than its own and those of all that depend on it");
}

/// Tells of one record a block: where one is out of place, others are.
void check_order(const Verified& verified, const BoundingBox& box, Teller& tell) {
  const Content& content = *verified.content;
  const auto codes = morton_codes(content.positions, box);
  const auto code_of = [&](std::uint32_t r) { return codes[content.refinement.vertex_of(RecordId{r}).index()]; };
  for (const std::uint32_t b : verified.decoded) {
    const BlockInfo& block = verified.reader->blocks()[b];
    for (std::uint32_t r = block.first_record + 1; r < block.end_record(); ++r) {
      if (content.generation[r - 1] != content.generation[r] || code_of(r - 1) <= code_of(r)) continue;
      tell({"the records of one generation in a block are not in Morton order", block.offset, b, r, {}});
      break;
    }
  }
}

// ---- geometry ----

Point position(const Content& content, VertexId v) {
  const PointArray& table = content.positions;
  return {table.value(v.index(), 0), table.value(v.index(), 1), table.value(v.index(), 2)};
}

int orientation_of(const Content& content, const Tet& tet) {
  return orientation(position(content, tet[0]), position(content, tet[1]), position(content, tet[2]),
                     position(content, tet[3]));
}

/// Whether some version that the collapse of `record` consumed became `coarse` and is not flat; or none became it.
bool is_of_one_not_flat(const Content& content, const Tet& coarse, RecordId record) {
  const Refinement& refinement = content.refinement;
  Tet wanted = coarse;
  std::replace(wanted.begin(), wanted.end(), refinement.target(record), refinement.vertex_of(record));
  std::sort(wanted.begin(), wanted.end());
  for (std::uint32_t k = 0; k < refinement.modified(record).size(); ++k) {
    const auto [a, b, c] = refinement.link_triangle(record, k);
    const Tet fine{refinement.vertex_of(record), a, b, c};
    Tet corners = fine;
    std::sort(corners.begin(), corners.end());
    if (corners == wanted) return orientation_of(content, fine) != 0;
  }
  return true;
}

/// Every tet that ever existed must be positively oriented. Flat tets of the original are tolerated, and flat tets that
/// a collapse made of a flat one.
void check_orientations(Verified& verified, Teller& tell, const ProgressCallback& progress) {
  const Content& content = *verified.content;
  const VersionTable versions(content.refinement);
  const auto block_of = blocks_by_record(verified.reader->blocks());
  std::uint64_t flat_originals = 0;
  verified.is_oriented = true;
  versions.each([&](std::uint32_t number, RecordId maker, const Tet& tet) {
    if (number % kBatch == 0) go_on(progress, "checking orientations", number, content.refinement.version_count());
    if (is_ghost(tet)) return;
    const int sign = orientation_of(content, tet);
    if (sign > 0) return;
    const auto wrong = [&](const char* what) {
      if (maker.is_none())
        tell({what, {}, {}, {}, number});
      else
        tell({what, verified.reader->blocks()[block_of[maker.index()]].offset, block_of[maker.index()], maker.index(),
              number});
    };
    const RecordId creator = versions.creator(number);
    if (sign < 0) {
      wrong("a tet (version) is inverted");
      verified.is_oriented = false;
    } else if (creator.is_none()) {
      ++flat_originals;
    } else if (is_of_one_not_flat(content, tet, creator)) {
      wrong("a tet (version) is flat and comes from one that is not");
    }
  });
  if (flat_originals > 0 && verified.is_whole())
    verified.notes.push_back(std::to_string(flat_originals) + (flat_originals == 1 ? " flat tet" : " flat tets") +
                             " in the original");
}

/// The scales of the field errors.
void check_ranges(const Header& header, const TetMesh& mesh, Teller& tell) {
  std::vector<char> is_used(mesh.vertex_count());
  for (const Tet& tet : mesh.tets)
    for (const VertexId v : tet)
      is_used[v.index()] = 1;
  for (std::size_t a = 0; a < header.arrays.size(); ++a) {
    if (!header.arrays[a].governing) continue;
    const PointArray& array = mesh.point_arrays[a];
    const double range = range_of(array, is_used);
    if (!std::isfinite(range) || !(std::abs(header.arrays[a].range - range) <= kDiagonalSlack * range))
      tell({"the range of '" + array.name + "' in the header is not that of its values", {}, {}, {}, {}});
  }
}

std::array<Point, 4> corners_of(const TetMesh& mesh, const Tet& tet) {
  return {mesh.position(tet[0]), mesh.position(tet[1]), mesh.position(tet[2]), mesh.position(tet[3])};
}

/// Of the vertices that tets use.
BoundingBox used_box(const TetMesh& mesh) {
  BoundingBox box;
  for (const Tet& tet : mesh.tets)
    box.join(box_of(corners_of(mesh, tet)));
  return box;
}

/// What the header says of the mesh, which has the box.
void check_header(const Header& header, const TetMesh& mesh, const BoundingBox& box, Teller& tell) {
  using namespace vec;
  double volume = 0, rounding = 0;
  for (const Tet& tet : mesh.tets) {
    const std::array<Point, 4> p = corners_of(mesh, tet);
    const auto a = p[1] - p[0], b = p[2] - p[0], c = p[3] - p[0];
    volume += tet_volume(p);
    rounding += kTetRounding * norm(a) * norm(b) * norm(c);
  }
  if (box.low != header.box_min || box.high != header.box_max)
    tell({"the bounding box of the header is not that of the mesh", 56, {}, {}, {}});
  const Vec3 extent = box.high - box.low;
  const double diagonal = std::hypot(extent[0], extent[1], extent[2]);
  if (diagonal > 0 && !(std::abs(header.diagonal - diagonal) <= kDiagonalSlack * diagonal))
    tell({"the diagonal of the header is not that of the mesh", 104, {}, {}, {}});
  if (header.volume > 0 && !(std::abs(header.volume - volume) <= kVolumeSlack * volume + rounding))
    tell({"the volume of the header is not that of the mesh", 112, {}, {}, {}});
  check_ranges(header, mesh, tell);
}

} // namespace

TetMesh finest_mesh(const Content& content) {
  TetMesh mesh;
  mesh.positions = content.positions;
  mesh.point_arrays = content.arrays;
  const Refinement& refinement = content.refinement;
  for (std::uint32_t place = 0; place < refinement.place_count(); ++place)
    if (!is_ghost(refinement.tet(place))) mesh.tets.push_back(refinement.tet(place));
  return mesh;
}

Verified verify(const std::shared_ptr<ByteSource>& source, const Violations& violations,
                const ProgressCallback& progress, const Limits& limits) {
  Verified verified;
  Teller tell(violations);
  // The reader lives longer than this call.
  const auto told_by_reader = std::make_shared<Violations>([&tell](const Violation& violation) { tell(violation); });
  OpenOptions options;
  options.limits = limits;
  go_on(progress, "reading", 0, 0);
  try {
    verified.reader = std::make_unique<Reader>(
        source, options, [told_by_reader](const Violation& violation) { (*told_by_reader)(violation); });
  } catch (const Error& error) {
    rethrow_unless_corrupt(error);
    tell(violation_of(error));
    verified.reader.reset();
  }
  check_section_hashes(*source, tell);
  if (!verified.reader) {
    verified.notes.emplace_back("what the table and the records say was not looked at");
    return verified;
  }
  check_input_order(*verified.reader, tell);
  Decoder(verified, tell, *told_by_reader, progress).run();
  *told_by_reader = [](const Violation&) {};
  if (!verified.content) return verified;
  go_on(progress, "checking the structure", 0, 0);
  if (const std::string broken = verified.content->refinement.validate(); !broken.empty())
    tell({broken, {}, {}, {}, {}});
  check_records(verified, tell, verified.notes);
  check_orientations(verified, tell, progress);
  if (!verified.is_whole()) return verified; // box and volume are of all vertices and tets
  const TetMesh mesh = finest_mesh(*verified.content);
  if (mesh.tets.empty()) return verified;
  const BoundingBox box = used_box(mesh);
  check_order(verified, box, tell);
  check_header(verified.reader->header(), mesh, box, tell);
  return verified;
}

} // namespace ptet::file
