#include "fuzz/checks.hpp"
#include "fuzz/fuzzed_requests.hpp"
#include "fuzz/sample_files.hpp"
#include "fuzz/targets.hpp"
#include "ptet/session.hpp"
#include "support/session_checks.hpp"

namespace ptet::fuzz {
namespace {

constexpr int kMostRequests = 6;

OpenOptions options_from(FuzzedRequests& requests) {
  OpenOptions options = small_limits();
  const std::uint64_t how = requests.number(1);
  if ((how & 1) != 0) options.memory_limit = 1 + 64 * requests.number(2);
  if ((how & 6) == 6) options.max_gap = requests.number(2);
  return options;
}

/// The session comes to what a fresh extraction gives, and tells every slot that it changes.
void follow(const Dataset& data, Session& session, test::SlotCopy& copy, const Request& request) {
  const Extraction fresh = data.extract(request);
  check_mesh(fresh);
  const SessionUpdate& update = session.update(request);
  copy.follow(session, update);
  if (const std::string found = copy.difference(session); !found.empty()) fail(found);
  check_mesh(session.extraction());
  if (!fresh.complete || !update.complete) return;
  if (const std::string found = test::difference(session, update, fresh); !found.empty())
    fail("the session differs from an extraction: " + found);
}

} // namespace

void run_cut(Input input) {
  if (input.empty()) return;
  const std::size_t count = std::min(static_cast<std::size_t>(input[0]), input.size() - 1);
  const Input file = input.subspan(1 + count);
  FuzzedRequests how(input.subspan(1, count), {});
  const OpenOptions options = options_from(how);
  try {
    const auto data = Dataset::open_memory({file.begin(), file.end()}, options);
    FuzzedRequests requests(input.subspan(1, count), data->info());
    static_cast<void>(options_from(requests));
    Session session(data);
    test::SlotCopy copy;
    for (int i = 0; i < kMostRequests && requests.has_more(); ++i) {
      const Request request = requests.next();
      try {
        follow(*data, session, copy, request);
      } catch (const Error& error) {
        if (error.code() != ErrorCode::kBadArgument) throw;
      }
    }
  } catch (const Error& error) {
    check_refusal(error);
  }
}

std::vector<Bytes> cut_seeds() {
  std::vector<Bytes> seeds;
  std::minstd_rand random(5);
  for (const Bytes& file : sample_files()) {
    Bytes& seed = seeds.emplace_back(Bytes{std::byte{64}});
    for (int i = 0; i < 64; ++i)
      seed.push_back(static_cast<std::byte>(random() >> 8 & 0xFF));
    seed[1] = std::byte{0};
    seed.insert(seed.end(), file.begin(), file.end());
  }
  return seeds;
}

void mutate_cut(Bytes& input, std::size_t most_bytes, Mutator& mutator) {
  if (input.empty()) input.push_back(std::byte{0});
  const std::size_t count = std::min(static_cast<std::size_t>(input[0]), input.size() - 1);
  const auto file_begin = input.begin() + static_cast<std::ptrdiff_t>(1 + count);
  Bytes requests(input.begin() + 1, file_begin);
  Bytes file(file_begin, input.end());
  if (mutator.below(2) == 0) {
    mutator.change(requests, std::min<std::size_t>(255, most_bytes > file.size() ? most_bytes - file.size() - 1 : 0));
  } else {
    mutate_file(file, most_bytes - std::min(most_bytes, 1 + requests.size()), mutator);
  }
  input.assign(1, static_cast<std::byte>(requests.size()));
  input.insert(input.end(), requests.begin(), requests.end());
  input.insert(input.end(), file.begin(), file.end());
}

} // namespace ptet::fuzz
