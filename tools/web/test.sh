#!/usr/bin/env bash
# Builds the page and tests it in headless Chromium; see parts_test.js and page_test.js.
#
#   tools/web/test.sh            needs build/ptet and tools/install-dependencies.sh --web --tests
#
# PTET names another program than build/ptet; PTET_DATA a folder with fire_ug.vtu, else a mesh is generated. What is made
# on the way, pictures among it, is in tools/web/build/test.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

ptet=$(realpath "${PTET:-../../build/ptet}")
started=$SECONDS
step() { printf '=== %s (%d s so far)\n' "$*" $((SECONDS - started)); }

step "The page"
./build.sh
npm ls playwright-core >/dev/null 2>&1 || npm ci --no-audit --no-fund --ignore-scripts

step "Parts of the page by themselves"
node parts_test.js

step "A file to look at"
rm -rf build/test
mkdir -p build/test/made
make_mesh() { # FILE SIZE EXPRESSION: a cube with the field that the expression makes of its points, or None
  PYTHONPATH=../../tests/cli /usr/bin/python3 -c "
from meshes import grid, vtu, wave
points, tets = grid($2)
vtu('$1', points, tets, $3)"
}
mesh=${PTET_DATA:-../../../shared/data}/fire_ug.vtu
if [[ ! -f $mesh ]]; then
  mesh=build/test/made/grid.vtu
  make_mesh "$mesh" 16 'wave(points)'
fi
"$ptet" build "$mesh" -o build/test/made/mesh.ptet --method QN --evaluate vertices --quiet
make_mesh build/test/made/bare.vtu 6 None
"$ptet" build build/test/made/bare.vtu -o build/test/bare.ptet --quiet

step "What the page shows of bounds"
node brief_up_test.js

step "The page in a browser"
node page_test.js build/test/made/mesh.ptet "$ptet" build/test

step "Done"
