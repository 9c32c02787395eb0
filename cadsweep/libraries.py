"""Why a compiled library cannot be imported, and what to install, in one line.

Foundation: gmsh's, OpenCASCADE's and VTK's wheels load system libraries that a bare Debian or Ubuntu
lacks; the loader names a file, a user needs a package.
"""

from __future__ import annotations

import re

_DEBIAN_PACKAGES = {
    "libGLU": "libglu1-mesa",
    "libGL": "libgl1",
    "libGLX": "libglx0",
    "libGLdispatch": "libglvnd0",
    "libEGL": "libegl1",
    "libX11": "libx11-6",
    "libXcursor": "libxcursor1",
    "libXext": "libxext6",
    "libXfixes": "libxfixes3",
    "libXft": "libxft2",
    "libXi": "libxi6",
    "libXinerama": "libxinerama1",
    "libXrender": "libxrender1",
    "libexpat": "libexpat1",
    "libfontconfig": "libfontconfig1",
    "libgomp": "libgomp1",
    "libxcb": "libxcb1",
}
"""System libraries that the wheels load, and the Debian/Ubuntu packages that hold them."""

ALL_PACKAGES = "libglu1-mesa libgl1 libxrender1 libxcursor1 libxft2 libxinerama1 libgomp1"
"""What a bare system may lack; the others come with these."""


def explain_import_error(library: str, error: BaseException, *, distribution: str) -> str:
    """Return one line that says why `library` cannot be imported and what to install.

    Parameters
    ----------
    library : str
        Its name for the user, such as ``"gmsh"``.
    error : ImportError or OSError
        What the import raised.
    distribution : str
        What pip installs it by, such as ``"cadquery"``.
    """
    text = " ".join(str(error).split())
    match = re.search(r"(lib\w+)[\w.+-]*: cannot open shared object file", text)
    if match is None:
        return f"{library} cannot be imported ({text}); install it with: pip install {distribution}"
    package = _DEBIAN_PACKAGES.get(match[1])
    if package is None:
        return f"{library} needs the system library {match[1]}, which is missing; install the package that holds it"
    return f"{library} needs the system library {match[1]}: apt-get install {package} (all it may need: {ALL_PACKAGES})"
