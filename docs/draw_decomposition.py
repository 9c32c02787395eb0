"""Draw four parts that are cut into cells, each cut open: ``python docs/draw_decomposition.py``."""

from pathlib import Path

import numpy as np
import pyvista as pv
from PIL import Image

import cadsweep as cs
from cadsweep.view import quiet_vtk

DOCS = Path(__file__).parent
PARTS = DOCS.parent / "tests" / "parts" / "decomposed"
OPEN = {  # what is left out, by the middle of a hexahedron
    "hollow_ball": lambda x, y, z: (x > 0) & (y < 0) & (z > 0),
    "cross_drilled_crossing": lambda x, y, z: (y < 0) & (z > 0),
    "round_pockets": lambda x, y, z: y < 0,
    "solid_tee": lambda x, y, z: (y < 0) & (x > -100),
}


def draw() -> None:
    """Write one picture of all four."""
    with quiet_vtk():
        plotter = pv.Plotter(off_screen=True, shape=(2, 2), window_size=(1200, 900), border=False)
        plotter.set_background("white")
        for number, (name, is_open) in enumerate(OPEN.items()):
            mesh = cs.sweep_mesh(PARTS / f"{name}.py")
            kept = mesh.hexes[~is_open(*mesh.points[mesh.hexes].mean(axis=1).T)]
            cells = np.column_stack([np.full(len(kept), 8), kept]).ravel()
            grid = pv.UnstructuredGrid(cells, np.full(len(kept), pv.CellType.HEXAHEDRON), mesh.points)
            plotter.subplot(*divmod(number, 2))
            plotter.add_mesh(grid, color="lightsteelblue", show_edges=True, line_width=1)
            plotter.view_vector((0.6, -1.0, 0.6), viewup=(0, 0, 1))
            plotter.enable_parallel_projection()
            worst = mesh.info["quality"].min_scaled_jacobian
            print(f"{name}: {mesh.n_hexes} hexes, scaled Jacobian at least {worst:.2f}")
        image = Image.fromarray(plotter.screenshot(None))
        plotter.close()
    image.quantize(96, method=Image.Quantize.MAXCOVERAGE).save(DOCS / "images" / "corner_blocks.png", optimize=True)


if __name__ == "__main__":
    draw()
