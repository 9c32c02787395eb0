#!/bin/sh
# Installs cadsweep from this checkout into ./.venv, with what a bare Debian or Ubuntu lacks for it.
#
#   sh install.sh          the package and its command
#   sh install.sh test     also what the tests need, CalculiX and Chromium included
#   sh install.sh all      every optional part
#
# System packages are installed with apt-get only where they are missing, as root or through sudo;
# where neither is possible, one line names them.
set -eu
cd "$(dirname "$0")"
extra=${1:-}

say() { printf 'install: %s\n' "$*" >&2; }

packages() { # install the named Debian packages, or say which are missing
    if [ "$(id -u)" = 0 ]; then root=""
    elif command -v sudo >/dev/null 2>&1; then root="sudo"
    else say "please install these packages first: $*"; exit 1; fi
    command -v apt-get >/dev/null 2>&1 || { say "please install what Debian calls: $*"; exit 1; }
    say "installing system packages: $*"
    $root apt-get update -qq >&2
    # shellcheck disable=SC2086
    $root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" >/dev/null ||
        { say "apt-get could not install: $*"; exit 1; }
}

new_enough() { "$1" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; }

python=""
for candidate in python3 python3.13 python3.12 python3.11; do
    if command -v "$candidate" >/dev/null 2>&1 && new_enough "$candidate"; then python=$candidate; break; fi
done
if [ -z "$python" ]; then
    packages python3 python3-venv
    python=python3
    new_enough python3 || { say "cadsweep needs Python 3.11 or later, this is $(python3 --version)"; exit 1; }
fi

missing=""
"$python" -c 'import ensurepip, venv' 2>/dev/null ||
    missing="$missing python3-venv"
# What the wheels of gmsh, OpenCASCADE and VTK load from the system.
for pair in libGLU.so.1:libglu1-mesa libGL.so.1:libgl1 libXrender.so.1:libxrender1 libXcursor.so.1:libxcursor1 \
            libXft.so.2:libxft2 libXinerama.so.1:libxinerama1 libXi.so.6:libxi6 libXfixes.so.3:libxfixes3 \
            libfontconfig.so.1:libfontconfig1 libgomp.so.1:libgomp1; do
    "$python" -c "import ctypes; ctypes.CDLL('${pair%%:*}')" 2>/dev/null || missing="$missing ${pair##*:}"
done
if [ "$extra" = test ] || [ "$extra" = all ]; then
    "$python" -c "import ctypes; ctypes.CDLL('libEGL.so.1')" 2>/dev/null || missing="$missing libegl1" # pictures
    command -v ccx >/dev/null 2>&1 || missing="$missing calculix-ccx"
    command -v chromium >/dev/null 2>&1 || command -v chromium-browser >/dev/null 2>&1 || missing="$missing chromium"
fi
# shellcheck disable=SC2086
[ -z "$missing" ] || packages $missing

[ -x .venv/bin/python ] || "$python" -m venv .venv
.venv/bin/python -m pip install --quiet --disable-pip-version-check ".${extra:+[$extra]}"
say "done: .venv/bin/cadsweep"
