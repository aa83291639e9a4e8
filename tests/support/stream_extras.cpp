#include "support/stream_extras.hpp"

#include <cmath>
#include <random>
#include <set>

namespace ptet::test {

void add_random_dependencies(RecordStream& stream, unsigned seed, unsigned one_in) {
  std::mt19937 random(seed);
  const auto count = static_cast<std::uint32_t>(stream.size());
  stream.also_needs_begin = {0};
  stream.also_needs.clear();
  for (std::uint32_t i = 0; i < count; ++i) {
    std::set<std::uint32_t> needed;
    if (i + 1 < count && random() % one_in == 0)
      for (unsigned k = 1 + random() % 3; k > 0; --k)
        needed.insert(i + 1 + static_cast<std::uint32_t>(random() % (count - i - 1)));
    stream.also_needs.insert(stream.also_needs.end(), needed.begin(), needed.end());
    stream.also_needs_begin.push_back(stream.also_needs.size());
  }
}

void add_random_squared_errors(RecordStream& stream, unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&] { return static_cast<double>(random() % 1000001) / 1e6; };
  if (!(stream.volume > 0)) stream.volume = 1 + 10 * uniform();
  stream.squared_error.clear();
  stream.uncovered_volume.clear();
  for (std::size_t i = 0; i < stream.field_error.size(); ++i) {
    const double range = stream.fields[i % stream.fields.size()].range;
    double value = stream.field_error[i] * stream.field_error[i] * stream.volume * std::exp2(-3 - 10 * uniform());
    if (random() % 8 == 0) value = -value / 2;
    if (random() % 50 == 0) value = 0;
    if (random() % 50 == 0) value = range * range * stream.volume * std::exp2(20 - 100 * uniform());
    stream.squared_error.push_back(range > 0 ? value : 0);
  }
  for (const double error : stream.domain_error) {
    double part = std::exp2(-3 - 30 * uniform());
    if (random() % 3 == 0) part = -part / 2;
    if (random() % 50 == 0) part = std::exp2(20 - 60 * uniform());
    stream.uncovered_volume.push_back(error > 0 && random() % 20 != 0 ? part * stream.volume : 0);
  }
}

void add_budget_weights(RecordStream& stream) {
  stream.budget.mean = true;
  stream.budget.domain = 1 / stream.diagonal;
  stream.budget.maximum.clear();
  for (const GoverningField& field : stream.fields)
    stream.budget.maximum.push_back(1 / field.scale());
}

} // namespace ptet::test
