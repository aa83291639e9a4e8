#!/usr/bin/env bash
# Goes the ways that the documents tell a newcomer, each in a bare Debian 12: the first commands after the heading
# "From a clone to a picture", from `git clone` on. They may be five at most, and there must be a picture in the end.
#
#   tools/newcomer.sh FOLDER [view|python|paraview|web]...        all four if none is named
#
# The clone is of this repository as it is committed. FOLDER then holds view.png and so on; the roots are in there, too,
# and removed by the next run, packages are kept. Two runs at a time need two folders. Must run as root and needs
# debootstrap and the network (bare-root.sh).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

[[ $# -ge 1 ]] || { sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0" >&2; exit 2; }
folder=$(realpath -m "$1")
shift
ways=("$@")
[[ $# -gt 0 ]] || ways=(view python paraview web)
mkdir -p "$folder/packages"
export PTET_DEBIAN_PACKAGES=$folder/packages

# The block after the heading, a command a line: without comments, lines that go on joined, `cd` with what it is for.
commands_of() {
  awk '/^#/ && /From a clone to a picture/ { found = 1 }
       found && /^```/ { if (open) exit; open = 1; next }
       open { sub(/[ ]+# .*/, ""); printf "%s", /\\$/ ? substr($0, 1, length($0) - 1) : $0 "\n" }' "$1"
}

[[ -e $folder/bare/bare-root.ready ]] || tools/bare-root.sh "$folder/bare" true
for way in "${ways[@]}"; do
  root=$folder/$way
  commands=$(commands_of "tools/$way/README.md")
  count=$(grep -c . <<<"$commands" || true)
  printf '=== %s: %s commands\n%s\n' "$way" "$count" "$commands"
  if [[ $count -eq 0 || $count -gt 5 ]]; then
    echo "newcomer.sh: tools/$way/README.md should have one to five commands to a picture" >&2
    exit 1
  fi
  rm -rf "$root"
  cp -a "$folder/bare" "$root"
  git clone -q --bare . "$root/ptet.git"
  {
    echo 'set -euo pipefail -x; cd /root; touch begun'
    sed -e 's,git clone [^ ]*,git clone /ptet.git,' -e 's,^tools/web/serve.py.*,& \& server=$!,' <<<"$commands"
    if [[ $way == web ]]; then # the browser that somebody would look with
      echo 'until (: </dev/tcp/127.0.0.1/8000) 2>/dev/null; do sleep 0.1; done'
      echo "node tools/web/screenshot.js '$(grep -om 1 'http://127[^>]*' tools/web/README.md)' quickstart/page.png"
      echo "kill \$server"
    fi
  } >"$root/way.sh"
  started=$SECONDS
  tools/bare-root.sh "$root" bash -c 'apt-get -q update && apt-get -q -y --no-install-recommends install git' \
    >"$folder/$way.log" 2>&1
  if ! tools/bare-root.sh "$root" bash /way.sh >>"$folder/$way.log" 2>&1; then
    tail -n 40 "$folder/$way.log" >&2
    echo "newcomer.sh: the way of tools/$way/README.md fails; all it said is in $folder/$way.log" >&2
    exit 1
  fi
  picture=$(find "$root/root/ptet" -newer "$root/root/begun" \( -path '*/quickstart/*' -o -path '*/ptet/picture.png' \) \
    -name '*.png' -printf '%T@ %p\n' | sort -n | tail -n 1 | cut -d ' ' -f 2)
  [[ -n $picture ]] || { echo "newcomer.sh: no picture at the end of tools/$way/README.md" >&2; exit 1; }
  cp "$picture" "$folder/$way.png"
  echo "$folder/$way.png, $((SECONDS - started)) s"
done
