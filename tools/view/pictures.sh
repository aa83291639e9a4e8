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
"$program" build "$mesh" -o "$out/bluntfin.ptet" --field Density --method QN --evaluate vertices

# The fin stands at the left of the far side (small x, small y); the shock before it is where Density changes.
focus=sphere:-0.4,0,1.2,1.6
camera=eye=-6,-19,8:at=1.6,1,2.1:angle=24
common=(--error none --focus "$focus" --colour Density --range 0.2..2.5 --camera "$camera" --size 1600x1000)
"$program" view "$out/bluntfin.ptet" "${common[@]}" --show surface --screenshot "$out/focus.png"
"$program" view "$out/bluntfin.ptet" "${common[@]}" --show cells --plane -y:0.7 --screenshot "$out/cells.png"
"$program" view "$out/bluntfin.ptet" "${common[@]}" --show slice --plane y:0.4 --split --screenshot "$out/split.png"
"$program" view "$out/bluntfin.ptet" "${common[@]}" --show cells --plane -y:0.7 --colour level \
  --screenshot "$out/level.png"
echo "$out/focus.png $out/cells.png $out/split.png $out/level.png"
