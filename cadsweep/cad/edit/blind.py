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

A boss with a bore in it needs less: a cone from its circle to the wall of the bore, and the boss halved. What is below
has a countersunk hole then, which is swept along the bore, and the circle is gone::

      |   | : |   |
    --+   | : |   +--      the boss ends in the cone
      |\\  | : |  /|
      | \\ | : | / |
          |   |

Not handled: circles that are not whole, and where the point would not lie well inside the material.
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
from .central import SAME, Cutter, plane_tool
from .circles import Rim, find_rims
from .inside import inside_of

DEPTHS = (0.8, 0.5, 0.3)
"""Depths of the point below the circle, in radii, that are tried: the first that has enough material below."""
ENOUGH = 1.8
"""Depth, in those of the cone, down to which there must be material: a little more than :data:`BELOW`."""
BELOW = 1.5
"""Depth, in those of the cone, of a plane that keeps the cells around it from what is further below."""
SLOPE, LEAST_SLOPE = 0.8, 0.3
"""Depth of a cone to a bore, in the width of the ring between bore and circle, at most and at least."""
NARROW = 0.9
"""Radius of a bore, in that of the circle around it, up to which a cone fits between them."""
SHARE = 0.6
"""Share of the depth of a bore below the circle that the cone takes, at most."""
BEYOND = 0.05
"""How far a cone reaches into the bore, in its own depth."""
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


def under_bored_bosses(solid: Solid, flat: float) -> Iterator[Cutter]:
    """Cones from the circles of bosses to the walls of the bores in them.

    Parameters
    ----------
    flat : float
        Radians from pi up to which two faces at an edge are one surface.
    """
    for rim, axis, seam, depth in bored_rims(solid, flat):
        yield Cutter(
            kind="cushion",
            reason=f"a cone from the circle on {rim.face.label()} to the bore in it",
            tools=countersink(solid, rim, axis, seam, depth),
            weight=rim.length,
        )


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


__all__ = [
    "LEAST_SLOPE",
    "SHARE",
    "SLOPE",
    "bored_rims",
    "countersink",
    "seam_in",
    "under_bored_bosses",
    "under_circles",
]
