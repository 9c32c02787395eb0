"""Meshes as pictures: a pyvista grid, a window, or a PNG without a display.

Place in the flow: after ``quality``; called by ``HexMesh.plot``, ``cadsweep view`` and the report.
pyvista is the extra ``view`` and is imported when first needed.

::

    to_pyvista, boundaries_to_pyvista, skin, kept_by_clip      arrays for pyvista      grid
    explode                                                    parts drawn apart       exploded
    plot, add_mesh                                             pictures                picture
    quiet_vtk, check_drawing, write_whole                      the machine             display
"""

from .display import can_open_window, check_drawing, quiet_vtk, write_whole
from .exploded import explode
from .grid import (
    Clip,
    boundaries_to_pyvista,
    boundary_colors,
    kept_by_clip,
    mesh_colors,
    outline,
    part_colors,
    skin,
    to_pyvista,
)
from .picture import add_mesh, plot, save_screenshot

__all__ = [
    "Clip",
    "add_mesh",
    "boundaries_to_pyvista",
    "boundary_colors",
    "can_open_window",
    "check_drawing",
    "explode",
    "kept_by_clip",
    "mesh_colors",
    "outline",
    "part_colors",
    "plot",
    "quiet_vtk",
    "save_screenshot",
    "skin",
    "to_pyvista",
    "write_whole",
]
