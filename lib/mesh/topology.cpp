#include "mesh/topology.hpp"

#include "mesh/by_parts.hpp"
#include "mesh/disjoint_sets.hpp"
#include "mesh/large_pages.hpp"

#include <algorithm>
#include <numeric>

namespace ptet {

namespace {

/// Vertices that are looked at by one thread in a row, at least.
constexpr std::size_t kVerticesTogether = 2048;
/// Each has marks on all tets and vertices: many of them at once would want more memory than a build.
constexpr std::size_t kMostWalkers = 8;

std::uint64_t edge_key(VertexId a, VertexId b) {
  return std::uint64_t{std::min(a, b).index()} << 32 | std::max(a, b).index();
}

/// A half-face in the bucket of its face's smallest vertex, with the other two.
struct Keyed {
  std::uint32_t middle, largest;
  HalfFace half_face;

  [[nodiscard]] std::uint64_t key() const { return std::uint64_t{middle} << 32 | largest; }
  friend bool operator<(const Keyed& x, const Keyed& y) {
    return x.key() != y.key() ? x.key() < y.key() : x.half_face < y.half_face;
  }
};

/// Half-faces in the buckets of their smallest vertices: bucket v is [begin[v], begin[v + 1]).
struct Buckets {
  std::vector<std::uint32_t> begin;
  LargeVector<Keyed> entries;
};

/// Calls `visit(smallest vertex, the rest)` for each half-face, ascending.
template <class Visit>
void each_half_face(std::span<const Tet> tets, Visit&& visit) {
  const auto half_face_count = static_cast<HalfFace>(tets.size() * 4);
  for (HalfFace h = 0; h < half_face_count; ++h) {
    Face face = face_of(tets, h);
    if (face[1] < face[0]) std::swap(face[0], face[1]);
    if (face[2] < face[1]) std::swap(face[1], face[2]);
    if (face[1] < face[0]) std::swap(face[0], face[1]);
    visit(face[0].index(), Keyed{face[1].index(), face[2].index(), h});
  }
}

Buckets sort_into_buckets(std::span<const Tet> tets, std::size_t vertex_count) {
  Buckets buckets{std::vector<std::uint32_t>(vertex_count + 2), LargeVector<Keyed>(tets.size() * 4)};
  // Counted two places on, so that filling the buckets leaves each begin where it belongs.
  each_half_face(tets, [&](std::uint32_t v, const Keyed&) { ++buckets.begin[v + 2]; });
  std::partial_sum(buckets.begin.begin(), buckets.begin.end(), buckets.begin.begin());
  each_half_face(tets, [&](std::uint32_t v, const Keyed& entry) { buckets.entries[buckets.begin[v + 1]++] = entry; });
  return buckets;
}

/// What a face table says of the faces of some vertices, but for the mates.
struct SomeFaces {
  std::vector<HalfFace> crowded;
  std::vector<TetId> duplicates;
  std::uint64_t face_count = 0;
};

/// Links the half-faces on one face, given ascending, and finds tets that are there twice.
void link_face(std::span<const Tet> tets, std::span<const Keyed> group, std::vector<HalfFace>& mate, SomeFaces& faces) {
  for (std::size_t i = 0; i < group.size(); ++i)
    mate[group[i].half_face] = group[(i + 1) % group.size()].half_face;
  ++faces.face_count;
  if (group.size() < 2) return;
  if (group.size() > 2) faces.crowded.push_back(group[0].half_face);

  if (group.size() == 2 && apex_of(tets, group[0].half_face) != apex_of(tets, group[1].half_face)) return;
  std::vector<std::pair<VertexId, HalfFace>> apexes;
  for (const Keyed& entry : group)
    apexes.emplace_back(apex_of(tets, entry.half_face), entry.half_face);
  std::sort(apexes.begin(), apexes.end());
  for (std::size_t i = 1; i < apexes.size(); ++i)
    if (apexes[i].first == apexes[i - 1].first) faces.duplicates.emplace_back(apexes[i].second / 4);
}

/// Walks over the tets at one vertex after another, from tet to tet through the faces at the vertex and, from a
/// boundary face to the next, through the ghost tets outside.
class LinkWalker {
public:
  LinkWalker(std::span<const Tet> tets, const FaceTable& faces, const BoundarySurface& boundary,
             std::size_t vertex_count)
      : tets_(tets), faces_(faces), boundary_(boundary), tet_seen_from_(tets.size()), vertex_seen_from_(vertex_count) {}

  /// Whether the closed link of v is a sphere. `start`: a tet at v, `degree`: the number of them.
  /// The link is closed if every triangle in it has one neighbour at each edge; connected through edges if the walk
  /// reaches all; and then, pinched or not, its Euler characteristic is 2 only if it is a sphere.
  bool is_sphere(VertexId v, std::uint32_t start, std::uint32_t degree) {
    walk(v, start);
    const std::uint64_t link_triangles = stack_.size() + boundary_faces_;
    const std::uint64_t link_vertices = neighbours_ + (boundary_faces_ > 0 ? 1 : 0);
    return closed_ && stack_.size() == degree && 2 * link_vertices == link_triangles + 4;
  }
  /// Vertices on an edge with the last v; all of them only if the link was a sphere.
  [[nodiscard]] std::uint64_t neighbours() const { return neighbours_; }

private:
  void walk(VertexId v, std::uint32_t start) {
    stack_.clear();
    neighbours_ = boundary_faces_ = 0;
    closed_ = true;
    vertex_seen_from_[v.index()] = v;
    visit(v, start);
    for (std::size_t i = 0; i < stack_.size(); ++i) {
      const Tet& tet = tets_[stack_[i]];
      for (std::uint32_t k = 0; k < 4; ++k) {
        if (tet[k] == v) continue;
        const HalfFace h = 4 * stack_[i] + k, mate = faces_.mate[h];
        if (mate == h) {
          cross_boundary_edges(v, h);
        } else {
          closed_ = closed_ && faces_.is_interior(h);
          visit(v, mate / 4);
        }
      }
    }
  }

  void cross_boundary_edges(VertexId v, HalfFace h) {
    ++boundary_faces_;
    const auto found = std::lower_bound(boundary_.half_faces.begin(), boundary_.half_faces.end(), h);
    const auto f = static_cast<std::uint32_t>(found - boundary_.half_faces.begin());
    for (std::uint32_t i = 0; i < 3; ++i) {
      if (boundary_.faces[f][(i + 2) % 3] == v) continue; // the edge opposite v
      const std::uint32_t mate = boundary_.edge_mate[3 * f + i];
      if (mate == BoundarySurface::kNoMate) {
        closed_ = false;
      } else {
        visit(v, boundary_.half_faces[mate / 3] / 4);
      }
    }
  }

  void visit(VertexId v, std::uint32_t tet) {
    if (tet_seen_from_[tet] == v) return;
    tet_seen_from_[tet] = v;
    stack_.push_back(tet);
    for (const VertexId x : tets_[tet]) {
      if (vertex_seen_from_[x.index()] == v) continue;
      vertex_seen_from_[x.index()] = v;
      ++neighbours_;
    }
  }

  std::span<const Tet> tets_;
  const FaceTable& faces_;
  const BoundarySurface& boundary_;
  std::vector<VertexId> tet_seen_from_, vertex_seen_from_;
  std::vector<std::uint32_t> stack_; ///< the tets reached, in order
  std::uint64_t neighbours_ = 0, boundary_faces_ = 0;
  bool closed_ = true;
};

/// The number of edges at `vertices` (ascending), those between two of them counted twice.
std::uint64_t count_edge_ends(std::span<const Tet> tets, std::span<const VertexId> vertices) {
  std::vector<std::uint64_t> ends;
  for (const Tet& tet : tets)
    for (const VertexId v : tet)
      if (std::binary_search(vertices.begin(), vertices.end(), v))
        for (const VertexId x : tet)
          if (x != v) ends.push_back(std::uint64_t{v.index()} << 32 | x.index());
  std::sort(ends.begin(), ends.end());
  return static_cast<std::uint64_t>(std::unique(ends.begin(), ends.end()) - ends.begin());
}

} // namespace

FaceTable build_face_table(std::span<const Tet> tets, std::size_t vertex_count) {
  Buckets buckets = sort_into_buckets(tets, vertex_count);
  FaceTable table;
  resize_large(table.mate, tets.size() * 4);
  const auto link = [&](SomeFaces& faces, std::size_t first, std::size_t last) {
    for (std::size_t v = first; v < last; ++v) {
      const std::span<Keyed> bucket(buckets.entries.data() + buckets.begin[v], buckets.begin[v + 1] - buckets.begin[v]);
      std::sort(bucket.begin(), bucket.end());
      for (std::size_t i = 0, j = 0; i < bucket.size(); i = j) {
        while (j < bucket.size() && bucket[j].key() == bucket[i].key())
          ++j;
        link_face(tets, bucket.subspan(i, j - i), table.mate, faces);
      }
    }
  };
  for (const SomeFaces& faces : by_parts<SomeFaces>(0, vertex_count, kVerticesTogether, link)) {
    append(table.crowded, faces.crowded);
    append(table.duplicates, faces.duplicates);
    table.face_count += faces.face_count;
  }
  std::sort(table.crowded.begin(), table.crowded.end());
  std::sort(table.duplicates.begin(), table.duplicates.end());
  table.duplicates.erase(std::unique(table.duplicates.begin(), table.duplicates.end()), table.duplicates.end());
  return table;
}

bool is_folded(std::span<const Tet> tets, const FaceTable& faces, HalfFace h) {
  const Face here = face_of(tets, h), there = face_of(tets, faces.mate[h]);
  const auto i = static_cast<std::size_t>(std::find(there.begin(), there.end(), here[0]) - there.begin());
  return there[(i + 1) % 3] == here[1];
}

BoundarySurface build_boundary(std::span<const Tet> tets, const FaceTable& faces, std::size_t vertex_count) {
  BoundarySurface surface;
  for (std::uint64_t h = 0; h < faces.mate.size(); ++h)
    if (faces.is_boundary(static_cast<HalfFace>(h))) surface.half_faces.push_back(static_cast<HalfFace>(h));

  struct Edge {
    std::uint64_t key;
    std::uint64_t edge;
    auto operator<=>(const Edge&) const = default;
  };
  std::vector<Edge> edges;
  edges.reserve(surface.half_faces.size() * 3);
  std::vector<char> on_boundary(vertex_count);
  for (const HalfFace h : surface.half_faces) {
    const Face& face = surface.faces.emplace_back(face_of(tets, h));
    for (std::size_t i = 0; i < 3; ++i) {
      edges.push_back({edge_key(face[i], face[(i + 1) % 3]), edges.size()});
      on_boundary[face[i].index()] = 1;
    }
  }
  std::sort(edges.begin(), edges.end());

  surface.edge_mate.assign(edges.size(), BoundarySurface::kNoMate);
  DisjointSets components(surface.faces.size());
  for (std::size_t i = 0, j = 0; i < edges.size(); i = j) {
    for (; j < edges.size() && edges[j].key == edges[i].key; ++j)
      components.join(static_cast<std::uint32_t>(edges[i].edge / 3), static_cast<std::uint32_t>(edges[j].edge / 3));
    ++surface.edge_count;
    if (j - i == 2) {
      surface.edge_mate[edges[i].edge] = static_cast<std::uint32_t>(edges[i + 1].edge);
      surface.edge_mate[edges[i + 1].edge] = static_cast<std::uint32_t>(edges[i].edge);
    } else {
      const std::uint64_t key = edges[i].key;
      surface.non_manifold_edges.push_back(
          {VertexId{static_cast<std::uint32_t>(key >> 32)}, VertexId{static_cast<std::uint32_t>(key)}});
    }
  }
  surface.components = components.count();
  surface.vertex_count = static_cast<std::uint64_t>(std::count(on_boundary.begin(), on_boundary.end(), 1));
  return surface;
}

VertexLinks examine_links(std::span<const Tet> tets, const FaceTable& faces, const BoundarySurface& boundary,
                          std::size_t vertex_count) {
  std::vector<std::uint32_t> degree(vertex_count), some_tet(vertex_count);
  for (std::size_t t = 0; t < tets.size(); ++t)
    for (const VertexId v : tets[t]) {
      ++degree[v.index()];
      some_tet[v.index()] = static_cast<std::uint32_t>(t);
    }
  VertexLinks links;
  links.used.resize(vertex_count);
  struct Some {
    std::vector<VertexId> non_manifold;
    std::uint64_t used_count = 0, edge_ends = 0;
  };
  const auto walk = [&](Some& some, std::size_t first, std::size_t last) {
    LinkWalker walker(tets, faces, boundary, vertex_count);
    for (std::size_t i = first; i < last; ++i) {
      if (degree[i] == 0) continue;
      links.used[i] = 1;
      ++some.used_count;
      const VertexId v{static_cast<std::uint32_t>(i)};
      if (walker.is_sphere(v, some_tet[i], degree[i])) {
        some.edge_ends += walker.neighbours();
      } else {
        some.non_manifold.push_back(v);
      }
    }
  };
  std::uint64_t edge_ends = 0;
  const std::size_t together = std::max(kVerticesTogether, (vertex_count + kMostWalkers - 1) / kMostWalkers);
  for (const Some& some : by_parts<Some>(0, vertex_count, together, walk)) {
    append(links.non_manifold, some.non_manifold);
    links.used_count += some.used_count;
    edge_ends += some.edge_ends;
  }
  if (!links.non_manifold.empty()) edge_ends += count_edge_ends(tets, links.non_manifold);
  links.edge_count = edge_ends / 2;
  return links;
}

std::uint64_t count_components(std::span<const Tet> tets, const FaceTable& faces) {
  DisjointSets components(tets.size());
  for (std::uint64_t h = 0; h < faces.mate.size(); ++h)
    components.join(static_cast<std::uint32_t>(h / 4), faces.mate[h] / 4);
  return components.count();
}

} // namespace ptet
