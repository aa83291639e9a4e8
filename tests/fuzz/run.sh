#!/usr/bin/env bash
# Fuzzes for long: every target with clang's libFuzzer under address and undefined-behaviour sanitizers, one after the
# other, from its seeds, the inputs in corpus/ and what earlier runs have found.
#
#   tests/fuzz/run.sh [--keep] [SECONDS [TARGET...]]      60 s a target when nothing is said
#
# Prints for each target executions, edges and features covered, inputs kept and processor time. What breaks a promise
# is left in build-fuzz/findings: mend the fault and put the input, under a name that says what it was, into
# corpus/TARGET, from where every run of the tests replays it.
#
# --keep: refills corpus/TARGET with the smallest inputs that cover what was found, some 5 kB for each target; named
# ones stay. To be done anew when the format changes, since inputs of the old one no longer get far.
#
# Needs clang-14 and its runtime (Debian: clang-14 libclang-rt-14-dev), or what CC and CXX name.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$here/../..
build=${PTET_FUZZ_BUILD:-$root/build-fuzz}
kept_bytes=5000

keep=no
if [[ ${1:-} == --keep ]]; then keep=yes; shift; fi
seconds=${1:-60}
if (($# > 0)); then shift; fi

launcher=()
if command -v ccache >/dev/null; then launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
if [[ ! -f $build/CMakeCache.txt ]]; then
  CC=${CC:-clang-14} CXX=${CXX:-clang++-14} cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_CXX_FLAGS_RELEASE="-O1 -g1" -DPTET_FUZZ=ON -DPTET_WARNINGS_AS_ERRORS=OFF "${launcher[@]}"
fi
cmake --build "$build" --target fuzz_long fuzz_replay --parallel "$(nproc)"

targets=("$@")
if ((${#targets[@]} == 0)); then mapfile -t targets < <("$build/fuzz_replay" --list); fi
mkdir -p "$build/findings"
export UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1
findings=0
printf '%-13s %12s %8s %9s %7s %7s\n' target executions edges features inputs 'cpu s'
for target in "${targets[@]}"; do
  corpus=$build/corpus/$target
  log=$build/findings/$target.log
  mkdir -p "$corpus" "$here/corpus/$target"
  "$build/fuzz_replay" --seeds "$target" "$corpus"
  options=(-max_total_time="$seconds" -max_len=20000 -timeout=60 -rss_limit_mb=2048 -malloc_limit_mb=256
    -print_final_stats=1 -artifact_prefix="$build/findings/$target-" -verbosity=1)
  unset ASAN_OPTIONS
  if [[ $target == import ]]; then # VTK asks for what a file announces, and keeps what it has when it gives up
    options+=(-malloc_limit_mb=1000000) # 0 would be the limit on what is resident
    # Freed, what was never touched still costs an eighth of its size: the sanitizer marks it.
    export ASAN_OPTIONS=allocator_may_return_null=1:detect_leaks=0:max_allocation_size_mb=4000
  fi
  before=$(awk '{print $16 + $17}' /proc/$$/stat)
  PTET_FUZZ_TARGET=$target "$build/fuzz_long" "${options[@]}" "$corpus" "$here/corpus/$target" >"$log" 2>&1 || {
    findings=1
    echo "$target: a finding, see $log" >&2
    grep -aE -m 3 'broken promise|ERROR|SUMMARY|runtime error' "$log" >&2 || true
  }
  after=$(awk '{print $16 + $17}' /proc/$$/stat)
  cpu=$(((after - before) / $(getconf CLK_TCK)))
  executions=$(awk '/^stat::number_of_executed_units/ {print $2}' "$log")
  last=$(grep -aE '^#[0-9]+' "$log" | grep -a 'cov:' | tail -1)
  edges=$(sed -E 's/.*cov: ([0-9]+).*/\1/' <<<"$last")
  features=$(sed -E 's/.*ft: ([0-9]+).*/\1/' <<<"$last")
  printf '%-13s %12s %8s %9s %7s %7s\n' "$target" "${executions:-?}" "$edges" "$features" \
    "$(find "$corpus" -type f | wc -l)" "$cpu"

  if [[ $keep == yes ]]; then
    merged=$(mktemp -d)
    PTET_FUZZ_TARGET=$target "$build/fuzz_long" -merge=1 -max_len=2000 -rss_limit_mb=2048 -detect_leaks=0 "$merged" \
      "$corpus" >>"$log" 2>&1
    find "$here/corpus/$target" -type f -regextype posix-extended -regex '.*/[0-9a-f]{40}' -delete
    find "$merged" -type f -printf '%s %p\n' | sort -n | while read -r size path; do
      kept_bytes=$((kept_bytes - size))
      if ((kept_bytes >= 0)); then cp "$path" "$here/corpus/$target/"; fi
    done
    rm -rf "$merged"
  fi
done
exit $findings
