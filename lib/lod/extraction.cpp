#include "lod/extraction.hpp"

#include "lod/mean_errors.hpp"
#include "lod/part_errors.hpp"
#include "lod/star.hpp"
#include "mesh/large_pages.hpp"
#include "mesh/rows.hpp"
#include "record/dependency_order.hpp"
#include "record/ghost.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

namespace ptet {
namespace {

constexpr std::uint32_t kUnused = VertexId::kNone;

/// Puts a mesh together from a cut. A place of the mesh holds what was left there by the last record of the cut that
/// touches it. Tets and boundary faces of the base come first, then those of the places that each record brings, in
/// ascending order of the records.
class Assembly {
public:
  Assembly(const Refinement& refinement, const Cut& cut)
      : refinement_(refinement), cut_(cut), order_(refinement),
        last_(std::make_unique_for_overwrite<std::uint32_t[]>(refinement.place_count())) {
    ask_for_large_pages(last_.get(), refinement.place_count() * sizeof(std::uint32_t));
  }

  void run(bool all_vertices) {
    number_vertices(all_vertices);
    std::size_t tet_count = refinement_.base_tet_count();
    for (std::uint32_t r = 0; r < cut_.applied.size(); ++r)
      if (cut_.applied[r] != 0) tet_count += refinement_.added_tet_count(RecordId{r});
    reserve_large(tets, tet_count);
    std::fill_n(last_.get(), refinement_.base_place_count(), kBase);
    order_.visit([&](std::uint32_t r) { return cut_.applied[r] != 0; }, [&](std::uint32_t r) { touch(RecordId{r}); });
    for (std::uint32_t t = 0; t < refinement_.base_place_count(); ++t)
      if (last_[t] == kBase) add(refinement_.base_tet(t));
    for (std::uint32_t r = 0; r < cut_.applied.size(); ++r)
      if (cut_.applied[r] != 0) add_left_by(RecordId{r});
  }

  /// The records that made the tets and the faces, as far as they are in blocks that the cut depends on. Of the records
  /// that change a place, and are not in the cut, the first made what is there (see Creators). To be called once, after
  /// run().
  struct Makers {
    std::vector<RecordId> of_tet, of_face;
  };
  [[nodiscard]] Makers find_makers(const std::vector<file::BlockInfo>& blocks) {
    std::vector<char> is_known(cut_.applied.size(), 0);
    for (std::size_t b = 0; b < blocks.size(); ++b)
      if (cut_.read[b] != 0) std::fill_n(is_known.begin() + blocks[b].first_record, blocks[b].record_count, 1);
    std::vector<RecordId> maker(refinement_.place_count());
    // The record before it that changes the place is in the cut, or the place is of the base: it has made something.
    // But for such records only what they depend on needs a visit.
    const auto is_maker = [&](std::uint32_t r) {
      return is_known[r] != 0 && has_made(refinement_, r, kHasTets | kHasGhosts, cut_.applied);
    };
    order_.visit(is_maker, [&](std::uint32_t r) {
      for (const Place place : refinement_.modified(RecordId{r}))
        if (maker[place.index()].is_none()) maker[place.index()] = RecordId{r};
    });
    Makers makers;
    makers.of_tet.reserve(tets.size());
    makers.of_face.reserve(faces.size());
    for (std::uint32_t t = 0; t < refinement_.base_place_count(); ++t)
      if (last_[t] == kBase) (t < refinement_.base_tet_count() ? makers.of_tet : makers.of_face).push_back(maker[t]);
    for (std::uint32_t r = 0; r < cut_.applied.size(); ++r) {
      if (cut_.applied[r] == 0) continue;
      for_each_left_by(
          RecordId{r},
          [&](Place place, std::size_t) {
            (place.is_ghost() ? makers.of_face : makers.of_tet).push_back(maker[place.index()]);
          },
          [&](std::uint32_t place, VertexId x, VertexId y) {
            (x == kDummyVertex || y == kDummyVertex ? makers.of_face : makers.of_tet).push_back(maker[place]);
          });
    }
    return makers;
  }

  std::vector<VertexId> in_file; ///< by vertex of the mesh
  std::vector<Tet> tets;
  std::vector<std::array<VertexId, 3>> faces;

private:
  // Vertices that no tet of the base uses are in the original only.
  void number_vertices(bool all) {
    row_.assign(refinement_.base_vertex_count() + std::size_t{refinement_.record_count()}, kUnused);
    std::fill_n(row_.begin(), refinement_.base_vertex_count(), all ? 0 : kUnused);
    for (std::uint32_t t = 0; t < refinement_.base_tet_count(); ++t)
      for (const VertexId v : refinement_.base_tet(t))
        row_[v.index()] = 0;
    in_file.reserve(refinement_.base_vertex_count() + std::size_t{cut_.count});
    for (std::uint32_t v = 0; v < row_.size(); ++v)
      if (v < refinement_.base_vertex_count() ? row_[v] == 0 : cut_.applied[v - refinement_.base_vertex_count()] != 0) {
        row_[v] = static_cast<std::uint32_t>(in_file.size());
        in_file.emplace_back(v);
      }
  }

  [[nodiscard]] VertexId row(VertexId v) const { return VertexId{row_[v.index()]}; }

  void touch(RecordId r) {
    for (const Place place : refinement_.modified(r))
      last_[place.index()] = r.index();
    std::fill_n(last_.get() + refinement_.rim_place(r), refinement_.rim(r).size(), r.index());
  }

  /// Calls `modified(place, k)` for the k-th modified tet and `added(place, a, b)` for the tet of rim edge (a, b), of
  /// those that are in the mesh.
  template <class Modified, class Added>
  void for_each_left_by(RecordId r, Modified&& modified, Added&& added) const {
    const auto places = refinement_.modified(r);
    for (std::size_t k = 0; k < places.size(); ++k)
      if (last_[places[k].index()] == r.index()) modified(places[k], k);
    const auto rim = refinement_.rim(r);
    const std::uint32_t first = refinement_.rim_place(r);
    for (std::uint32_t i = 0; i < rim.size(); ++i) {
      const auto [a, b] = rim_edge(rim, i);
      if (last_[first + i] == r.index()) added(first + i, a, b);
    }
  }

  void add_left_by(RecordId r) {
    const VertexId v = refinement_.vertex_of(r), u = refinement_.target(r);
    for_each_left_by(
        r,
        [&](Place place, std::size_t k) {
          const auto [a, b, c] = refinement_.link_triangle(r, k);
          if (place.is_ghost())
            add({v, a, b, c});
          else
            tets.push_back({row(v), row(a), row(b), row(c)});
        },
        [&](std::uint32_t, VertexId a, VertexId b) {
          add({v, u, a, b});
        });
  }

  void add(const Tet& tet) {
    const auto at = static_cast<std::uint32_t>(std::find(tet.begin(), tet.end(), kDummyVertex) - tet.begin());
    if (at == 4) {
      tets.push_back({row(tet[0]), row(tet[1]), row(tet[2]), row(tet[3])});
    } else {
      const auto [a, b, c] = face_of_ghost(tet, at);
      faces.push_back({row(a), row(b), row(c)});
    }
  }

  const Refinement& refinement_;
  const Cut& cut_;
  DependencyOrder order_;
  static constexpr std::uint32_t kBase = kUnused;
  /// By place in the mesh: the last record of the cut that touches it, or kBase.
  std::unique_ptr<std::uint32_t[]> last_;
  std::vector<std::uint32_t> row_; ///< by vertex in the file
};

/// By code the largest own error of the records that made something of the mesh; of blocks not read, of all records.
std::vector<ErrorCode16> achieved_codes(const Hierarchy& hierarchy, const Cut& cut) {
  const file::Content& content = hierarchy.content();
  const std::size_t count = content.errors_per_record, domain = count - 1;
  std::vector<ErrorCode16> achieved(count, 0);
  for (std::size_t b = 0; b < hierarchy.blocks().size(); ++b) {
    const file::BlockInfo& block = hierarchy.blocks()[b];
    if (cut.read[b] == 0) {
      for (std::size_t i = 0; i < count; ++i)
        achieved[i] = std::max(achieved[i], block.max_own[i]);
      continue;
    }
    for (std::uint32_t r = block.first_record; r < block.end_record(); ++r) {
      if (cut.applied[r] != 0) continue;
      const ErrorCode16* const own = content.own.data() + r * count;
      for (std::size_t i = 0; i < count; ++i)
        if (own[i] > achieved[i] && has_made(content.refinement, r, i == domain ? kHasGhosts : kHasTets, cut.applied))
          achieved[i] = own[i];
    }
  }
  return achieved;
}

/// The tets of the mesh that some record has made, with their vertices' ids in the file.
std::vector<MadeVersion> made_versions(const std::vector<Tet>& tets, const std::vector<RecordId>& makers,
                                       const std::vector<VertexId>& in_file) {
  std::vector<MadeVersion> made;
  for (std::size_t t = 0; t < tets.size(); ++t) {
    if (makers[t].is_none()) continue;
    made.push_back({tets[t], makers[t]});
    for (VertexId& v : made.back().tet)
      v = in_file[v.index()];
  }
  return made;
}
/// The same of boundary faces, as ghosts.
std::vector<MadeVersion> made_versions(const std::vector<std::array<VertexId, 3>>& faces,
                                       const std::vector<RecordId>& makers, const std::vector<VertexId>& in_file) {
  std::vector<MadeVersion> made;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (makers[f].is_none()) continue;
    const auto [a, b, c] = faces[f];
    made.push_back({{kDummyVertex, in_file[a.index()], in_file[b.index()], in_file[c.index()]}, makers[f]});
  }
  return made;
}

} // namespace

bool has_made(const Refinement& refinement, std::uint32_t r, VersionKinds kind, const std::vector<char>& applied) {
  if ((refinement.base_kinds(RecordId{r}) & kind) != 0) return true;
  const auto parents = refinement.parents(RecordId{r});
  for (std::size_t i = 0; i < parents.size(); ++i)
    if (applied[parents[i].index()] != 0 && (refinement.parent_kinds(RecordId{r}, i) & kind) != 0) return true;
  return false;
}

Extraction extract_cut(const Hierarchy& hierarchy, const Cut& cut, const ResolvedRequest& request) {
  const file::Content& content = hierarchy.content();
  Assembly assembly(content.refinement, cut);
  assembly.run(cut.count == cut.applied.size());

  Extraction result;
  result.limited_by = cut.limited_by;
  if (request.origins || names_parts(request)) {
    auto makers = assembly.find_makers(hierarchy.blocks());
    if (names_parts(request))
      state_part_errors(hierarchy, cut, request, made_versions(assembly.tets, makers.of_tet, assembly.in_file),
                        made_versions(assembly.faces, makers.of_face, assembly.in_file), result);
    if (request.origins) result.made_by = std::move(makers.of_tet);
  }
  result.vertex_in_file = std::move(assembly.in_file);
  result.mesh.positions = gather(content.positions, result.vertex_in_file);
  for (const PointArray& array : content.arrays)
    result.mesh.point_arrays.push_back(gather(array, result.vertex_in_file));
  result.mesh.tets = std::move(assembly.tets);
  result.boundary_faces = std::move(assembly.faces);

  const std::vector<ErrorCode16> achieved = achieved_codes(hierarchy, cut);
  for (const file::ArrayInfo& array : hierarchy.header().arrays)
    if (array.governing) result.field_error.push_back(decode_error(achieved[result.field_error.size()], array.range));
  MeanErrors mean = mean_errors(hierarchy, cut.applied, result.field_error);
  result.rms_error = std::move(mean.rms_error);
  result.covered = mean.covered;
  result.domain_error = decode_error(achieved.back(), hierarchy.header().diagonal);
  return result;
}

} // namespace ptet
