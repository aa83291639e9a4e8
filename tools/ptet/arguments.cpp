#include "arguments.hpp"

#include "mesh/vec3.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

namespace ptet::cli {
namespace {

[[noreturn]] void refuse(std::string_view option, std::string_view text, const std::string& why) {
  throw Error(ErrorCode::kBadArgument, std::string(option) + " '" + std::string(text) + "': " + why);
}

/// X or X%, X finite and not negative (minus zero included).
std::optional<Bound> bound_of(std::string_view text) {
  const bool relative = text.ends_with('%');
  if (relative) text.remove_suffix(1);
  const auto value = finite(text);
  if (!value || std::signbit(*value)) return std::nullopt;
  return Bound{relative ? *value / 100 : *value, relative};
}

/// [NAME=]X[%]
std::optional<FieldBound> field_bound_of(std::string_view text) {
  const std::size_t equals = text.rfind('=');
  const bool named = equals != std::string_view::npos;
  const auto bound = bound_of(named ? text.substr(equals + 1) : text);
  if (!bound || equals == 0) return std::nullopt;
  return FieldBound{named ? std::string(text.substr(0, equals)) : std::string{}, *bound};
}

Point point_of(std::string_view option, std::string_view text, std::string_view list) {
  const std::vector<double> numbers = parse_numbers(option, text, list);
  if (numbers.size() != 3) refuse(option, text, "'" + std::string(list) + "' is not a point x,y,z");
  return {numbers[0], numbers[1], numbers[2]};
}

constexpr double kDegree = 3.14159265358979323846 / 180;

/// From the centre, two half axes, and half the thickness across them.
OrientedBox oriented_box(std::string_view option, std::string_view text, const Point& centre, const Point& a,
                         const Point& b, double h) {
  const auto length = [](const Point& p) { return std::hypot(p[0], p[1], p[2]); };
  const Point normal = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  if (!(length(normal) > 0) || !std::isfinite(length(normal)))
    refuse(option, text, "the half axes (ax,ay,az) and (bx,by,bz) span no plane");
  constexpr double kAskew = 1e-6;
  if (std::fabs(a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) > kAskew * length(a) * length(b))
    refuse(option, text, "the half axes (ax,ay,az) and (bx,by,bz) are not perpendicular");
  if (h < 0) refuse(option, text, "the half thickness is negative");
  const double scale = h / length(normal);
  return {centre, {a, b, {scale * normal[0], scale * normal[1], scale * normal[2]}}};
}

} // namespace

std::optional<double> finite(std::string_view text) {
  double value = 0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (status != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::uint64_t Count::of(std::uint64_t total) const {
  constexpr double kRounding = 1 + 0x1p-51; // 29% of 100 is 29
  return static_cast<std::uint64_t>(relative ? std::floor(value * static_cast<double>(total) * kRounding) : value);
}

double parse_number(std::string_view option, std::string_view text) {
  const auto value = finite(text);
  if (!value || std::signbit(*value)) refuse(option, text, "a finite number that is not negative is wanted");
  return *value;
}

std::vector<double> parse_numbers(std::string_view option, std::string_view text, std::string_view list) {
  std::vector<double> numbers;
  for (std::size_t begin = 0; begin <= list.size();) {
    const std::size_t end = std::min(list.find(',', begin), list.size());
    const std::string_view number = list.substr(begin, end - begin);
    const auto value = finite(number);
    if (!value) refuse(option, text, "'" + std::string(number) + "' is not a finite number");
    numbers.push_back(*value);
    begin = end + 1;
  }
  return numbers;
}

std::uint64_t parse_whole(std::string_view option, std::string_view text, std::uint64_t least, std::uint64_t most) {
  std::uint64_t value = 0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (status != std::errc{} || end != text.data() + text.size() || value < least || value > most) {
    refuse(option, text, "a whole number from " + std::to_string(least) + " to " + std::to_string(most) + " is wanted");
  }
  return value;
}

Bound parse_bound(std::string_view option, std::string_view text) {
  const auto bound = bound_of(text);
  if (!bound) refuse(option, text, "a finite number that is not negative is wanted, or a percentage such as 1%");
  return *bound;
}

std::optional<Bound> welding_of(bool weld, const std::optional<std::string>& within) {
  if (within) return parse_bound("--weld-within", *within);
  return weld ? std::optional(Bound{}) : std::nullopt;
}

std::vector<FieldBound> parse_field_bounds(std::string_view option, const std::vector<std::string>& texts) {
  std::vector<FieldBound> bounds;
  for (const std::string& text : texts) {
    std::size_t begin = 0;
    for (std::size_t comma = 0; comma != std::string::npos;) {
      comma = text.find(',', std::max(begin, comma));
      const std::size_t end = std::min(comma, text.size());
      if (const auto bound = field_bound_of(std::string_view(text).substr(begin, end - begin))) {
        bounds.push_back(*bound);
        begin = end + 1;
      } else if (comma == std::string::npos) {
        refuse(option, text, "X, X%, NAME=X or NAME=X% is wanted (several with commas), X finite and not negative");
      }
      if (comma != std::string::npos) ++comma;
    }
  }
  for (auto bound = bounds.begin(); bound != bounds.end(); ++bound) {
    if (std::any_of(bounds.begin(), bound, [&](const FieldBound& other) { return other.field == bound->field; })) {
      throw Error(ErrorCode::kBadArgument,
                  std::string(option) + ": two bounds for " +
                      (bound->field.empty() ? "every field" : "the field '" + bound->field + "'"));
    }
  }
  return bounds;
}

Count parse_count(std::string_view option, std::string_view text) {
  if (text.ends_with('%')) {
    const auto bound = bound_of(text);
    if (!bound || bound->value > 1) refuse(option, text, "a percentage from 0% to 100% is wanted");
    return {bound->value, true};
  }
  // 2^53: every whole number up to here is a double.
  return {static_cast<double>(parse_whole(option, text, 0, std::uint64_t{1} << 53)), false};
}

std::uint64_t parse_bytes(std::string_view option, std::string_view text) {
  struct Unit {
    std::string_view name;
    std::uint64_t bytes;
  };
  static constexpr std::array<Unit, 9> kUnits = {{{"kB", 1000},
                                                  {"MB", 1000000},
                                                  {"GB", 1000000000},
                                                  {"KiB", 1 << 10},
                                                  {"MiB", 1 << 20},
                                                  {"GiB", 1 << 30},
                                                  {"k", 1000},
                                                  {"M", 1000000},
                                                  {"G", 1000000000}}};
  for (const Unit& unit : kUnits) {
    if (!text.ends_with(unit.name)) continue;
    const auto value = finite(text.substr(0, text.size() - unit.name.size()));
    if (!value || std::signbit(*value) || *value > 1e9)
      refuse(option, text, "a size such as 500kB, 20MB or 1.5GB is wanted");
    return static_cast<std::uint64_t>(*value * static_cast<double>(unit.bytes));
  }
  if (text.find_first_not_of("0123456789") != std::string_view::npos)
    refuse(option, text, "a size such as 500kB, 20MB or 1.5GB is wanted");
  return parse_whole(option, text, 0, std::uint64_t{1} << 53);
}

std::uint64_t parse_memory_limit(std::string_view text) {
  const std::uint64_t bytes = parse_bytes("--memory-limit", text);
  if (bytes == 0) refuse("--memory-limit", text, "more than nothing is wanted; without the option there is no limit");
  return bytes;
}

double parse_duration(std::string_view option, std::string_view text) {
  std::string_view number = text;
  double unit = 1;
  if (!text.empty() && (text.back() == 's' || text.back() == 'm' || text.back() == 'h')) {
    unit = text.back() == 's' ? 1 : text.back() == 'm' ? 60 : 3600;
    number.remove_suffix(1);
  }
  const auto value = finite(number);
  if (!value || std::signbit(*value)) refuse(option, text, "a time such as 90s, 5m or 1h is wanted");
  return *value * unit;
}

Region parse_region(std::string_view option, std::string_view text) {
  const std::size_t colon = text.find(':');
  const std::string_view shape = text.substr(0, colon);
  const std::vector<double> numbers =
      colon == std::string_view::npos ? std::vector<double>{} : parse_numbers(option, text, text.substr(colon + 1));
  const auto point = [&](std::size_t first) { return Point{numbers[first], numbers[first + 1], numbers[first + 2]}; };
  if (shape == "box" && numbers.size() == 6) {
    const Box box{point(0), point(3)};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (box.min[axis] > box.max[axis]) {
        const std::string name(1, "xyz"[axis]);
        refuse(option, text, "the box is empty: " + name + "0 is greater than " + name + "1");
      }
    }
    return box;
  }
  if (shape == "sphere" && numbers.size() == 4) {
    if (numbers[3] < 0) refuse(option, text, "the radius is negative");
    return Sphere{point(0), numbers[3]};
  }
  if (shape == "half" && numbers.size() == 4) {
    if (point(0) == Point{}) refuse(option, text, "the normal is 0,0,0");
    return HalfSpace{point(0), numbers[3]};
  }
  if (shape == "obox" && numbers.size() == 10)
    return oriented_box(option, text, point(0), point(3), point(6), numbers[9]);
  refuse(option, text,
         "box:x0,y0,z0,x1,y1,z1 or sphere:x,y,z,r or half:nx,ny,nz,d or obox:x,y,z,ax,ay,az,bx,by,bz,h is wanted");
}

ValuesOfInterest parse_isovalue(std::string_view option, std::string_view text) {
  const std::size_t equals = text.rfind('=');
  const auto value = equals == std::string_view::npos ? std::nullopt : finite(text.substr(equals + 1));
  if (!value || equals == 0) refuse(option, text, "FIELD=V is wanted, V finite");
  return {std::string(text.substr(0, equals)), *value, *value};
}

ValuesOfInterest parse_values(std::string_view option, std::string_view text) {
  const std::size_t equals = text.rfind('=');
  const std::string_view ends = equals == std::string_view::npos ? std::string_view{} : text.substr(equals + 1);
  const std::size_t dots = ends.find("..");
  if (equals == 0 || dots == std::string_view::npos) refuse(option, text, "FIELD=MIN..MAX is wanted");
  const std::string_view least = ends.substr(0, dots), most = ends.substr(dots + 2);
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto min = least.empty() ? -kInfinity : finite(least), max = most.empty() ? kInfinity : finite(most);
  if (!min || !max) refuse(option, text, "FIELD=MIN..MAX is wanted, MIN and MAX finite or left out");
  if (*min > *max) refuse(option, text, "the interval is empty: MIN is greater than MAX");
  return {std::string(text.substr(0, equals)), *min, *max};
}

View parse_view(std::string_view option, std::string_view text, bool has_size) {
  View view;
  view.vertical_angle = kDegree * 30;
  std::optional<Point> eye, at, up;
  std::vector<std::string_view> seen;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(':', begin), text.size());
    const std::string_view part = text.substr(begin, end - begin);
    begin = end + 1;
    const std::size_t equals = part.find('=');
    const std::string_view name = part.substr(0, equals);
    const std::string_view value = equals == std::string_view::npos ? std::string_view{} : part.substr(equals + 1);
    if (std::find(seen.begin(), seen.end(), name) != seen.end())
      refuse(option, text, "'" + std::string(name) + "' is there twice");
    seen.push_back(name);
    if (name == "eye") {
      eye = point_of(option, text, value);
    } else if (name == "at") {
      at = point_of(option, text, value);
    } else if (name == "up") {
      up = point_of(option, text, value);
    } else if (name == "angle") {
      const auto angle = finite(value);
      if (!angle || *angle <= 0 || *angle >= 180)
        refuse(option, text, "an angle above 0 and below 180 degrees is wanted");
      view.vertical_angle = kDegree * *angle;
    } else if (name == "size" && has_size) {
      const std::size_t times = std::min(value.find('x'), value.size());
      constexpr std::uint64_t kMost = 1U << 20;
      const std::string of_size = std::string(option) + " size";
      view.width = static_cast<std::uint32_t>(parse_whole(of_size, value.substr(0, times), 1, kMost));
      view.height =
          static_cast<std::uint32_t>(parse_whole(of_size, value.substr(std::min(times + 1, value.size())), 1, kMost));
    } else {
      refuse(option, text,
             "'" + std::string(part) +
                 "' is none of eye=, at=, up=, angle=" + (has_size ? ", size=" : "; the size is that of --size"));
    }
  }
  if (!eye || !at) refuse(option, text, "eye=x,y,z:at=x,y,z is wanted");
  if (*eye == *at) refuse(option, text, "the eye is where it looks at");
  view.eye = *eye;
  view.direction = {(*at)[0] - (*eye)[0], (*at)[1] - (*eye)[1], (*at)[2] - (*eye)[2]};
  const std::optional<Point> along = direction_of(view.direction);
  if (!along) refuse(option, text, "the eye is too far from where it looks at");
  constexpr double kAlong = 1e-6, kParallel = 1e-9; // what is taken is far from what is refused
  view.up = up ? *up : std::hypot((*along)[0], (*along)[1]) <= kAlong ? Point{0, 1, 0} : Point{0, 0, 1};
  const std::optional<Point> upward = direction_of(view.up);
  if (!upward || !(norm(cross(*along, *upward)) > kParallel))
    refuse(option, text, "up must be another direction than that from the eye to at");
  return view;
}

void check_field(std::string_view option, const std::string& field, const std::vector<std::string>& all,
                 const std::vector<std::string>& governing) {
  if (std::find(governing.begin(), governing.end(), field) != governing.end()) return;
  const bool carried = std::find(all.begin(), all.end(), field) != all.end();
  throw Error(ErrorCode::kBadArgument,
              std::string(option) + ": " + (carried ? "no errors are kept for the field '" : "there is no field '") +
                  field + (carried ? "'; they are for: " : "'; the fields with errors are: ") + quoted_list(governing));
}

std::vector<FieldBound> resolve_field_bounds(std::string_view option, const std::vector<FieldBound>& bounds,
                                             const std::vector<std::string>& all,
                                             const std::vector<std::string>& governing) {
  std::vector<FieldBound> resolved;
  for (const FieldBound& bound : bounds) {
    if (bound.field.empty()) continue;
    check_field(option, bound.field, all, governing);
    resolved.push_back(bound);
  }
  const auto general =
      std::find_if(bounds.begin(), bounds.end(), [](const FieldBound& bound) { return bound.field.empty(); });
  if (general == bounds.end()) return resolved;
  if (governing.empty()) {
    throw Error(ErrorCode::kBadArgument, std::string(option) + ": there is no field with errors to bound");
  }
  for (const std::string& field : governing) {
    if (std::none_of(resolved.begin(), resolved.end(), [&](const FieldBound& b) { return b.field == field; })) {
      resolved.push_back({field, general->bound});
    }
  }
  return resolved;
}

std::string quoted_list(const std::vector<std::string>& names) {
  if (names.empty()) return "none";
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    text += (i == 0 ? "'" : i + 1 == names.size() ? " and '" : ", '") + names[i] + "'";
  }
  return text;
}

} // namespace ptet::cli
