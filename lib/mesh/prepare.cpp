#include "mesh/prepare.hpp"

#include "mesh/box_tree.hpp"
#include "mesh/disjoint_sets.hpp"
#include "mesh/examination.hpp"
#include "mesh/local_origin.hpp"
#include "mesh/morton.hpp"
#include "mesh/rows.hpp"
#include "ptet/error.hpp"

#include <algorithm>
#include <numeric>

namespace ptet {

namespace {

BoundingBox box_of_used(const std::vector<Point>& points, const VertexLinks& links) {
  BoundingBox box;
  for (std::uint32_t v = 0; v < points.size(); ++v)
    if (links.used[v]) box.add(points[v]);
  return box;
}

/// Old ids in their new order: used vertices along a Morton curve through their bounding box, then the unused ones.
std::vector<VertexId> vertex_order(const std::vector<Point>& points, const VertexLinks& links, const BoundingBox& box) {
  std::vector<std::pair<std::uint64_t, VertexId>> curve;
  curve.reserve(links.used_count);
  std::vector<VertexId> unused;
  for (std::uint32_t v = 0; v < points.size(); ++v) {
    if (links.used[v])
      curve.emplace_back(0, v);
    else
      unused.emplace_back(v);
  }
  const Point& low = box.low;
  const Point& high = box.high;
  const double extent = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
  for (auto& [key, v] : curve)
    key = morton_code(points[v.index()], low, extent);
  std::sort(curve.begin(), curve.end());
  std::vector<VertexId> order;
  order.reserve(points.size());
  for (const auto& entry : curve)
    order.push_back(entry.second);
  order.insert(order.end(), unused.begin(), unused.end());
  return order;
}

/// New place of each tet (of new vertex ids): by smallest vertex, then as they were.
std::vector<std::uint32_t> tet_places(const std::vector<Tet>& tets, std::size_t vertex_count) {
  std::vector<std::uint32_t> next(vertex_count + 1), place(tets.size());
  const auto smallest = [](const Tet& tet) { return std::min({tet[0], tet[1], tet[2], tet[3]}).index(); };
  for (const Tet& tet : tets)
    ++next[smallest(tet) + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  for (std::size_t t = 0; t < tets.size(); ++t)
    place[t] = next[smallest(tets[t])]++;
  return place;
}

/// By old vertex id.
std::vector<char> find_frozen(const Examination& found) {
  std::vector<char> frozen(found.points.size());
  for (const auto& edge : found.boundary.non_manifold_edges)
    for (const VertexId v : edge)
      frozen[v.index()] = 1;
  for (const VertexId v : found.links.non_manifold)
    frozen[v.index()] = 1;
  for (const HalfFace h : found.folded)
    for (const HalfFace side : {h, found.faces.mate[h]})
      for (const VertexId v : found.tets[side / 4])
        frozen[v.index()] = 1;
  return frozen;
}

/// By boundary face, as PreparedMesh::crossing_curves. `boundary`: ascending, as `crossing` names them.
std::vector<std::uint32_t> find_crossing_curves(const std::vector<HalfFace>& boundary,
                                                const std::vector<std::array<HalfFace, 2>>& crossing) {
  if (crossing.empty()) return {};
  const auto face_at = [&](HalfFace h) {
    return static_cast<std::uint32_t>(std::lower_bound(boundary.begin(), boundary.end(), h) - boundary.begin());
  };
  DisjointSets sets(boundary.size());
  std::vector<char> crosses(boundary.size());
  for (const auto& pair : crossing) {
    const std::uint32_t a = face_at(pair[0]), b = face_at(pair[1]);
    crosses[a] = crosses[b] = 1;
    sets.join(a, b);
  }
  std::vector<std::uint32_t> curve(boundary.size());
  std::uint32_t count = 0;
  for (std::uint32_t f = 0; f < boundary.size(); ++f)
    if (crosses[f] != 0) curve[f] = sets.root(f) == f ? ++count : curve[sets.root(f)];
  return curve;
}

} // namespace

PreparedMesh prepare(TetMesh mesh, const ProgressCallback& progress) {
  Examination found = examine(mesh, progress);
  PreparedMesh prepared;
  for (const Finding& finding : found.findings) {
    if (finding.severity == Severity::kError) throw Error(ErrorCode::kBadInput, finding.message);
    prepared.notes.push_back(finding.message);
  }

  const BoundingBox box = box_of_used(found.points, found.links);
  prepared.used_vertex_count = static_cast<std::uint32_t>(found.links.used_count);
  prepared.original_vertex = vertex_order(found.points, found.links, box);
  const std::vector<VertexId>& order = prepared.original_vertex;
  std::vector<VertexId> renumbered(order.size());
  for (std::uint32_t v = 0; v < order.size(); ++v)
    renumbered[order[v].index()] = VertexId{v};

  mesh.positions = gather(mesh.positions, order);
  for (PointArray& array : mesh.point_arrays)
    array = gather(array, order);
  const std::vector<char> frozen = find_frozen(found);
  prepared.points.reserve(order.size());
  prepared.frozen.reserve(order.size());
  const Point origin = local_origin(box.low, box.high);
  for (const VertexId v : order) {
    const Point& p = found.points[v.index()];
    prepared.points.push_back({p[0] - origin[0], p[1] - origin[1], p[2] - origin[2]});
    prepared.frozen.push_back(frozen[v.index()]);
  }

  for (Tet& tet : found.tets)
    for (VertexId& v : tet)
      v = renumbered[v.index()];
  const std::vector<std::uint32_t> place = tet_places(found.tets, order.size());
  for (std::size_t t = 0; t < place.size(); ++t)
    mesh.tets[place[t]] = found.tets[t];

  std::vector<HalfFace> boundary = std::move(found.boundary.half_faces);
  const auto renumber = [&](HalfFace& h) { h = 4 * place[h / 4] + h % 4; };
  std::for_each(boundary.begin(), boundary.end(), renumber);
  std::sort(boundary.begin(), boundary.end());
  for (auto& pair : found.crossing)
    std::for_each(pair.begin(), pair.end(), renumber);
  prepared.crossing_curves = find_crossing_curves(boundary, found.crossing);
  prepared.overlaps_itself = found.overlaps_itself;
  prepared.boundary_faces.reserve(boundary.size());
  for (const HalfFace h : boundary)
    prepared.boundary_faces.push_back(face_of(mesh.tets, h));
  prepared.mesh = std::move(mesh);
  return prepared;
}

} // namespace ptet
