#!/usr/bin/env bash
# How much of the library its tests run: lines and branches of each folder, by gcovr. A build of its own
# (build-coverage), without the programs and VTK.
#
#   tools/coverage.sh             builds, runs the tests, prints the table
#   tools/coverage.sh --files     also each file, with the lines that no test runs
#   tools/coverage.sh --branches  also each file, with the lines of which a branch is not taken
#
# Not counted are branches that only an exception takes (every call has one) and those on lines without code: gcovr's
# --exclude-throw-branches and --exclude-unreachable-branches. PTET_COVERAGE_TESTS: which programs to run.
# PTET_JOBS: how many compilers run at a time.
# Needs what tools/install-dependencies.sh --coverage installs.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
build="build-coverage"
log=$build/log.txt
detail=${1:-}
folders=(lib/lod lib/record formats/ptet lib/error lib/build lib/mesh lib/capi)
read -ra programs <<<"${PTET_COVERAGE_TESTS:-unit_tests golden_tests fuzz_tests build_property_tests \
cut_property_tests session_property_tests fuzz_replay memory_limit_test c_interface_test out_of_memory_test}"

case $detail in
  '' | --files | --branches) ;;
  *) sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"; exit 2 ;;
esac
command -v gcovr >/dev/null || { echo "coverage.sh: no gcovr; run tools/install-dependencies.sh --coverage" >&2; exit 1; }

mkdir -p $build
cmake -S . -B $build -G Ninja -DCMAKE_BUILD_TYPE=Debug -DPTET_BUILD_TOOLS=OFF -DPTET_BUILD_EXAMPLES=OFF \
  -DPTET_PYTHON=OFF -DPTET_WARNINGS_AS_ERRORS=OFF -DCGAL_DO_NOT_WARN_ABOUT_CMAKE_BUILD_TYPE=ON \
  -DCMAKE_CXX_FLAGS_DEBUG="-O1 -g1 --coverage -fprofile-abs-path -fprofile-exclude-files=/usr/" \
  -DCMAKE_EXE_LINKER_FLAGS=--coverage -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=6 >$log
cmake --build $build --parallel "${PTET_JOBS:-$(nproc)}" --target "${programs[@]}" >>$log || { tail -n 30 $log >&2; exit 1; }
find $build -name '*.gcda' -delete

# The counters are not atomic: each program keeps to one processor, and as many run at a time as there are.
list_runs() {
  local program target source
  for program in "${programs[@]}"; do
    case $program in
      fuzz_replay)
        $build/fuzz_replay --list | while read -r target; do
          echo "fuzz_replay $target 200 tests/fuzz/corpus/$target"
        done
        ;;
      *_property_tests) # the other's files have no tests in this one
        for source in tests/property/*_property.cpp; do
          [[ $source == *real_cuts* ]] || echo "$program --filenames-as-tags [#$(basename "$source" .cpp)]"
        done
        ;;
      *) echo "$program" ;;
    esac
  done
}
run_on() { # PROCESSOR: every run whose turn it is
  local line number=0
  while read -r line; do
    if ((number++ % $(nproc) != $1)); then continue; fi
    # shellcheck disable=SC2086 # words are arguments
    PTET_DATA=/nonexistent taskset --cpu-list "$1" $build/$line >$build/run-"$1".log 2>&1 ||
      { tail -n 30 $build/run-"$1".log >&2; echo "coverage.sh: $line fails" >&2; exit 1; }
  done < <(list_runs)
}
processes=()
for ((processor = 0; processor < $(nproc); ++processor)); do
  run_on "$processor" &
  processes+=($!)
done
for process in "${processes[@]}"; do wait "$process"; done

gcovr --root . --object-directory $build --exclude-throw-branches --exclude-unreachable-branches --filter 'lib/' \
  --filter 'formats/ptet/' -j "$(nproc)" --json $build/coverage.json $build/lib $build/formats >>$log 2>&1 ||
  { tail -n 30 $log >&2; exit 1; }
printf '%-14s %8s %9s\n' folder lines branches
for folder in "${folders[@]}"; do
  gcovr --root . --add-tracefile $build/coverage.json --filter "$folder/" --json-summary $build/summary.json
  python3 - "$folder" $build/summary.json <<'END'
import json
import sys
found = json.load(open(sys.argv[2], encoding="utf-8"))
print(f"{sys.argv[1]:14} {found['line_percent']:7.1f}% {found['branch_percent']:8.1f}%")
END
done
case $detail in
  --files) gcovr --root . --add-tracefile $build/coverage.json ;;
  --branches) gcovr --root . --add-tracefile $build/coverage.json --branches ;;
esac
