#!/usr/bin/env bash
# Makes tools/web/screenshot.png: bluntfin cut open, a focus box at the shock before the fin, the original inside and
# 30% of the field's range allowed outside.
#
#   tools/web/screenshot.sh [BLUNTFIN.vtu]      by default bluntfin.vtu in PTET_DATA
#
# Needs build/ptet (or PTET) and tools/install-dependencies.sh --web.
set -euo pipefail
mesh=$(realpath "${1:-${PTET_DATA:-$(dirname "${BASH_SOURCE[0]}")/../../../shared/data}/bluntfin.vtu}")
cd "$(dirname "${BASH_SOURCE[0]}")"

./build.sh
npm ls playwright-core >/dev/null 2>&1 || npm ci --no-audit --no-fund --ignore-scripts
mkdir -p build/screenshot
"${PTET:-../../build/ptet}" build "$mesh" -o build/screenshot/bluntfin.ptet --field Density --quiet
node screenshot.js build/screenshot screenshot.png \
  "file=bluntfin.ptet&error=0.3&focus=-3,0,1.4,1,2.2,3.2&axis=z&plane=0.4&flip=0&show=surface,cut,edges&camera=-1.05,-1.8,1.7,-0.08,-0.1,-0.2"
echo "The picture is tools/web/screenshot.png"
