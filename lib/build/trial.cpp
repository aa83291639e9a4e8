#include "build/trial.hpp"

#include "build/certify.hpp"

#include <algorithm>
#include <functional>
#include <span>
#include <tuple>

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

/// The modified tets: first those in which the largest errors were seen.
void Trial::order_slots() {
  order_.clear();
  for (std::size_t i = 0; i < check_.modified().size(); ++i)
    if (const SlotId s = check_.modified()[i]; !complex_.is_ghost(complex_.slot(s)))
      order_.push_back({simulation_.error_in(s), i});
  std::sort(order_.begin(), order_.end(),
            [](const Next& a, const Next& b) { return std::tie(b.worst, a.index) < std::tie(a.worst, b.index); });
}

/// Drops what is known of versions that cannot be made any more.
void Trial::forget_gone() {
  const auto star = complex_.star(check_.plan().vs);
  const std::size_t width = known_->keys.empty() ? 0 : known_->values.size() / known_->keys.size();
  std::size_t kept = 0;
  for (std::size_t i = 0; i < known_->keys.size(); ++i) {
    const KnownVersions::Key key = known_->keys[i];
    if (std::none_of(star.begin(), star.end(), [&](SlotId s) { return complex_.slot(s).version == key.fine; }))
      continue;
    std::copy_n(&known_->values[i * width], width, &known_->values[kept * width]);
    known_->keys[kept++] = key;
  }
  known_->keys.resize(kept);
  known_->values.resize(kept * width);
}

/// Index of what is known of the version that comes from `fine`; that of the end if nothing is.
std::size_t Trial::find_known(std::uint32_t fine) const {
  const auto found = std::find_if(known_->keys.begin(), known_->keys.end(), [&](const KnownVersions::Key& key) {
    return key.fine == fine && key.target == check_.plan().vd;
  });
  return static_cast<std::size_t>(found - known_->keys.begin());
}

bool Trial::measure_slot(SlotId slot, std::vector<double>& errors, double* squared, const std::vector<double>& limit) {
  const std::size_t fields = errors.size();
  const std::size_t width = fields + 1;
  const Slot& fine = complex_.slot(slot);
  const auto take_in = [&](bool whole) {
    for (std::size_t f = 0; f < fields; ++f) {
      errors[f] = std::max(errors[f], certified(measured_[f]));
      if (errors[f] > limit[f]) whole = false;
    }
    return whole;
  };
  std::size_t at = 0;
  if (known_ != nullptr) {
    at = find_known(fine.version);
    if (at < known_->keys.size()) {
      const double* const values = &known_->values[(fields + width) * at];
      measured_.assign(values, values + fields);
      // Beyond a limit a measurement ends with what it has seen by then, which is not known.
      if (std::equal(measured_.begin(), measured_.end(), limit.begin(), std::less_equal<>())) {
        std::copy_n(values + fields, width, squared);
        return take_in(true);
      }
    }
  }
  Tet version;
  for (std::size_t i = 0; i < 4; ++i)
    version[i] = VertexId{fine.v[i] == check_.plan().vs ? check_.plan().vd : fine.v[i]};
  measured_.assign(fields, 0.0);
  integrals_.assign(squared != nullptr ? width : 0, 0.0);
  const bool whole = exact_->measure(version, *workspace_, measured_, integrals_, limit);
  if (whole) std::copy(integrals_.begin(), integrals_.end(), squared);
  if (known_ != nullptr && known_->takes_more && whole && at == known_->keys.size()) {
    known_->keys.push_back({fine.version, check_.plan().vd});
    known_->values.insert(known_->values.end(), measured_.begin(), measured_.end());
    known_->values.insert(known_->values.end(), squared, squared + width);
  }
  return take_in(whole);
}

} // namespace ptet::build
