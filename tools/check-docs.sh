#!/usr/bin/env bash
# Runs the documents: writes the files that they show (blocks that open with a language and a path, as in
# ```cpp a/b.cpp) into place, then runs their commands (blocks marked ```sh) in order, in one shell that stops at the first
# failure. What they make lands in build/ and quickstart/. Blocks marked ```text show what is printed and are not run.
#
#   tools/check-docs.sh [DOCUMENT...]        README.md and tools/docs/*.md if none is named
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
documents=("$@")
if [[ $# -eq 0 ]]; then documents=(README.md tools/docs/*.md); fi

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
awk -v folder="$folder" '
  /^```/ {
    if (open) { open = 0; close(file); next }
    open = 1
    file = $1 == "```sh" ? folder "/commands.sh" : NF == 2 ? $2 : "/dev/null"
    if (NF == 2) { path = $2; sub(/\/[^\/]*$/, "", path); system("mkdir -p " path); printf "" > file }
    next
  }
  open { print >> file }' "${documents[@]}"
[[ -s $folder/commands.sh ]] || { echo "check-docs.sh: no commands in ${documents[*]}" >&2; exit 1; }
bash -euo pipefail -x "$folder/commands.sh"
