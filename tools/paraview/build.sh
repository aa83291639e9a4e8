#!/usr/bin/env bash
# Builds the run-time library and ParaView's plugin in build-paraview/ and says where the plugin is. What it needs:
# tools/install-dependencies.sh --paraview
#
#   tools/paraview/build.sh [CMAKE-OPTION...]        options of the library, such as -DBUILD_SHARED_LIBS=ON
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

build="build-paraview"
export CMAKE_GENERATOR=${CMAKE_GENERATOR:-Ninja}
cmake -S . -B $build/library -DCMAKE_BUILD_TYPE=Release -DPTET_BUILD_BUILDER=OFF -DPTET_BUILD_EXAMPLES=OFF "$@"
cmake --build $build/library --parallel "$(nproc)"
cmake --install $build/library --prefix $build/prefix
cmake -S tools/paraview -B $build/plugin -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$PWD/$build/prefix"
cmake --build $build/plugin --parallel "$(nproc)"
find "$PWD/$build/plugin" -name ptet.so
