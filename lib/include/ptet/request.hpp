// What is asked of an opened file: errors allowed, where, and how much the answer may cost. All parts may be combined.
//
//   focus            here exactly, and next to it within what grows with distance    a promise by itself
//   error bounds     within this everywhere, or only
//     at values      where a field may take values of interest, and
//     in a view      as sharp as a camera's picture shows it
//   budgets          and of all that, what fits: what keeps errors small first
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
  /// Largest error allowed of the tets and boundary faces that meet the region, and of the original in it: no point of
  /// its boundary there is further from that of the mesh, and where the mesh does not reach its vertices are compared.
  ///   0         these are original ones, bit for bit
  ///   relative  every governing field may be off by this fraction of its range, the boundary by this fraction of the
  ///             diagonal
  ///   absolute  every governing field may be off by this, in its units; the boundary by the fraction of the diagonal
  ///             that this is of the largest range of a governing field, or by nothing where none governs or has a
  ///             range
  Bound error{0, true};
  /// Outside the region the error may grow with the distance: of a tet whose nearest point is `distance` away from the
  /// region, error + falloff * distance / diagonal is allowed, of a point of the original likewise. None: nothing is
  /// asked outside.
  std::optional<Bound> falloff = std::nullopt;
};

/// Refine only where a field may take values in [min, max]; min == max: an isovalue.
struct ValuesOfInterest {
  std::string field; ///< a governing one; of a field of vectors the interval is of their Euclidean norm
  double min = 0;    ///< field units, as `max`; -infinity and infinity leave an end open
  double max = 0;
};

/// What a camera sees, in perspective.
struct View {
  Point eye{};
  Point direction{0, 0, -1};                   ///< of any length but 0
  Point up{0, 1, 0};                           ///< not parallel to the direction
  double vertical_angle = 0.52359877559829887; ///< of the whole picture, radians (30 degrees), below pi
  std::uint32_t width = 1920;                  ///< pixels
  std::uint32_t height = 1080;                 ///< pixels
  /// Largest domain error, in pixels: as seen from the eye no boundary point in the picture is further from its place.
  double max_pixels = 1;
  /// Outside the picture errors may be so many times those allowed in it, by pixels and by Request's bounds; >= 1.
  /// Infinity: nothing is asked there.
  double outside = std::numeric_limits<double>::infinity();
};

/// Left as it is, it asks for the original mesh.
struct Request {
  /// The largest field errors allowed; where two bounds are on one field the smaller holds. With values of interest or
  /// a view these bounds and the next hold only where those say.
  std::vector<FieldBound> field_error;
  /// The largest distance allowed between the boundary of the mesh and that of the original, either way.
  std::optional<Bound> domain_error;

  /// Budgets of size. What is asked is refined in an order that the file has, up to the first collapse that would pass
  /// a budget. The order keeps small what the file was built for, greatest errors, mean squares or both together, at
  /// all sizes: a bound on the greatest error alone may come out smaller for as many tets, with a larger RMS. Where no
  /// bound, value or view says what is asked, all of the original is, beside a focus too. Of files
  /// whose errors are not measured everywhere it is the builder's own. The base mesh and what the focus regions need
  /// inside are there in any case, even where they pass a budget.
  std::optional<std::uint64_t> max_tets;
  std::optional<std::uint64_t> max_vertices;
  /// Bytes of the answer: positions, fields, tets (16 each) and boundary faces (12 each).
  std::optional<std::uint64_t> max_bytes;
  /// About how long the call may take, wall time.
  ///
  /// Dataset::extract stops refining when the time is up, inside focus regions too. Making the mesh out of what was
  /// refined is reckoned with; a read that is under way may still pass the time, and so may making anew what is in
  /// memory where damage was met, and stating the errors of the parts that the request names (Extraction::in_focus,
  /// at_values, in_view), which takes a look at every record read. `origins` read all of the file, whatever the time.
  /// Two answers to such a request need not be the same.
  ///
  /// Session::update leaves to the next update what it has not done, and comes to the same mesh in the end. It reads as
  /// many blocks as seem to fit the time, but at least one, with those that it depends on (unless another thread is
  /// reading): in a large file of which nothing has been read, some ten blocks and ms. Then it splits and
  /// collapses, looking at the clock every 64 records: these get at least half of the time, however long reading took.
  /// Not bounded: finding the cut among the records in memory, and reading where memory is limited
  /// (OpenOptions::memory_limit). With OpenOptions::background it reads nothing itself, but may have to wait while the
  /// reading thread puts some dozen records in their places, packs its tables once all of the file is read, or makes
  /// them anew where it met damage.
  std::optional<double> max_milliseconds;

  /// Each region is refined for itself, whatever the bounds and budgets say; what their falloffs ask for outside is
  /// subject to the budgets.
  std::vector<Focus> focus;
  /// Where given, the bounds on errors and the view's hold only for tets that may have one of these values: whose
  /// values, widened by the tet's error, reach into the interval. So neither the isosurface of the mesh nor that of the
  /// original runs where the bounds do not hold. With no bounds these tets are original ones. Of what the mesh leaves
  /// outside this holds for the original's vertices, which are sampled, see Extraction::field_error; the bound on the
  /// boundary holds for faces that may have one of the values, or stand for a part of the original that may.
  std::vector<ValuesOfInterest> values;
  /// Where given, what the picture shows, of the mesh and of the original, is sharp to View::max_pixels, besides the
  /// bounds on errors. These hold no more
  /// outside the picture, but for View::outside: the errors of the whole mesh may pass them.
  std::optional<View> view;

  /// Also tell which record made each tet (Extraction::made_by, Session::made_by()), and state the errors achieved as
  /// tightly as they are known. This reads all of the file: what made a tet is often told by a record that is not
  /// needed for the mesh.
  bool origins = false;

  /// Put vertices in the order of the mesh that the file was built from, and fill Extraction::input_vertex. Where the
  /// answer is the whole original its tets and their corners come in that order, too: byte for byte what was given.
  /// Only of a file that keeps the order (DatasetInfo::has_input_order), and not of a Session, whose slots have an
  /// order of their own. Each call reads all that the file has of it, also with OpenOptions::background and whatever
  /// the budget of time.
  bool input_order = false;
};

} // namespace ptet
