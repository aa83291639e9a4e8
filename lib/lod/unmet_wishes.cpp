#include "lod/camera.hpp"
#include "lod/region.hpp"
#include "lod/tet_runs.hpp"
#include "mesh/magnitude.hpp"
#include "ptet/dataset.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <span>
#include <vector>

namespace ptet {
namespace {

/// Of a scalar field, or of the length of a field of vectors, at the corners of tets. Nothing is in that of NaN alone.
struct ValuesOfRun {
  double least, greatest;

  static ValuesOfRun of(const PointArray& array, TetRun run) {
    ValuesOfRun values{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    for (const Tet& tet : run)
      for (const VertexId v : tet) {
        const double value = magnitude(array, v);
        values.least = std::min(values.least, value);
        values.greatest = std::max(values.greatest, value);
      }
    if (array.components > 1) values.least = std::min(values.least, 0.0); // between vectors the length may fall to 0
    return values;
  }
  [[nodiscard]] bool reach(const ValuesOfInterest& wanted) const {
    return wanted.min <= greatest && wanted.max >= least;
  }
};

/// What each run of a mesh is in, found when it is first asked for: a box, or values.
template <class Of>
class Runs {
public:
  explicit Runs(const std::vector<Tet>& tets) : tets_(tets) {}

  /// Whether `tet_meets` is true of any tet, and so `run_meets` of what its run is in. `measure`: of a run, what it is
  /// in; the same in every call.
  template <class Measure, class RunMeets, class TetMeets>
  bool any_of(Measure&& measure, RunMeets&& run_meets, TetMeets&& tet_meets) {
    for (std::size_t first = 0; first < tets_.size(); first += kRunLength) {
      const TetRun run = run_from(tets_, first);
      if (first / kRunLength == measured_.size()) measured_.push_back(measure(run));
      if (run_meets(measured_[first / kRunLength]) && std::any_of(run.begin(), run.end(), tet_meets)) return true;
    }
    return false;
  }

private:
  std::span<const Tet> tets_;
  std::vector<Of> measured_;
};

class WishCheck {
public:
  explicit WishCheck(const Extraction& answer)
      : mesh_(answer.mesh),
        is_all_(answer.complete && answer.limited_by != LimitedBy::kTime && answer.limited_by != LimitedBy::kBudget),
        around_(is_all_ ? 0 : answer.domain_error), boxes_(mesh_.tets) {}

  bool is_met(const Focus& focus) {
    return boxes_.any_of([&](TetRun run) { return box_around(mesh_, run); },
                         [&](const BoundingBox& box) { return meets(focus.region, box.low, box.high, around_); },
                         [&](const Tet& tet) { return meets(focus.region, corners_of(mesh_, tet), around_); });
  }
  bool is_met(const ValuesOfInterest& wanted) {
    if (!is_all_) return true; // for all that is known
    const PointArray* const array = mesh_.find(wanted.field);
    if (array == nullptr) return false;
    return values_.try_emplace(array, mesh_.tets)
        .first->second.any_of([&](TetRun run) { return ValuesOfRun::of(*array, run); },
                              [&](const ValuesOfRun& values) { return values.reach(wanted); },
                              [&](const Tet& tet) {
                                return ValuesOfRun::of(*array, {&tet, 1}).reach(wanted);
                              });
  }
  bool is_met(const View& view) {
    const Camera camera(view);
    return boxes_.any_of([&](TetRun run) { return box_around(mesh_, run); },
                         [&](const BoundingBox& box) {
                           return camera.meets(Box{box.low, box.high}, around_);
                         },
                         [&](const Tet& tet) { return camera.meets(corners_of(mesh_, tet), around_); });
  }
  template <class Wish>
  std::vector<std::size_t> unmet(const std::vector<Wish>& wishes) {
    std::vector<std::size_t> places;
    for (std::size_t i = 0; i < wishes.size(); ++i)
      if (!is_met(wishes[i])) places.push_back(i);
    return places;
  }

private:
  const TetMesh& mesh_;
  bool is_all_;   ///< the mesh is what was asked for, not cut short
  double around_; ///< so far from it what it lacks may be
  Runs<BoundingBox> boxes_;
  std::map<const PointArray*, Runs<ValuesOfRun>> values_;
};

} // namespace

UnmetWishes unmet_wishes(const Request& request, const Extraction& answer) {
  WishCheck check(answer);
  return {check.unmet(request.focus), check.unmet(request.values), request.view && !check.is_met(*request.view)};
}

} // namespace ptet
