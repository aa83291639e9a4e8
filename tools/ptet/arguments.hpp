// What a user types after an option, made into what the library takes. Numbers are read the same in every locale.
//
//   bound    X | X%                        absolute | percent of the field's range, or of the bounding-box diagonal
//   bounds   bound | NAME=bound, ...       for every governing field | for one; an entry may follow after a comma
//   count    N | N%                        so many | percent of the original's
//   size     N | NkB | NMB | NGB           bytes, in thousands; kB or k, and so on; KiB, MiB, GiB: in 1024s
//   time     N | Ns | Nm | Nh              seconds, minutes, hours
//   region   box:x0,y0,z0,x1,y1,z1 | sphere:x,y,z,r | half:nx,ny,nz,d | obox:x,y,z,ax,ay,az,bx,by,bz,h
//   values   FIELD=V | FIELD=MIN..MAX      either end may be left out
//   view     eye=x,y,z:at=x,y,z[:up=x,y,z][:angle=DEGREES][:size=WxH]
//
// All functions throw Error(kBadArgument) with a message that begins with the option's name.
#pragma once

#include "ptet/bounds.hpp"
#include "ptet/dataset.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ptet::cli {

/// A number of vertices or tets; relative: a fraction of the original's.
struct Count {
  double value = 0;
  bool relative = false;
  /// The count, rounded down, given how many the original has.
  [[nodiscard]] std::uint64_t of(std::uint64_t total) const;
};

/// The whole of `text` as a finite number, or nothing.
[[nodiscard]] std::optional<double> finite(std::string_view text);
/// A finite number >= 0.
[[nodiscard]] double parse_number(std::string_view option, std::string_view text);
/// Finite numbers with commas between them: `list`, which is a part of `text`, what was typed and a refusal quotes.
[[nodiscard]] std::vector<double> parse_numbers(std::string_view option, std::string_view text, std::string_view list);
/// A whole number >= `least`, <= `most`.
[[nodiscard]] std::uint64_t parse_whole(std::string_view option, std::string_view text, std::uint64_t least,
                                        std::uint64_t most);
[[nodiscard]] Bound parse_bound(std::string_view option, std::string_view text);

/// What --weld and --weld-within ask for; none: no welding.
[[nodiscard]] std::optional<Bound> welding_of(bool weld, const std::optional<std::string>& within);
/// Names may hold commas and equal signs: an entry ends at the first comma before which it is complete.
/// No name may occur twice.
[[nodiscard]] std::vector<FieldBound> parse_field_bounds(std::string_view option,
                                                         const std::vector<std::string>& texts);
/// At most 100%.
[[nodiscard]] Count parse_count(std::string_view option, std::string_view text);
[[nodiscard]] std::uint64_t parse_bytes(std::string_view option, std::string_view text);
/// Bytes, more than 0.
[[nodiscard]] std::uint64_t parse_memory_limit(std::string_view text);
/// Seconds.
[[nodiscard]] double parse_duration(std::string_view option, std::string_view text);
[[nodiscard]] Region parse_region(std::string_view option, std::string_view text);
/// FIELD=V
[[nodiscard]] ValuesOfInterest parse_isovalue(std::string_view option, std::string_view text);
/// FIELD=MIN..MAX
[[nodiscard]] ValuesOfInterest parse_values(std::string_view option, std::string_view text);
/// 30 degrees from side to side of the height and 1920 x 1080 pixels when it does not say; z is up, or y when it looks
/// along z. `has_size`: whether the text may say how many pixels, or that is another option's to say.
[[nodiscard]] View parse_view(std::string_view option, std::string_view text, bool has_size = true);

/// Refuses a field that is not one of `governing`; `all` and `governing` as below.
void check_field(std::string_view option, const std::string& field, const std::vector<std::string>& all,
                 const std::vector<std::string>& governing);

/// One bound per governing field that is bounded: a bound by name goes before the one for every field.
/// `all` are the names a file or mesh has, `governing` those among them that bounds can be on.
[[nodiscard]] std::vector<FieldBound> resolve_field_bounds(std::string_view option,
                                                           const std::vector<FieldBound>& bounds,
                                                           const std::vector<std::string>& all,
                                                           const std::vector<std::string>& governing);

/// "'a', 'b' and 'c'"; "none" for an empty list.
[[nodiscard]] std::string quoted_list(const std::vector<std::string>& names);

} // namespace ptet::cli
