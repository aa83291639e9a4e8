// What has been measured of collapses that were then put back: a version's errors do not depend on what is around it,
// so they hold for as long as the tet stays from which it would come. Nothing is decided by it but the time that a
// build takes.
#pragma once

#include "build/working_complex.hpp"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace ptet::build {

/// What has been measured, to the end, of the versions that half-edges of one vertex would make.
struct KnownVersions {
  struct Key {
    std::uint32_t fine; ///< version that it would come from
    Vertex target;
  };
  std::vector<Key> keys;
  std::vector<double> values; ///< for each: the errors (fractions of the ranges, one a field), then as Trial::measure()
  bool takes_more = true;     ///< whether what is measured from now on joins it

  /// With what the three allocations of it add.
  [[nodiscard]] std::size_t bytes() const {
    return sizeof *this + keys.capacity() * sizeof(Key) + values.capacity() * sizeof(double) + 3 * std::size_t{16};
  }
};

/// The known versions of all vertices, within a room that the owner sets. Several threads may use it, each with
/// vertices of its own.
class KnownOfVertices {
public:
  explicit KnownOfVertices(std::uint32_t vertices) : known_(vertices) {}

  /// Nothing joins what is known while it takes up so many bytes; 0: nothing is kept. Not while others use it: what has
  /// been forgotten goes back to the system once it is half of what there was.
  void set_room(std::size_t bytes);
  /// For Trial::measure(), and then to be settled or forgotten; null where nothing is known and there is no room.
  [[nodiscard]] KnownVersions* of(Vertex v);
  /// What has been added takes up no more than it has to, and counts.
  void settle(Vertex v);
  void forget(Vertex v);

private:
  struct Counted : KnownVersions {
    std::size_t counted = 0; ///< bytes of it that are in `held_`
  };

  std::vector<std::unique_ptr<Counted>> known_;
  std::atomic<std::size_t> held_ = 0;
  std::size_t room_ = 0;
  std::size_t most_ = 0; ///< held at once since something was last given back
};

} // namespace ptet::build
