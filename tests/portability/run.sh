#!/usr/bin/env bash
# Whether machines of another byte order and of 32 bits make the same of .ptet files: builds the run-time library and
# decode.cpp for this machine, for s390x (big-endian, 64 bits) and for i386 (little-endian, 32 bits), runs all of them
# over the golden files and the worked example, those of other machines in qemu, and compares what they print.
#
#   tests/portability/run.sh [FILE.ptet...]      more files to look at
#
# Needs what tools/install-dependencies.sh --portability installs, and the network the first time: zstd and xxHash for
# these machines are downloaded by apt-get and unpacked, not installed, in build-portability. PTET_JOBS: how many compilers
# run at a time.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(cd "$here/../.." && pwd)
build=$root/build-portability
files=("$root"/tests/golden/*.ptet "$root"/formats/ptet/example.ptet "$@")

fail() {
  echo "run.sh: $*" >&2
  exit 1
}
for program in cmake ninja apt-get dpkg-deb {s390x,i686}-linux-gnu-g++ qemu-{s390x,i386}-static; do
  command -v "$program" >/dev/null || fail "there is no $program here; run tools/install-dependencies.sh --portability"
done
launcher=()
if command -v ccache >/dev/null; then
  launcher=(-DCMAKE_C_COMPILER_LAUNCHER=ccache -DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
fi
mkdir -p "$build"

# The static libraries of another architecture, by lists of packages of our own: this machine's stay as they are.
fetch_libraries() {
  local architecture=$1 work=$build/apt/$1
  rm -rf "$work" "${build:?}/$architecture"
  mkdir -p "$work"/{state/lists/partial,cache/archives/partial,packages}
  touch "$work/state/status"
  local apt=(apt-get -q -o "APT::Architecture=$architecture" -o "APT::Architectures::=$architecture"
    -o "Dir::State=$work/state" -o "Dir::State::status=$work/state/status" -o "Dir::Cache=$work/cache"
    -o APT::Sandbox::User=)
  "${apt[@]}" update || echo "run.sh: some package sources cannot be had; going on without them" >&2
  (cd "$work/packages" && "${apt[@]}" download libzstd-dev libxxhash-dev)
  local package
  for package in "$work"/packages/*.deb; do
    dpkg-deb -x "$package" "$build/$architecture.part"
  done
  find "$build/$architecture.part" -name '*.so' -delete # what they lead to is not here
  mv "$build/$architecture.part" "$build/$architecture"
  rm -rf "$work"
}

make_decoder() { # FOLDER CMAKE-ARGUMENT...
  local folder=$build/$1
  shift
  cmake -S "$here" -B "$folder" -G Ninja -DCMAKE_BUILD_TYPE=Release "${launcher[@]}" "$@" >"$folder.log"
  cmake --build "$folder" --parallel "${PTET_JOBS:-$(nproc)}" --target decode >>"$folder.log" || { tail -n 50 "$folder.log" >&2; fail "see $folder.log"; }
}

make_cross_decoder() { # ARCHITECTURE TRIPLET PROCESSOR
  local architecture=$1 triplet=$2 processor=$3 sysroot=$build/$1
  [[ -d $sysroot ]] || fetch_libraries "$architecture"
  local headers=$sysroot/headers
  mkdir -p "$headers"
  ln -sfn /usr/include/boost "$headers/boost" # the same for all machines
  local libraries
  libraries=$(dirname "$(find "$sysroot/usr/lib" -name libzstd.a)")
  PKG_CONFIG_LIBDIR=$libraries/pkgconfig PKG_CONFIG_SYSROOT_DIR=$sysroot make_decoder \
    "$architecture-build" -DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR="$processor" \
    -DCMAKE_C_COMPILER="$triplet-gcc" -DCMAKE_CXX_COMPILER="$triplet-g++" -DCMAKE_EXE_LINKER_FLAGS="-static -L$libraries" \
    -DBoost_NO_BOOST_CMAKE=ON -DBoost_INCLUDE_DIR="$headers"
}

echo "building for this machine, s390x and i386"
make_decoder native
make_cross_decoder s390x s390x-linux-gnu s390x
make_cross_decoder i386 i686-linux-gnu i686

"$build/native/decode" "${files[@]}" >"$build/native.txt"
differs=0
for architecture in s390x i386; do
  text=$build/$architecture.txt
  "qemu-$architecture-static" "$build/$architecture-build/decode" "${files[@]}" >"$text" || true
  if cmp -s "$build/native.txt" "$text"; then
    echo "$architecture: the same of ${#files[@]} files, $(wc -l <"$text") lines"
  else
    echo "$architecture: not the same; diff $build/native.txt $text:"
    diff "$build/native.txt" "$text" | head -n 20 || true
    differs=1
  fi
done
exit "$differs"
