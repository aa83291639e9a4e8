#!/usr/bin/env bash
# Builds the ParaView plugin and tests it with pvbatch in a Debian 12 of its own, because ParaView's Python and VTK's
# cannot be installed together. Must run as root (for chroot) and needs debootstrap, and the network the first time.
#
#   tools/paraview/test-in-root.sh [FOLDER]        default: build-paraview-root; it is kept, so that the next run is quick
#
# tools/bare-root.sh says where packages come from. Where bluntfin.vtu lies in PTET_DATA (default: ../shared/data beside
# the clone) and build/ptet is built, that mesh is tested and drawn as well. The pictures are left in
# FOLDER/ptet/pictures.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

root=$(realpath -m "${1:-build-paraview-root}")
data=${PTET_DATA:-../shared/data}
tools/bare-root.sh "$root" true

# The files of this working copy, and what was built before.
mkdir -p "$root/ptet/pictures"
git ls-files -z --cached --others --exclude-standard | tar --create --null --files-from - | tar -x -C "$root/ptet"
if [[ -f $data/bluntfin.vtu && -x build/ptet && ! -e $root/ptet/bluntfin.ptet ]]; then
  build/ptet build "$data/bluntfin.vtu" --field Density --quiet -o "$root/ptet/bluntfin.ptet"
fi

tools/bare-root.sh "$root" bash -euo pipefail /ptet/tools/paraview/test-here.sh
echo "pictures: $root/ptet/pictures"
