#include "formats/ptet/writer.hpp"

#include "formats/ptet/layout.hpp"
#include "formats/ptet/ordering.hpp"
#include "formats/ptet/packing.hpp"
#include "formats/ptet/record_codec.hpp"
#include "formats/ptet/record_runs.hpp"
#include "formats/ptet/seed_choice.hpp"
#include "formats/ptet/slot_match.hpp"
#include "formats/ptet/transcript.hpp"
#include "formats/whole_file.hpp"
#include "mesh/rows.hpp"
#include "mesh/utf8.hpp"
#include "record/budget_rank.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <string_view>

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

namespace ptet::file {
namespace {

void report(const ProgressCallback& progress, std::string_view stage, std::uint64_t done, std::uint64_t total) {
  if (progress && !progress({stage, done, total})) throw Error(ErrorCode::kCancelled, "writing was cancelled");
}

void check_sizes(std::uint64_t vertices, std::uint64_t tets, std::uint64_t versions) {
  if (vertices > kMaxFileVertices || tets > kMaxFileTets || versions > kMaxFileVersions)
    throw Error(ErrorCode::kLimit, "the mesh is too large for a .ptet file");
}

/// Everything about a file to be written, and the steps that find it, in the order of encode().
class Encoding {
public:
  Encoding(TetMesh mesh, RecordStream records, const ProgressCallback& progress, const GivenIds* given)
      : mesh_(std::move(mesh)), records_(std::move(records)), progress_(progress), given_(given),
        vertex_count_(mesh_.vertex_count()) {}

  void check_input() const;
  void order();
  void describe();
  void number_errors();
  void number_squared_errors();
  void forget_errors();
  void number_order();
  void make_base();
  void find_needs();
  void transcribe();
  void train();
  void code_blocks();
  [[nodiscard]] std::vector<std::byte> assemble(const Manifest& manifest);

private:
  [[nodiscard]] std::vector<std::byte> code_block(std::uint32_t b);
  [[nodiscard]] Content full_content();
  void take_back(Content& content);
  [[nodiscard]] std::vector<std::size_t> stream_fields() const;
  [[nodiscard]] std::size_t record_count() const { return records_.size(); }
  [[nodiscard]] std::vector<double> squared_sums(const BlockInfo& info) const;
  void note_others(OtherParents& others, RecordId r) const;

  TetMesh mesh_;         ///< until order()
  RecordStream records_; ///< the stars and slots until transcribe()
  const ProgressCallback& progress_;
  const GivenIds* const given_; ///< where the order of the input is kept
  const std::size_t vertex_count_;

  StreamParents parents_;
  std::vector<std::uint32_t> budget_rank_; ///< by stream record, until number_order()
  FileOrder order_;
  std::vector<std::uint32_t> file_record_; ///< by stream record
  std::vector<std::uint32_t> block_of_;    ///< by file record
  FixedHeader fixed_;
  std::vector<Precisions> precisions_;
  std::optional<Schema> schema_;
  PointArray positions_;
  std::vector<PointArray> arrays_;
  std::vector<ErrorCode16> own_, monotone_;
  std::vector<OrderCode> order_code_; ///< by file record
  std::vector<double> squared_error_; ///< by file record and code, see BlockInfo::squared_error
  std::vector<SquaredErrorCode> squared_code_;
  std::vector<Tet> base_tets_;
  std::vector<BlockInfo> infos_;
  std::vector<TableRow> rows_;
  std::vector<OtherParents> others_;    ///< by block
  std::vector<Transcript> transcripts_; ///< by block
  InitialProbabilities initial_;
  std::vector<std::vector<std::byte>> block_bytes_;
};

void Encoding::check_input() const {
  check_storable(mesh_);
  check_sizes(mesh_.vertex_count(), records_.original_tet_count, records_.version_count());
  if (mesh_.positions.components != 3) throw Error(ErrorCode::kBadInput, "positions must have three components");
  for (const PointArray& array : mesh_.point_arrays)
    if (array.size() != mesh_.vertex_count())
      throw Error(ErrorCode::kBadInput, "point array '" + array.name + "' does not have one row for each vertex");
}

void Encoding::order() {
  parents_ = StreamParents(records_);
  budget_rank_ = budget_rank(records_, parents_);
  order_ = order_file(mesh_, records_, parents_, budget_rank_, kDefaultRecordsPerBlock);
  file_record_.resize(record_count());
  for (std::uint32_t r = 0; r < record_count(); ++r)
    file_record_[order_.stream_record[r]] = r;
  block_of_ = blocks_by_record(order_.blocks);
  const auto take = [&](PointArray& array) {
    PointArray in_file = gather(array, order_.mesh_vertex);
    array = {};
    return in_file;
  };
  positions_ = take(mesh_.positions);
  for (PointArray& array : mesh_.point_arrays)
    arrays_.push_back(take(array));
}

void Encoding::describe() {
  Header& header = fixed_.header;
  header.base_vertex_count = order_.base_vertex_count;
  header.record_count = static_cast<std::uint32_t>(record_count());
  header.tet_count = records_.original_tet_count;
  header.block_count = static_cast<std::uint32_t>(order_.blocks.size());
  header.position_type = positions_.type;
  header.diagonal = records_.diagonal;
  header.volume = records_.volume;
  header.has_squared_errors = records_.has_squared_errors();
  header.overlaps_itself = records_.overlaps_itself;
  header.box_min = order_.box.low;
  header.box_max = order_.box.high;
  const auto precisions_of = [](const PointArray& array) {
    Precisions precisions;
    for (std::uint32_t c = 0; c < array.components; ++c)
      precisions.push_back(find_precision(array, c));
    return precisions;
  };
  precisions_.push_back(precisions_of(positions_));
  for (const PointArray& array : arrays_) {
    header.arrays.push_back({array.name, array.type, array.components, false, 0});
    precisions_.push_back(precisions_of(array));
  }
  for (const GoverningField& field : records_.fields) {
    header.arrays[field.array].governing = true;
    header.arrays[field.array].range = field.range;
  }
  fixed_.array_count = static_cast<std::uint32_t>(header.arrays.size());
  fixed_.records_per_block = kDefaultRecordsPerBlock;
  fixed_.position_precisions = precisions_.front();
  schema_.emplace(header, precisions_);
}

/// For each governing array its place among the fields of the stream, which may have them in another order.
std::vector<std::size_t> Encoding::stream_fields() const {
  std::vector<std::size_t> field_of(schema_->governing.size());
  for (std::size_t f = 0; f < records_.fields.size(); ++f) {
    const auto place = std::find(schema_->governing.begin(), schema_->governing.end(), records_.fields[f].array);
    field_of[static_cast<std::size_t>(place - schema_->governing.begin())] = f;
  }
  return field_of;
}

// Own errors are coded; the monotone ones gather, from fine to coarse, what depends on a record. Errors at vertices
// that are left outside are in the monotone ones only.
void Encoding::number_errors() {
  const std::size_t codes = schema_->code_count();
  const std::size_t fields = records_.fields.size();
  own_.resize(record_count() * codes);
  monotone_.resize(own_.size());
  const std::vector<std::size_t> field_of = stream_fields();
  const auto code_of = [&](double error, double scale) {
    if (!(error >= 0) || (error > 0 && !(scale > 0))) {
      throw Error(ErrorCode::kBadInput, "a record has an error that is negative, not a number or without a scale");
    }
    const ErrorCode16 code = error > 0 ? encode_error(error, scale) : ErrorCode16{0};
    if (decode_error(code, scale) < error) throw Error(ErrorCode::kLimit, "an error is too large for a .ptet file");
    return code;
  };
  for (std::size_t i = 0; i < record_count(); ++i) {
    const std::size_t row = file_record_[i] * codes;
    for (std::size_t c = 0; c + 1 < codes; ++c) {
      own_[row + c] = code_of(records_.field_error[i * fields + field_of[c]], schema_->scale[c]);
    }
    own_[row + codes - 1] = code_of(records_.domain_error[i], schema_->scale.back());
    for (std::size_t c = 0; c + 1 < codes; ++c)
      monotone_[row + c] =
          std::max(monotone_[row + c], code_of(records_.largest_error(i, field_of[c]), schema_->scale[c]));
    monotone_[row + codes - 1] = std::max(monotone_[row + codes - 1], own_[row + codes - 1]);
    for_each_parent(records_, parents_, i, [&](std::uint32_t stream_parent) {
      const std::size_t parent = file_record_[stream_parent] * codes;
      for (std::size_t c = 0; c < codes; ++c)
        monotone_[parent + c] = std::max(monotone_[parent + c], monotone_[row + c]);
    });
  }
}

/// Which are coded by now.
void Encoding::forget_errors() {
  for (std::vector<double>* const errors : {&records_.field_error, &records_.outside_error, &records_.domain_error,
                                            &records_.squared_error, &records_.uncovered_volume})
    *errors = std::vector<double>(); // {} would keep its memory
}

void Encoding::number_squared_errors() {
  if (!records_.has_squared_errors()) return;
  const std::size_t codes = schema_->code_count();
  const std::size_t fields = records_.fields.size();
  const std::vector<std::size_t> field_of = stream_fields();
  squared_error_.resize(record_count() * codes);
  squared_code_.resize(squared_error_.size());
  // Divisions round; what they may take is added again.
  const auto put = [&](std::size_t place, double fraction, auto&& encode) {
    fraction += std::fabs(fraction) * 0x1p-50;
    if (!(std::fabs(fraction) <= decode_squared_error(kMaxSquaredErrorCode)))
      throw Error(ErrorCode::kLimit, "a squared error or uncovered volume is too large for a .ptet file");
    squared_error_[place] = fraction;
    squared_code_[place] = encode(fraction);
  };
  const auto encode_volume = [&](double fraction) { return encode_uncovered(fraction, fixed_.header.record_count); };
  for (std::size_t i = 0; i < record_count(); ++i) {
    const std::size_t row = file_record_[i] * codes;
    for (std::size_t c = 0; c < fields; ++c) {
      const double squared = records_.squared_error[i * fields + field_of[c]], range = schema_->scale[c];
      if (!std::isfinite(squared) || (squared != 0 && !(range > 0)))
        throw Error(ErrorCode::kBadInput, "a record has a squared error that is not a number or without a scale");
      put(row + c,
          squared == 0                            ? 0
          : holds_squares(range, records_.volume) ? squared / range / range / records_.volume
                                                  : squared / records_.volume,
          encode_squared_error);
    }
    const double uncovered = records_.uncovered_volume[i];
    if (!std::isfinite(uncovered))
      throw Error(ErrorCode::kBadInput, "a record has an uncovered volume that is not a number");
    put(row + fields, uncovered / records_.volume, encode_volume);
  }
}

void Encoding::number_order() {
  order_code_.resize(record_count());
  for (std::size_t i = 0; i < record_count(); ++i)
    order_code_[file_record_[i]] = encode_order(vertex_count_, vertex_count_ - record_count() + 1 + budget_rank_[i]);
  budget_rank_ = std::vector<std::uint32_t>();
}

void Encoding::make_base() {
  for (const std::uint32_t slot : records_.base_slots()) {
    if (records_.is_ghost(slot)) continue;
    Tet tet = records_.slots[slot];
    for (VertexId& v : tet)
      v = order_.file_vertex[v.index()];
    // Even permutations bring the least vertex to the front and the least of the others behind it.
    const auto least = static_cast<std::size_t>(std::min_element(tet.begin(), tet.end()) - tet.begin());
    tet = {tet[least], tet[least ^ 1U], tet[least ^ 2U], tet[least ^ 3U]};
    std::rotate(tet.begin() + 1, std::min_element(tet.begin() + 1, tet.end()), tet.end());
    base_tets_.push_back(tet);
  }
  std::sort(base_tets_.begin(), base_tets_.end());
  fixed_.header.base_tet_count = static_cast<std::uint32_t>(base_tets_.size());
}

// Rounded up, so that no sum over blocks is below the truth.
std::vector<double> Encoding::squared_sums(const BlockInfo& info) const {
  if (!fixed_.header.has_squared_errors) return {};
  const std::size_t codes = schema_->code_count();
  std::vector<double> sums(codes, 0), magnitudes(codes, 0);
  for (std::size_t r = info.first_record; r < info.end_record(); ++r) {
    for (std::size_t c = 0; c < codes; ++c) {
      sums[c] += squared_error_[r * codes + c];
      magnitudes[c] += std::fabs(squared_error_[r * codes + c]);
    }
  }
  for (std::size_t c = 0; c < codes; ++c)
    sums[c] += magnitudes[c] * 0x1p-52 * (info.record_count + 1);
  return sums;
}

void Encoding::note_others(OtherParents& others, RecordId r) const {
  const auto needed = records_.others_needed(order_.stream_record[r.index()]);
  if (needed.empty()) return;
  others.records.push_back(r);
  for (const std::uint32_t record : needed)
    others.parents.emplace_back(file_record_[record]);
  std::sort(others.parents.begin() + others.begin.back(), others.parents.end());
  others.begin.push_back(static_cast<std::uint32_t>(others.parents.size()));
}

void Encoding::find_needs() {
  infos_.resize(order_.blocks.size());
  rows_.resize(order_.blocks.size());
  others_.resize(order_.blocks.size());
  const std::size_t codes = schema_->code_count();
  for (std::uint32_t b = 0; b < infos_.size(); ++b) {
    BlockInfo& info = infos_[b];
    info.first_record = order_.blocks[b].first_record;
    info.record_count = order_.blocks[b].record_count;
    info.box_min.fill(std::numeric_limits<double>::infinity());
    info.box_max.fill(-std::numeric_limits<double>::infinity());
    info.max_error.resize(codes);
    info.max_own.resize(codes);
    for (std::uint32_t r = info.first_record; r < info.end_record(); ++r) {
      const std::uint32_t record = order_.stream_record[r];
      for_each_parent(records_, parents_, record, [&](std::uint32_t parent) {
        const std::uint32_t home = block_of_[file_record_[parent]];
        if (home != b) info.needs.push_back(home);
      });
      note_others(others_[b], RecordId{r});
      rows_[b].version_count += static_cast<std::uint32_t>(records_.star(record).size());
      for (std::size_t c = 0; c < codes; ++c) {
        info.max_error[c] = std::max(info.max_error[c], monotone_[r * codes + c]);
        info.max_own[c] = std::max(info.max_own[c], own_[r * codes + c]);
      }
      info.max_order = std::max(info.max_order, order_code_[r]);
    }
    info.squared_error = squared_sums(info);
    std::sort(info.needs.begin(), info.needs.end());
    info.needs.erase(std::unique(info.needs.begin(), info.needs.end()), info.needs.end());
    fixed_.version_count += rows_[b].version_count;
  }
}

/// Takes what is per record and vertex with it: two copies of these would stand beside the refinement, the largest
/// thing there is.
Content Encoding::full_content() {
  Refinement refinement(base_tets_, order_.base_vertex_count, static_cast<std::uint32_t>(record_count()));
  Refinement::Sizes sizes;
  sizes.places = records_.slot_count();
  for (std::size_t i = 0; i < record_count(); ++i) {
    sizes.modified += records_.modified_count[i];
    sizes.link_vertices += (records_.star(i).size() + 2) / 2; // of a disk
    sizes.parents += parents_.of(i).size() + records_.others_needed(i).size();
  }
  parents_ = StreamParents(); // what it held takes memory
  refinement.reserve(sizes);
  return {std::move(refinement),           std::move(positions_),    std::move(arrays_),
          schema_->code_count(),           std::move(own_),          std::move(monotone_),
          std::move(order_code_),          std::move(squared_code_), std::move(order_.generation),
          std::vector<char>(infos_.size())};
}

void Encoding::take_back(Content& content) {
  positions_ = std::move(content.positions);
  arrays_ = std::move(content.arrays);
  own_ = std::move(content.own);
  monotone_ = std::move(content.monotone);
  order_code_ = std::move(content.order);
  squared_code_ = std::move(content.squared_error);
  order_.generation = std::move(content.generation);
}

/// Keeps what a coder of the block will be told until the model is there, and moves the probabilities that seeds are
/// chosen by: those of the first contexts.
class Scribe {
public:
  Scribe(std::vector<Probability>& of_seeds, Transcript& transcript) : of_seeds_(of_seeds), transcript_(transcript) {}
  bool bit(std::uint32_t context, bool bit) {
    transcript_.bit(context, bit);
    if (context < of_seeds_.size()) of_seeds_[context].update(bit);
    return bit;
  }
  std::uint64_t raw(unsigned count, std::uint64_t value) {
    transcript_.raw(count, value);
    return value;
  }

private:
  std::vector<Probability>& of_seeds_;
  Transcript& transcript_;
};

/// Those of blocks that are over, until they are so many that memory wants them packed.
class UnpackedTranscripts {
public:
  explicit UnpackedTranscripts(std::span<Transcript> transcripts) : transcripts_(transcripts) {}
  void add(std::uint32_t block) {
    over_.push_back(block);
    bytes_ += transcripts_[block].bytes();
  }
  void pack_many() {
    if (bytes_ < kMostBytes) return;
    oneapi::tbb::parallel_for(std::size_t{0}, over_.size(), [&](std::size_t i) { transcripts_[over_[i]].pack(); });
    over_.clear();
    bytes_ = 0;
  }

private:
  /// Some millions of tets stay below it: packing takes 4% of the time of a build by quadrics alone.
  static constexpr std::size_t kMostBytes = std::size_t{256} << 20;

  std::span<Transcript> transcripts_;
  std::vector<std::uint32_t> over_;
  std::size_t bytes_ = 0;
};

void Encoding::transcribe() {
  Content content = full_content();
  SlotMatch match(records_, order_, content.refinement);
  FileStars stars(records_, order_);
  SeedChoice choice(records_, order_, *schema_, infos_, block_of_, match, stars);
  RecordCodec codec(*schema_, infos_, vertex_count_);
  std::vector<Probability> of_seeds(schema_->seed_contexts());
  transcripts_.resize(infos_.size());
  std::vector<BlockState> states;
  for (std::uint32_t b = 0; b < infos_.size(); ++b)
    states.emplace_back(b, infos_[b].needs.size(), schema_->code_count());
  UnpackedTranscripts unpacked(transcripts_);
  std::size_t done = 0;
  std::vector<std::uint32_t> together;
  for (const std::vector<Run>& group : groups_of_runs(content.generation, infos_)) {
    together.clear();
    for (const Run& run : group)
      for (std::uint32_t r = run.first_record; r <= run.last_record; ++r)
        together.push_back(r);
    choice.choose(of_seeds, states, content.refinement, together);
    for (std::size_t i = 0; i < together.size(); ++i, ++done) {
      if (done % 4096 == 0) report(progress_, "writing records", done, record_count());
      const RecordId r{together[i]};
      BlockState& state = states[block_of_[r.index()]];
      const auto modified = stars.modified(r);
      const auto in_region = [&](std::uint32_t behind) {
        return std::find(modified.begin(), modified.end(), match.slot_of(behind)) != modified.end();
      };
      Scribe scribe(of_seeds, transcripts_[state.block]);
      codec.code(scribe, state, content, r, RecordKnown<decltype(in_region)>{choice.seeds(i), in_region},
                 others_[state.block].of(r));
      codec.extend_by_star(infos_[state.block].box_min, infos_[state.block].box_max);
    }
    match.add_rims(content.refinement, stars, together);
    for (const Run& run : group) {
      const BlockInfo& block = infos_[run.open_block];
      if (run.last_record + 1 != block.first_record + block.record_count) continue;
      stars.forget(run.open_block);
      unpacked.add(run.open_block);
    }
    unpacked.pack_many();
  }
  take_back(content);
}

void Encoding::train() {
  // There are many contexts where there are many arrays: a counter for each of many threads takes more than the mesh.
  const std::size_t count = std::min<std::size_t>(
      {kMaxCounters, static_cast<std::size_t>(oneapi::tbb::this_task_arena::max_concurrency()), transcripts_.size()});
  std::vector<std::optional<BitCounter>> counters(count);
  oneapi::tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    counters[i].emplace(schema_->context_count());
    for (std::size_t b = i; b < transcripts_.size(); b += count)
      transcripts_[b].tell(*counters[i]);
  });
  BitCounter all(schema_->context_count());
  for (const std::optional<BitCounter>& counter : counters)
    all += *counter;
  initial_ = all.trained();
}

void Encoding::code_blocks() {
  constexpr std::size_t kBetweenLooks = 256; // blocks
  block_bytes_.resize(infos_.size());
  for (std::size_t begin = 0; begin < infos_.size(); begin += kBetweenLooks) {
    report(progress_, "coding blocks", begin, infos_.size());
    oneapi::tbb::parallel_for(begin, std::min(begin + kBetweenLooks, infos_.size()),
                              [&](std::size_t b) { block_bytes_[b] = code_block(static_cast<std::uint32_t>(b)); });
  }
}

/// Forgets the transcript.
std::vector<std::byte> Encoding::code_block(std::uint32_t b) {
  ByteWriter out;
  const std::span generations(order_.generation);
  put_runs(out, generations.subspan(infos_[b].first_record, infos_[b].record_count));
  put_others(out, b, infos_, others_[b]);
  RangeEncoder encoder(initial_);
  transcripts_[b].tell(encoder);
  transcripts_[b] = {};
  out.put_bytes(encoder.finish());
  const std::uint64_t least = std::max(
      (rows_[b].version_count + kMaxVersionsPerByte - 1) / kMaxVersionsPerByte,
      static_cast<std::uint32_t>((infos_[b].record_count * vertex_bytes(fixed_.header) + kMaxValueBytesPerByte - 1) /
                                 kMaxValueBytesPerByte));
  while (out.size() < least)
    out.put(std::uint8_t{0});
  return out.take();
}

std::vector<std::byte> Encoding::assemble(const Manifest& manifest) {
  ByteWriter file;
  put_header(file, fixed_);
  std::vector<Section> sections;
  const auto add = [&](SectionKind kind, const std::vector<std::byte>& raw) {
    const std::vector<std::byte> stored =
        packed(raw, [&](std::size_t done) { report(progress_, "packing", done, raw.size()); });
    sections.push_back(
        {static_cast<std::uint32_t>(kind), flags_of(kind), file.size(), stored.size(), raw.size(), hash_of(stored)});
    file.put_bytes(stored);
  };
  ByteWriter arrays, base, table, manifest_bytes;
  put_arrays(arrays, fixed_.header, precisions_);
  add(SectionKind::kArrays, arrays.bytes());
  const auto model = std::as_bytes(std::span(initial_));
  add(SectionKind::kModel, {model.begin(), model.end()});
  put_base(base, positions_, arrays_, fixed_.header.base_vertex_count, base_tets_);
  add(SectionKind::kBase, base.bytes());

  const std::uint64_t blocks_offset = file.size();
  for (std::size_t b = 0; b < infos_.size(); ++b) {
    infos_[b].offset = file.size();
    infos_[b].stored_bytes = block_bytes_[b].size();
    rows_[b].info = infos_[b];
    rows_[b].hash = hash_of(block_bytes_[b]);
    file.put_bytes(block_bytes_[b]);
  }
  const std::uint64_t blocks_bytes = file.size() - blocks_offset;
  sections.push_back(
      {static_cast<std::uint32_t>(SectionKind::kBlocks), kMandatory, blocks_offset, blocks_bytes, blocks_bytes, 0});
  if (given_ != nullptr) {
    ByteWriter order;
    put_input_order(order, input_order(*given_, order_.file_vertex));
    add(SectionKind::kInputOrder, order.take());
  }
  put_manifest(manifest_bytes, manifest);
  add(SectionKind::kManifest, manifest_bytes.bytes());
  put_table(table, fixed_.header, rows_);
  add(SectionKind::kTable, table.bytes());

  const std::uint64_t directory_offset = file.size();
  put_directory(file, sections);
  const std::uint64_t directory_hash = hash_of(std::span(file.bytes()).subspan(directory_offset));
  put_footer(file, {directory_offset, static_cast<std::uint32_t>(sections.size()), directory_hash,
                    file.size() + kFooterBytes});
  return file.take();
}

} // namespace

void check_storable(const TetMesh& mesh) {
  check_sizes(mesh.vertex_count(), mesh.tets.size(), mesh.tets.size());
  if (mesh.point_arrays.size() > kMaxArrays) throw Error(ErrorCode::kLimit, "the mesh has more than 1024 point arrays");
  std::set<std::string_view> names;
  for (const PointArray& array : mesh.point_arrays) {
    if (array.components == 0 || array.components > kMostComponents)
      throw Error(ErrorCode::kLimit, "point array '" + array.name + "' has " + std::to_string(array.components) +
                                         " components; 1 to 1024 can be stored");
    if (array.name.empty()) throw Error(ErrorCode::kBadInput, "a point array has no name");
    if (array.name.find('\0') != std::string::npos)
      throw Error(ErrorCode::kBadInput, "the name of point array '" + array.name.substr(0, array.name.find('\0')) +
                                            "' goes on behind a zero byte, where other programs end it");
    if (!is_utf8(array.name))
      throw Error(ErrorCode::kBadInput,
                  "the name of point array '" + as_utf8(array.name) + "' is not text in UTF-8, which a .ptet file has");
    if (!names.insert(array.name).second)
      throw Error(ErrorCode::kBadInput, "two point arrays are called '" + array.name + "'");
  }
}

std::vector<std::byte> encode(TetMesh mesh, RecordStream records, const Manifest& manifest,
                              const ProgressCallback& progress, const GivenIds* given) {
  Encoding encoding(std::move(mesh), std::move(records), progress, given);
  encoding.check_input();
  report(progress, "ordering records", 0, 0);
  encoding.order();
  encoding.describe();
  encoding.number_errors();
  encoding.number_squared_errors();
  encoding.forget_errors();
  encoding.number_order();
  encoding.make_base();
  encoding.find_needs();
  encoding.transcribe();
  report(progress, "coding blocks", 0, 0);
  encoding.train();
  encoding.code_blocks();
  return encoding.assemble(manifest);
}

std::uint64_t write(const std::string& path, TetMesh mesh, RecordStream records, const Manifest& manifest,
                    const ProgressCallback& progress, const GivenIds* given) {
  // The file is made first: that it cannot be written should not be learnt at the end of a long encoding.
  WholeFile file(path);
  const auto bytes = encode(std::move(mesh), std::move(records), manifest, progress, given);
  constexpr std::size_t kPart = std::size_t{1} << 22;
  for (std::size_t begin = 0; begin < bytes.size(); begin += kPart) {
    report(progress, "writing the file", begin, bytes.size());
    file.write(std::span(bytes).subspan(begin, std::min(kPart, bytes.size() - begin)));
  }
  report(progress, "writing the file", bytes.size(), bytes.size());
  file.commit();
  return bytes.size();
}

} // namespace ptet::file
