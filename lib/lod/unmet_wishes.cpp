#include "lod/region.hpp"
#include "mesh/magnitude.hpp"
#include "ptet/dataset.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace ptet {
namespace {

bool is_met(const Region& region, const TetMesh& mesh) {
  return std::any_of(mesh.tets.begin(), mesh.tets.end(), [&](const Tet& tet) {
    const std::array<Point, 4> corners = {mesh.position(tet[0]), mesh.position(tet[1]), mesh.position(tet[2]),
                                          mesh.position(tet[3])};
    return meets(region, corners);
  });
}

/// Least and largest value at the corners of the tet.
std::pair<double, double> range_in(const Tet& tet, const PointArray& array) {
  std::array<double, 4> values{};
  std::transform(tet.begin(), tet.end(), values.begin(), [&](VertexId v) { return magnitude(array, v); });
  return {*std::min_element(values.begin(), values.end()), *std::max_element(values.begin(), values.end())};
}

bool is_met(const ValuesOfInterest& wanted, const TetMesh& mesh) {
  const PointArray* const array = mesh.find(wanted.field);
  return array != nullptr && std::any_of(mesh.tets.begin(), mesh.tets.end(), [&](const Tet& tet) {
           const auto [least, most] = range_in(tet, *array);
           // Between vectors the length may fall to 0.
           return wanted.min <= most && wanted.max >= (array->components == 1 ? least : 0);
         });
}

template <class Wish, class Of>
std::vector<std::size_t> unmet(const std::vector<Wish>& wishes, const TetMesh& mesh, Of&& of) {
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < wishes.size(); ++i)
    if (!is_met(of(wishes[i]), mesh)) places.push_back(i);
  return places;
}

} // namespace

UnmetWishes unmet_wishes(const Request& request, const TetMesh& mesh) {
  return {
      unmet(request.focus, mesh, [](const Focus& focus) -> const Region& { return focus.region; }),
      unmet(request.values, mesh, [](const ValuesOfInterest& wanted) -> const ValuesOfInterest& { return wanted; })};
}

} // namespace ptet
