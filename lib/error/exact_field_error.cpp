#include "error/exact_field_error.hpp"

#include "mesh/vec3.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include <boost/geometry.hpp>
#include <boost/geometry/geometries/box.hpp>
#include <boost/geometry/geometries/point.hpp>
#include <boost/geometry/index/rtree.hpp>

namespace ptet {
using namespace vec;
namespace {

using BoxPoint = boost::geometry::model::point<double, 3, boost::geometry::cs::cartesian>;
using BoostBox = boost::geometry::model::box<BoxPoint>;
using FaceTree = boost::geometry::index::rtree<std::pair<BoostBox, HalfFace>, boost::geometry::index::linear<16>>;

BoostBox box_of(std::span<const Point> points) {
  Point low = points[0];
  Point high = points[0];
  for (const Point& p : points)
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], p[i]);
      high[i] = std::max(high[i], p[i]);
    }
  return {BoxPoint(low[0], low[1], low[2]), BoxPoint(high[0], high[1], high[2])};
}

/// Corners that are in use at once while a tet is cut at four planes one after the other: its own, and up to four new
/// ones for each plane.
constexpr std::size_t kPieceCorners = 20;

} // namespace

struct ExactFieldError::Impl {
  Impl(const PreparedMesh& p, ChannelView c)
      : prepared(p), channels(c), faces(build_face_table(p.mesh.tets, p.used_vertex_count)) {
    on_boundary.resize(p.used_vertex_count);
    std::vector<std::pair<BoostBox, HalfFace>> boundary;
    for (HalfFace h = 0; h < faces.mate.size(); ++h)
      if (faces.is_boundary(h)) {
        const Face face = face_of(prepared.mesh.tets, h);
        const std::array<Point, 3> x{point(face[0]), point(face[1]), point(face[2])};
        boundary.emplace_back(box_of(x), h);
        for (const VertexId v : face)
          on_boundary[v.index()] = 1;
      }
    boundary_tree = FaceTree(boundary.begin(), boundary.end());
    std::vector<std::uint32_t> count(p.used_vertex_count + 1);
    for (const Tet& tet : p.mesh.tets)
      for (const VertexId v : tet)
        ++count[v.index() + 1];
    for (std::size_t v = 1; v < count.size(); ++v)
      count[v] += count[v - 1];
    star_begin = count;
    star.resize(4 * p.mesh.tets.size());
    for (std::uint32_t t = 0; t < p.mesh.tets.size(); ++t)
      for (const VertexId v : p.mesh.tets[t])
        star[count[v.index()]++] = t;
  }

  [[nodiscard]] const Point& point(VertexId v) const { return prepared.points[v.index()]; }

  const PreparedMesh& prepared;
  ChannelView channels;
  FaceTable faces;
  std::vector<std::uint32_t> star_begin; ///< by vertex, into `star`
  std::vector<std::uint32_t> star;       ///< tets around each vertex
  std::vector<char> on_boundary;         ///< by vertex
  FaceTree boundary_tree;
};

ExactFieldError::Workspace::Workspace(const ExactFieldError& original)
    : vertices_(original.impl_->prepared.used_vertex_count),
      differences_(original.impl_->prepared.used_vertex_count * original.impl_->channels.channels),
      tet_stamp_(original.impl_->prepared.mesh.tets.size()),
      pieces_(kPieceCorners * (4 + original.impl_->channels.channels)) {}

ExactFieldError::ExactFieldError(const PreparedMesh& prepared, ChannelView channels)
    : impl_(std::make_unique<Impl>(prepared, channels)) {}
ExactFieldError::~ExactFieldError() = default;

/// One measurement: the walk over the original tets that a version meets.
class ExactFieldError::Walk {
public:
  Walk(const Impl& original, const Tet& version, Workspace& w, std::span<double> errors, std::span<double> squared,
       std::span<const double> limit = {})
      : original_(original), channels_(original.channels.channels), row_size_(4 + channels_), version_(version), w_(w),
        errors_(errors), squared_(squared), limit_(limit) {}

  /// False when it was given up.
  bool run() {
    if (!begin()) return true;
    // Around a vertex inside the domain the corner of the version is full of original tets. At the boundary there may
    // be none, and those that do not lie beyond one of the version's planes need not meet it.
    const auto start =
        std::find_if(version_.begin(), version_.end(), [&](VertexId v) { return !original_.on_boundary[v.index()]; });
    met_boundary_ = start == version_.end();
    if (!met_boundary_) {
      enter_star(*start);
      walk();
    }
    if (!met_boundary_ || beyond_limit_) return !beyond_limit_;
    namespace bgi = boost::geometry::index;
    std::array<Point, 4> x;
    for (std::size_t i = 0; i < 4; ++i)
      x[i] = original_.point(version_[i]);
    for (auto it = original_.boundary_tree.qbegin(bgi::intersects(box_of(x))); it != original_.boundary_tree.qend();
         ++it)
      enter(it->second / 4);
    for (const VertexId v : version_)
      enter_star(v);
    walk();
    return !beyond_limit_;
  }

private:
  /// A tet's stamp while it waits in the queue and after it has left it.
  [[nodiscard]] std::uint32_t queued() const { return w_.stamp_; }
  [[nodiscard]] std::uint32_t done() const { return w_.stamp_ + 1; }

  /// False for a flat version.
  bool begin() {
    origin_ = original_.point(version_[0]);
    const Vec3 e1 = original_.point(version_[1]) - origin_;
    const Vec3 e2 = original_.point(version_[2]) - origin_;
    const Vec3 e3 = original_.point(version_[3]) - origin_;
    const Vec3 n1 = cross(e2, e3);
    const double det = dot(e1, n1);
    if (!(det > 0) || !std::isfinite(1 / det)) return false;
    row_ = {(1 / det) * n1, (1 / det) * cross(e3, e1), (1 / det) * cross(e1, e2)};
    w_.queue_.clear();
    w_.stamp_ += 2;
    if (w_.stamp_ < 2) { // the stamps have gone round
      for (auto& vertex : w_.vertices_)
        vertex.stamp = 0;
      std::fill(w_.tet_stamp_.begin(), w_.tet_stamp_.end(), 0);
      w_.stamp_ = 2;
    }
    for (std::size_t i = 0; i < 4; ++i) { // at its own corners the version is exact
      Workspace::Vertex& corner = w_.vertices_[version_[i].index()];
      corner = {{}, w_.stamp_, static_cast<std::uint8_t>(0xF & ~(1U << i)), 0};
      corner.barycentric[i] = 1;
      std::fill_n(&w_.differences_[version_[i].index() * channels_], channels_, 0.0);
    }
    return true;
  }

  const Workspace::Vertex& look_at(VertexId v) {
    Workspace::Vertex& seen = w_.vertices_[v.index()];
    if (seen.stamp == w_.stamp_) return seen;
    seen.stamp = w_.stamp_;
    const Vec3 d = original_.point(v) - origin_;
    const double b1 = dot(row_[0], d);
    const double b2 = dot(row_[1], d);
    const double b3 = dot(row_[2], d);
    seen.barycentric = {1 - b1 - b2 - b3, b1, b2, b3};
    seen.beyond = seen.strictly_beyond = 0;
    for (unsigned i = 0; i < 4; ++i) {
      seen.beyond |= static_cast<std::uint8_t>(static_cast<unsigned>(seen.barycentric[i] <= 0) << i);
      seen.strictly_beyond |= static_cast<std::uint8_t>(static_cast<unsigned>(seen.barycentric[i] < 0) << i);
    }
    const double* const values = original_.channels.values.data();
    double* const difference = &w_.differences_[v.index() * channels_];
    for (std::size_t c = 0; c < channels_; ++c) {
      double interpolated = 0;
      for (std::size_t i = 0; i < 4; ++i)
        interpolated += seen.barycentric[i] * values[version_[i].index() * channels_ + c];
      difference[c] = values[v.index() * channels_ + c] - interpolated;
    }
    return seen;
  }

  /// Whether one plane of the version has all the vertices on its outer side (or on it).
  template <std::size_t N>
  [[nodiscard]] static bool apart(const std::array<const Workspace::Vertex*, N>& vertices) {
    unsigned common = 0xF;
    for (const Workspace::Vertex* const v : vertices)
      common &= v->beyond;
    return common != 0;
  }

  void enter(std::uint32_t t) {
    if (w_.tet_stamp_[t] >= queued()) return;
    const Tet& tet = original_.prepared.mesh.tets[t];
    if (apart<4>({&look_at(tet[0]), &look_at(tet[1]), &look_at(tet[2]), &look_at(tet[3])})) return;
    w_.tet_stamp_[t] = queued();
    w_.queue_.push_back(t);
  }

  void enter_star(VertexId v) {
    for (std::uint32_t i = original_.star_begin[v.index()]; i != original_.star_begin[v.index() + 1]; ++i)
      enter(original_.star[i]);
  }

  void walk() {
    for (; next_ < w_.queue_.size() && !beyond_limit_; ++next_) {
      const std::uint32_t t = w_.queue_[next_];
      w_.tet_stamp_[t] = done();
      // The parts of a tet that are integrated over have all the corners that count for the maximum.
      const bool maximum_known = !squared_.empty() && integrate(original_.prepared.mesh.tets[t]);
      for (HalfFace h = 4 * t; h < 4 * t + 4; ++h) {
        const std::uint32_t other = original_.faces.mate[h] / 4;
        const bool boundary = original_.faces.is_boundary(h);
        if (!boundary && w_.tet_stamp_[other] == done()) continue; // the face was seen from there
        const Face face = face_of(original_.prepared.mesh.tets, h);
        const std::array<const Workspace::Vertex*, 3> v{&look_at(face[0]), &look_at(face[1]), &look_at(face[2])};
        if (apart<3>(v)) continue;
        if (!maximum_known) see_face(face, v);
        if (boundary)
          met_boundary_ = true;
        else if (w_.tet_stamp_[other] < queued()) {
          w_.tet_stamp_[other] = queued();
          w_.queue_.push_back(other);
        }
      }
    }
  }

  /// Raises the errors by those on the part of an original face in the version.
  void see_face(const Face& face, const std::array<const Workspace::Vertex*, 3>& v) {
    // The difference is linear on the face: its norm is greatest at one of the three vertices.
    bool worth_clipping = false;
    for (const VertexId x : face)
      worth_clipping |= passes(&w_.differences_[x.index() * channels_], false);
    if (!worth_clipping) return;
    // A row of the polygon: barycentric coordinates, then differences.
    const std::size_t row = row_size_;
    w_.polygon_.resize(3 * row);
    for (std::size_t i = 0; i < 3; ++i) {
      std::copy(v[i]->barycentric.begin(), v[i]->barycentric.end(), &w_.polygon_[i * row]);
      std::copy_n(&w_.differences_[face[i].index() * channels_], channels_, &w_.polygon_[i * row + 4]);
    }
    for (std::size_t plane = 0; plane < 4 && !w_.polygon_.empty(); ++plane)
      clip(plane, row);
    for (std::size_t i = 0; i < w_.polygon_.size(); i += row)
      passes(&w_.polygon_[i + 4], true);
  }

  /// Keeps the part of the polygon where barycentric coordinate `plane` is not negative (Sutherland and Hodgman 1974).
  void clip(std::size_t plane, std::size_t row) {
    auto& in = w_.polygon_;
    auto& out = w_.clipped_;
    const std::size_t n = in.size() / row;
    bool all_inside = true;
    for (std::size_t i = 0; i < n; ++i)
      all_inside &= in[i * row + plane] >= 0;
    if (all_inside) return;
    out.clear();
    for (std::size_t i = 0; i < n; ++i) {
      const double* const a = &in[i * row];
      const double* const b = &in[((i + 1) % n) * row];
      if (a[plane] >= 0) out.insert(out.end(), a, a + row);
      if ((a[plane] >= 0) == (b[plane] >= 0)) continue;
      const double s = a[plane] / (a[plane] - b[plane]);
      for (std::size_t k = 0; k < row; ++k)
        out.push_back(a[k] + s * (b[k] - a[k]));
    }
    in.swap(out);
  }

  /// Whether the difference is greater than the error of some field so far; raises the errors to it if asked to.
  bool passes(const double* difference, bool raise) {
    bool greater = false;
    double sum_sq = 0;
    for (std::size_t c = 0; c < channels_; ++c) {
      sum_sq += difference[c] * difference[c];
      const std::size_t field = original_.channels.field_of[c];
      if (c + 1 != channels_ && original_.channels.field_of[c + 1] == field) continue;
      if (sum_sq > errors_[field] * errors_[field]) {
        greater = true;
        if (raise) raise_error(field, std::sqrt(sum_sq));
      }
      sum_sq = 0;
    }
    return greater;
  }

  void raise_error(std::size_t field, double error) {
    errors_[field] = error;
    beyond_limit_ |= !limit_.empty() && error > limit_[field];
  }

  /// Adds the integrals over the part of an original tet in the version, and raises the errors by those there. False,
  /// and nothing done, for a flat tet.
  bool integrate(const Tet& tet) {
    const Point& o = original_.point(tet[0]);
    const double volume =
        std::abs(dot(original_.point(tet[1]) - o, cross(original_.point(tet[2]) - o, original_.point(tet[3]) - o))) / 6;
    if (!(volume > 0)) return false;
    unsigned cut_by = 0; // the version's planes that have a corner of the tet on their outer side
    std::array<const double*, 4> differences{};
    for (std::size_t i = 0; i < 4; ++i) {
      const Workspace::Vertex& vertex = look_at(tet[i]);
      cut_by |= vertex.strictly_beyond;
      differences[i] = &w_.differences_[tet[i].index() * channels_];
    }
    if (cut_by == 0) {
      add_integral(differences, volume);
      return true;
    }
    Piece corners{};
    for (std::size_t i = 0; i < 4; ++i) {
      corners[i] = &w_.pieces_[i * row_size_];
      std::copy_n(w_.vertices_[tet[i].index()].barycentric.begin(), 4, corners[i]);
      std::copy_n(differences[i], channels_, corners[i] + 4);
    }
    integrate_inside(corners, volume, cut_by, &w_.pieces_[4 * row_size_]);
    return true;
  }

  /// Corners of a tet, a row each: barycentric coordinates in the version, then differences.
  using Piece = std::array<double*, 4>;

  /// Adds the integrals over the part of a tet on the inner side of the planes `cut_by` (a set of bits).
  /// `free`: rows for new corners.
  void integrate_inside(const Piece& corners, double volume, unsigned cut_by, double* free) {
    if (cut_by == 0) {
      add_integral({corners[0] + 4, corners[1] + 4, corners[2] + 4, corners[3] + 4}, volume);
      return;
    }
    const auto plane = static_cast<unsigned>(std::countr_zero(cut_by));
    const unsigned others = cut_by & (cut_by - 1);
    Piece c{}; // those inside first
    std::size_t inside = 0;
    std::size_t outside = 4;
    for (double* const corner : corners)
      c[corner[plane] >= 0 ? inside++ : --outside] = corner;
    // The edge from c[i], inside, to c[j] is cut at `s` of its length; `rest` = 1 - s.
    struct Cut {
      double* at;
      double s, rest;
    };
    const auto cut = [&](std::size_t i, std::size_t j) {
      const double* const a = c[i];
      const double* const b = c[j];
      const double length = a[plane] - b[plane];
      const Cut made{free, a[plane] / length, -b[plane] / length};
      for (std::size_t k = 0; k < row_size_; ++k)
        made.at[k] = made.rest * a[k] + made.s * b[k];
      free += row_size_;
      return made;
    };
    const auto go_on = [&](const Piece& piece, double part) { integrate_inside(piece, part * volume, others, free); };
    switch (inside) {
    case 0: return;
    case 1: {
      const Cut x = cut(0, 1), y = cut(0, 2), z = cut(0, 3);
      go_on({c[0], x.at, y.at, z.at}, x.s * y.s * z.s);
      return;
    }
    case 2: { // a prism between triangles (c0, p, q) and (c1, r, s)
      const Cut p = cut(0, 2), q = cut(0, 3), r = cut(1, 2), s = cut(1, 3);
      go_on({c[0], p.at, q.at, s.at}, p.s * q.s * s.rest);
      go_on({c[0], p.at, r.at, s.at}, p.s * r.rest * s.s);
      go_on({c[0], c[1], r.at, s.at}, r.s * s.s);
      return;
    }
    case 3: { // a prism between triangles (c0, c1, c2) and (x, y, z)
      const Cut x = cut(0, 3), y = cut(1, 3), z = cut(2, 3);
      go_on({c[0], c[1], c[2], z.at}, z.s);
      go_on({c[0], c[1], y.at, z.at}, y.s * z.rest);
      go_on({c[0], x.at, y.at, z.at}, x.s * y.rest * z.rest);
      return;
    }
    default: go_on(c, 1);
    }
  }

  /// Adds the integrals over a tet, from the differences at its corners, and raises the errors to these.
  void add_integral(const std::array<const double*, 4>& differences, double volume) {
    for (const double* const difference : differences)
      passes(difference, true);
    for (std::size_t channel = 0; channel < channels_; ++channel) {
      double sum = 0;
      double sum_sq = 0;
      for (const double* const difference : differences) {
        sum += difference[channel];
        sum_sq += difference[channel] * difference[channel];
      }
      squared_[original_.channels.field_of[channel]] += volume / 20 * (sum * sum + sum_sq);
    }
  }

  const Impl& original_;
  std::size_t channels_;
  std::size_t row_size_; ///< numbers at a corner of a clipped face or tet: four barycentric coordinates, the channels
  const Tet& version_;
  Workspace& w_;
  std::span<double> errors_;
  std::span<double> squared_;     ///< empty: not wanted
  std::span<const double> limit_; ///< empty: none
  bool beyond_limit_ = false;
  Point origin_{};
  std::array<Vec3, 3> row_{};
  std::size_t next_ = 0;
  bool met_boundary_ = false;
};

void ExactFieldError::measure(const Tet& version, Workspace& workspace, std::span<double> errors) const {
  Walk(*impl_, version, workspace, errors, {}).run();
}

void ExactFieldError::measure(const Tet& version, Workspace& workspace, std::span<double> errors,
                              std::span<double> squared) const {
  Walk(*impl_, version, workspace, errors, squared).run();
}

bool ExactFieldError::measure(const Tet& version, Workspace& workspace, std::span<double> errors,
                              std::span<double> squared, std::span<const double> limit) const {
  return Walk(*impl_, version, workspace, errors, squared, limit).run();
}

} // namespace ptet
