#include "formats/vtk/number_text.hpp"

#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <system_error>

namespace ptet::vtkio {
namespace {

constexpr const char* kNoNumber = "is not a number";
constexpr const char* kNoInteger = "is not an integer";
constexpr const char* kOutOfRange = "is out of range";

template <class Float>
const char* unfit_float(std::string_view text) {
  Float value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc::invalid_argument || end != text.data() + text.size()) return kNoNumber;
  // Too small is zero, and as good as that.
  const bool too_large =
      error == std::errc::result_out_of_range && std::abs(std::strtod(std::string(text).c_str(), nullptr)) > 1;
  return too_large ? kOutOfRange : nullptr;
}

template <class Integer>
const char* unfit_integer(std::string_view text) {
  Integer value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc() && end == text.data() + text.size()) return nullptr;
  if (unfit_float<double>(text) == kNoNumber) return kNoNumber;
  const bool digits = text.find_first_not_of("0123456789", text.starts_with('-') ? 1 : 0) == std::string_view::npos;
  return digits ? kOutOfRange : kNoInteger;
}

} // namespace

const char* unfitness(std::string_view text, ScalarType type) {
  // A sign that std::from_chars does not know.
  if (text.size() > 1 && text.front() == '+' && text[1] != '-') text.remove_prefix(1);
  switch (type) {
  case ScalarType::kInt8: return unfit_integer<std::int8_t>(text);
  case ScalarType::kUInt8: return unfit_integer<std::uint8_t>(text);
  case ScalarType::kInt16: return unfit_integer<std::int16_t>(text);
  case ScalarType::kUInt16: return unfit_integer<std::uint16_t>(text);
  case ScalarType::kInt32: return unfit_integer<std::int32_t>(text);
  case ScalarType::kUInt32: return unfit_integer<std::uint32_t>(text);
  case ScalarType::kInt64: return unfit_integer<std::int64_t>(text);
  case ScalarType::kUInt64: return unfit_integer<std::uint64_t>(text);
  case ScalarType::kFloat32: return unfit_float<float>(text);
  case ScalarType::kFloat64: return unfit_float<double>(text);
  }
  return nullptr;
}

} // namespace ptet::vtkio
