#!/usr/bin/env bash
# From a fresh clone to pictures, on Debian 12: installs what is needed (apt-get, as root or through sudo), builds the
# program, fetches a real mesh with the temperature of a fire in a room, builds a .ptet file from it, takes three meshes
# out of that file, and draws them.
#
#   tools/quickstart.sh          everything lands in build/ and quickstart/; running it again is safe
#
# PTET_DATA=DIR takes the mesh from DIR/fire_ug.vtu instead of the Debian package that holds it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

out=quickstart
python=/usr/bin/python3 # Debian's own, which sees the package python3-vtk9
program=build/ptet

say() { printf '\n# %s\n' "$*"; }
run() {
  printf '$ %s\n' "$*"
  "$@"
}

# extract NAME OPTION...: a mesh out of the file, and the report on it that its picture shows.
extract() {
  local name=$1
  shift
  run "$program" extract "$out/fire_ug.ptet" -o "$out/$name.vtu" "$@"
  "$program" extract "$out/fire_ug.ptet" "$@" --json >"$out/$name.json"
}

fetch_mesh() {
  local mesh=$out/fire_ug.vtu
  if [[ -s $mesh ]]; then
    echo "$mesh is there already."
    return
  fi
  if [[ -n ${PTET_DATA:-} && -f $PTET_DATA/fire_ug.vtu ]]; then
    run cp "$PTET_DATA/fire_ug.vtu" "$mesh"
    return
  fi
  local folder
  folder=$(mktemp -d)
  # shellcheck disable=SC2064  # the folder's name is wanted as it is now
  trap "rm -rf '$folder'" EXIT
  if ! (cd "$folder" && apt-get download -q mayavi2) 2>"$folder/log"; then
    echo "The package list may be old: refreshing it."
    if [[ $(id -u) -eq 0 ]]; then apt-get update -q || true; else sudo apt-get update -q || true; fi
    if ! (cd "$folder" && apt-get download -q mayavi2) 2>"$folder/log"; then
      cat "$folder/log" >&2
      echo "quickstart.sh: could not download the Debian package mayavi2, which holds the example mesh." >&2
      echo "Put any copy of its fire_ug.vtu at $PWD/$mesh and run this again." >&2
      exit 1
    fi
  fi
  dpkg-deb -x "$folder"/mayavi2_*.deb "$folder/unpacked"
  local found
  found=$(find "$folder/unpacked" \( -name fire_ug.vtu -o -name fire_ug.vtu.gz \) -print -quit)
  case "$found" in
    *.gz) gzip -dc "$found" >"$mesh.part" && mv "$mesh.part" "$mesh" ;;
    *.vtu) cp "$found" "$mesh.part" && mv "$mesh.part" "$mesh" ;;
    *) echo "quickstart.sh: this version of the package mayavi2 holds no fire_ug.vtu." >&2; exit 1 ;;
  esac
  echo "Fetched $mesh."
}

# On a virtual display, so that it works everywhere and no window opens.
picture() {
  xvfb-run -a "$python" tools/python/picture.py "$@"
}

say "1. What has to be installed"
tools/install-dependencies.sh

say "2. The program"
configure_log=$(mktemp)
CMAKE_GENERATOR=${CMAKE_GENERATOR:-Ninja} cmake -S . -B build -DCMAKE_BUILD_TYPE=Release >"$configure_log" 2>&1 ||
  { cat "$configure_log" >&2; exit 1; }
rm -f "$configure_log"
cmake --build build --parallel "$(nproc)" --target ptet_cli

say "3. A mesh: air, smoke and temperature of a fire in a room with a door"
mkdir -p "$out"
fetch_mesh

say "4. One file with all its levels of detail; the errors that count are those of the temperature t"
run "$program" build "$out/fire_ug.vtu" -o "$out/fire_ug.ptet" --field t

say "5. A coarse mesh: at most 5% of the vertices, the best that the file has for that"
extract coarse --vertices 5%

say "6. An error-bounded mesh: as few tetrahedra as 2% of the temperature's range allow"
extract bounded --field-error 2%

say "7. A focus: the original, bit for bit, in a box at the fire, and coarse everywhere else"
box=0,1.2,0,1.2,2.2,1.2
extract focus --focus box:$box

say "8. Pictures"
common=(--field t --clip y:1.7 --range "298,600")
picture "$out/coarse.vtu" "${common[@]}" --title "Coarse: 5% of the vertices" \
  --report "$out/coarse.json" -o "$out/coarse.png"
picture "$out/bounded.vtu" "${common[@]}" --title "Bounded: 2% of the range of t" \
  --report "$out/bounded.json" -o "$out/bounded.png"
picture "$out/focus.vtu" "${common[@]}" --title "Focus: the original inside the blue box" --box $box \
  --report "$out/focus.json" -o "$out/focus.png"
"$program" extract "$out/fire_ug.ptet" -o "$out/original.vtu" >/dev/null # nothing is asked of it: the whole mesh
picture "$out/original.vtu" "$out/coarse.vtu" "$out/bounded.vtu" "$out/focus.vtu" "${common[@]}" \
  --title Original --title Coarse --title Bounded --title Focus \
  --report - --report "$out/coarse.json" --report "$out/bounded.json" --report "$out/focus.json" \
  --box $box --box-on 4 --columns 2 --size 900x560 -o "$out/side-by-side.png"
for name in coarse bounded focus side-by-side; do echo "$PWD/$out/$name.png"; done
