#include "formats/surface/formats.hpp"

#include <bit>
#include <charconv>
#include <cstring>
#include <string_view>
#include <type_traits>

namespace ptet {
namespace {

/// Text and bytes, gathered to larger pieces.
class Gathered {
public:
  explicit Gathered(WholeFile& file) : file_(file) {}

  Gathered& operator<<(std::string_view text) {
    add(text.data(), text.size());
    return *this;
  }
  /// In the fewest digits that give it back.
  template <class T>
  requires std::is_arithmetic_v<T> Gathered& operator<<(T number) {
    std::array<char, 32> digits{};
    const auto [end, status] = std::to_chars(digits.data(), digits.data() + digits.size(), number);
    add(digits.data(), static_cast<std::size_t>(end - digits.data()));
    return *this;
  }
  /// As the machine holds it.
  template <class T>
  void bytes(T number) {
    std::array<char, sizeof(T)> raw{};
    std::memcpy(raw.data(), &number, sizeof(T));
    add(raw.data(), raw.size());
  }
  void flush() {
    file_.write(std::as_bytes(std::span(gathered_)));
    gathered_.clear();
  }

private:
  void add(const char* data, std::size_t size) {
    constexpr std::size_t kPiece = std::size_t{1} << 20;
    gathered_.insert(gathered_.end(), data, data + size);
    if (gathered_.size() >= kPiece) flush();
  }

  WholeFile& file_;
  std::vector<char> gathered_;
};

/// Calls f(x, y, z) for each row, of the type that they are written in.
template <class F>
void for_each_point(const SurfaceRows& rows, F&& f) {
  const PointArray& positions = *rows.positions;
  for (const VertexId v : rows.vertices) {
    const auto coordinate = [&](std::uint32_t axis) { return positions.value(v.index(), axis); };
    if (positions.type == ScalarType::kFloat32)
      f(static_cast<float>(coordinate(0)), static_cast<float>(coordinate(1)), static_cast<float>(coordinate(2)));
    else
      f(coordinate(0), coordinate(1), coordinate(2));
  }
}

} // namespace

void write_obj(WholeFile& file, const SurfaceRows& rows) {
  Gathered out(file);
  out << "# " << rows.vertices.size() << " vertices, " << rows.faces.size() << " faces\n";
  for_each_point(rows, [&](auto x, auto y, auto z) { out << "v " << x << " " << y << " " << z << "\n"; });
  for (const auto& [a, b, c] : rows.faces) // counted from 1
    out << "f " << std::uint64_t{a} + 1 << " " << std::uint64_t{b} + 1 << " " << std::uint64_t{c} + 1 << "\n";
  out.flush();
}

void write_off(WholeFile& file, const SurfaceRows& rows) {
  Gathered out(file);
  out << "OFF\n" << rows.vertices.size() << " " << rows.faces.size() << " 0\n";
  for_each_point(rows, [&](auto x, auto y, auto z) { out << x << " " << y << " " << z << "\n"; });
  for (const auto& [a, b, c] : rows.faces)
    out << "3 " << a << " " << b << " " << c << "\n";
  out.flush();
}

void write_ply(WholeFile& file, const SurfaceRows& rows) {
  Gathered out(file);
  const std::string_view type = rows.positions->type == ScalarType::kFloat32 ? "float" : "double";
  out << "ply\nformat " << (std::endian::native == std::endian::little ? "binary_little_endian" : "binary_big_endian")
      << " 1.0\nelement vertex " << rows.vertices.size() << "\n";
  for (const std::string_view name : {"x", "y", "z"})
    out << "property " << type << " " << name << "\n";
  out << "element face " << rows.faces.size() << "\nproperty list uchar int vertex_indices\nend_header\n";
  for_each_point(rows, [&](auto x, auto y, auto z) {
    for (const auto coordinate : {x, y, z})
      out.bytes(coordinate);
  });
  for (const auto& face : rows.faces) {
    out.bytes(std::uint8_t{3});
    for (const std::uint32_t corner : face)
      out.bytes(corner);
  }
  out.flush();
}

} // namespace ptet
