// Error bounds by the book (PTET.md, "Cuts"): the records above the bound and, over and over, what they depend on; then
// each version by itself, whether it is there. No order, no index, no block table.
#include "formats/ptet/version_table.hpp"
#include "fuzz/checks.hpp"
#include "fuzz/fuzzed_requests.hpp"
#include "fuzz/targets.hpp"
#include "ptet/session.hpp"
#include "record/ghost.hpp"
#include "support/mesh_checks.hpp"
#include "support/session_checks.hpp"

#include <algorithm>
#include <optional>

namespace ptet::fuzz {
namespace {

constexpr int kMostRequests = 8;

class PlainCuts {
public:
  PlainCuts(const file::Header& header, const file::Content& content)
      : content_(content), versions_(content.refinement) {
    for (const file::ArrayInfo& array : header.arrays)
      if (array.governing) {
        names_.push_back(array.name);
        scale_.push_back(array.range);
      }
    scale_.push_back(header.diagonal);
  }

  /// Finds the cut; false when the request is not one that can be asked of the file.
  [[nodiscard]] bool find(const Request& request) {
    is_split_.assign(content_.refinement.record_count(), 0);
    if (request.max_tets) return true;
    const bool asks_all = request.field_error.empty() && !request.domain_error;
    std::vector<std::optional<double>> most(scale_.size());
    for (const FieldBound& asked : request.field_error) {
      bool is_known = asked.field.empty();
      for (std::size_t i = 0; i < names_.size(); ++i)
        if (asked.field.empty() || asked.field == names_[i]) {
          const double bound = asked.bound.absolute(scale_[i]);
          most[i] = most[i] ? std::min(*most[i], bound) : bound;
          is_known = true;
        }
      if (!is_known) return false;
    }
    if (request.domain_error) most.back() = request.domain_error->absolute(scale_.back());
    for (std::uint32_t r = 0; r < is_split_.size(); ++r)
      for (std::size_t i = 0; i < most.size(); ++i)
        if (asks_all || (most[i] && error(RecordId{r}, i) > *most[i])) is_split_[r] = 1;
    close();
    return true;
  }

  [[nodiscard]] std::vector<Tet> tets() const {
    std::vector<Tet> present;
    each_there([&](RecordId, const Tet& tet) {
      if (!is_ghost(tet)) present.push_back(test::sorted_keeping_orientation(tet));
    });
    std::sort(present.begin(), present.end());
    return present;
  }

  /// Largest error over the records that made what is there; by field, the domain's last.
  [[nodiscard]] std::vector<double> errors() const {
    std::vector<double> largest(scale_.size(), 0);
    each_there([&](RecordId maker, const Tet& tet) {
      if (maker.is_none()) return;
      for (std::size_t i = 0; i < largest.size(); ++i)
        if (is_ghost(tet) == (i + 1 == largest.size())) largest[i] = std::max(largest[i], error(maker, i));
    });
    return largest;
  }

private:
  [[nodiscard]] double error(RecordId r, std::size_t i) const {
    return decode_error(content_.own[r.index() * scale_.size() + i], scale_[i]);
  }
  void close() {
    for (bool has_grown = true; has_grown;) {
      has_grown = false;
      for (std::uint32_t r = 0; r < is_split_.size(); ++r) {
        if (is_split_[r] == 0) continue;
        for (const RecordId parent : content_.refinement.parents(RecordId{r})) {
          has_grown |= is_split_[parent.index()] == 0;
          is_split_[parent.index()] = 1;
        }
      }
    }
  }
  /// Calls `visit(record that made it or none, tet)` for what the cut holds.
  template <class Visit>
  void each_there(Visit&& visit) const {
    versions_.each([&](std::uint32_t number, RecordId consumer, const Tet& tet) {
      const RecordId creator = versions_.creator(number);
      if ((consumer.is_none() || is_split_[consumer.index()] != 0) &&
          (creator.is_none() || is_split_[creator.index()] == 0))
        visit(creator, tet);
    });
  }

  const file::Content& content_;
  file::VersionTable versions_;
  std::vector<std::string> names_;
  std::vector<double> scale_;
  std::vector<char> is_split_;
};

std::vector<Tet> tets_of(const Session& session) {
  std::vector<Tet> tets;
  for (const auto& slots : session.tets()) {
    if (slots[0] == Session::kUnused) continue;
    Tet tet;
    for (std::size_t i = 0; i < 4; ++i)
      tet[i] = session.vertex_in_file()[slots[i]];
    tets.push_back(test::sorted_keeping_orientation(tet));
  }
  std::sort(tets.begin(), tets.end());
  return tets;
}

void compare(const PlainCuts& plain, const Session& session, const SessionUpdate& update) {
  if (!update.complete) fail("a sound file gives no complete mesh");
  if (tets_of(session) != plain.tets()) fail("the session's mesh is not that of the cut");
  const std::vector<double> errors = plain.errors();
  for (std::size_t i = 0; i + 1 < errors.size(); ++i)
    if (!(errors[i] <= update.field_error[i])) fail("a stated field error is too small");
  if (!(errors.back() <= update.domain_error)) fail("the stated domain error is too small");
}

void run_over(const Bytes& file, Input bytes) {
  file::Reader reader(file::over_memory(file), small_limits());
  const file::Content content = load_all(reader);
  PlainCuts plain(reader.header(), content);
  const auto data = Dataset::open_memory(file, small_limits());
  FuzzedRequests requests(bytes, data->info());
  Session session(data);
  for (int i = 0; i < kMostRequests && requests.has_more(); ++i) {
    const Request request = requests.next_bound();
    try {
      const SessionUpdate& update = session.update(request);
      if (!plain.find(request)) fail("a field that is not there was not missed");
      compare(plain, session, update);
      const Extraction fresh = data->extract(request);
      if (const std::string found = test::difference(session, update, fresh); !found.empty())
        fail("the session differs from an extraction: " + found);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kBadArgument) throw;
    }
  }
}

} // namespace

void run_differential(Input input) {
  if (input.empty()) return;
  const std::size_t count = std::min(static_cast<std::size_t>(input[0]), input.size() - 1);
  const Input file = input.subspan(1 + count);
  try {
    run_over({file.begin(), file.end()}, input.subspan(1, count));
  } catch (const Error& error) {
    check_refusal(error);
  }
}

} // namespace ptet::fuzz
