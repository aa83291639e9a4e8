#include "support/replay.hpp"

#include "support/mesh_checks.hpp"

#include <algorithm>
#include <set>
#include <stdexcept>

namespace ptet::test {
namespace {

Tet renumbered(const Tet& tet, const std::vector<VertexId>& ids) {
  Tet result = tet;
  for (VertexId& v : result)
    if (v != kDummyVertex) v = ids[v.index()];
  return result;
}

} // namespace

Replay start_replay(const TetMesh& mesh, const RecordStream& stream) {
  const auto n = static_cast<std::uint32_t>(mesh.vertex_count()), records = static_cast<std::uint32_t>(stream.size());
  std::vector<VertexId> file_id(n), original_id(n);
  for (std::uint32_t i = 0; i < records; ++i)
    file_id[stream.removed[i].index()] = VertexId{n - 1 - i};
  std::uint32_t next = 0;
  for (VertexId& id : file_id)
    if (id.is_none()) id = VertexId{next++};
  for (std::uint32_t v = 0; v < n; ++v)
    original_id[file_id[v].index()] = VertexId{v};

  Versions all(stream);
  std::vector<char> is_consumed(all.tets.size(), 0);
  for (const VersionId t : all.fine)
    is_consumed[t.index()] = 1;
  std::vector<Tet> base;
  for (std::size_t t = 0; t < all.tets.size(); ++t) {
    const Tet& tet = all.tets[t];
    if (!is_consumed[t] && std::find(tet.begin(), tet.end(), kDummyVertex) == tet.end())
      base.push_back(renumbered(tet, file_id));
  }
  return {Refinement(std::move(base), n - records, records), std::move(file_id), std::move(original_id),
          std::move(all)};
}

void apply(Replay& replay, const RecordStream& stream, RecordId r) {
  Refinement& refinement = replay.refinement;
  const std::size_t i = replay.in_stream(r);
  std::set<Tet> coarse, fine;
  const Versions& all = replay.all;
  for (std::size_t m = 0; m < all.consumed(i).size(); ++m) {
    fine.insert(sorted_keeping_orientation(renumbered(all.tets[all.consumed(i)[m].index()], replay.file_id)));
    if (m < stream.modified_count[i])
      coarse.insert(sorted_keeping_orientation(renumbered(all.tets[all.coarse_begin[i].index() + m], replay.file_id)));
  }
  const auto in_region = [&](std::uint32_t place) {
    return coarse.count(sorted_keeping_orientation(refinement.tet(place))) != 0;
  };
  // Any tet of the region is a seed: take the one whose vertices come first.
  std::uint32_t seed = 0;
  while (seed < refinement.place_count() && sorted_keeping_orientation(refinement.tet(seed)) != *coarse.begin())
    ++seed;
  if (seed == refinement.place_count())
    throw std::logic_error("a coarse tet of record " + std::to_string(r.index()) + " is not in the mesh");
  refinement.split(r, replay.file_id[stream.target[i].index()], std::span(&seed, 1),
                   [&](const GrowthFace& face) { return in_region(face.behind); });
  std::set<Tet> made;
  for (const Tet& tet : refinement.fine_tets(r))
    made.insert(sorted_keeping_orientation(tet));
  if (made != fine)
    throw std::logic_error("record " + std::to_string(r.index()) + " made other tets than its collapse consumed");
}

std::vector<std::vector<RecordId>> parents_in_stream(const RecordStream& stream) {
  const auto n = static_cast<std::uint32_t>(stream.size());
  const Versions all(stream);
  std::vector<std::uint32_t> consumer(all.tets.size(), n);
  for (std::uint32_t i = 0; i < n; ++i)
    for (const VersionId t : all.consumed(i))
      consumer[t.index()] = i;
  std::vector<std::vector<RecordId>> parents(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    std::set<RecordId> found;
    for (std::uint32_t m = 0; m < stream.modified_count[i]; ++m)
      if (const std::uint32_t by = consumer[all.coarse_begin[i].index() + m]; by != n)
        found.insert(RecordId{n - 1 - by});
    parents[n - 1 - i].assign(found.begin(), found.end());
  }
  return parents;
}

std::vector<Tet> present(const Replay& replay) {
  std::vector<Tet> tets;
  for (std::uint32_t place = 0; place < replay.refinement.place_count(); ++place)
    tets.push_back(sorted_keeping_orientation(renumbered(replay.refinement.tet(place), replay.original_id)));
  std::sort(tets.begin(), tets.end());
  return tets;
}

} // namespace ptet::test
