// A mesh that follows its requests: what a viewer holds from frame to frame.
//
//   Session --update(Request)--> the mesh that extract(Request) gives, by splitting and collapsing what differs
//
//   slot    0        1        2        3        4 ...        Tets, boundary faces and vertices keep their slots while
//   tets  [a b c d][b c d e][  unused ][d e f g] ...         they stay, so that a copy elsewhere, as on a graphics
//                                                            card, needs only the changed slots. Where hardly any are
//                                                            used any more all is moved to the first ones, once.
//
// Source: after Hoppe, View-dependent refinement of progressive meshes (1997), section 4, and Danovaro et al. on
// multi-tessellations: every cut between two closed cuts that splits parents first and collapses children first is
// closed itself, and so its mesh is conforming.
#pragma once

#include "ptet/dataset.hpp"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

namespace ptet {

/// What an update did and what mesh there is now. The spans are valid until the next update.
struct SessionUpdate {
  /// The slots to be copied anew: those that were taken, were freed, or hold something else now (tets and faces: other
  /// corners); each once, in no order. A slot that is in the end as it was may be among them. With
  /// Request::origins, so are tets that Session::made_by() now gives another record for; when origins are asked for
  /// after a request that did not, these are all tets in use.
  std::span<const std::uint32_t> changed_tets, changed_faces, changed_vertices;
  /// Of the mesh as it is now.
  std::uint64_t tets = 0, boundary_faces = 0, vertices = 0;
  /// What splits brought and collapses took away; tets that only got another corner are not counted. The first update
  /// also brings the base mesh, as does one that starts over, which does not count what it leaves behind.
  std::uint64_t tets_added = 0, tets_removed = 0, vertices_added = 0, vertices_removed = 0;
  std::uint64_t splits = 0, collapses = 0;
  /// As in Extraction: one per governing field, in field units; `rms_error` may be empty.
  std::span<const double> field_error, rms_error;
  std::optional<double> covered; ///< as in Extraction
  double domain_error = 0;       ///< mesh units
  LimitedBy limited_by = LimitedBy::kNothing;
  /// Whether this is the mesh that was asked for. If not, `limited_by` says why: the time was up, or blocks could not
  /// be had (yet), see Extraction::complete. The mesh is conforming, its errors are those stated here, and the next
  /// update with the same request goes on.
  bool complete = true;
  std::span<const BlockFailure> failures; ///< as in Extraction
  double seconds = 0;                     ///< wall time of the call
  /// Whether tets, faces and vertices were moved to the first slots; `changed_...` then have all slots in use, and the
  /// arrays are shorter as a rule. That happens when the update is complete and of more than 4096 tet slots less than
  /// one in four is used (it costs a look at all slots and records), and when the session started over, see update().
  /// Otherwise what stays in the mesh keeps its slot.
  bool renumbered = false;
};

/// One viewer's mesh. Any number of sessions may share a dataset, each used by one thread at a time.
class Session {
public:
  static constexpr std::uint32_t kUnused = 0xFFFFFFFF;

  /// Holds the base mesh; reads nothing. Throws Error: kBadArgument without a dataset, kIo in a process that was forked
  /// from that of the dataset; std::bad_alloc.
  explicit Session(std::shared_ptr<const Dataset> dataset);
  ~Session();
  /// Of one that was moved from nothing may be asked.
  Session(Session&&) noexcept;
  Session& operator=(Session&&) noexcept;

  /// Makes the mesh that answers `request`: once it is complete, that of Dataset::extract(request), whatever came
  /// before. Reads the blocks that it needs, and keeps them in memory. Where they were dropped all the same (see
  /// OpenOptions::memory_limit; or a damaged block was met), it starts over from the base mesh, see
  /// SessionUpdate::renumbered.
  ///
  /// Returns what changed; valid until the next update.
  /// Throws what extract throws, and Error(kBadArgument) for Request::input_order. A request that is refused
  /// (kBadArgument, before `progress` is asked) leaves the mesh as it was. So does one that is cancelled (kCancelled),
  /// unless the session had to start over; what it has read is there for the next one. Whatever else is thrown, as for
  /// want of memory or by `progress` itself, leaves slots that must not be used before the next update, which starts
  /// over.
  /// `progress` is called first and then as by extract: while blocks are read or waited for, not while the mesh
  /// changes, which Request::max_milliseconds bounds. It must not use the session; asking the dataset for more there
  /// may throw kBadArgument.
  /// Cost: proportional to what differs from the last request, and to the records of blocks of which the request wants
  /// some and not others; where a budget of size ends before them these are not looked at.
  /// Allocates memory only to read, where the mesh grows beyond what it was since it was last renumbered, which gives
  /// memory back, where it is renumbered, and where origins are asked for first.
  const SessionUpdate& update(const Request& request, const ProgressCallback& progress = {});

  // The mesh by slots, valid until the next update. In unused slots all corners are kUnused, vertices and records none.
  /// Vertex slots of the corners; positively oriented.
  [[nodiscard]] std::span<const std::array<std::uint32_t, 4>> tets() const;
  /// For each tet slot the record that made the tet, as Extraction::made_by; none for original tets and unused slots.
  /// Empty unless the last request has `origins`. Dataset::origin_values tells errors and levels by it.
  /// Cost: the first request that asks for it takes a look at all records, whatever time it has, and some 80 bytes a
  /// vertex of the original; from then on no more than the change of the mesh itself.
  [[nodiscard]] std::span<const RecordId> made_by() const;
  /// Vertex slots of the corners; oriented outward.
  [[nodiscard]] std::span<const std::array<std::uint32_t, 3>> boundary_faces() const;
  /// For each vertex slot its id in the file, as Extraction::vertex_in_file; none for unused slots.
  [[nodiscard]] std::span<const VertexId> vertex_in_file() const;
  /// A row for each vertex slot; rows of unused slots mean nothing.
  [[nodiscard]] const PointArray& positions() const;
  [[nodiscard]] std::span<const PointArray> point_arrays() const;

  /// The mesh without slots, in the order of Dataset::extract; before the first update the base mesh. Where the next
  /// update would start over, see update(), it is that of Dataset::extract for the last request without its budget of
  /// time.
  [[nodiscard]] Extraction extraction() const;

private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

} // namespace ptet
