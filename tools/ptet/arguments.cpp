#include "arguments.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <optional>

namespace ptet::cli {
namespace {

[[noreturn]] void refuse(std::string_view option, std::string_view text, const std::string& why) {
  throw Error(ErrorCode::kBadArgument, std::string(option) + " '" + std::string(text) + "': " + why);
}

/// The whole of `text` as a finite number, or nothing.
std::optional<double> finite(std::string_view text) {
  double value = 0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (status != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
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

} // namespace

std::uint64_t Count::of(std::uint64_t total) const {
  return static_cast<std::uint64_t>(relative ? std::floor(value * static_cast<double>(total)) : value);
}

double parse_number(std::string_view option, std::string_view text) {
  const auto value = finite(text);
  if (!value || std::signbit(*value)) refuse(option, text, "a finite number that is not negative is wanted");
  return *value;
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

FocusRegion parse_focus(std::string_view option, std::string_view text) {
  const std::size_t colon = text.find(':');
  const std::string_view shape = text.substr(0, colon);
  std::vector<double> numbers;
  for (std::size_t at = colon; at != std::string_view::npos; at = text.find(',', at + 1)) {
    const std::string_view number = text.substr(at + 1, text.find(',', at + 1) - (at + 1));
    const auto value = finite(number);
    if (!value) refuse(option, text, "'" + std::string(number) + "' is not a finite number");
    numbers.push_back(*value);
  }
  if (shape == "box" && numbers.size() == 6) {
    const Box box{{numbers[0], numbers[1], numbers[2]}, {numbers[3], numbers[4], numbers[5]}};
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
    return Sphere{{numbers[0], numbers[1], numbers[2]}, numbers[3]};
  }
  refuse(option, text, "box:x0,y0,z0,x1,y1,z1 or sphere:x,y,z,r is wanted");
}

std::vector<FieldBound> resolve_field_bounds(std::string_view option, const std::vector<FieldBound>& bounds,
                                             const std::vector<std::string>& all,
                                             const std::vector<std::string>& governing) {
  std::vector<FieldBound> resolved;
  for (const FieldBound& bound : bounds) {
    if (bound.field.empty()) continue;
    if (std::find(governing.begin(), governing.end(), bound.field) == governing.end()) {
      const bool carried = std::find(all.begin(), all.end(), bound.field) != all.end();
      throw Error(ErrorCode::kBadArgument,
                  std::string(option) + ": " +
                      (carried ? "no errors are kept for the field '" : "there is no field '") + bound.field +
                      (carried ? "'; they are for: " : "'; the fields with errors are: ") + quoted_list(governing));
    }
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

std::string ending_of(const std::string& path) {
  return std::filesystem::path(path).extension().string();
}

} // namespace ptet::cli
