"""Mesh the models with their defaults and draw them: ``python docs/draw_gallery.py [NAME ...]``."""

import sys
from pathlib import Path

import pyvista as pv
from PIL import Image

import cadsweep as cs
from cadsweep.view import add_mesh, quiet_vtk

DOCS = Path(__file__).parent
VIEWS = {
    "c_shape": (0.5, 1.0, 0.75),
    "square_semicircle": (0.5, 1.0, 0.75),
    "skewed_ellipses": (-0.5, 1.0, 0.45),
    "square_to_arcs": (-0.5, 1.0, 0.45),
    "plate_with_holes": (0.5, -1.0, 1.0),
    "elbow": (1.0, 1.0, 0.8),
    "i_beam": (0.9, 0.55, 0.75),
    "twisted_blade": (1.0, -0.7, 0.45),
    "lofted_duct": (0.3, -1.0, 0.5),
    "embossed_sheet": (0.9, -0.8, 0.8),
    "assemblies/bolted_flanges": (0.7, -1.0, 0.8),
    "assemblies/fuel_pin": (0.7, -1.0, 0.8),
    "assemblies/sandwich_panel": (0.5, -1.0, 0.7),
    "cells/angle_bracket": (1.0, -0.8, 0.8),
    "cells/boss_over_bore": (0.6, -1.0, 0.8),
    "cells/pillow_block": (0.5, -1.0, 0.7),
    "cells/slanted_bore": (0.5, -1.0, 0.7),
    "blended/blended_bracket": (1.0, -0.8, 0.8),
    "blended/cast_lever": (0.6, -1.0, 0.7),
}
SCALE = {"title_font_size": 14, "label_font_size": 12, "position_x": 0.85}


def draw(name: str, mesh: cs.HexMesh) -> None:
    """Write the picture of a mesh as a PNG of few colours."""
    with quiet_vtk():
        plotter = pv.Plotter(off_screen=True, window_size=(760, 520))
        plotter.set_background("white")
        add_mesh(plotter, mesh, show_boundaries=False, scale=SCALE)
        plotter.view_vector(VIEWS[name], viewup=(0, 0, 1))
        plotter.enable_parallel_projection()
        plotter.camera.zoom(0.98)
        image = Image.fromarray(plotter.screenshot(None))
        plotter.close()
    image.quantize(96, method=Image.Quantize.MAXCOVERAGE).save(
        DOCS / "images" / f"{Path(name).name}.png", optimize=True
    )


if __name__ == "__main__":
    for chosen in sys.argv[1:] or VIEWS:
        made = cs.sweep_mesh(DOCS.parent / "models" / f"{chosen}.py")
        draw(chosen, made)
        found = made.info["quality"]
        print(f"{chosen}: {found.n_hexes} hexes, scaled Jacobian at least {found.min_scaled_jacobian:.2f}")
