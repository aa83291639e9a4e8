#!/usr/bin/env bash
# Installs what ptet needs on Debian 12 (or a relative of it), through apt-get. Only packages that are missing are
# installed, so the script is quick and needs no rights when there is nothing to do.
#
#   tools/install-dependencies.sh            to build the program and to draw pictures
#   tools/install-dependencies.sh --tests    also what tools/test.sh and .ci/run need
#   tools/install-dependencies.sh --python   also what the Python module and its examples need
#   tools/install-dependencies.sh --bench    also what tools/bench needs
#   tools/install-dependencies.sh --mpi      also what the CMake option PTET_BUILD_MPI needs
#   tools/install-dependencies.sh --paraview instead: what tools/paraview needs (ParaView's Python excludes VTK's)
#   tools/install-dependencies.sh --web      also what tools/web needs, to build the page and to test it
#   tools/install-dependencies.sh --fuzz     also what tests/fuzz/run.sh needs
#   tools/install-dependencies.sh --coverage    also what tools/coverage.sh needs
#   tools/install-dependencies.sh --portability also what tests/portability/run.sh needs
#   tools/install-dependencies.sh --list     prints the packages that it would install, and stops
set -euo pipefail

packages=(
  g++ cmake ninja-build pkg-config
  libvtk9-dev        # mesh files in and out
  libcgal-dev        # exact predicates
  libopenmesh-dev    # boundary surface
  libboost-dev       # Boost.Serialization and containers, headers only
  libeigen3-dev      # small dense linear algebra
  libtbb-dev         # threads
  libzstd-dev        # block compression
  libxxhash-dev      # block hashes
  libcli11-dev       # command line
  nlohmann-json3-dev # JSON output
  catch2             # tests
  python3 python3-numpy python3-vtk9
  xvfb xauth         # pictures on a machine without a display
)
test_packages=(clang clang-format clang-tidy libclang-rt-dev shellcheck git python3-meshio python3-zstandard python3-xxhash)
python_packages=(pybind11-dev python3-dev python3-pip python3-venv python3-matplotlib)
paraview_packages=(g++ cmake ninja-build pkg-config libboost-dev libzstd-dev libxxhash-dev paraview-dev
  python3-paraview libopenmpi-dev mpi-default-bin libgl1-mesa-dri xvfb xauth)
mpi_packages=(libopenmpi-dev openmpi-bin)
test_packages+=("${python_packages[@]}" "${mpi_packages[@]}" mypy) # mypy: the module's types
bench_packages=(libbenchmark-dev python3-matplotlib python3-zstandard)
web_packages=(
  emscripten nodejs # the library in WebAssembly
  xz-utils          # zstd's decoder, from its source package
  chromium          # the page's test
)
command -v npm >/dev/null || web_packages+=(npm) # a newer node than Debian's brings its own, and refuses Debian's
fuzz_packages=(clang-14 libclang-rt-14-dev)
coverage_packages=(gcovr)
portability_packages=(g++-s390x-linux-gnu g++-i686-linux-gnu qemu-user-static) # of other machines: compilers, and to run

list_only=no
for argument in "$@"; do
  case "$argument" in
    --tests) packages+=("${test_packages[@]}") ;;
    --python) packages+=("${python_packages[@]}") ;;
    --bench) packages+=("${bench_packages[@]}") ;;
    --mpi) packages+=("${mpi_packages[@]}") ;;
    --paraview) packages=("${paraview_packages[@]}") ;;
    --web) packages+=("${web_packages[@]}") ;;
    --fuzz) packages+=("${fuzz_packages[@]}") ;;
    --coverage) packages+=("${coverage_packages[@]}") ;;
    --portability) packages+=("${portability_packages[@]}") ;;
    --list) list_only=yes ;;
    -h | --help) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit 0 ;;
    *) echo "install-dependencies.sh: unknown option $argument (see --help)" >&2; exit 2 ;;
  esac
done

if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
  echo "install-dependencies.sh: no apt-get here. Install these yourself: ${packages[*]}" >&2
  exit 1
fi

missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null || true)
  [[ $status == installed* ]] || missing+=("$package")
done
if [[ $list_only == yes ]]; then
  printf '%s\n' "${missing[@]}"
  exit 0
fi
if [[ ${#missing[@]} -eq 0 ]]; then
  echo "Every package is installed already."
  exit 0
fi

as_root=()
if [[ $(id -u) -ne 0 ]]; then
  if ! command -v sudo >/dev/null; then
    echo "install-dependencies.sh: not root, and no sudo. As root, run: apt-get install ${missing[*]}" >&2
    exit 1
  fi
  as_root=(sudo)
fi

echo "Installing: ${missing[*]}"
run_apt() { "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -y -q "$@" </dev/null; }
if ! run_apt update; then
  echo "install-dependencies.sh: apt-get update failed; is the network there, and /etc/apt in order?" >&2
  exit 1
fi
if ! run_apt install --no-install-recommends "${missing[@]}"; then
  echo "install-dependencies.sh: apt-get could not install: ${missing[*]}" >&2
  exit 1
fi
