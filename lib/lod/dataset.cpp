#include "ptet/dataset.hpp"

#include "lod/dataset_impl.hpp"
#include "lod/extraction.hpp"
#include "lod/input_order.hpp"
#include "lod/mean_errors.hpp"
#include "lod/provenance.hpp"
#include "record/order_code.hpp"

#include <algorithm>
#include <chrono>
#include <limits>
#include <optional>
#include <string>
#include <utility>

namespace ptet {
namespace {

DatasetInfo describe(const Hierarchy& hierarchy) {
  const file::Header& header = hierarchy.header();
  DatasetInfo info;
  info.vertices = std::uint64_t{header.base_vertex_count} + header.record_count;
  info.tets = header.tet_count;
  info.base_vertices = hierarchy.used_base_vertex_count();
  info.base_tets = header.base_tet_count;
  info.records = header.record_count;
  info.blocks = hierarchy.blocks().size();
  info.file_bytes = hierarchy.file_bytes();
  info.position_type = header.position_type;
  info.has_input_order = header.has_input_order;
  info.errors_are_bounds = hierarchy.manifest().states_bounds();
  info.overlaps_itself = header.overlaps_itself;
  info.box_min = header.box_min;
  info.box_max = header.box_max;
  info.diagonal = header.diagonal;
  std::vector<ErrorCode16> most(hierarchy.errors_per_record(), 0);
  for (const file::BlockInfo& block : hierarchy.blocks())
    for (std::size_t i = 0; i < most.size(); ++i)
      most[i] = std::max(most[i], block.max_own[i]);
  for (const file::ArrayInfo& array : header.arrays) {
    info.fields.push_back({array.name, array.type, array.components, array.governing, array.range});
    if (array.governing) info.max_field_error.push_back(decode_error(most[info.max_field_error.size()], array.range));
  }
  info.max_domain_error = decode_error(most.back(), header.diagonal);
  MeanErrors mean = mean_errors(hierarchy, std::vector<char>(header.record_count, 0), info.max_field_error);
  info.base_rms_error = std::move(mean.rms_error);
  info.base_covered = mean.covered;
  info.memory_for_all = hierarchy.loader().bytes_for_all();
  info.provenance_json = to_json(hierarchy.manifest());
  return info;
}

} // namespace

Dataset::Impl::Impl(std::shared_ptr<ByteSource> source, const OpenOptions& options)
    : hierarchy(std::move(source), options), info(describe(hierarchy)) {}

const char* name_of(LimitedBy limit) {
  switch (limit) {
  case LimitedBy::kNothing: return "nothing";
  case LimitedBy::kError: return "error";
  case LimitedBy::kFocus: return "focus";
  case LimitedBy::kBudget: return "budget";
  case LimitedBy::kTime: return "time";
  case LimitedBy::kLoading: return "loading";
  case LimitedBy::kMemory: return "memory";
  case LimitedBy::kUnreadable: return "unreadable";
  }
  return "unknown";
}

Dataset::Dataset(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

// The last reference may go within a read of the source, as where a collector of garbage runs in it.
Dataset::~Dataset() {
  Loader& loader = impl_->hierarchy.loader();
  if (loader.is_own_thread()) loader.end_with({impl_.release(), [](void* impl) { delete static_cast<Impl*>(impl); }});
}

std::shared_ptr<const Dataset> Dataset::open(std::shared_ptr<ByteSource> source, const OpenOptions& options) {
  return std::make_shared<const Dataset>(std::make_unique<Impl>(std::move(source), options));
}

std::shared_ptr<const Dataset> Dataset::open(const std::string& path, const OpenOptions& options) {
  std::shared_ptr<ByteSource> source = file::open_file(path);
  try {
    return open(std::move(source), options);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kIo) throw; // names the path
    const std::string what = "'" + path + "': " + std::string(error.reason());
    if (error.byte_offset()) throw Error(error.code(), what, *error.byte_offset());
    throw Error(error.code(), what);
  }
}

std::shared_ptr<const Dataset> Dataset::open_memory(std::vector<std::byte> bytes, const OpenOptions& options) {
  return open(file::over_memory(std::move(bytes)), options);
}

const DatasetInfo& Dataset::info() const {
  return impl_->info;
}

Extraction Dataset::extract(const Request& request, const ProgressCallback& progress) const {
  const auto begin = std::chrono::steady_clock::now();
  Hierarchy& hierarchy = impl_->hierarchy;
  Loader& loader = hierarchy.loader();
  const ResolvedRequest resolved = resolve(request, hierarchy.header());
  std::optional<file::InputOrder> order;
  if (request.input_order) {
    if (!hierarchy.header().has_input_order)
      throw Error(ErrorCode::kBadArgument, "the file does not keep the order of its input; build it so (keep_order)");
    order = hierarchy.read_input_order();
  }
  constexpr int kMostTries = 8;
  for (int tries = 1;; ++tries) {
    auto [cut, lock] = find_cut(hierarchy, resolved, progress);
    Extraction extraction = extract_cut(hierarchy, cut, resolved);
    extraction.complete = std::count(cut.missing.begin(), cut.missing.end(), 1) == 0;
    if (!extraction.complete) {
      Loader::Shortfall shortfall = loader.explain(cut.missing);
      // Nothing stands against it any more: another thread has got since what this one failed to.
      const bool is_had = shortfall.limited_by == LimitedBy::kUnreadable && shortfall.failures.empty();
      if (is_had && tries < kMostTries && !request.max_milliseconds) continue;
      extraction.limited_by = shortfall.limited_by;
      extraction.failures = std::move(shortfall.failures);
    }
    lock.unlock();
    if (order) put_in_input_order(extraction, *order);
    extraction.bytes_read = hierarchy.bytes_read();
    extraction.read_requests = hierarchy.read_requests();
    extraction.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return extraction;
  }
}

void Dataset::origin_values(std::span<const RecordId> made_by, OriginValue what, std::size_t field,
                            std::span<double> values) const {
  if (values.size() != made_by.size())
    throw Error(ErrorCode::kBadArgument,
                std::to_string(values.size()) + " values for " + std::to_string(made_by.size()) + " records");
  Hierarchy& hierarchy = impl_->hierarchy;
  const std::size_t codes = hierarchy.errors_per_record();
  if (what == OriginValue::kFieldError && field >= codes - 1)
    throw Error(ErrorCode::kBadArgument, "there is no governing field " + std::to_string(field));
  const auto lock = hierarchy.lock();
  const file::Content& content = hierarchy.content();
  const auto fill = [&](auto&& value_of) {
    for (std::size_t i = 0; i < made_by.size(); ++i) {
      const std::uint32_t r = made_by[i].index();
      if (!made_by[i].is_none() && r >= content.generation.size())
        throw Error(ErrorCode::kBadArgument, "there is no record " + std::to_string(r));
      values[i] = made_by[i].is_none()                      ? 0.0
                  : !content.refinement.applied(made_by[i]) ? std::numeric_limits<double>::quiet_NaN()
                                                            : static_cast<double>(value_of(r));
    }
  };
  switch (what) {
  case OriginValue::kFieldError: {
    std::vector<double> ranges;
    for (const file::ArrayInfo& array : hierarchy.header().arrays)
      if (array.governing) ranges.push_back(array.range);
    fill([&](std::size_t r) { return decode_error(content.own[r * codes + field], ranges[field]); });
    break;
  }
  case OriginValue::kDomainError:
    fill([&](std::size_t r) { return decode_error(content.own[(r + 1) * codes - 1], hierarchy.header().diagonal); });
    break;
  case OriginValue::kLevel: fill([&](std::size_t r) { return halvings(content.order[r]); }); break;
  case OriginValue::kGeneration: fill([&](std::size_t r) { return content.generation[r]; }); break;
  }
}

void Dataset::wait_until_loaded(const ProgressCallback& progress) const {
  impl_->hierarchy.loader().wait_until_loaded(progress);
}

std::uint64_t Dataset::bytes_read() const {
  return impl_->hierarchy.bytes_read();
}

} // namespace ptet
