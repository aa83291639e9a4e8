// What is asked of an opened file: errors allowed, where, and how much the answer may cost. All parts may be combined.
//
//   focus            here exactly, and next to it within what grows with distance    a promise by itself
//   error bounds     within this everywhere, or only
//     at values      where a field may take values of interest, and
//     in a view      as sharp as a camera's picture shows it
//   budgets          and of all that, what fits: the collapses made last first
#pragma once

#include "ptet/bounds.hpp"
#include "ptet/mesh.hpp"

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace ptet {

/// An axis-parallel box, closed.
struct Box {
  Point min{};
  Point max{};

  friend bool operator==(const Box&, const Box&) = default;
};
/// A box in any position, closed: centre + a x + b y + c z, -1 <= a, b, c <= 1.
struct OrientedBox {
  Point centre{};
  /// x, y, z: from the centre to the middle of a side; mutually perpendicular (to within 1e-6 of their lengths).
  std::array<Point, 3> half_axes{};

  friend bool operator==(const OrientedBox&, const OrientedBox&) = default;
};
/// A ball, closed.
struct Sphere {
  Point centre{};
  double radius = 0;

  friend bool operator==(const Sphere&, const Sphere&) = default;
};
/// The points x with dot(normal, x) <= offset; the normal, of any length but 0, points out of it.
struct HalfSpace {
  Point normal{};
  double offset = 0;

  friend bool operator==(const HalfSpace&, const HalfSpace&) = default;
};
using Region = std::variant<Box, OrientedBox, Sphere, HalfSpace>;

/// A part of space where more is asked than elsewhere, whatever else the request says.
struct Focus {
  Region region;
  /// Largest error of the tets and boundary faces that meet the region: for every governing field; a domain error is
  /// allowed up to the same fraction of the diagonal (an absolute bound: up to the least fraction that it is of a
  /// field's range). 0: they are original ones, bit for bit.
  Bound error{0, true};
  /// Outside: the error allowed of a tet at a distance from the region, measured from its nearest point, is
  /// error + falloff * (distance / diagonal of the bounding box). None: nothing is asked outside.
  std::optional<Bound> falloff = std::nullopt;
};

/// Refine only where a field may take values in [min, max]; min == max: an isovalue.
struct ValuesOfInterest {
  std::string field; ///< a governing one; of vectors the Euclidean norm counts
  double min = 0;
  double max = 0;
};

/// What a camera sees, in perspective.
struct View {
  Point eye{};
  Point direction{0, 0, -1};   ///< of any length but 0
  Point up{0, 1, 0};           ///< not parallel to the direction
  double vertical_angle = 0.5; ///< of the whole picture, radians, below pi
  std::uint32_t width = 1920;  ///< pixels
  std::uint32_t height = 1080; ///< pixels
  /// Largest domain error, in pixels: as seen from the eye no boundary point in the picture is further from its place.
  double max_pixels = 1;
  /// What cannot be seen may have so many times the errors; >= 1. Infinity: nothing is asked outside the picture.
  double outside = std::numeric_limits<double>::infinity();
};

struct Request {
  /// Bounds on field errors; a bound with an empty name is for every governing field.
  std::vector<FieldBound> field_error;
  std::optional<Bound> domain_error;

  /// Budgets: of what is asked the collapses made last are undone first, up to the first that does not fit. With no
  /// bounds that is the mesh that the builder had at that size (to within 2.2% of its vertices), the smallest error in
  /// the sense of the file's objective. The base mesh and what the focus regions need inside are there in any case,
  /// even where they pass a budget.
  std::optional<std::uint64_t> max_tets;
  std::optional<std::uint64_t> max_vertices;
  /// Bytes of the answer: positions, fields, tets (16 each) and boundary faces (12 each).
  std::optional<std::uint64_t> max_bytes;
  /// How long the call may take, about. extract() then stops refining, the focus too: putting the mesh out, whose time
  /// is reckoned with as it grows, and the read under way may pass it, and two answers to such a request need not be
  /// the same. Session::update leaves what it has not done to the next update, and comes to the same mesh in the end:
  /// it reads blocks as they seem to fit the time, at least one unless another thread is reading, and splits and
  /// collapses 64 records between two looks at the clock, for half of the time where all of it went before. Not bounded
  /// is what it takes to find the cut among the records in memory; nor is reading where memory is limited. With
  /// OpenOptions::background it never reads itself, but waits while some dozen records are put in their places, and
  /// while tables are packed once all of the file is read, or made anew where damage is met.
  std::optional<double> max_milliseconds;

  /// Each asks by itself; falloffs share the budgets with what else is asked outside.
  std::vector<Focus> focus;
  /// Where given, bounds on errors (the view's too) hold only where one of these may be met: where the values of a tet,
  /// widened by its error, reach into the interval. So neither the isosurface of the mesh nor that of the original runs
  /// where the bounds do not hold. With no bound the tets there are original ones.
  std::vector<ValuesOfInterest> values;
  std::optional<View> view;

  /// Also fill Extraction::made_by, keep Session::made_by(), and state the errors achieved as tightly as they are
  /// known. This reads all of the file: what made a tet is often told by a record that is not needed for the mesh.
  bool origins = false;

  /// Vertices in the order of the mesh that the file was built from, and, where all of it is there, its tets and their
  /// corners, too: byte for byte what was given. Also fill Extraction::input_vertex. Only of a file that keeps it
  /// (DatasetInfo::has_input_order); not of a Session, whose slots have an order of their own. Each call reads
  /// what the file has of it, all at once, also with OpenOptions::background and whatever the budget of time.
  bool input_order = false;
};
// A request that asks for nothing at all asks for the original mesh.

} // namespace ptet
