#include "support/brute_force.hpp"

#include "support/mesh_checks.hpp"
#include "support/replay.hpp"
#include "support/versions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

namespace ptet::test {
namespace {

using Vector = std::array<double, 3>;

Vector from_to(const Point& a, const Point& b) {
  return {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
}
double dot(const Vector& a, const Vector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double determinant(const Point& a, const Point& b, const Point& c, const Point& d) {
  return dot(from_to(a, b), cross(from_to(a, c), from_to(a, d)));
}

} // namespace

CutMesh cut_mesh(const RecordStream& stream, const std::vector<char>& is_split) {
  std::vector<Tet> tets = stream.original();
  std::vector<std::size_t> maker(tets.size(), CutMesh::kOriginal);
  std::vector<char> is_there(tets.size(), 1);
  CutMesh cut;
  for (std::size_t i = 0; i < stream.size(); ++i) {
    if (is_split[i]) continue;
    cut.removed.push_back(stream.removed[i]);
    for (std::size_t k = 0; k < stream.star(i).size(); ++k) {
      const std::uint32_t slot = stream.star(i)[k];
      if (k >= stream.modified_count[i]) {
        is_there[slot] = 0;
        continue;
      }
      std::replace(tets[slot].begin(), tets[slot].end(), stream.removed[i], stream.target[i]);
      maker[slot] = i;
    }
  }
  for (std::size_t slot = 0; slot < is_there.size(); ++slot) {
    if (!is_there[slot]) continue;
    const bool is_ghost = std::find(tets[slot].begin(), tets[slot].end(), kDummyVertex) != tets[slot].end();
    (is_ghost ? cut.ghosts : cut.tets).push_back(tets[slot]);
    (is_ghost ? cut.ghost_maker : cut.tet_maker).push_back(maker[slot]);
  }
  return cut;
}

std::vector<char> after_collapses(const RecordStream& stream, std::size_t count) {
  std::vector<char> is_split(stream.size(), 1);
  std::fill_n(is_split.begin(), count, 0);
  return is_split;
}

void close_cut(const RecordStream& stream, std::vector<char>& is_split) {
  // Who takes a slot next comes later in the stream, so one pass is enough.
  std::vector<char> next_must(stream.slot_count());
  for (std::size_t i = 0; i < stream.size(); ++i) {
    for (const std::uint32_t slot : stream.star(i))
      if (next_must[slot]) is_split[i] = 1;
    for (const std::uint32_t slot : stream.star(i))
      next_must[slot] = is_split[i];
    if (!is_split[i]) continue;
    for (const std::uint32_t next : stream.others_needed(i))
      is_split[next] = 1;
  }
}

double largest_domain_error(const RecordStream& stream, const CutMesh& cut) {
  double largest = 0;
  for (const std::size_t i : cut.ghost_maker)
    if (i != CutMesh::kOriginal) largest = std::max<double>(largest, stream.domain_error[i]);
  return largest;
}

std::optional<std::array<double, 4>> barycentrics(const Point& p, const std::array<Point, 4>& tet) {
  const double whole = determinant(tet[0], tet[1], tet[2], tet[3]);
  if (whole == 0) return std::nullopt;
  std::array<double, 4> weight{};
  for (std::size_t i = 0; i < 4; ++i) {
    std::array<Point, 4> part = tet;
    part[i] = p;
    weight[i] = determinant(part[0], part[1], part[2], part[3]) / whole;
  }
  return weight;
}

Nearest nearest_on_triangle(const Point& p, const std::array<Point, 3>& triangle) {
  Nearest best{std::numeric_limits<double>::infinity(), {}};
  const auto offer = [&](const std::array<double, 3>& weight) {
    Vector away{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      away[axis] =
          p[axis] - weight[0] * triangle[0][axis] - weight[1] * triangle[1][axis] - weight[2] * triangle[2][axis];
    const double distance = std::sqrt(dot(away, away));
    if (distance < best.distance) best = {distance, weight};
  };
  const Vector normal = cross(from_to(triangle[0], triangle[1]), from_to(triangle[0], triangle[2]));
  if (const double area_sq = dot(normal, normal); area_sq > 0) {
    std::array<double, 3> weight{};
    for (std::size_t i = 0; i < 3; ++i)
      weight[i] = dot(normal, cross(from_to(p, triangle[(i + 1) % 3]), from_to(p, triangle[(i + 2) % 3]))) / area_sq;
    if (*std::min_element(weight.begin(), weight.end()) >= 0) offer(weight);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const Vector side = from_to(triangle[i], triangle[j]);
    const double length_sq = dot(side, side);
    const double t = length_sq > 0 ? std::clamp(dot(side, from_to(triangle[i], p)) / length_sq, 0.0, 1.0) : 0;
    std::array<double, 3> weight{};
    weight[i] = 1 - t;
    weight[j] = t;
    offer(weight);
  }
  return best;
}

NearestOnTet nearest_on_tet(const Point& p, const std::array<Point, 4>& tet) {
  if (const auto weight = barycentrics(p, tet); weight && *std::min_element(weight->begin(), weight->end()) >= 0)
    return {0, *weight};
  NearestOnTet best{std::numeric_limits<double>::infinity(), {}};
  for (std::size_t apex = 0; apex < 4; ++apex) {
    const std::array<std::size_t, 3> face = {(apex + 1) % 4, (apex + 2) % 4, (apex + 3) % 4};
    const Nearest here = nearest_on_triangle(p, {tet[face[0]], tet[face[1]], tet[face[2]]});
    if (here.distance >= best.distance) continue;
    best = {here.distance, {}};
    for (std::size_t i = 0; i < 3; ++i)
      best.weight[face[i]] = here.weight[i];
  }
  return best;
}

std::vector<std::size_t> makers(const RecordStream& stream) {
  const Versions all(stream);
  std::vector<std::size_t> maker(all.tets.size(), CutMesh::kOriginal);
  for (std::size_t i = 0; i < stream.size(); ++i)
    std::fill_n(maker.begin() + all.coarse_begin[i].index(), stream.modified_count[i], i);
  return maker;
}

std::vector<std::vector<VersionId>> possible_holders(const RecordStream& stream, const std::vector<Point>& points,
                                                     const std::vector<char>& is_split,
                                                     const std::vector<VertexId>& vertices) {
  const Versions all(stream);
  std::map<VertexId, std::set<VersionId>> holders; // of the vertices that are followed and gone
  std::map<VersionId, std::set<VertexId>> held;
  const std::set<VertexId> followed(vertices.begin(), vertices.end());
  for (std::size_t i = 0; i < stream.size(); ++i) {
    if (is_split[i]) continue;
    std::set<VertexId> homeless;
    if (followed.count(stream.removed[i]) != 0) homeless.insert(stream.removed[i]);
    for (const VersionId t : all.consumed(i)) {
      const auto found = held.find(t);
      if (found == held.end()) continue;
      for (const VertexId v : found->second)
        holders[v].erase(t);
      homeless.merge(found->second);
      held.erase(found);
    }
    if (homeless.empty()) continue;
    for (const VertexId v : homeless) {
      std::vector<std::pair<double, VersionId>> offers;
      double nearest = std::numeric_limits<double>::infinity();
      for (std::uint32_t m = 0; m < stream.modified_count[i]; ++m) {
        const VersionId t{all.coarse_begin[i].index() + m};
        const Tet& tet = all.tets[t.index()];
        if (std::find(tet.begin(), tet.end(), kDummyVertex) != tet.end()) continue;
        const std::array<Point, 4> corners = {points[tet[0].index()], points[tet[1].index()], points[tet[2].index()],
                                              points[tet[3].index()]};
        const auto weight = barycentrics(points[v.index()], corners);
        const bool touches = weight && *std::min_element(weight->begin(), weight->end()) >= kTouching;
        offers.emplace_back(touches ? 0 : nearest_on_tet(points[v.index()], corners).distance, t);
        nearest = std::min(nearest, offers.back().first);
      }
      for (const auto& [distance, t] : offers)
        if (distance <= nearest * (1 + 1e-9) + 1e-11 * stream.diagonal) {
          holders[v].insert(t);
          held[t].insert(v);
        }
    }
  }
  std::vector<std::vector<VersionId>> result;
  result.reserve(vertices.size());
  for (const VertexId v : vertices)
    result.emplace_back(holders[v].begin(), holders[v].end());
  return result;
}

double interpolation_error(const PointArray& field, VertexId v, const Tet& corner,
                           const std::array<double, 4>& weight) {
  double sum_sq = 0;
  for (std::uint32_t c = 0; c < field.components; ++c) {
    double difference = field.value(v.index(), c);
    for (std::size_t i = 0; i < 4; ++i)
      difference -= weight[i] * field.value(corner[i].index(), c);
    sum_sq += difference * difference;
  }
  return std::sqrt(sum_sq);
}

OverlapIntegrals integrals_over_overlap(const std::vector<Point>& points, const PointArray& field, const Tet& original,
                                        const Tet& version) {
  using Corners = std::array<Point, 4>;
  using Polygon = std::vector<Point>;
  const auto at = [&](const Tet& tet) {
    return Corners{points[tet[0].index()], points[tet[1].index()], points[tet[2].index()], points[tet[3].index()]};
  };
  const std::array<Corners, 2> tets = {at(original), at(version)};
  const auto face = [](const Corners& tet, std::size_t apex) {
    return Polygon{tet[(apex + 1) % 4], tet[(apex + 2) % 4], tet[(apex + 3) % 4]};
  };
  const auto is_coplanar = [](const Polygon& a, const Polygon& b) {
    return std::all_of(b.begin(), b.end(), [&](const Point& p) { return orientation(a[0], a[1], a[2], p) == 0; });
  };

  std::vector<Polygon> polygons;
  for (const std::size_t mine : {0U, 1U})
    for (std::size_t apex = 0; apex < 4; ++apex) {
      const Corners& other = tets[1 - mine];
      Polygon polygon = face(tets[mine], apex);
      bool is_repeated = false; // where a face lies on one of the other tet, that of the original counts
      for (std::size_t k = 0; k < 4; ++k) {
        const Polygon plane = face(other, k);
        if (is_coplanar(plane, face(tets[mine], apex))) {
          is_repeated |= mine == 1;
          continue;
        }
        const double side = determinant(plane[0], plane[1], plane[2], other[k]);
        const auto height = [&](const Point& p) { return determinant(plane[0], plane[1], plane[2], p) / side; };
        Polygon inside;
        for (std::size_t i = 0; i < polygon.size(); ++i) {
          const Point& a = polygon[i];
          const Point& b = polygon[(i + 1) % polygon.size()];
          const double above_a = height(a);
          const double above_b = height(b);
          if (above_a >= 0) inside.push_back(a);
          if ((above_a >= 0) == (above_b >= 0)) continue;
          const double s = above_a / (above_a - above_b);
          inside.push_back({a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1]), a[2] + s * (b[2] - a[2])});
        }
        polygon.swap(inside);
      }
      if (!is_repeated && !polygon.empty()) polygons.push_back(std::move(polygon));
    }

  OverlapIntegrals found{std::vector<double>(field.components, 0)};
  Point centre{};
  std::size_t count = 0;
  for (const Polygon& polygon : polygons)
    for (const Point& p : polygon) {
      for (std::size_t axis = 0; axis < 3; ++axis)
        centre[axis] += p[axis];
      ++count;
    }
  for (double& x : centre)
    x /= static_cast<double>(std::max<std::size_t>(count, 1));
  const auto difference = [&](const Point& p, std::uint32_t component) {
    const auto fine = barycentrics(p, tets[0]);
    const auto coarse = barycentrics(p, tets[1]);
    double d = 0;
    for (std::size_t i = 0; i < 4; ++i)
      d += fine->at(i) * field.value(original[i].index(), component) -
           coarse->at(i) * field.value(version[i].index(), component);
    return d;
  };
  for (const Polygon& polygon : polygons)
    for (std::size_t i = 2; i < polygon.size(); ++i) {
      const Corners cone = {centre, polygon[0], polygon[i - 1], polygon[i]};
      const double volume = std::abs(determinant(cone[0], cone[1], cone[2], cone[3])) / 6;
      found.volume += volume;
      for (std::uint32_t c = 0; c < field.components; ++c) {
        double sum = 0;
        double sum_sq = 0;
        for (const Point& p : cone) {
          const double d = difference(p, c);
          sum += d;
          sum_sq += d * d;
        }
        found.squared[c] += volume / 20 * (sum * sum + sum_sq);
      }
    }
  return found;
}

std::vector<std::size_t> places_in_budgets(const RecordStream& stream) {
  const std::size_t n = stream.size(), fields = stream.fields.size();
  const auto parents = parents_in_stream(stream);
  const auto needs = [&](std::size_t r) {
    std::vector<std::size_t> all(stream.others_needed(r).begin(), stream.others_needed(r).end());
    for (const RecordId parent : parents[n - 1 - r])
      all.push_back(n - 1 - parent.index());
    return all;
  };
  // `key` of any that depends on a record is at most its own.
  const auto raise = [&](std::vector<double>& key) {
    for (bool changed = true; std::exchange(changed, false);)
      for (std::size_t r = 0; r < n; ++r)
        for (const std::size_t parent : needs(r))
          if (key[parent] < key[r]) {
            key[parent] = key[r];
            changed = true;
          }
  };
  const auto places_by = [&](const std::vector<double>& key) {
    std::vector<std::size_t> place(n, 0);
    for (std::size_t r = 0; r < n; ++r)
      for (std::size_t other = 0; other < n; ++other)
        place[r] += key[other] > key[r] || (key[other] == key[r] && other > r) ? 1 : 0;
    return place;
  };
  std::vector<double> by_collapse(n), by_maximum(n, 0), by_mean(n, 0);
  std::vector<double> changed(fields, 0);
  for (std::size_t r = 0; r < n; ++r)
    for (std::size_t f = 0; f < fields && stream.budget.mean; ++f)
      changed[f] += std::abs(stream.squared_error[r * fields + f]);
  for (std::size_t r = 0; r < n; ++r) {
    by_collapse[r] = static_cast<double>(r);
    by_maximum[r] = stream.budget.domain * stream.domain_error[r];
    for (std::size_t f = 0; f < fields; ++f) {
      if (!stream.budget.maximum.empty())
        by_maximum[r] = std::max(by_maximum[r], stream.budget.maximum[f] * stream.largest_error(r, f));
      if (stream.budget.mean && changed[f] > 0)
        by_mean[r] = std::max(by_mean[r], stream.squared_error[r * fields + f] / changed[f]);
    }
  }
  std::vector<std::size_t> best = places_by(by_collapse);
  for (std::size_t& place : best)
    place *= 10;
  const auto take_less = [&](std::vector<double>& key) {
    raise(key);
    const std::vector<std::size_t> place = places_by(key);
    for (std::size_t r = 0; r < n; ++r)
      best[r] = std::min(best[r], (stream.budget.mean && !stream.budget.maximum.empty() ? 11 : 5) * place[r]);
  };
  if (!stream.budget.maximum.empty()) take_less(by_maximum);
  if (stream.budget.mean) take_less(by_mean);
  std::vector<double> least_first(n);
  for (std::size_t r = 0; r < n; ++r)
    least_first[r] = -static_cast<double>(best[r]);
  return places_by(least_first);
}

} // namespace ptet::test
