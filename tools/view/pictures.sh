#!/usr/bin/env bash
# Makes the documentation's pictures of the viewer: bluntfin, coarse, with a focus whose inside is the original.
#
#   tools/view/pictures.sh bluntfin.vtu [FOLDER]      pictures land in FOLDER (pictures)
#
# Takes build/ptet; needs no display (Xvfb makes one).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

[[ $# -ge 1 && $# -le 2 ]] || { sed -n '2,6s/^# \{0,1\}//p' "$0" >&2; exit 2; }
mesh=$1
out=${2:-pictures}
program=build/ptet

mkdir -p "$out"
[[ -s $out/bluntfin.ptet ]] || "$program" build "$mesh" -o "$out/bluntfin.ptet" --field Density --method QN --evaluate vertices

# The flow comes from the left, in front of the blunt fin the density is highest: red. Behind that the box.
common=(--error none --focus "box:1,0,1,4,2.2,4" --range 0.2..2.5 --size 1600x1000)
near="eye=-5,-20,9:at=3,1,2.4:angle=27"
far="eye=1,-26,10:at=3,1,2.4:angle=40"
picture() {
  local name=$1
  shift
  "$program" view "$out/bluntfin.ptet" "${common[@]}" "$@" --screenshot "$out/$name.png"
  echo "$out/$name.png"
}
picture focus --colour Density --camera "$near" --show cells --plane -y:1
picture surface --colour Density --camera "$near" --show surface
picture split --colour Density --camera "$far" --show slice --plane y:1 --split
picture level --camera "$near" --show cells --plane -y:1 --colour level
