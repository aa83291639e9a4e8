// The mesh of a cut in slots that stay: a split or a collapse changes the few tets around one edge and nothing else.
//
//   place of the hierarchy  ->  slot     tets()   boundary_faces()   vertices(), positions(), arrays()
//                                         slots of their own kind, filled from the least up as far as the mesh was
//                                         ever large; those that are not used wait in a list to be used next
#pragma once

#include "lod/creators.hpp"
#include "lod/hierarchy.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace ptet {

class SlotMesh {
public:
  using TetSlots = std::array<std::uint32_t, 4>;
  using FaceSlots = std::array<std::uint32_t, 3>;
  static constexpr std::uint32_t kUnused = 0xFFFFFFFF;
  static constexpr std::size_t kFewSlots = 4096;
  static constexpr std::size_t kSlotsATet = 4;

  /// The base mesh. `hierarchy` must outlive it. Here and in what follows the hierarchy's lock must be held.
  explicit SlotMesh(const Hierarchy& hierarchy);

  /// To be called before the first split after records were read.
  void make_room();
  /// All parents of `r` are split, `r` is not.
  void split(RecordId r);
  /// `r` is split, none of those that depend on it is.
  void collapse(RecordId r);
  /// For records that are about to be split or collapsed: what that looks at lies all over memory, so the processor is
  /// told ahead, in steps. After Refinement::fetch_record() and fetch_lists() first for the places and vertices, then,
  /// some records later, for the slots that these name.
  void fetch_places(RecordId r) const;
  void fetch_slots(RecordId r) const;
  /// Gives back slots where hardly any are used: of more than kFewSlots tet slots less than one in kSlotsATet. The
  /// tets, faces and vertices that there are then have the first ones, in the order they had, and all count as changed.
  /// Returns whether it did. Cost: a look at all slots and all records.
  bool compact();
  /// Whether the vertices that no tet of the base uses are there, too, as they are in the original.
  void show_unused_vertices(bool shown);

  [[nodiscard]] const std::vector<TetSlots>& tets() const { return tets_.rows; }
  [[nodiscard]] const std::vector<FaceSlots>& boundary_faces() const { return faces_.rows; }
  /// Ids in the file; none: unused.
  [[nodiscard]] const std::vector<VertexId>& vertices() const { return vertices_.rows; }
  [[nodiscard]] const PointArray& positions() const { return positions_; }
  [[nodiscard]] const std::vector<PointArray>& arrays() const { return arrays_; }
  [[nodiscard]] std::uint64_t tet_count() const { return tets_.used(); }
  [[nodiscard]] std::uint64_t face_count() const { return faces_.used(); }
  [[nodiscard]] std::uint64_t vertex_count() const { return vertices_.used(); }

  /// From here on keeps which record made each tet, as far as the records of `known`, a closed set of loaded blocks,
  /// tell. To be called after make_room(), and again whenever `known` is another set. Tets for which another record is
  /// named than before count as changed. `applied`: by record, whether the mesh is split by it.
  void follow_creators(const BlockSet& known, const std::vector<char>& applied);
  void forget_creators();
  /// By tet slot, none for unused slots and original tets; empty unless it is kept.
  [[nodiscard]] const std::vector<RecordId>& made_by() const { return made_by_; }

  /// Begins the lists of changed slots anew.
  void forget_changes();
  // Slots taken, freed or with something else in them; each once.
  [[nodiscard]] std::span<const std::uint32_t> changed_tets() const { return tets_.changed; }
  [[nodiscard]] std::span<const std::uint32_t> changed_faces() const { return faces_.changed; }
  [[nodiscard]] std::span<const std::uint32_t> changed_vertices() const { return vertices_.changed; }

private:
  template <class Row>
  struct Slots {
    std::vector<Row> rows;
    std::vector<std::uint32_t> free;
    std::vector<std::uint32_t> changed;
    std::vector<bool> is_changed; ///< by slot: whether it is among them

    [[nodiscard]] std::uint64_t used() const { return rows.size() - free.size(); }
    std::uint32_t take(const Row& row);
    void release(std::uint32_t slot, const Row& unused);
    /// Of each slot where it goes, kUnused if it is not used; everything is told.
    std::vector<std::uint32_t> compact(const Row& unused);
    void tell(std::uint32_t slot) {
      if (is_changed[slot]) return;
      is_changed[slot] = true;
      changed.push_back(slot);
    }
    void forget_changes() {
      for (const std::uint32_t slot : changed)
        is_changed[slot] = false;
      changed.clear();
    }
  };

  std::uint32_t add_vertex(VertexId v);
  void remove_vertex(VertexId v);
  void replace(Place place, std::uint32_t from, std::uint32_t to);
  void move_places(const std::vector<std::uint32_t>& tet, const std::vector<std::uint32_t>& face);
  void settle();
  void find_creators(const std::vector<char>& applied);
  void fetch_tet(std::uint32_t slot) const;
  void set_creator(std::uint32_t tet_slot, RecordId creator);
  void add_ghost(std::uint32_t place, const std::array<std::uint32_t, 4>& slots, std::size_t dummy_corner);

  const Hierarchy& hierarchy_;
  Slots<TetSlots> tets_;
  Slots<FaceSlots> faces_;
  Slots<VertexId> vertices_;
  PointArray positions_;
  std::vector<PointArray> arrays_;
  std::vector<std::uint32_t> slot_of_place_;  ///< of a tet or a face, as the place is one's or the other's
  bool is_settled_ = false;                   ///< places are numbered as in the settled refinement
  std::vector<std::uint32_t> rim_place_;      ///< by record, of those that are split, until then
  std::vector<std::uint32_t> slot_of_vertex_; ///< by id in the file
  std::vector<VertexId> unused_;              ///< base vertices of no base tet
  bool shows_unused_ = false;
  std::optional<Creators> creators_;
  std::vector<RecordId> made_by_;
};

} // namespace ptet
