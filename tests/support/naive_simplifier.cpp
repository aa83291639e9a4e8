#include "support/naive_simplifier.hpp"

#include "support/mesh_checks.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <set>

namespace ptet::test {
namespace {

using Simplex = std::set<VertexId>;

Point minus(const Point& a, const Point& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
double dot(const Point& a, const Point& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
double length(const Point& a) {
  return std::sqrt(dot(a, a));
}

double six_volumes(const Point& a, const Point& b, const Point& c, const Point& d) {
  const Point x = minus(b, a), y = minus(c, a), z = minus(d, a);
  return x[0] * (y[1] * z[2] - y[2] * z[1]) - x[1] * (y[0] * z[2] - y[2] * z[0]) + x[2] * (y[0] * z[1] - y[1] * z[0]);
}

Point closest_on_segment(const Point& p, const Point& a, const Point& b) {
  const Point ab = minus(b, a);
  const double t = std::clamp(dot(minus(p, a), ab) / dot(ab, ab), 0.0, 1.0);
  return {a[0] + t * ab[0], a[1] + t * ab[1], a[2] + t * ab[2]};
}

double distance_to_triangle(const Point& p, const Point& a, const Point& b, const Point& c) {
  double least = length(minus(p, closest_on_segment(p, a, b)));
  least = std::min(least, length(minus(p, closest_on_segment(p, b, c))));
  least = std::min(least, length(minus(p, closest_on_segment(p, c, a))));
  // The foot of the perpendicular counts when it lies inside: solve for its two coordinates in the plane.
  const Point u = minus(b, a), v = minus(c, a), w = minus(p, a);
  const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), wu = dot(w, u), wv = dot(w, v);
  const double d = uu * vv - uv * uv;
  if (d > 0) {
    const double s = (vv * wu - uv * wv) / d, t = (uu * wv - uv * wu) / d;
    if (s >= 0 && t >= 0 && s + t <= 1) {
      const Point foot = {a[0] + s * u[0] + t * v[0], a[1] + s * u[1] + t * v[1], a[2] + s * u[2] + t * v[2]};
      least = std::min(least, length(minus(p, foot)));
    }
  }
  return least;
}

class Simplifier {
public:
  Simplifier(const TetMesh& mesh, const NaiveOptions& options) : mesh_(mesh), options_(options), random_(options.seed) {
    versions_ = mesh.tets;
    stream_.original_tet_count = static_cast<std::uint32_t>(mesh.tets.size());
    for (const Face& face : examine(mesh).boundary)
      versions_.push_back({face[0], face[1], face[2], kDummyVertex});
    stream_.original_ghost_count = static_cast<std::uint32_t>(versions_.size() - mesh.tets.size());
    stream_.slots = versions_;
    slot_of_.resize(versions_.size());
    std::iota(slot_of_.begin(), slot_of_.end(), 0U);
    for (std::uint32_t t = 0; t < versions_.size(); ++t)
      put(t, -1);
    for (const Tet& tet : mesh.tets)
      vertices_.insert(tet.begin(), tet.end());
    measure_scales();
  }

  RecordStream run() {
    for (int round = 0; vertices_.size() > options_.target_vertices; ++round)
      if (!run_round(round)) break;
    return std::move(stream_);
  }

private:
  void measure_scales() {
    Point low{INFINITY, INFINITY, INFINITY}, high{-INFINITY, -INFINITY, -INFINITY};
    for (const VertexId v : vertices_)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], mesh_.position(v)[axis]);
        high[axis] = std::max(high[axis], mesh_.position(v)[axis]);
      }
    stream_.diagonal = length(minus(high, low));
    for (std::uint32_t a = 0; a < mesh_.point_arrays.size(); ++a) {
      const PointArray& array = mesh_.point_arrays[a];
      if (array.type != ScalarType::kFloat32 && array.type != ScalarType::kFloat64) continue;
      double range_sq = 0;
      for (std::uint32_t c = 0; c < array.components; ++c) {
        double least = INFINITY, most = -INFINITY;
        for (const VertexId v : vertices_) {
          least = std::min(least, array.value(v.index(), c));
          most = std::max(most, array.value(v.index(), c));
        }
        range_sq += (most - least) * (most - least);
      }
      stream_.fields.push_back({a, std::sqrt(range_sq)});
    }
  }

  void put(std::uint32_t t, int round) {
    for (const VertexId v : versions_[t])
      star_[v].insert(t);
    made_in_[t] = round;
  }
  void take(std::uint32_t t) {
    for (const VertexId v : versions_[t])
      star_[v].erase(t);
  }

  // Every simplex without `v` in the closed star of `v`, the empty one left out.
  std::set<Simplex> link_of_vertex(VertexId v) const {
    std::set<Simplex> link;
    for (const std::uint32_t t : star_.at(v)) {
      Simplex rest(versions_[t].begin(), versions_[t].end());
      rest.erase(v);
      add_faces(rest, link);
    }
    return link;
  }
  std::set<Simplex> link_of_edge(VertexId v, VertexId w) const {
    std::set<Simplex> link;
    for (const std::uint32_t t : star_.at(v)) {
      Simplex rest(versions_[t].begin(), versions_[t].end());
      if (rest.erase(w) == 0) continue;
      rest.erase(v);
      add_faces(rest, link);
    }
    return link;
  }
  static void add_faces(const Simplex& simplex, std::set<Simplex>& faces) {
    if (simplex.empty() || !faces.insert(simplex).second) return;
    for (const VertexId v : simplex) {
      Simplex facet = simplex;
      facet.erase(v);
      add_faces(facet, faces);
    }
  }

  bool is_real(std::uint32_t t) const {
    const Tet& tet = versions_[t];
    return std::find(tet.begin(), tet.end(), kDummyVertex) == tet.end();
  }

  bool may_collapse(VertexId from, VertexId to, int round) const {
    for (const std::uint32_t t : star_.at(from))
      if (made_in_.at(t) == round) return false;
    const std::set<Simplex> link_from = link_of_vertex(from), link_to = link_of_vertex(to);
    if (link_from.count({kDummyVertex}) != 0 && link_from.count({kDummyVertex, to}) == 0) return false;
    std::set<Simplex> common;
    std::set_intersection(link_from.begin(), link_from.end(), link_to.begin(), link_to.end(),
                          std::inserter(common, common.end()));
    if (common != link_of_edge(from, to)) return false;
    for (const std::uint32_t t : star_.at(from)) {
      Tet tet = versions_[t];
      if (std::find(tet.begin(), tet.end(), to) != tet.end() || !is_real(t)) continue;
      std::replace(tet.begin(), tet.end(), from, to);
      if (orientation(mesh_.position(tet[0]), mesh_.position(tet[1]), mesh_.position(tet[2]), mesh_.position(tet[3])) <=
          0)
        return false;
    }
    for (const Simplex& simplex : link_from) {
      if (simplex.size() != 1 || *simplex.begin() == kDummyVertex) continue;
      const VertexId v = *simplex.begin();
      bool stays = false;
      for (const std::uint32_t t : star_.at(v)) {
        const Tet& tet = versions_[t];
        const bool has_from = std::find(tet.begin(), tet.end(), from) != tet.end();
        const bool has_to = std::find(tet.begin(), tet.end(), to) != tet.end();
        stays |= is_real(t) && !(has_from && has_to);
      }
      if (!stays) return false;
    }
    return true;
  }

  bool run_round(int round) {
    std::vector<std::pair<VertexId, VertexId>> candidates;
    for (const VertexId from : vertices_)
      for (const Simplex& simplex : link_of_vertex(from))
        if (simplex.size() == 1 && *simplex.begin() != kDummyVertex) candidates.emplace_back(from, *simplex.begin());
    std::shuffle(candidates.begin(), candidates.end(), random_);
    const auto most =
        static_cast<std::size_t>(std::ceil(static_cast<double>(vertices_.size()) * options_.round_fraction));
    std::size_t taken = 0;
    for (const auto& [from, to] : candidates) {
      if (taken == most || vertices_.size() <= options_.target_vertices) break;
      if (vertices_.count(from) == 0 || vertices_.count(to) == 0 || link_of_vertex(from).count({to}) == 0 ||
          !may_collapse(from, to, round))
        continue;
      collapse(from, to, round);
      ++taken;
    }
    return taken > 0;
  }

  void collapse(VertexId from, VertexId to, int round) {
    const std::vector<std::uint32_t> star(star_.at(from).begin(), star_.at(from).end());
    std::vector<std::uint32_t> modified, deleted;
    for (const std::uint32_t t : star) {
      const Tet& tet = versions_[t];
      (std::find(tet.begin(), tet.end(), to) == tet.end() ? modified : deleted).push_back(t);
    }
    const auto first_coarse = static_cast<std::uint32_t>(versions_.size());
    std::set<VertexId> held = {from}, held_outside;
    if (link_of_vertex(from).count({kDummyVertex}) != 0) held_outside.insert(from);
    for (const std::uint32_t t : star) {
      (is_real(t) ? held : held_outside).insert(held_[t].begin(), held_[t].end());
      take(t);
    }
    for (const std::uint32_t t : modified) {
      Tet tet = versions_[t];
      std::replace(tet.begin(), tet.end(), from, to);
      versions_.push_back(tet);
      slot_of_.push_back(slot_of_[t]);
      stream_.slots[slot_of_[t]] = tet;
      put(static_cast<std::uint32_t>(versions_.size() - 1), round);
    }
    vertices_.erase(from);

    stream_.removed.push_back(from);
    stream_.target.push_back(to);
    stream_.round.push_back(static_cast<std::uint32_t>(round));
    for (const auto& part : {modified, deleted})
      for (const std::uint32_t t : part)
        stream_.stars.push_back(slot_of_[t]);
    stream_.star_begin.push_back(stream_.stars.size());
    stream_.modified_count.push_back(static_cast<std::uint16_t>(modified.size()));
    std::vector<double> field_error(stream_.fields.size(), 0);
    double domain_error = 0;
    for (const VertexId v : held)
      hand_down_to_tet(v, first_coarse, field_error);
    for (const VertexId v : held_outside)
      hand_down_to_face(v, first_coarse, domain_error);
    for (const double error : field_error)
      stream_.field_error.push_back(error);
    stream_.domain_error.push_back(domain_error);
    stream_.also_needs_begin.push_back(stream_.also_needs.size());
  }

  // To the coarse tet that holds the point, or that it lies least outside of.
  void hand_down_to_tet(VertexId v, std::uint32_t first_coarse, std::vector<double>& field_error) {
    const Point p = mesh_.position(v);
    double best = -INFINITY;
    std::uint32_t best_tet = 0;
    std::array<double, 4> best_weights{};
    for (std::uint32_t t = first_coarse; t < versions_.size(); ++t) {
      if (!is_real(t)) continue;
      std::array<Point, 4> corners;
      for (std::size_t i = 0; i < 4; ++i)
        corners[i] = mesh_.position(versions_[t][i]);
      const double whole = six_volumes(corners[0], corners[1], corners[2], corners[3]);
      std::array<double, 4> weights{};
      for (std::size_t i = 0; i < 4; ++i) {
        auto replaced = corners;
        replaced[i] = p;
        weights[i] = six_volumes(replaced[0], replaced[1], replaced[2], replaced[3]) / whole;
      }
      const double least = *std::min_element(weights.begin(), weights.end());
      if (least > best) {
        best = least;
        best_tet = t;
        best_weights = weights;
      }
    }
    if (best == -INFINITY) return;
    held_[best_tet].insert(v);
    double sum = 0;
    for (double& weight : best_weights)
      sum += weight = std::max(weight, 0.0);
    for (std::size_t f = 0; f < field_error.size(); ++f) {
      const PointArray& array = mesh_.point_arrays[stream_.fields[f].array];
      double error_sq = 0;
      for (std::uint32_t c = 0; c < array.components; ++c) {
        double value = 0;
        for (std::size_t i = 0; i < 4; ++i)
          value += best_weights[i] / sum * array.value(versions_[best_tet][i].index(), c);
        const double difference = value - array.value(v.index(), c);
        error_sq += difference * difference;
      }
      field_error[f] = std::max(field_error[f], std::sqrt(error_sq));
    }
  }

  void hand_down_to_face(VertexId v, std::uint32_t first_coarse, double& domain_error) {
    double least = INFINITY;
    std::uint32_t best = 0;
    for (std::uint32_t t = first_coarse; t < versions_.size(); ++t) {
      if (is_real(t)) continue;
      std::vector<Point> face;
      for (const VertexId corner : versions_[t])
        if (corner != kDummyVertex) face.push_back(mesh_.position(corner));
      const double distance = distance_to_triangle(mesh_.position(v), face[0], face[1], face[2]);
      if (distance < least) {
        least = distance;
        best = t;
      }
    }
    if (least == INFINITY) return;
    held_[best].insert(v);
    domain_error = std::max(domain_error, least);
  }

  const TetMesh& mesh_;
  const NaiveOptions options_;
  std::mt19937 random_;
  RecordStream stream_;
  std::set<VertexId> vertices_;
  std::map<VertexId, std::set<std::uint32_t>> star_;
  std::map<std::uint32_t, int> made_in_;
  std::vector<Tet> versions_; ///< all that the slots ever held
  std::vector<std::uint32_t> slot_of_;
  std::map<std::uint32_t, std::set<VertexId>> held_;
};

} // namespace

RecordStream simplify_naively(const TetMesh& mesh, const NaiveOptions& options) {
  return Simplifier(mesh, options).run();
}

} // namespace ptet::test
