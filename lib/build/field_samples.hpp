// Points inside the original tets, with the values of the original fields there: what the errors are looked at besides
// the removed vertices, so that what happens between vertices counts too (the paper's BFS).
//
//   tets      | flat field |  | steep field  |  |    |       in number as the field varies over the tet,
//   samples   |            |  |  .  :  .  .  |  | .  |       spread evenly over its volume
//
// Source: Cignoni et al. 2000, sections 4.4 and 5.4. Positions: the R3 sequence of Roberts, The Unreasonable
// Effectiveness of Quasirandom Sequences, 2018, folded into the tet by sorting (Devroye, Non-Uniform Random Variate
// Generation, 1986, section V.2).
#pragma once

#include "build/normalized_fields.hpp"
#include "build/working_complex.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace ptet::build {

struct Sample {
  std::uint32_t tet;            ///< the original tet that it lies in
  std::array<double, 4> weight; ///< barycentric coordinates in it: positive, sum 1
};

/// How much the fields vary over a tet: the largest distance between the values of two corners, as a fraction of the
/// range, over all fields.
[[nodiscard]] double field_variation(const NormalizedFields& fields, const std::array<Vertex, 4>& corners);

/// `count` samples over all tets, ascending by tet, in number proportional to the fields' variation over each; none
/// where nothing varies. What falls to a tet is rounded so that the sum over every run of tets is off by less than 1.
/// Same input, same samples. Cost: O(tets + count).
[[nodiscard]] std::vector<Sample> choose_samples(std::span<const Tet> tets, const NormalizedFields& fields,
                                                 std::size_t count);
/// As above, one sample a tet on average.
[[nodiscard]] std::vector<Sample> choose_samples(std::span<const Tet> tets, const NormalizedFields& fields);

/// Where samples are, and the fields there.
struct FieldSamples {
  std::vector<Point> points;  ///< by sample; to be put behind the vertices' positions
  std::vector<double> values; ///< sample x channel, as NormalizedFields::exact() has them for vertices
};
/// `fields` are those of the mesh with these tets: what is taken off 64-bit integers differs from mesh to mesh.
[[nodiscard]] FieldSamples look_at(std::span<const Sample> samples, std::span<const Tet> tets,
                                   const std::vector<Point>& positions, const NormalizedFields& fields);

} // namespace ptet::build
