#!/bin/sh
# Runs README's commands on a system with nothing installed but Python: a fresh Debian or Ubuntu in a folder.
#
#   sh scripts/try_bare_system.sh bookworm            README's first command
#   sh scripts/try_bare_system.sh noble test          its test command
#
# Needs root, a network and debootstrap. The folder (under $TMPDIR or /var/tmp) is removed at the end.
set -eu
cd "$(dirname "$0")/.."
release=$1
which=${2:-first}

[ "$(id -u)" = 0 ] && command -v debootstrap >/dev/null ||
    { echo "try_bare_system: needs root and debootstrap (apt-get install debootstrap)" >&2; exit 1; }

case $release in
    jammy | noble) mirror=http://archive.ubuntu.com/ubuntu; areas="main universe"; keys=--no-check-gpg ;;
    *) mirror=http://deb.debian.org/debian; areas=main; keys= ;;
esac
scripts=/usr/share/debootstrap/scripts
[ -e "$scripts/$release" ] || { case $mirror in *ubuntu) ln -s gutsy "$scripts/$release" ;; *) ln -s sid "$scripts/$release" ;; esac; }

case $which in # the command as it stands in the README
    first) command=$(sed -n 's/^\(sh install.sh && .*\)$/\1/p' README.md) ;;
    test) command=$(sed -n 's/^\(sh install.sh test && .*\)$/\1/p' README.md) ;;
    *) echo "try_bare_system: first or test, not $which" >&2; exit 1 ;;
esac

root=$(mktemp -d "${TMPDIR:-/var/tmp}/bare.XXXXXX")
remove() {
    for place in dev/pts dev sys proc; do umount "$root/$place" 2>/dev/null || :; done
    # One file system only: what is still mounted must not be emptied.
    rm -rf --one-file-system "$root"
}
trap remove EXIT
chmod 755 "$root"
# shellcheck disable=SC2086
debootstrap $keys --variant=minbase --include=ca-certificates,python3 "$release" "$root" "$mirror" >/dev/null
echo "deb $mirror $release $areas" >"$root/etc/apt/sources.list"
for place in proc sys dev dev/pts; do mount --bind "/$place" "$root/$place"; done
cp /etc/resolv.conf /etc/hosts "$root/etc/"
cp /etc/ssl/certs/ca-certificates.crt "$root/etc/ssl/certs/"
git archive --prefix=cadsweep/ HEAD | tar -x -C "$root/root"

echo "$release: \$ $command"
chroot "$root" env -i HOME=/root LANG=C.UTF-8 PATH=/usr/sbin:/usr/bin:/sbin:/bin \
    PIP_CERT=/etc/ssl/certs/ca-certificates.crt sh -c "cd /root/cadsweep && $command"
