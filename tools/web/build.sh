#!/usr/bin/env bash
# Makes the page: tools/web/dist/, which any static server with range requests can serve.
#
#   tools/web/build.sh
#
# Needs what tools/install-dependencies.sh --web installs, and the network the first time: zstd's decoder comes from
# Debian's source package (through apt-get, which checks its signature; no root), three.js from the npm registry (at the
# version and hash that package-lock.json names). Nothing is installed; all goes to tools/web/build, dist, node_modules.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

for program in emcmake cmake ninja npm apt-get xz; do
  if ! command -v "$program" >/dev/null; then
    echo "build.sh: there is no $program here; run tools/install-dependencies.sh --web" >&2
    exit 1
  fi
done
mkdir -p build dist/three

# ---- zstd's decoder ----

fetch_zstd() {
  local work=$PWD/build/apt
  rm -rf "$work" build/zstd
  mkdir -p "$work"/{parts,lists/partial,cache/archives/partial,source}
  # This machine's own package sources, asked for source packages.
  local file
  for file in /etc/apt/sources.list.d/*.sources; do
    if [[ -f $file ]]; then sed 's/^Types:.*/Types: deb-src/' "$file" >"$work/parts/${file##*/}"; fi
  done
  for file in /etc/apt/sources.list /etc/apt/sources.list.d/*.list; do
    if [[ -f $file ]]; then sed -n 's/^deb[[:space:]]/deb-src /p' "$file" >"$work/parts/${file##*/}.list"; fi
  done
  local apt=(apt-get -q -o Dir::Etc::SourceList=/dev/null -o Dir::Etc::SourceParts="$work/parts"
    -o Dir::State::Lists="$work/lists" -o Dir::Cache="$work/cache" -o APT::Sandbox::User=)
  "${apt[@]}" update || echo "build.sh: some package sources cannot be had; going on without them" >&2
  (cd "$work/source" && "${apt[@]}" source --download-only libzstd)
  mkdir build/zstd.part
  tar -C build/zstd.part --strip-components=1 -xf "$work"/source/libzstd_*.orig.tar.xz
  mv build/zstd.part build/zstd
  rm -rf "$work"
}
rm -rf build/zstd.part
if [[ ! -d build/zstd ]]; then fetch_zstd; fi

# ---- headers of the machine that hold for WebAssembly, too, and no others ----

mkdir -p build/headers
ln -sfn /usr/include/boost build/headers/boost
ln -sf /usr/include/xxhash.h /usr/include/xxh3.h build/headers/

# ---- the library ----

# Debian's emscripten finds its modules where Debian's node looks for them, and another node does not.
export NODE_PATH=/usr/share/nodejs:/usr/lib/nodejs
launcher=()
if command -v ccache >/dev/null; then
  launcher=(-DCMAKE_C_COMPILER_LAUNCHER=ccache -DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
fi
emcmake cmake -S . -B build/wasm -G Ninja -DCMAKE_BUILD_TYPE=Release -DPTET_WEB_HEADERS="$PWD/build/headers" \
  -DPTET_WEB_ZSTD="$PWD/build/zstd/lib" "${launcher[@]}" >build/configure.log 2>&1 || { cat build/configure.log >&2; exit 1; }
cmake --build build/wasm --parallel "$(nproc)"

# ---- three.js ----

if [[ ! -f node_modules/three/package.json || package-lock.json -nt node_modules/.package-lock.json ]]; then
  npm ci --no-audit --no-fund --ignore-scripts
fi

# ---- the page ----

cp page/* build/wasm/ptet.js build/wasm/ptet.wasm dist/
cp node_modules/three/build/three.{module,core}.min.js node_modules/three/examples/jsm/controls/OrbitControls.js \
  node_modules/three/LICENSE dist/three/
cp build/zstd/LICENSE dist/zstd-LICENSE
echo "The page is in tools/web/dist: $(du -sh dist | cut -f1)"
