#!/usr/bin/env bash
# Installs what the tests need, builds everything (Release, in build/) and runs every test.
#
#   tools/test.sh [CTEST-ARGUMENT...]        for instance: tools/test.sh -R unit
#
# The tests on real meshes look for them in PTET_DATA, by default ../shared/data beside the clone; where there are none
# they say so and are skipped.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

tools/install-dependencies.sh --tests

CMAKE_GENERATOR=${CMAKE_GENERATOR:-Ninja} cmake -S . -B build -DCMAKE_BUILD_TYPE=Release -DPTET_BUILD_TESTS=ON \
  -DPTET_BUILD_MPI=ON
cmake --build build --parallel "$(nproc)"
ctest --test-dir build --output-on-failure --parallel "$(nproc)" "$@"
