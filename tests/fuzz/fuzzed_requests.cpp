#include "fuzz/fuzzed_requests.hpp"

#include <bit>

namespace ptet::fuzz {

std::uint64_t FuzzedRequests::number(std::size_t width) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < width && !bytes_.empty(); ++i) {
    value = value << 8 | static_cast<std::uint64_t>(bytes_.front());
    bytes_ = bytes_.subspan(1);
  }
  return value;
}

double FuzzedRequests::fraction() {
  const std::uint64_t code = number(1);
  if (code == 255) return std::bit_cast<double>(number(8));
  const double x = static_cast<double>(code) / 254;
  return x * x * x;
}

std::string FuzzedRequests::field() {
  const std::uint64_t which = number(1);
  if (which == 0 || info_.fields.empty()) return which == 0 ? "" : "no such field";
  return info_.fields[which % info_.fields.size()].name;
}

Point FuzzedRequests::point() {
  Point at{};
  for (std::size_t i = 0; i < 3; ++i)
    at[i] = info_.box_min[i] + static_cast<double>(number(1)) / 255 * (info_.box_max[i] - info_.box_min[i]);
  return at;
}

Region FuzzedRequests::region() {
  const Point centre = point();
  const double size = fraction() * info_.diagonal;
  switch (number(1) % 4) {
  case 0: return HalfSpace{vector(), fraction() * info_.diagonal};
  case 1: return OrientedBox{centre, {{{size, 0, 0}, {0, fraction() * info_.diagonal, 0}, {0, 0, size}}}};
  case 2: return Sphere{centre, size};
  default: return Box{centre, {centre[0] + size, centre[1] + size, centre[2] + fraction() * info_.diagonal}};
  }
}

View FuzzedRequests::view() {
  View view;
  view.eye = point();
  view.direction = vector();
  view.up = vector();
  view.vertical_angle = 3.2 * fraction();
  view.width = static_cast<std::uint32_t>(number(2));
  view.height = static_cast<std::uint32_t>(number(2));
  view.max_pixels = 20 * fraction();
  if (number(1) % 2 == 0) view.outside = 1 + 10 * fraction();
  return view;
}

Request FuzzedRequests::next() {
  Request request;
  const std::uint64_t parts = number(2);
  if ((parts & 1) != 0) request.field_error.push_back({field(), bound()});
  if ((parts & 2) != 0) request.domain_error = bound();
  if ((parts & 4) != 0) request.max_tets = number(2);
  if ((parts & 8) != 0) request.max_vertices = number(2);
  if ((parts & 16) != 0) request.max_bytes = number(3);
  if ((parts & 32) != 0) {
    Focus focus{region()};
    focus.error = bound();
    if ((parts & 64) != 0) focus.falloff = bound();
    request.focus.push_back(focus);
  }
  if ((parts & 128) != 0) request.focus.push_back({region()});
  if ((parts & 256) != 0) {
    const double least = fraction();
    request.values.push_back({field(), least, least + fraction()});
  }
  if ((parts & 512) != 0) request.view = view();
  request.origins = (parts & 1024) != 0;
  return request;
}

Request FuzzedRequests::next_bound() {
  Request request;
  const std::uint64_t kind = number(1) % 8;
  if (kind == 0) request.max_tets = 0;
  if (kind == 2 || kind == 3) request.domain_error = Bound{fraction(), true};
  if (kind >= 3) request.field_error.push_back({kind < 6 ? "" : field(), bound()});
  request.origins = number(1) % 2 == 1;
  return request;
}

} // namespace ptet::fuzz
