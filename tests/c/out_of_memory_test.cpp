// The C interface when memory runs out: every allocation of opening a file and extracting from it fails once, and each
// time the call says so and leaves nothing behind. Its own program, because it replaces operator new.
#include "ptet/ptet.h"
#include "ptet/ptet_build.h"

#include <atomic>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <new>
#include <vector>

namespace {

/// Allocations of this thread that still succeed; negative: all.
thread_local long left = -1;
/// Allocations not given back.
std::atomic<long> held{0};
int failures = 0;

void* allocate(std::size_t size) {
  if (left == 0) return nullptr;
  if (left > 0) --left;
  void* const memory = std::malloc(size == 0 ? 1 : size);
  if (memory != nullptr) ++held;
  return memory;
}

void release(void* memory) {
  if (memory != nullptr) --held;
  std::free(memory);
}

void check(bool good, const char* what, long at) {
  if (good) return;
  ++failures;
  std::fprintf(stderr, "allocation %ld fails: not so: %s\n", at, what);
}

/// Calls with the first allocation failing, then with the second, and so on until the call succeeds. Before each call
/// `clear` gives back whatever the call before has left, then `prepare` makes what the next one needs; both have memory
/// to spare. Returns how many times it failed.
long exhaust(
    const char* what, const std::function<ptet_status(ptet_error**)>& call, const std::function<void()>& clear = {},
    const std::function<void()>& prepare = [] {}) {
  if (clear) clear();
  const long held_before = held;
  for (long at = 0;; ++at) {
    if (clear) {
      clear();
      check(held == held_before, "nothing is left behind", at - 1);
    }
    prepare();
    ptet_error* error = nullptr;
    left = at;
    const ptet_status status = call(&error);
    left = -1;
    if (status == PTET_OK) {
      check(error == nullptr, "no error on success", at);
      std::printf("%s: %ld allocations\n", what, at);
      return at;
    }
    check(status == PTET_OUT_OF_MEMORY, what, at);
    check(error != nullptr && ptet_error_status(error) == status, "an error object", at);
    ptet_error_free(error);
    if (failures > 10) std::exit(1);
  }
}

/// A cube of 3 x 3 x 3 cells with a field, built into bytes.
ptet_bytes* build() {
  constexpr std::uint32_t kSide = 4;
  constexpr std::uint32_t kWays[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}};
  std::vector<float> points, field;
  std::vector<std::uint32_t> tets;
  for (std::uint32_t p = 0; p < kSide * kSide * kSide; ++p) {
    const std::uint32_t at[3] = {p % kSide, p / kSide % kSide, p / kSide / kSide};
    for (const std::uint32_t x : at)
      points.push_back(static_cast<float>(x));
    field.push_back(static_cast<float>(at[0] * at[1] + at[2] * at[2]));
    if (at[0] + 1 == kSide || at[1] + 1 == kSide || at[2] + 1 == kSide) continue;
    for (const auto& way : kWays) {
      constexpr std::uint32_t kStep[3] = {1, kSide, kSide * kSide};
      tets.insert(tets.end(), {p, p + kStep[way[0]], p + kStep[way[0]] + kStep[way[1]],
                               p + kStep[way[0]] + kStep[way[1]] + kStep[way[2]]});
    }
  }
  ptet_builder* const builder = ptet_builder_new();
  ptet_bytes* bytes = nullptr;
  exhaust("points", [&](ptet_error** error) {
    return ptet_builder_set_points(builder, PTET_FLOAT32, field.size(), points.data(), error);
  });
  exhaust("tets",
          [&](ptet_error** error) { return ptet_builder_set_tets(builder, tets.size() / 4, tets.data(), error); });
  exhaust("field", [&](ptet_error** error) {
    return ptet_builder_add_field(builder, "a field whose name is long", PTET_FLOAT32, 1, field.data(), error);
  });
  ptet_error* error = nullptr;
  if (ptet_builder_set_prediction(builder, PTET_PREDICT_QUADRIC, nullptr) != PTET_OK ||
      ptet_builder_build_memory(builder, nullptr, nullptr, &bytes, nullptr, &error) != PTET_OK) {
    std::fprintf(stderr, "%s\n", ptet_error_message(error));
    std::exit(1);
  }
  ptet_builder_free(builder);
  return bytes;
}

/// The tets in the slots of a session; none where one has a corner that is in no vertex slot.
std::uint64_t tets_in_slots(const ptet_session* session) {
  std::uint64_t slots = 0, vertex_slots = 0, tets = 0;
  const std::uint32_t* const corners = ptet_session_tets(session, &slots);
  const std::uint32_t* const vertices = ptet_session_vertices_in_file(session, &vertex_slots);
  for (std::uint64_t slot = 0; slot < slots; ++slot) {
    if (corners[4 * slot] == UINT32_MAX) continue;
    ++tets;
    for (std::uint64_t i = 4 * slot; i < 4 * slot + 4; ++i)
      if (corners[i] >= vertex_slots || vertices[corners[i]] == UINT32_MAX) return 0;
  }
  return tets;
}

} // namespace

void* operator new(std::size_t size) {
  if (void* const memory = allocate(size)) return memory;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return allocate(size);
}
void operator delete(void* memory) noexcept {
  release(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  release(memory);
}

int main() {
  ptet_bytes* const bytes = build();
  ptet_dataset* dataset = nullptr;
  const auto open = [&](ptet_error** error) {
    return ptet_dataset_open_memory(ptet_bytes_data(bytes), ptet_bytes_size(bytes), nullptr, &dataset, error);
  };
  const auto close = [&] {
    ptet_dataset_free(dataset);
    dataset = nullptr;
  };
  const long to_open = exhaust("open", open, close);

  left = 0;
  check(ptet_request_new() == nullptr, "no request without memory", 0);
  check(ptet_builder_new() == nullptr, "no builder without memory", 0);
  left = -1;
  ptet_request* const request = ptet_request_new();
  const long to_ask = exhaust("bound", [&](ptet_error** error) {
    return ptet_request_add_field_error(request, "a field whose name is long", 0.1, 1, error);
  });
  ptet_extraction* extraction = nullptr;
  const auto extract = [&](ptet_error** error) {
    return ptet_dataset_extract(dataset, request, nullptr, nullptr, &extraction, error);
  };
  // What a file is read into may be left in the middle: each attempt has a dataset of its own.
  const long to_extract = exhaust("extract", extract, close, [&] { check(open(nullptr) == PTET_OK, "opens", -1); });
  ptet_extraction_info info{};
  info.struct_size = sizeof info;
  check(ptet_extraction_get_info(extraction, &info, nullptr) == PTET_OK, "extracts", -1);
  check(info.tets > 0 && ptet_extraction_field_error(extraction, 0) <= 0.1 * 18, "within the bound", -1);
  ptet_extraction_free(extraction);

  ptet_session* session = nullptr;
  const auto close_both = [&] {
    ptet_session_free(session);
    session = nullptr;
    close();
  };
  const auto open_both = [&] {
    check(open(nullptr) == PTET_OK && ptet_session_open(dataset, &session, nullptr) == PTET_OK, "opens", -1);
  };
  exhaust(
      "update",
      [&](ptet_error** error) { return ptet_session_update(session, request, nullptr, nullptr, nullptr, error); },
      close_both, open_both);
  // A session that has failed goes on, whatever the failure has left of its slots.
  ptet_request* const whole = ptet_request_new();
  const auto check_and_close = [&] {
    if (session != nullptr) {
      check(ptet_session_update(session, request, nullptr, nullptr, nullptr, nullptr) == PTET_OK, "goes on", -1);
      check(tets_in_slots(session) == info.tets, "the same mesh in slots", -1);
    }
    close_both();
  };
  exhaust(
      "update from mesh to mesh",
      [&](ptet_error** error) { return ptet_session_update(session, whole, nullptr, nullptr, nullptr, error); },
      check_and_close,
      [&] {
        open_both();
        check(ptet_session_update(session, request, nullptr, nullptr, nullptr, nullptr) == PTET_OK, "updates", -1);
      });
  check_and_close();
  ptet_request_free(whole);

  // A dataset whose blocks were left in the middle, and then what they are made anew in, answers whatever is asked
  // next.
  ptet_request* const hurried = ptet_request_new();
  check(ptet_request_add_field_error(hurried, nullptr, 0.1, 1, nullptr) == PTET_OK &&
            ptet_request_set_max_milliseconds(hurried, 1e6, nullptr) == PTET_OK,
        "asks", -1);
  enum class Next { kOrigins, kHurried, kSession };
  for (const Next next : {Next::kOrigins, Next::kHurried, Next::kSession}) {
    const auto ask_and_close = [&] {
      if (dataset != nullptr) {
        const std::uint32_t made_by = 0;
        double level = 0;
        if (next == Next::kOrigins)
          check(ptet_dataset_get_origin_values(dataset, &made_by, 1, PTET_ORIGIN_LEVEL, 0, &level, nullptr) == PTET_OK,
                "tells origins", -1);
        if (next == Next::kHurried) {
          ptet_extraction* in_time = nullptr;
          check(ptet_dataset_extract(dataset, hurried, nullptr, nullptr, &in_time, nullptr) == PTET_OK, "in time", -1);
          ptet_extraction_free(in_time);
        }
        if (next == Next::kSession) {
          check(ptet_session_update(session, request, nullptr, nullptr, nullptr, nullptr) == PTET_OK, "goes on", -1);
          check(tets_in_slots(session) == info.tets, "the same mesh in slots", -1);
        }
      }
      left = 0; // what is freed takes no memory
      ptet_session_free(session);
      left = -1;
      session = nullptr;
      close();
    };
    exhaust(
        "make anew",
        [&](ptet_error** error) {
          return ptet_dataset_extract(dataset, request, nullptr, nullptr, &extraction, error);
        },
        ask_and_close,
        [&] {
          open_both();
          left = to_extract / 2;
          check(ptet_dataset_extract(dataset, request, nullptr, nullptr, &extraction, nullptr) == PTET_OUT_OF_MEMORY,
                "is left in the middle", -1);
          left = -1;
        });
    ptet_extraction_free(extraction);
    ask_and_close();
  }
  ptet_request_free(hurried);

  open_both();
  check(ptet_session_update(session, request, nullptr, nullptr, nullptr, nullptr) == PTET_OK, "updates", -1);
  exhaust("extract from a session",
          [&](ptet_error** error) { return ptet_session_extract(session, &extraction, error); });
  ptet_extraction_info updated{};
  updated.struct_size = sizeof updated;
  check(ptet_extraction_get_info(extraction, &updated, nullptr) == PTET_OK, "extracts", -1);
  check(updated.tets == info.tets, "the same mesh", -1);
  ptet_extraction_free(extraction);
  ptet_session_free(session);
  ptet_request_free(request);
  ptet_dataset_free(dataset);
  ptet_bytes_free(bytes);
  check(to_open > 10 && to_ask > 0 && to_extract > 10, "operator new is the one that is used", -1);
  return failures == 0 ? 0 : 1;
}
