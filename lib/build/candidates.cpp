#include "build/candidates.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

namespace ptet::build {
namespace {

/// A vertex all of whose half-edges were refused waits 1, 2, 4, ... rounds; at most 2 to this power.
constexpr std::uint32_t kLongestWait = 5;
/// When the star of a vertex changes its cost may fall, but seldom to less than this part: what was far from being
/// picked stays as it was seen last until the rounds come near.
constexpr float kStale = 0.5F;
/// Heights from here on count as one when vertices are picked.
constexpr std::uint32_t kHighest = (1U << 24U) - 1;
/// So much counts of the root of the mean square that the quadrics see. They take the error at the vertex for that of
/// all its tets, which is 2.2 times the root of the integral as a rule, and in places many times that. What the removed
/// vertices say themselves is nearer to it, but collapses that go by nothing else than the errors there leave 1.7 times
/// the maximum in between.
constexpr double kOfQuadrics = 0.3;
/// Where costs are measured, predictions are what they are at least: so much of the growth of the integral that the
/// removed vertices see. Where one vertex goes from a mesh as it was, the integral is .4 of that, later .7 as a rule,
/// and less than .25 in one of twenty collapses. A larger part hides collapses that cost little (.6: one mean square in
/// thirty), a smaller one has more of them measured.
constexpr double kOfVerticesAtLeast = 0.3;
/// And so much of the domain error that the quadrics see.
constexpr double kOfPlanesAtLeast = 0.5;
/// So much is predicted before who waits is asked whether to go on: some tenths of a second of work.
constexpr std::size_t kGrainsBetweenLooks = 256;

} // namespace

Candidates::Candidates(const WorkingComplex& complex, const WorkingSurface& surface, const Predictor& predictor,
                       const QuadricPredictor* quadrics, const CollapseCost& cost, Prediction prediction,
                       double round_fraction, std::function<Trial()> new_trial, const std::vector<char>& frozen)
    : complex_(complex), surface_(surface), predictor_(predictor), quadrics_(quadrics), cost_(cost),
      prediction_(prediction), round_fraction_(round_fraction), pages_(complex.vertex_count()),
      dirty_(complex.vertex_count(), 1),
      workers_([&complex, new_trial = std::move(new_trial)] { return Worker(new_trial(), complex.vertex_count()); }) {
  for (Vertex v = 0; v < complex.vertex_count(); ++v)
    if (!frozen[v]) movable_.push_back(v);
}

/// The vertices that `v` may be unified with; raises its height to what is found.
void Candidates::find_targets(Vertex v, Worker& worker) {
  worker.targets.clear();
  worker.seen.clear();
  worker.seen.add(v);
  const bool boundary = surface_.contains(v);
  // Never lowered, so that it is the same whether a page is filled anew or mended.
  std::uint32_t& height = pages_[v].height;
  for (const SlotId s : complex_.star(v)) {
    const Slot& slot = complex_.slot(s);
    height = std::max(height, slot.height);
    // A boundary vertex may only move along the boundary: its targets stand in its ghosts.
    if (boundary && !complex_.is_ghost(slot)) continue;
    for (const Vertex x : slot.v) {
      if (x != complex_.dummy() && worker.seen.add(x)) worker.targets.push_back(x);
    }
  }
}

void Candidates::fill_page(Vertex v, Worker& worker) {
  Page& page = pages_[v];
  if (complex_.star(v).size() > CollapseCheck::kMaxRemovedStar) { // whatever its target
    ++worker.refusals[static_cast<std::size_t>(CollapseStatus::kRemovedStarTooLarge)];
    page.best.fill({});
    page.next = 0;
    return;
  }
  find_targets(v, worker);
  worker.costs.resize(worker.targets.size());
  predictor_.costs(v, worker.targets, worker.costs);
  auto& half_edges = worker.half_edges;
  half_edges.clear();
  for (std::size_t i = 0; i < worker.targets.size(); ++i)
    half_edges.push_back({worker.costs[i], worker.targets[i]});
  if (simulates()) simulate(v, worker);
  // What the simulation left is what goes on the page, best first.
  if (prediction_ != Prediction::kExact) std::erase_if(half_edges, [&](const HalfEdge& h) { return h <= page.floor; });
  const std::size_t count = std::min(kPage, half_edges.size());
  std::partial_sort(half_edges.begin(), half_edges.begin() + static_cast<std::ptrdiff_t>(count), half_edges.end());
  std::copy_n(half_edges.begin(), count, page.best.begin());
  std::fill(page.best.begin() + static_cast<std::ptrdiff_t>(count), page.best.end(), HalfEdge{});
  page.next = 0;
  if (prediction_ != Prediction::kExact && count > 0) page.floor = page.best[count - 1];
}

/// Takes from the page of `v` what is gone and puts on it what is new; everything on it may be tried again. False when
/// it must be filled.
bool Candidates::mend_page(Vertex v) {
  Page& page = pages_[v];
  if (!page.whole) return false;
  const auto gone = std::remove_if(page.best.begin(), page.best.end(),
                                   [&](const HalfEdge& h) { return h.target == kNone || !complex_.alive(h.target); });
  auto count = static_cast<std::size_t>(gone - page.best.begin());
  std::fill(gone, page.best.end(), HalfEdge{});
  for (std::uint32_t n = page.news; n != kNone; n = news_[n].next) {
    const HalfEdge joined{quadrics_->cost(v, news_[n].target), news_[n].target};
    if (joined > page.floor) continue;
    const bool full = count == kPage;
    if (full && joined > page.best.back()) {
      page.floor = page.best.back();
      continue;
    }
    const auto end = page.best.begin() + static_cast<std::ptrdiff_t>(full ? kPage - 1 : count++);
    const auto place = std::upper_bound(page.best.begin(), end, joined);
    std::copy_backward(place, end, end + 1);
    *place = joined;
    if (full) page.floor = page.best.back();
  }
  page.news = kNone;
  page.next = 0;
  return count > 0;
}

void Candidates::change_star(const LinkVertex& v, Vertex vd, std::uint32_t height) {
  Page& page = pages_[v.vertex];
  dirty_[v.vertex] = 1;
  page.height = std::max(page.height, height);
  page.whole &= costs_last();
  if (!page.whole || !(v.joins || v.joins_on_boundary)) return;
  if (!(surface_.contains(v.vertex) ? v.joins_on_boundary : v.joins)) return;
  news_.push_back({vd, page.news});
  page.news = static_cast<std::uint32_t>(news_.size() - 1);
}

/// Replaces predicted by simulated costs: of every half-edge, or of the best ones beyond the floor, enough for a page.
/// Those that are not allowed go.
void Candidates::simulate(Vertex v, Worker& worker) {
  auto& half_edges = worker.half_edges;
  const bool shortlist = prediction_ == Prediction::kExact;
  Page& page = pages_[v];
  if (shortlist) {
    std::erase_if(half_edges, [&](const HalfEdge& h) { return h <= page.floor; });
    std::sort(half_edges.begin(), half_edges.end());
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < half_edges.size() && !(shortlist && kept == kShortlist); ++i) {
    const HalfEdge half_edge = half_edges[i];
    if (shortlist) page.floor = half_edge;
    const CollapseStatus status = worker.trial.examine(v, half_edge.target);
    if (status != CollapseStatus::kAccepted) {
      ++worker.refusals[static_cast<std::size_t>(status)];
      continue;
    }
    ++worker.simulations;
    half_edges[kept++] = {simulated_cost(v, half_edge.target, worker.trial, worker.growth), half_edge.target};
  }
  half_edges.resize(kept);
}

float Candidates::simulated_cost(Vertex v, Vertex target, Trial& trial, std::vector<double>& growth) const {
  const RemovedVertices::Simulation& seen = trial.simulate();
  const double maximum = cost_.of_maximum(seen.errors());
  const bool is_measured = prediction_ == Prediction::kExact;
  double part = 1;
  if (is_measured) {
    growth.assign(seen.squared_growth().begin(), seen.squared_growth().end());
    part = kOfVerticesAtLeast;
  } else {
    growth.resize(cost_.field_weight().size());
    quadrics_->squared_growth(v, target, growth);
    part = kOfQuadrics * kOfQuadrics;
  }
  for (double& squared : growth)
    squared *= part;
  const double field = cost_.of_field(maximum, cost_.of_mean(growth));
  const double domain = (is_measured ? kOfPlanesAtLeast : 1.0) * quadrics_->domain_cost(v, target);
  return static_cast<float>(std::max(field, domain) + quadrics_->length_cost(v, target));
}

void Candidates::predict(std::uint32_t round, const std::function<void()>& look) {
  std::erase_if(movable_, [&](Vertex v) { return !complex_.alive(v); });
  work_.clear();
  // Where the star has changed since, the page is brought up to date first.
  std::erase_if(used_up_, [&](Vertex v) { return dirty_[v] != 0 || !complex_.alive(v); });
  const auto is_far = [&](Vertex v) {
    return simulates() && best(v).target != kNone && kStale * best(v).cost > round_cost_;
  };
  for (const Vertex v : movable_)
    if (dirty_[v] && pages_[v].resume_round <= round && !is_far(v)) {
      dirty_[v] = 0;
      work_.push_back(v);
    }
  const std::size_t fresh = work_.size();
  work_.insert(work_.end(), used_up_.begin(), used_up_.end());
  used_up_.clear();
  const std::size_t grain = simulates() ? 16 : 256;
  const std::size_t batch = grain * kGrainsBetweenLooks;
  for (std::size_t begin = 0; begin < work_.size(); begin += batch) {
    if (begin > 0 && look) look();
    const oneapi::tbb::blocked_range<std::size_t> part(begin, std::min(begin + batch, work_.size()), grain);
    oneapi::tbb::parallel_for(part, [&](const auto& range) {
      Worker& worker = workers_.local();
      for (std::size_t i = range.begin(); i != range.end(); ++i) {
        const std::size_t ahead = i + WorkingComplex::kPrefetch;
        if (ahead < range.end() && !pages_[work_[ahead]].whole) complex_.prefetch_star(work_[ahead]);
        const Vertex v = work_[i];
        if (i < fresh) {
          if (mend_page(v)) continue;
          Page& page = pages_[v];
          page.floor = kLowest;
          page.news = kNone;
          page.whole = true;
          fill_page(v, worker);
        } else {
          turn_page(v, worker, round);
        }
      }
    });
  }
  news_.clear();
}

std::vector<Vertex> Candidates::pick() {
  // Costs are not negative: their bits are in the same order as they.
  keys_.clear();
  for (const Vertex v : movable_)
    if (best(v).target != kNone) keys_.push_back(std::uint64_t{std::bit_cast<std::uint32_t>(best(v).cost)} << 32U | v);
  if (keys_.empty()) return {};
  const auto count = std::clamp<std::size_t>(
      static_cast<std::size_t>(std::ceil(round_fraction_ * static_cast<double>(keys_.size()))), 1, keys_.size());
  std::nth_element(keys_.begin(), keys_.begin() + static_cast<std::ptrdiff_t>(count - 1), keys_.end());
  keys_.resize(count);
  round_cost_ = best(static_cast<Vertex>(keys_.back())).cost;
  std::erase_if(keys_,
                [&](std::uint64_t key) { return dirty_[static_cast<Vertex>(key)] != 0; }); // to be looked at first
  // Within an octave of cost along the curve of the numbering: what is near in space is near in memory.
  for (std::uint64_t& key : keys_) {
    const std::uint64_t height = std::min(pages_[static_cast<Vertex>(key)].height, kHighest);
    key = height << 40U | key >> 55U << 32U | static_cast<Vertex>(key);
  }
  std::sort(keys_.begin(), keys_.end());
  return {keys_.begin(), keys_.end()};
}

void Candidates::drop_best(Vertex v, std::uint32_t round) {
  Page& page = pages_[v];
  if (page.next + 1 < kPage && page.best[page.next + 1].target != kNone) {
    ++page.next;
    return;
  }
  page.best[page.next] = {};
  if (prediction_ == Prediction::kExact) { // costs are simulated: with those of the next round, in parallel
    used_up_.push_back(v);
    return;
  }
  turn_page(v, workers_.local(), round);
}

/// The next page of `v`, or a pause.
void Candidates::turn_page(Vertex v, Worker& worker, std::uint32_t round) {
  Page& page = pages_[v];
  page.whole = false;
  fill_page(v, worker);
  // A vertex that nothing can be done with is likely to stay so: wait longer each time.
  if (page.best[0].target == kNone) page.resume_round = round + (1U << std::min(page.failures++, kLongestWait));
}

void Candidates::raise_best(Vertex v, float cost) {
  Page& page = pages_[v];
  const auto next = page.best.begin() + page.next;
  next->cost = std::max(next->cost, cost);
  std::sort(next, page.best.end());
}

void Candidates::forget_all() {
  round_cost_ = std::numeric_limits<float>::infinity();
  for (const Vertex v : movable_) {
    forget(v);
    pages_[v].resume_round = 0;
  }
}

StatusCounts Candidates::refusals() const {
  StatusCounts sum{};
  for (const Worker& worker : workers_)
    for (std::size_t i = 0; i < sum.size(); ++i)
      sum[i] += worker.refusals[i];
  return sum;
}

std::uint64_t Candidates::simulations() const {
  std::uint64_t sum = 0;
  for (const Worker& worker : workers_)
    sum += worker.simulations;
  return sum;
}

} // namespace ptet::build
