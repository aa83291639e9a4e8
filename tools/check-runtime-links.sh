#!/usr/bin/env bash
# The run-time library needs no OpenMesh, VTK, CGAL, TBB nor compiled Boost library: no source of it includes them, and
# a program that reads a file links with zstd and xxHash alone.
#
#   tools/check-runtime-links.sh BUILD-FOLDER        (built with Ninja, which knows what each source includes)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

build=${1:?usage: check-runtime-links.sh BUILD-FOLDER}
fail() {
  echo "check-runtime-links.sh: $*" >&2
  exit 1
}

includes=$(ninja -C "$build" -t deps | awk '/^[^ ]/ { ours = /ptet_runtime\.dir/ } ours')
[[ $includes == *ptet/mesh.hpp* ]] || fail "$build holds no Ninja build of the run-time library"
if grep -E '/(OpenMesh|CGAL|vtk-[0-9.]+|tbb|oneapi)/' <<<"$includes"; then
  fail "the run-time library includes what it must not"
fi

library=$(find "$build" \( -name libptet.a -o -name libptet.so \) -print -quit)
[[ -n $library ]] || fail "no libptet in $build"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
read -ra codecs < <(pkg-config --libs libzstd libxxhash)
# --whole-archive: every object of the library takes part, not only what this program happens to use.
"${CXX:-c++}" -std=c++20 -Ilib/include tests/install/consumer/cut_file.cpp -o "$folder/reader" \
  -Wl,--whole-archive "$library" -Wl,--no-whole-archive "${codecs[@]}" -pthread
if ldd "$folder/reader" | grep -iE 'openmesh|vtk|boost|tbb|gmp|mpfr'; then
  fail "the run-time library links what it must not"
fi
