"""Draw the castings of ``docs/fitted.md``, each filled by a fitted grid.

    python docs/draw_fitted.py

Writes ``docs/images/fitted.png``.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pyvista as pv

import cadsweep as cs

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "tests" / "fitted"))
import castings  # noqa: E402

VIEWS = {"bracket": (1, -1.3, 0.8), "pump_housing": (1, -1.3, 0.8), "knob": (1, 1.3, 0.5), "cover": (0.6, -0.8, -1)}


def main() -> None:
    """Mesh and draw."""
    plotter = pv.Plotter(off_screen=True, shape=(1, len(VIEWS)), window_size=(400 * len(VIEWS), 420), border=False)
    for column, (name, view) in enumerate(VIEWS.items()):
        mesh = cs.sweep_mesh(getattr(castings, name)(), fitted=True)
        quads = np.concatenate(list(mesh.boundaries.values()))
        plotter.subplot(0, column)
        faces = np.column_stack([np.full(len(quads), 4), quads]).ravel()
        plotter.add_mesh(pv.PolyData(mesh.points, faces), color="#dcd6c8", show_edges=True, edge_color="#24405c")
        plotter.view_vector(view, (0, 0, 1))
        plotter.camera.zoom(1.3)
    plotter.screenshot(HERE / "images" / "fitted.png")


if __name__ == "__main__":
    main()
