#!/usr/bin/env bash
# Builds the ParaView plugin and tests it where ParaView is, or may be, installed: the inner half of test-in-root.sh.
# Writes into build-paraview/ and pictures/.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

tools/install-dependencies.sh --paraview
tools/paraview/build.sh -DBUILD_SHARED_LIBS=ON # the test calls the library as well
plugin=$(find "$PWD/build-paraview/plugin" -name ptet.so)
files=()
if [[ -e bluntfin.ptet ]]; then files=(bluntfin.ptet); fi
mkdir -p build-paraview/work pictures

# ParaView opens and closes its display while it starts; the server must not begin anew in between.
display() { xvfb-run -a -s '-screen 0 1280x1024x24 -noreset' "$@"; }
display pvbatch tools/paraview/test_plugin.py "$plugin" build-paraview/prefix/lib/libptet.so tests/golden \
  build-paraview/work "${files[@]}"
display mpiexec -n 2 --oversubscribe pvbatch tools/paraview/test_parallel.py "$plugin" tests/golden/real.ptet
display pvbatch tools/paraview/picture.py tests/golden/real.ptet -o pictures/real.png
if [[ -e bluntfin.ptet ]]; then
  display pvbatch tools/paraview/picture.py bluntfin.ptet -o pictures/bluntfin.png --field Density --range=0.3,2.5 \
    --box=-2,0.3,1.2,1.2,3,4 --towards=0.35,-1,0.3 --zoom 1.6
fi
ls -l pictures
