"""Cones under the ends of blind round holes and under round bosses, so that their circle goes no further.

Place in the flow: candidates of :mod:`.cutters`. The circle at the end of a hole divides whatever is swept through it,
and with it every cell beyond, where other features ask for other divisions. A cone from the circle to a point in the
material, with two planes through its axis, leaves cells with corners of three edges::

      |   |     |   |        ring around the hole: four prisms, swept along it
    --+   |     |   +--
      |   +-----+   |        the circle
      |    \\   /    |        four cells between cone and disc, four around the cone: a block at every corner,
      |     \\ /     |        and outside of these plane rectangles only
      +-------------+

Not handled: circles that are not whole, and where the point would not lie well inside the material.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import pi
from typing import Any

import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.Geom import Geom_ConicalSurface
from OCP.gp import gp_Ax3, gp_Dir, gp_Pnt

from ...arrays import FloatArray
from ...brep import Solid
from .central import Cutter, plane_tool
from .circles import Rim, find_rims, inside_of

DEPTHS = (0.8, 0.5, 0.3)
"""Depths of the point below the circle, in radii, that are tried: the first that has enough material below."""
ENOUGH = 1.8
"""Depth, in those of the cone, down to which there must be material: a little more than :data:`BELOW`."""
BELOW = 1.5
"""Depth, in those of the cone, of a plane that keeps the cells around it from what is further below."""
ASIDE = 1.2
"""Radius, in those of the circle, up to which there must be material around it."""


def under_circles(solid: Solid, flat: float) -> Iterator[Cutter]:
    """Cones under the circles at which a solid is re-entrant, or that are imprinted on its faces.

    Parameters
    ----------
    flat : float
        Radians from pi up to which two faces at an edge are one surface.
    """
    rims = find_rims(solid, flat)
    if not rims:
        return
    is_inside = inside_of(solid)
    for rim in rims:
        depth = next((d * rim.radius for d in DEPTHS if _fits(rim, d * rim.radius, is_inside)), None)
        if depth is None:
            continue
        out = rim.start - rim.center
        out /= np.linalg.norm(out)
        planes = [(np.cross(rim.normal, out), rim.center), (out, rim.center), (rim.normal, rim.center)]
        planes.append((rim.normal, rim.center - BELOW * depth * rim.normal))
        yield Cutter(
            kind="cushion",
            reason=f"a cone under the circle on {rim.face.label()}",
            tools=(_cone(rim, out, depth), *(plane_tool(solid, normal, place) for normal, place in planes)),
            weight=rim.length,
        )


def _fits(rim: Rim, depth: float, is_inside: Any) -> bool:
    """Whether there is material around a circle, and below the point of its cone."""
    across = np.linalg.svd(rim.normal[None])[2][1:]
    angles = np.linspace(0.0, 2.0 * pi, 9)[:-1]
    around = np.cos(angles)[:, None] * across[0] + np.sin(angles)[:, None] * across[1]
    below = rim.center - depth * rim.normal
    ring = rim.center - 0.1 * depth * rim.normal + ASIDE * rim.radius * around
    places = [below, rim.center - ENOUGH * depth * rim.normal, *ring, *(below + rim.radius * around)]
    return all(is_inside(place) for place in places)


def _cone(rim: Rim, out: FloatArray, depth: float) -> Any:
    """The cone from a circle to its point, which lies `depth` below."""
    frame = gp_Ax3(gp_Pnt(*map(float, rim.center)), gp_Dir(*map(float, rim.normal)), gp_Dir(*map(float, out)))
    half_angle = float(np.arctan2(rim.radius, depth))
    surface = Geom_ConicalSurface(frame, half_angle, rim.radius)
    return BRepBuilderAPI_MakeFace(surface, 0.0, 2.0 * pi, -depth / np.cos(half_angle), 0.0, 1e-7).Face()
