// Lists that ask for large pages are lists like any other, and do ask.
#include "mesh/large_pages.hpp"

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <sstream>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

using namespace ptet;

namespace {

/// Whether large pages have been asked for at this address, by what the kernel says of its mapping.
bool is_asked_for(const void* address) {
  const auto at = reinterpret_cast<std::uintptr_t>(address);
  std::ifstream mappings("/proc/self/smaps");
  bool is_here = false;
  for (std::string line; std::getline(mappings, line);) {
    std::istringstream words(line);
    std::string first;
    words >> first;
    if (first == "VmFlags:") {
      if (is_here) return (line + " ").find(" hg ") != std::string::npos;
    } else if (const std::size_t dash = first.find('-'); dash != std::string::npos && first.back() != ':') {
      is_here = std::stoull(first.substr(0, dash), nullptr, 16) <= at &&
                at < std::stoull(first.substr(dash + 1), nullptr, 16);
    }
  }
  return false;
}

constexpr std::size_t kMany = 4'000'000;

} // namespace

TEST_CASE("large pages: asked for behind large lists, and not behind small ones", "[mesh][large pages]") {
  if (!std::filesystem::exists("/sys/kernel/mm/transparent_hugepage")) {
    WARN("this system has no large pages: not tested");
    return;
  }
  const LargeVector<std::uint32_t> list(kMany);
  CHECK(is_asked_for(&list[kMany / 2]));
  std::vector<double> other;
  reserve_large(other, kMany);
  CHECK(is_asked_for(other.data() + kMany / 2));
  const LargeVector<std::uint32_t> small(1000);
  CHECK_FALSE(is_asked_for(small.data()));
}

TEST_CASE("large pages: lists keep what is in them, and grow by more than one", "[mesh][large pages]") {
  std::vector<std::string> list{"a", "b"};
  reserve_large(list, 10);
  CHECK(list == std::vector<std::string>{"a", "b"});
  CHECK(list.capacity() >= 10);
  const std::string* const first = list.data();
  reserve_large(list, 5);
  CHECK(list.data() == first);

  std::vector<std::uint32_t> numbers;
  std::size_t moves = 0;
  for (std::uint32_t i = 0; i < kMany; ++i) {
    const std::uint32_t* const before = numbers.data();
    grow_large(numbers, numbers.size() + 1);
    moves += numbers.data() != before ? 1 : 0;
    numbers.push_back(i);
  }
  CHECK(moves < 30);
  std::vector<std::uint32_t> expected(kMany);
  std::iota(expected.begin(), expected.end(), 0U);
  CHECK(numbers == expected);

  LargeVector<std::uint32_t> grown(expected.begin(), expected.end());
  grown.resize(2 * kMany);
  CHECK(std::equal(expected.begin(), expected.end(), grown.begin()));
  CHECK(std::accumulate(grown.begin() + kMany, grown.end(), 0U) == 0);
}
