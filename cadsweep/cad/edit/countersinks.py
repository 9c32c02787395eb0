r"""Cones from the circles of bosses, and of the floors of counterbores, to the walls of the bores in them.

Place in the flow: for :mod:`.strips` and :mod:`.grids`. The circle of a bored boss divides whatever is swept past it.
A cone from it to the wall of the bore, and the boss halved, leave a countersunk hole below, which is swept along the
bore, and the circle is gone::

      |   | : |   |
    --+   | : |   +--      the boss ends in the cone
      |\  | : |  /|
      | \ | : | / |
          |   |

Not handled: circles that are not whole.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import pi
from typing import Any

import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakePolygon
from OCP.Geom import Geom_ConicalSurface
from OCP.gp import gp_Ax3, gp_Dir, gp_Pnt

from ...arrays import FloatArray
from ...brep import Solid
from .axes import Axis, find_axes, is_hollow
from .central import SAME
from .circles import Rim, find_rims

SLOPE, LEAST_SLOPE = 0.8, 0.3
"""Depth of a cone, in the width of the ring between bore and circle, at most and at least."""
NARROW = 0.9
"""Radius of a bore, in that of the circle around it, up to which a cone fits between them."""
SHARE = 0.6
"""Share of the depth of a bore below the circle that the cone takes, at most."""
BEYOND = 0.05
"""How far a cone reaches into the bore, in its own depth."""


def bored_rims(solid: Solid, flat: float) -> Iterator[tuple[Rim, Axis, FloatArray, float]]:
    """Circles with a bore in them, where a cone has room: with the bore, its seam, and the depth of the cone."""
    axes = find_axes(solid)
    for rim in find_rims(solid, flat):
        for axis in axes:
            seam = seam_in(solid, rim, axis)
            room = None if seam is None else _room(rim, axis)
            if seam is None or room is None or room < LEAST_SLOPE * (rim.radius - axis.radius):
                continue
            yield rim, axis, seam, min(SLOPE * (rim.radius - axis.radius), room)


def seam_in(solid: Solid, rim: Rim, axis: Axis) -> FloatArray | None:
    """Direction from the axis to where the wall of a bore inside of a circle is divided; None where it is none."""
    off = rim.center - axis.place
    is_coaxial = (
        abs(float(axis.direction @ rim.normal)) > 1.0 - SAME
        and float(np.linalg.norm(off - (off @ axis.direction) * axis.direction)) < SAME * solid.size
    )
    if not is_coaxial or axis.radius > NARROW * rim.radius:
        return None
    for face in (solid.faces[f] for f in sorted(axis.faces)):
        for edge in (solid.edges[e] for e in face.edges):
            if edge.kind == "line" and is_hollow(face, edge.midpoint, axis.place, axis.direction):
                arm = edge.midpoint - axis.place
                return np.asarray((arm - (arm @ axis.direction) * axis.direction) / axis.radius)
    return None


def _room(rim: Rim, axis: Axis) -> float | None:
    """Depth below a circle down to which a cone may go to the wall of a bore; None where that begins elsewhere."""
    up = float(np.sign(axis.direction @ rim.normal))
    level = float((rim.center - axis.place) @ axis.direction) * up
    low, high = sorted((up * axis.low, up * axis.high))
    return SHARE * (level - low) if high > level - SAME * rim.radius else None


def countersink(solid: Solid, rim: Rim, axis: Axis, seam: FloatArray, depth: float) -> tuple[Any, ...]:
    """A cone from a circle to a bore, and planes from its sides up through the boss.

    Parameters
    ----------
    solid : Solid
    rim : Rim
    axis : Axis
        Of the bore in it.
    seam : (3,) float64
        Unit vector from the axis to where its wall is divided, as :func:`seam_in` gives it.
    depth : float
        Of the cone.
    """
    size = solid.size
    frame = gp_Ax3(gp_Pnt(*map(float, rim.center)), gp_Dir(*map(float, rim.normal)), gp_Dir(*map(float, seam)))
    half_angle = float(np.arctan2(rim.radius - axis.radius, depth))
    surface = Geom_ConicalSurface(frame, half_angle, rim.radius)
    # Around a boss is nothing that a cone could reach into, but around the floor of a counterbore is.
    above = 0.0 if _is_sunk(rim, solid) else BEYOND
    bottom, top = (share * depth / float(np.cos(half_angle)) for share in (-1.0 - BEYOND, above))
    # All around at once: where two halves meet, OpenCASCADE's splitter loses both.
    tools = [BRepBuilderAPI_MakeFace(surface, 0.0, 2.0 * pi, bottom, top, 1e-7).Face()]
    slope = (rim.radius - axis.radius) / depth
    inner = rim.radius - (1.0 + BEYOND) * depth * slope
    for out in (seam, -seam):
        wire = BRepBuilderAPI_MakePolygon()
        for aside, up in (
            (rim.radius, 0.0), (rim.radius, size), (inner, size), (inner, -(1.0 + BEYOND) * depth),
        ):  # fmt: skip
            wire.Add(gp_Pnt(*map(float, rim.center + aside * out + up * rim.normal)))
        wire.Close()
        tools.append(BRepBuilderAPI_MakeFace(wire.Wire(), True).Face())
    return tuple(tools)


def _is_sunk(rim: Rim, solid: Solid) -> bool:
    """Whether a circle is the rim of a floor, not that of a boss."""
    for edge in (solid.edges[e] for e in rim.face.edges):
        wall = solid.faces[edge.faces[edge.faces[0] == rim.face.id]]
        if wall.kind != "plane" and abs(float(np.linalg.norm(edge.midpoint - rim.center)) - rim.radius) < SAME:
            return is_hollow(wall, edge.midpoint, rim.center, rim.normal)
    return False


__all__ = [
    "LEAST_SLOPE",
    "SHARE",
    "SLOPE",
    "bored_rims",
    "countersink",
    "seam_in",
]
