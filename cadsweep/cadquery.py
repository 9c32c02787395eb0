"""A CadQuery plugin: ``import cadsweep.cadquery`` adds methods to every Workplane.

Place in the flow: beside the command line, an outer end of the package; nothing imports it::

    import cadquery as cq
    import cadsweep.cadquery

    mesh = cq.Workplane().box(60, 40, 8).faces(">Z").workplane().hole(12).sweepMesh(size=2)
    mesh.write("plate.inp")
    cq.Workplane().circle(5).extrude(20).showMesh(size=1)

Tags of the Workplane become names of boundaries, as everywhere.
"""

from __future__ import annotations

from typing import Any

import cadquery as cq

from .mesh import HexMesh

_VIEW = frozenset({"screenshot", "scalars", "clip", "crinkle", "show_boundaries", "limits", "window_size", "camera"})


def sweep_mesh(self: cq.Workplane, **options: Any) -> HexMesh:
    """Mesh the solid at the end of the chain with hexahedra.

    Parameters
    ----------
    **options
        Those of :func:`cadsweep.sweep_mesh`: ``size``, ``layers``, ...

    Raises
    ------
    CadSweepError
        As of :func:`cadsweep.sweep_mesh`.
    """
    from .pipeline import sweep_mesh as mesh_part

    return mesh_part(self, **options)


def show_mesh(self: cq.Workplane, **options: Any) -> cq.Workplane:
    """Mesh the solid and show it, in a window or in the notebook; the chain goes on.

    Parameters
    ----------
    **options
        Those of :func:`cadsweep.sweep_mesh`, and of :meth:`cadsweep.HexMesh.plot` (``screenshot``, ``clip``, ...).
    """
    shown = {name: options.pop(name) for name in list(options) if name in _VIEW}
    picture = sweep_mesh(self, **options).plot(**shown)
    if picture is not None and "screenshot" not in shown:
        from IPython.display import display

        display(picture)
    return self


cq.Workplane.sweepMesh = sweep_mesh
cq.Workplane.showMesh = show_mesh
