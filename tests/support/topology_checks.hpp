// What every cut shares with the original mesh; for tests that have Catch2's main.
#pragma once

#include "support/mesh_checks.hpp"

#include <catch2/catch.hpp>

namespace ptet::test {

/// CHECKs that tets are there once, join face to face, and make the same components and boundary as the original.
inline void check_same_topology(const MeshFacts& facts, const MeshFacts& original) {
  CHECK(facts.repeated_tets == 0);
  CHECK(facts.crowded_faces == 0);
  CHECK(facts.folded_faces == 0);
  CHECK(facts.components == original.components);
  CHECK(facts.boundary_euler_characteristic == original.boundary_euler_characteristic);
}

} // namespace ptet::test
