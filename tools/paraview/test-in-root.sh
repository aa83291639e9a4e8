#!/usr/bin/env bash
# Builds the ParaView plugin and tests it with pvbatch in a Debian 12 of its own, because ParaView's Python and VTK's
# cannot be installed together. Must run as root (for chroot) and needs debootstrap, and the network the first time.
#
#   tools/paraview/test-in-root.sh [FOLDER]        default: build-paraview-root; it is kept, so that the next run is quick
#
# Packages come from the mirror of this machine's apt, or from PTET_DEBIAN_MIRROR. Where bluntfin.vtu lies in PTET_DATA
# (default: ../shared/data beside the clone) and build/ptet is built, that mesh is tested and drawn as well. The pictures
# are left in FOLDER/ptet/pictures.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

fail() {
  echo "test-in-root.sh: $*" >&2
  exit 1
}
[[ $(id -u) -eq 0 ]] || fail "must run as root"
command -v debootstrap >/dev/null || fail "needs debootstrap (apt-get install debootstrap)"
root=$(realpath -m "${1:-build-paraview-root}")
[[ $root != / ]] || fail "not in /"
data=${PTET_DATA:-../shared/data}

if [[ ! -e $root/ptet.ready ]]; then
  # shellcheck disable=SC2016 # apt-get expands it
  mirror=${PTET_DEBIAN_MIRROR:-$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' |
    grep -m 1 /debian || true)}
  [[ -n $mirror ]] || fail "apt knows no mirror of Debian; name one in PTET_DEBIAN_MIRROR"
  rm -rf "$root"
  debootstrap --variant=minbase bookworm "$root" "$mirror"
  printf '#!/bin/sh\nexit 101\n' >"$root/usr/sbin/policy-rc.d" # no services
  chmod +x "$root/usr/sbin/policy-rc.d"
  touch "$root/ptet.ready"
fi

# The files of this working copy, and what was built before.
mkdir -p "$root/ptet/pictures"
git ls-files -z --cached --others --exclude-standard | tar --create --null --files-from - | tar -x -C "$root/ptet"
if [[ -f $data/bluntfin.vtu && -x build/ptet && ! -e $root/ptet/bluntfin.ptet ]]; then
  build/ptet build "$data/bluntfin.vtu" --field Density --quiet -o "$root/ptet/bluntfin.ptet"
fi

# In mounts of its own, which end with it.
unshare --mount bash -euo pipefail -s "$root" <<'SETUP'
mount -t proc proc "$1/proc"
mount -t tmpfs tmpfs "$1/tmp"
mount -t tmpfs tmpfs "$1/dev/shm"
exec chroot "$1" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 \
  OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 bash -euo pipefail /ptet/tools/paraview/test-here.sh
SETUP
echo "pictures: $root/ptet/pictures"
