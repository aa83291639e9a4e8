#!/usr/bin/env bash
# Runs a command in a Debian 12 of its own, which at first holds what debootstrap calls minbase and nothing else. Must
# run as root (for chroot) and needs debootstrap, and the network.
#
#   tools/bare-root.sh FOLDER COMMAND [ARGUMENT...]     FOLDER is made if it is not there, and kept
#
# Packages come from the mirror of this machine's apt, or from PTET_DEBIAN_MIRROR; they are kept in PTET_DEBIAN_PACKAGES,
# if that names a folder, for the next root.
set -euo pipefail

fail() {
  echo "bare-root.sh: $*" >&2
  exit 1
}
[[ $# -ge 2 ]] || fail "needs a folder and a command"
[[ $(id -u) -eq 0 ]] || fail "must run as root"
command -v debootstrap >/dev/null || fail "needs debootstrap (apt-get install debootstrap)"
root=$(realpath -m "$1")
shift
[[ $root != / ]] || fail "not in /"
packages=${PTET_DEBIAN_PACKAGES:-}

if [[ ! -e $root/bare-root.ready ]]; then
  # shellcheck disable=SC2016 # apt-get expands it
  mirror=${PTET_DEBIAN_MIRROR:-$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' |
    grep -m 1 /debian || true)}
  [[ -n $mirror ]] || fail "apt knows no mirror of Debian; name one in PTET_DEBIAN_MIRROR"
  rm -rf "$root"
  debootstrap --variant=minbase ${packages:+--cache-dir="$packages"} bookworm "$root" "$mirror"
  printf '#!/bin/sh\nexit 101\n' >"$root/usr/sbin/policy-rc.d" # no services
  chmod +x "$root/usr/sbin/policy-rc.d"
  echo force-unsafe-io >"$root/etc/dpkg/dpkg.cfg.d/bare-root" # it can be made again
  # Those who stand between this machine and the network are known in there, too.
  mkdir -p "$root/usr/local/share/ca-certificates"
  find /usr/local/share/ca-certificates -name '*.crt' -exec cp {} "$root/usr/local/share/ca-certificates/" \;
  touch "$root/bare-root.ready"
fi
# Debian's apt throws packages away once they are installed; these are kept.
if [[ -n $packages ]]; then
  packages=$(realpath "$packages")
  echo 'Binary::apt-get::APT::Keep-Downloaded-Packages "true";' >"$root/etc/apt/apt.conf.d/keep"
fi

# In mounts of its own, which end with it.
unshare --mount bash -euo pipefail -s "$root" "$packages" "$@" <<'INSIDE'
root=$1 packages=$2
shift 2
mount -t proc proc "$root/proc"
mount -t tmpfs tmpfs "$root/tmp"
mount -t tmpfs tmpfs "$root/dev/shm"
if [[ -n $packages ]]; then mount --bind "$packages" "$root/var/cache/apt/archives"; fi
exec chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 \
  NODE_EXTRA_CA_CERTS=/etc/ssl/certs/ca-certificates.crt \
  OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 "$@" </dev/null
INSIDE
