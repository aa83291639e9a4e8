// Numbers by planes: all lowest bytes, then all second ones, and so on. What is alike in them stands together. PTET.md,
// "Base".
#pragma once

#include "formats/ptet/bytes.hpp"

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace ptet::file {

/// `count` numbers of `width` bytes, at most 8.
class Planes {
public:
  Planes(ByteReader& in, std::size_t count, std::size_t width, std::string_view name)
      : bytes_(in.get_bytes(count * width, name)), count_(count), width_(width) {}
  [[nodiscard]] std::uint64_t at(std::size_t i) const {
    std::uint64_t value = 0;
    for (std::size_t plane = 0; plane < width_; ++plane) {
      value |= static_cast<std::uint64_t>(bytes_[plane * count_ + i]) << (8 * plane);
    }
    return value;
  }

private:
  std::span<const std::byte> bytes_;
  std::size_t count_, width_;
};

inline void put_planes(ByteWriter& out, const std::vector<std::uint64_t>& numbers, std::size_t width) {
  for (std::size_t plane = 0; plane < width; ++plane) {
    for (const std::uint64_t number : numbers)
      out.put(static_cast<std::uint8_t>(number >> (8 * plane)));
  }
}

} // namespace ptet::file
