#include "extract_notes.hpp"

#include "console.hpp"
#include "mesh/magnitude.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace ptet::cli {
namespace {

/// "the focus", or of several "focus 2".
std::string nth(const char* what, std::size_t i, std::size_t count) {
  return count == 1 ? std::string("the ") + what : std::string(what) + ' ' + std::to_string(i + 1);
}

/// Least and largest value at the corners of tets, of vectors the length.
std::pair<double, double> value_interval(const PointArray& array, const TetMesh& mesh) {
  std::pair range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const Tet& tet : mesh.tets) {
    for (const VertexId v : tet) {
      const double value = magnitude(array, v);
      range.first = std::min(range.first, value);
      range.second = std::max(range.second, value);
    }
  }
  return range;
}

} // namespace

std::vector<std::string> notes_on_wishes(const ExtractOutcome& outcome) {
  const TetMesh& mesh = outcome.extraction.mesh;
  const Request& request = outcome.request;
  const UnmetWishes unmet = unmet_wishes(request, outcome.extraction);
  std::vector<std::string> notes;
  const std::string in_box = ": the mesh is in the box " + placed(outcome.info.box_min, outcome.info.diagonal) +
                             " to " + placed(outcome.info.box_max, outcome.info.diagonal);
  for (const std::size_t i : unmet.focus)
    notes.push_back("no tet of the mesh meets " + nth("focus", i, request.focus.size()) + in_box);
  if (unmet.view) notes.push_back("nothing of the mesh is in the view" + in_box);
  for (const std::size_t i : unmet.values) {
    const ValuesOfInterest& wanted = request.values[i];
    const PointArray* const array = mesh.find(wanted.field);
    if (array == nullptr) continue;
    const auto [least, most] = value_interval(*array, mesh);
    notes.push_back("nothing of the mesh has the values asked for" +
                    (request.values.size() == 1 ? "" : " in place " + std::to_string(i + 1)) + ": " +
                    (array->components == 1 ? wanted.field : "the length of " + wanted.field) + " is from " +
                    placed(least, most - least) + " to " + placed(most, most - least) + " in it");
  }
  return notes;
}

std::vector<std::string> notes_on_surface(const SurfaceLoss& loss) {
  constexpr double kLastDigits = 1e-6;
  if (loss.largest_move <= kLastDigits * loss.diagonal && loss.degenerate_faces == 0) return {};
  std::string note = "the 32-bit floats of .stl moved vertices by up to " + brief_up(loss.largest_move);
  const std::string share = percent_up(loss.largest_move, loss.diagonal);
  if (!share.empty()) note += " (" + share + " of the diagonal)";
  if (loss.degenerate_faces != 0) note += ", " + counted(loss.degenerate_faces, "face") + " lost all area";
  return {note + "; .obj, .off and .ply keep positions as they are"};
}

} // namespace ptet::cli
