"""Compile what cadsweep compiles at its first use, so that nobody waits for it: ``install.sh`` calls this.

numba keeps the compiled kernels beside the installed modules, or in the user's cache folder where these cannot be
written. Small parts are meshed that take every way through the package; what is compiled already is only loaded.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import cadquery as cq

import cadsweep as cs


def parts() -> dict[str, tuple[cq.Workplane, dict[str, object]]]:
    """Small parts, and options, that between them need every kernel."""
    plate = cq.Workplane().box(8, 6, 2).faces(">Z").workplane().hole(2)
    wave = [(0, 0), (2, 1), (4, 0), (6, 1)]
    elbow = cq.Workplane().rect(2, 2).revolve(90, (4, 0, 0), (4, 1, 0))
    return {
        "plate": (plate, {"order": 2}),
        "bent": (
            cq.Workplane().spline(wave).lineTo(6, 4).lineTo(0, 4).close().extrude(2),
            {"order": 2, "strategy": "advancing"},
        ),
        "twisted": (cq.Workplane().rect(4, 2).workplane(3).transformed((0, 0, 30)).rect(3, 2).loft(), {"size": 0.2}),
        "wedge": (cq.Workplane().polyline([(0, 0), (9, 0), (9, 1)]).close().extrude(2), {}),
        "elbow": (elbow, {"functional": "F"}),
        "ring": (cq.Workplane().center(5, 0).circle(1).revolve(360, (-5, 0, 0), (-5, 1, 0)), {}),
        "pin": (cq.Workplane().circle(2).extrude(3).faces(">Z").edges().fillet(0.4), {"functional": "G"}),
    }


def main() -> int:
    """Mesh the parts; what goes wrong is said and harms nothing, as the kernels are compiled when they are needed."""
    with tempfile.TemporaryDirectory() as folder:
        for name, (part, options) in parts().items():
            try:
                mesh = cs.sweep_mesh(part, **options)
                mesh.write(Path(folder) / f"{name}.vtu")
            except cs.CadSweepError as error:
                print(f"{name}: {error}", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
