#!/bin/sh
# Installs cadsweep from this checkout into ./.venv, with what a bare Debian or Ubuntu lacks for it.
#
#   sh install.sh          the package and its command
#   sh install.sh test     also what the tests need; CalculiX and Chromium where they can be had
#   sh install.sh all      every optional part
#
# System packages are installed with apt-get only where they are missing, as root or through sudo;
# where neither is possible, one line names them.
set -eu
cd "$(dirname "$0")"
extra=${1:-}

say() { printf 'install: %s\n' "$*" >&2; }

root=""
[ "$(id -u)" = 0 ] || root=sudo

can_install() { command -v apt-get >/dev/null 2>&1 && { [ -z "$root" ] || command -v sudo >/dev/null 2>&1; }; }

updated=""
apt() { # install the named packages; fails quietly
    [ -n "$updated" ] || $root apt-get update -qq >&2 || return 1
    updated=yes
    $root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" >/dev/null 2>&1
}

packages() { # install the named Debian packages, or say which are missing
    can_install || { say "please install these packages first, as root: apt-get install $*"; exit 1; }
    say "installing system packages: $*"
    apt "$@" || { say "apt-get could not install: $*"; exit 1; }
}

wish() { # install package $2, whose program $1 some tests make use of; those are skipped without it
    ! command -v "$1" >/dev/null 2>&1 || return 0
    if can_install && say "installing for the tests: $2" && apt "$2" && command -v "$1" >/dev/null 2>&1; then return; fi
    say "$2 cannot be installed here: the tests that need it are skipped"
}

find_python() { # the first Python that all wheels exist for, then any later one
    for candidate in python3 python3.13 python3.12 python3.11; do
        if command -v "$candidate" >/dev/null 2>&1 &&
            "$candidate" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info < (3, 14))' 2>/dev/null
        then python=$candidate; return; fi
    done
    if python3 -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then python=python3; return; fi
    return 1
}

find_python || {
    packages python3
    # Ubuntu 22.04 has 3.10 as its python3, and 3.11 beside it.
    find_python || { say "looking for a later Python than $(python3 --version)"; apt python3.11 python3.11-venv || :; find_python; } ||
        { say "cadsweep needs Python 3.11 or later, and no package of it was found"; exit 1; }
}

missing=""
"$python" -c 'import ensurepip, venv' 2>/dev/null || missing="$missing $python-venv"
# What the wheels of gmsh, OpenCASCADE and VTK load from the system.
for pair in libGLU.so.1:libglu1-mesa libGL.so.1:libgl1 libXrender.so.1:libxrender1 libXcursor.so.1:libxcursor1 \
            libXft.so.2:libxft2 libXinerama.so.1:libxinerama1 libXi.so.6:libxi6 libXfixes.so.3:libxfixes3 \
            libfontconfig.so.1:libfontconfig1 libgomp.so.1:libgomp1; do
    "$python" -c "import ctypes; ctypes.CDLL('${pair%%:*}')" 2>/dev/null || missing="$missing ${pair##*:}"
done
if [ "$extra" = test ] || [ "$extra" = all ]; then
    "$python" -c "import ctypes; ctypes.CDLL('libEGL.so.1')" 2>/dev/null || missing="$missing libegl1" # pictures
fi
# shellcheck disable=SC2086
[ -z "$missing" ] || packages $missing
if [ "$extra" = test ] || [ "$extra" = all ]; then
    wish ccx calculix-ccx
    wish chromium chromium
fi

# A folder that an interrupted run has left without pip is made anew.
.venv/bin/python -m pip --version >/dev/null 2>&1 || { rm -rf .venv; "$python" -m venv .venv; }
# Whoever runs the tests runs the sources: kernels compiled below are theirs, and not those of a copy beside them.
editable=""
[ "$extra" = test ] && editable="--editable"
# shellcheck disable=SC2086
.venv/bin/python -m pip install --quiet --disable-pip-version-check $editable ".${extra:+[$extra]}"
# Of a copy that was installed before, pip leaves the folders with its compiled kernels, which would hide the sources.
for left in .venv/lib/python*/site-packages/cadsweep; do
    [ -e "$left/__init__.py" ] || rm -rf "$left"
done
# A wheel brings its kernels; the sources, which can be edited, do not.
if [ -n "$editable" ]; then
    say "compiling kernels, so that the first mesh need not"
    .venv/bin/python scripts/compile_kernels.py || say "they are compiled when they are first used"
fi
say "done: .venv/bin/cadsweep"
