#include "generate/jitter.hpp"
#include "generate/shapes.hpp"
#include "mesh/scalar_dispatch.hpp"
#include "mesh/topology.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>

namespace ptet::bench {
namespace {

using Edge = std::array<std::uint8_t, 2>;
/// Corners of a tet; a midpoint is named by its edge, a corner by itself twice.
constexpr std::array<Edge, 6> kEdges{{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};
/// The octahedron in the middle: its diagonals, and the other four midpoints in a ring around each, such that
/// (diagonal, ring i, ring i + 1) is oriented like the tet.
struct Diagonal {
  std::array<std::uint8_t, 2> ends;
  std::array<std::uint8_t, 4> ring;
};
constexpr std::array<Diagonal, 3> kDiagonals{{{{0, 5}, {2, 4, 3, 1}}, {{1, 4}, {3, 5, 2, 0}}, {{2, 3}, {1, 5, 4, 0}}}};

/// Edges by their lesser vertex, each with a number.
class Edges {
public:
  explicit Edges(const TetMesh& mesh) : begin_(mesh.vertex_count() + 1) {
    const auto each = [&](auto&& visit) {
      for (const Tet& tet : mesh.tets)
        for (const Edge& e : kEdges) {
          const std::uint32_t a = tet[e[0]].index(), b = tet[e[1]].index();
          visit(std::min(a, b), std::max(a, b));
        }
    };
    // Every edge as often as there are tets around it, then once.
    each([&](std::uint32_t low, std::uint32_t) { ++begin_[low + 1]; });
    for (std::size_t v = 1; v < begin_.size(); ++v)
      begin_[v] += begin_[v - 1];
    others_.resize(begin_.back());
    std::vector<std::uint64_t> next(begin_.begin(), begin_.end() - 1);
    each([&](std::uint32_t low, std::uint32_t high) { others_[next[low]++] = high; });
    std::uint64_t kept = 0;
    for (std::size_t v = 0; v + 1 < begin_.size(); ++v) {
      const auto first = others_.begin() + static_cast<std::ptrdiff_t>(begin_[v]);
      const auto last = others_.begin() + static_cast<std::ptrdiff_t>(begin_[v + 1]);
      std::sort(first, last);
      const auto end = std::unique(first, last);
      std::copy(first, end, others_.begin() + static_cast<std::ptrdiff_t>(kept));
      begin_[v] = kept;
      kept += static_cast<std::uint64_t>(end - first);
    }
    begin_.back() = kept;
    others_.resize(kept);
  }

  [[nodiscard]] std::uint64_t count() const { return others_.size(); }
  [[nodiscard]] std::uint32_t number(VertexId a, VertexId b) const {
    const std::uint32_t low = std::min(a, b).index(), high = std::max(a, b).index();
    const auto first = others_.begin() + static_cast<std::ptrdiff_t>(begin_[low]);
    const auto last = others_.begin() + static_cast<std::ptrdiff_t>(begin_[low + 1]);
    return static_cast<std::uint32_t>(std::lower_bound(first, last, high) - others_.begin());
  }
  /// Calls `visit(lesser vertex, greater vertex)` in the order of the numbers.
  template <class Visit>
  void each(Visit&& visit) const {
    for (std::uint32_t v = 0; v + 1 < begin_.size(); ++v)
      for (std::uint64_t e = begin_[v]; e < begin_[v + 1]; ++e)
        visit(v, others_[e]);
  }

private:
  std::vector<std::uint64_t> begin_; ///< by vertex, and one more
  std::vector<std::uint32_t> others_;
};

PointArray with_midpoints(const PointArray& from, const Edges& edges) {
  PointArray to{from.name, from.type, from.components, {}};
  to.bytes.reserve(from.bytes.size() + edges.count() * from.row_bytes());
  to.bytes = from.bytes;
  to.resize(from.size() + edges.count());
  std::byte* at = to.bytes.data() + from.bytes.size();
  dispatch(from.type, [&]<class T>(T) {
    edges.each([&](std::uint32_t a, std::uint32_t b) {
      for (std::uint32_t c = 0; c < from.components; ++c, at += sizeof(T)) {
        const double mean = (from.value(a, c) + from.value(b, c)) / 2;
        store(at, static_cast<T>(std::is_integral_v<T> ? std::floor(mean) : mean));
      }
    });
  });
  return to;
}

double distance_sq(const Point& a, const Point& b) {
  double sum = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    sum += (a[axis] - b[axis]) * (a[axis] - b[axis]);
  return sum;
}

} // namespace

TetMesh refined(const TetMesh& mesh, const ProgressCallback& progress) {
  if (mesh.tets.size() > kMaxTets / 8)
    throw Error(ErrorCode::kLimit,
                "eight times " + std::to_string(mesh.tets.size()) + " tets are more than ptet takes");
  tell(progress, "finding edges", 0, 1);
  const Edges edges(mesh);
  if (mesh.vertex_count() + edges.count() > std::numeric_limits<std::int32_t>::max())
    throw Error(ErrorCode::kLimit, "the refined mesh would have more than 2^31 vertices");
  TetMesh fine;
  fine.positions = with_midpoints(mesh.positions, edges);
  for (const PointArray& array : mesh.point_arrays)
    fine.point_arrays.push_back(with_midpoints(array, edges));

  const auto first_midpoint = static_cast<std::uint32_t>(mesh.vertex_count());
  fine.tets.reserve(mesh.tets.size() * 8);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    if (t % 65536 == 0) tell(progress, "refining", t, mesh.tets.size());
    const Tet& tet = mesh.tets[t];
    std::array<VertexId, 6> middle;
    for (std::size_t e = 0; e < 6; ++e)
      middle[e] = VertexId{first_midpoint + edges.number(tet[kEdges[e][0]], tet[kEdges[e][1]])};
    // A corner with the midpoints of its edges, each in the place of the edge's other end.
    for (std::uint8_t corner = 0; corner < 4; ++corner) {
      Tet part = tet;
      for (std::size_t e = 0; e < 6; ++e) {
        if (kEdges[e][0] == corner) part[kEdges[e][1]] = middle[e];
        if (kEdges[e][1] == corner) part[kEdges[e][0]] = middle[e];
      }
      fine.tets.push_back(part);
    }
    const auto length = [&](const Diagonal& d) {
      return distance_sq(fine.position(middle[d.ends[0]]), fine.position(middle[d.ends[1]]));
    };
    const Diagonal& shortest =
        *std::min_element(kDiagonals.begin(), kDiagonals.end(),
                          [&](const Diagonal& a, const Diagonal& b) { return length(a) < length(b); });
    for (std::size_t i = 0; i < 4; ++i)
      fine.tets.push_back({middle[shortest.ends[0]], middle[shortest.ends[1]], middle[shortest.ring[i]],
                           middle[shortest.ring[(i + 1) % 4]]});
  }
  return fine;
}

} // namespace ptet::bench
