#!/usr/bin/env bash
# The one-way arrows of the house: which folder may include what. Prints each include that goes the wrong way.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

wrong=0
# forbid WHY INCLUDE-PATTERN FILE...: no file may have an #include whose path matches the pattern.
forbid() {
  local why=$1 pattern=$2
  shift 2
  [[ $# -gt 0 ]] || return 0
  if grep -nE "^[[:space:]]*#[[:space:]]*include[[:space:]]*[<\"]($pattern)" "$@" /dev/null; then
    echo "  ^ $why" >&2
    wrong=1
  fi
}

sources() { find "$@" -type f \( -name '*.cpp' -o -name '*.hpp' -o -name '*.h' \) 2>/dev/null | sort; }

# What the run-time library has of formats/ptet: its sources, and what they include, and so on.
run_time_format() {
  local names all=() more=()
  names=$(sed -n 's/^set(ptet_format_run_time \(.*\))$/\1/p' formats/ptet/run_time.cmake)
  for name in $names; do more+=("formats/ptet/$name.cpp"); done
  while [[ ${#more[@]} -gt ${#all[@]} ]]; do
    all=("${more[@]}")
    mapfile -t more < <({
      printf '%s\n' "${all[@]}"
      sed -n 's/^#include "\(formats\/ptet\/.*\)"$/\1/p' "${all[@]}"
    } | sort -u)
  done
  printf '%s\n' "${all[@]}"
}

mapfile -t lod < <(sources lib/lod)
mapfile -t build < <(sources lib/build)
mapfile -t c_run_time < <(find lib/capi -name '*.?pp' ! -name build.cpp)
mapfile -t c_build < <(sources lib/capi/build.cpp)
mapfile -t python < <(sources tools/python)
mapfile -t record < <(sources lib/record)
mapfile -t ground < <(sources lib/mesh lib/error)
mapfile -t all_lib < <(sources lib)
mapfile -t all_formats < <(sources formats)
mapfile -t ptet_format < <(run_time_format)
[[ ${#ptet_format[@]} -gt 1 ]] || { echo "formats/ptet/run_time.cmake names no sources" >&2; exit 1; }
mapfile -t paraview < <(sources tools/paraview)
mapfile -t public < <(sources lib/include)

offline='OpenMesh/|vtk|CGAL/|tbb/|oneapi/|boost/(filesystem|iostreams|program_options|thread|log|regex)'
forbid "lod does not know build" 'build/|ptet/build\.hpp|formats/ptet/writer\.hpp' "${lod[@]}"
forbid "build does not know lod" 'lod/|ptet/(dataset|request|session)\.hpp|formats/ptet/reader\.hpp' "${build[@]}"
forbid "the C interface stands on the public one" '(lod|build|record|formats)/' "${c_run_time[@]}" "${c_build[@]}"
forbid "the C interface of the run-time library does not know build" 'ptet/(ptet_)?build\.h' "${c_run_time[@]}"
forbid "the C interface of the builder does not know lod" 'ptet/(dataset|request|session)\.hpp' "${c_build[@]}"
forbid "the Python module stands on the public interface" '(lib|mesh|error|lod|build|record|formats)/' "${python[@]}"
forbid "records do not know formats" 'formats/|build/|lod/' "${record[@]}"
forbid "mesh and error are the ground floor" 'formats/|build/|lod/|record/' "${ground[@]}"
forbid "the library does not know the tools" '(.*/)?tools/' "${all_lib[@]}" "${all_formats[@]}"
forbid "ParaView's reader stands on the installed library" '(lib|mesh|error|lod|build|record|formats)/' "${paraview[@]}"
forbid "public headers name no dependency" 'OpenMesh/|vtk|CGAL/|tbb/|boost/|Eigen/|zstd|xxhash' "${public[@]}"
forbid "the run-time library is small" "$offline" "${lod[@]}" "${record[@]}" "${ptet_format[@]}"
exit $wrong
