#include "build/trial.hpp"

#include "build/certify.hpp"

#include <algorithm>
#include <span>

namespace ptet::build {

Trial::Trial(const WorkingComplex& complex, const std::vector<Point>& positions, const RemovedVertices& removed,
             const ExactFieldError* exact, double min_quality, std::uint32_t max_star)
    : complex_(complex), removed_(removed), exact_(exact), check_(complex, positions, min_quality, max_star) {
  if (exact != nullptr) workspace_.emplace(*exact);
}

const RemovedVertices::Simulation& Trial::simulate() {
  removed_.simulate(complex_, check_.plan().vs, check_.plan().vd, check_.deleted(), check_.modified(),
                    check_.moves_boundary(), simulation_);
  return simulation_;
}

bool Trial::measure_slot(SlotId slot, std::vector<double>& errors, std::vector<double>* integrals,
                         const std::vector<double>& limit) {
  squared_.assign(errors.size(), 0.0);
  bool whole = true;
  if (!complex_.is_ghost(complex_.slot(slot))) {
    Tet version;
    for (std::size_t i = 0; i < 4; ++i) {
      const Vertex x = complex_.slot(slot).v[i];
      version[i] = VertexId{x == check_.plan().vs ? check_.plan().vd : x};
    }
    measured_ = errors;
    const std::span<double> squared = integrals != nullptr ? std::span<double>(squared_) : std::span<double>();
    walk_limit_ = limit;
    for (double& most : walk_limit_)
      most = std::max(most, kRoundingSlack); // what is below counts as none
    whole = exact_->measure(version, *workspace_, measured_, squared, walk_limit_);
    for (std::size_t f = 0; f < errors.size(); ++f) {
      if (measured_[f] > errors[f]) errors[f] = certified(measured_[f]);
      if (errors[f] > limit[f]) whole = false;
      if (errors[f] == 0) squared_[f] = 0; // where there is no error the integral is rounding
    }
  }
  if (integrals != nullptr) integrals->insert(integrals->end(), squared_.begin(), squared_.end());
  return whole;
}

} // namespace ptet::build
