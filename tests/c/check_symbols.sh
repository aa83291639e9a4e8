#!/usr/bin/env bash
# Every function that ptet.h and ptet_build.h declare is defined, under its plain C name, in the library that goes with
# the header, and c_interface_test.c calls it.
#
#   check_symbols.sh LIBPTET LIBPTET_BUILD
set -euo pipefail
here=$(dirname "${BASH_SOURCE[0]}")
include=$here/../../lib/include/ptet

wrong=0
fail() {
  echo "check_symbols.sh: $*" >&2
  wrong=1
}
# check HEADER LIBRARY: a shared library must have the functions among what it exports.
check() {
  local functions symbols dynamic=()
  if [[ $2 == *.so* ]]; then dynamic=(-D); fi
  # Comments and typedefs out, then each name before an opening parenthesis.
  functions=$(gcc -fpreprocessed -dD -E -P -x c "$1" 2>/dev/null | grep -v '^typedef' |
    grep -oE '\bptet_[a-z_]+\(' | tr -d '(' | sort -u)
  symbols=$(nm --defined-only "${dynamic[@]}" "$2" 2>/dev/null | awk '$2 == "T" { print $3 }' | sort -u)
  [[ $(wc -l <<<"$functions") -gt 10 ]] || fail "found hardly any function in $1"
  local name
  for name in $functions; do
    grep -qx "$name" <<<"$symbols" || fail "$2 has no $name"
    grep -q "\b$name(" "$here/c_interface_test.c" || fail "no test calls $name"
  done
}
check "$include/ptet.h" "$1"
check "$include/ptet_build.h" "$2"
exit $wrong
