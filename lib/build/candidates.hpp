// The half-edges that may be collapsed next.
//
//   every vertex   a page of its best half-edges, each (cost, target), and a floor: what lies beyond it has not been on
//                  a page since the star last changed
//
//                      [ refused | next ... | ] floor  ...
//
//   a round        predict  brings the pages of vertices whose star has changed up to date, in parallel
//                  pick     the best part of the vertices by the cost of their next half-edge
//
// A cost by quadrics depends on nothing but its two ends. So when vs -> vd changes the star of a vertex x, all that
// becomes of the page of x is that vs leaves it and vd may join it, and that refused half-edges may be tried again. The
// page is filled anew when nothing else is left on it, and where the quadric itself has changed.
//
// Source: Cignoni et al. 2000, sections 4.3 and 5.
#pragma once

#include "build/collapse_check.hpp"
#include "build/collapse_cost.hpp"
#include "build/quadric_predictor.hpp"
#include "build/trial.hpp"
#include "build/working_surface.hpp"
#include "mesh/clearable_set.hpp"
#include "mesh/large_pages.hpp"

#include <array>
#include <compare>
#include <functional>
#include <limits>
#include <vector>

#include <oneapi/tbb/enumerable_thread_specific.h>

namespace ptet::build {

struct HalfEdge {
  float cost = std::numeric_limits<float>::infinity();
  Vertex target = kNone;
  friend auto operator<=>(const HalfEdge&, const HalfEdge&) = default;

  template <class Archive>
  void serialize(Archive& archive, unsigned /*version*/) {
    archive& cost& target;
  }
};

/// How often each thing became of a half-edge that was looked at.
using StatusCounts = std::array<std::uint64_t, kCollapseStatusCount>;

class Candidates {
public:
  /// The predictor of the costs; for predictions that simulate it makes the shortlist.
  Candidates(const WorkingComplex& complex, const WorkingSurface& surface, const Predictor& predictor,
             const QuadricPredictor* quadrics, const CollapseCost& cost, Prediction prediction, double round_fraction,
             std::function<Trial()> new_trial, const std::vector<char>& frozen);

  /// Brings the pages up to date. Vertices that failed wait until `round` is theirs. Where costs are simulated, those
  /// that were far from being picked keep their old page until they are near (lazy evaluation).
  /// `look` is called now and then from this thread, and may throw.
  void predict(std::uint32_t round, const std::function<void()>& look = {});
  /// The best part of the vertices with a candidate that is up to date, in the order (height, octave of cost, vertex).
  [[nodiscard]] std::vector<Vertex> pick();
  /// The highest cost of the last pick.
  [[nodiscard]] float round_cost() const { return round_cost_; }

  [[nodiscard]] const HalfEdge& best(Vertex v) const { return pages_[v].best[pages_[v].next]; }
  /// Longest chain of records below the tets that are, or since they were last looked at have been, around `v`.
  [[nodiscard]] std::uint32_t height(Vertex v) const { return pages_[v].height; }
  /// The best half-edge of `v` is refused: the next one takes its place, or `v` waits. When the page is empty and costs
  /// are measured, the next page is filled by predict().
  /// Thread rule: several threads may drop half-edges of different vertices at once, unless costs are measured.
  void drop_best(Vertex v, std::uint32_t round);
  /// By any thread, before drop_best().
  void count_refusal(CollapseStatus status) { ++workers_.local().refusals[static_cast<std::size_t>(status)]; }
  /// The best half-edge of `v` has turned out to cost more.
  void raise_best(Vertex v, float cost);
  /// All that is known of `v` is no longer so.
  void forget(Vertex v) {
    dirty_[v] = 1;
    pages_[v].whole = false;
  }
  /// Whether the star of `v` has changed since its page was brought up to date. Thread rule: const.
  [[nodiscard]] bool has_changed(Vertex v) const { return dirty_[v] != 0; }
  /// A collapse vs -> vd, the record of which has this height, has changed the star of a vertex of Lk(vs).
  void change_star(const LinkVertex& v, Vertex vd, std::uint32_t height);
  /// Looks at everything afresh.
  void forget_all();

  [[nodiscard]] std::size_t movable_count() const { return movable_.size(); }
  [[nodiscard]] Trial& trial() { return workers_.local().trial; }
  /// Refusals met while predicting, so far.
  [[nodiscard]] StatusCounts refusals() const;
  [[nodiscard]] std::uint64_t simulations() const;

  /// All that lasts from one round to the next and is not told by the complex, which must be the same when it is loaded
  /// as it was when it was saved.
  template <class Archive>
  void serialize(Archive& archive, unsigned /*version*/) {
    std::erase_if(movable_, [&](Vertex v) { return !complex_.alive(v); });
    for (const Vertex v : movable_) {
      archive& pages_[v] & dirty_[v];
      if constexpr (Archive::is_loading::value)
        if (dirty_[v]) forget(v); // what happened to it is not kept
    }
    StatusCounts refused = refusals();
    std::uint64_t simulated = simulations();
    archive& used_up_& round_cost_& refused& simulated;
    if constexpr (Archive::is_loading::value) {
      Worker& worker = workers_.local();
      worker.refusals = refused;
      worker.simulations = simulated;
    }
  }

private:
  static constexpr std::size_t kPage = 6;
  /// Of these where they are measured: simulating a third for every star that changes gains nothing.
  static constexpr std::size_t kShortlist = 2;

  struct Page {
    std::array<HalfEdge, kPage> best; ///< ascending
    HalfEdge floor;
    std::uint32_t next = 0;     ///< those before it were refused
    std::uint32_t news = kNone; ///< head of a list in news_: what has joined the star since the last predict()
    bool whole = false;         ///< has all half-edges up to the floor
    std::uint32_t height = 0;
    std::uint32_t failures = 0;     ///< how often every half-edge was refused
    std::uint32_t resume_round = 0; ///< not looked at again before this round, unless nothing else is left

    template <class Archive>
    void serialize(Archive& archive, unsigned /*version*/) {
      archive& best& floor& next& whole& height& failures& resume_round;
    }
  };
  struct Worker {
    Worker(Trial its_trial, std::size_t vertices) : trial(std::move(its_trial)), seen(vertices + 1) {}

    Trial trial;
    ClearableSet seen; ///< of vertices, the dummy last
    std::vector<Vertex> targets;
    std::vector<float> costs;
    std::vector<HalfEdge> half_edges;
    std::vector<double> growth;
    StatusCounts refusals{};
    std::uint64_t simulations = 0;
  };

  /// A new neighbour of some vertex, and the next one in its list.
  struct News {
    Vertex target;
    std::uint32_t next;
  };

  static constexpr HalfEdge kLowest{-std::numeric_limits<float>::infinity(), 0};

  /// Whether costs come from simulated collapses.
  [[nodiscard]] bool simulates() const {
    return prediction_ == Prediction::kSimulate || prediction_ == Prediction::kExact;
  }
  /// Whether a cost depends on nothing but the quadric of the vertex and its target.
  [[nodiscard]] bool costs_last() const { return prediction_ == Prediction::kQuadric; }
  void fill_page(Vertex v, Worker& worker);
  [[nodiscard]] bool mend_page(Vertex v);
  void turn_page(Vertex v, Worker& worker, std::uint32_t round);
  void find_targets(Vertex v, Worker& worker);
  void simulate(Vertex v, Worker& worker);
  [[nodiscard]] float simulated_cost(Vertex v, Vertex target, Trial& trial, std::vector<double>& growth) const;

  const WorkingComplex& complex_;
  const WorkingSurface& surface_;
  const Predictor& predictor_;
  const QuadricPredictor* quadrics_;
  const CollapseCost& cost_;
  Prediction prediction_;
  double round_fraction_;
  LargeVector<Page> pages_;
  std::vector<char> dirty_;
  std::vector<News> news_;
  std::vector<Vertex> movable_; ///< vertices that are there and not frozen
  std::vector<Vertex> work_;
  std::vector<std::uint64_t> keys_; ///< what pick() sorts by
  std::vector<Vertex> used_up_;     ///< vertices whose page has no half-edge left that was not refused
  float round_cost_ = std::numeric_limits<float>::infinity();
  oneapi::tbb::enumerable_thread_specific<Worker> workers_;
};

} // namespace ptet::build
