r"""Walls that meet at a sharp corner are divided finer there, as their layers ask for.

Layers that meet at a corner share the column along its bisector, whose faces are as long as the layers' heights over
the sine of half the angle. Cells much longer than that along their walls have their middles far to one side of it::

        o-----------o          the line between the middles of two cells passes the face between them at a distance
         \  x       |          that solvers call its skewness, in lengths of the face: OpenFOAM wants no more than 4
          o---------o
         /  x       |

So the first segment of each wall there is `_LONGEST` such faces long, and the others grow back from it.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from functools import partial

import numpy as np

from ...arrays import FloatArray
from ...asked import WallLayers
from ...brep import Part
from ...plan import Plan
from ...surface import Division, column_length
from ...sweep import Sweep
from .leaving import joints
from .local_sizes import GROWTH
from .size_divisions import by_density, divided_by

_LONGEST = 2.4
"""Segment at a sharp corner over the face that its first cells share, along the wall."""
_SHARP = np.radians(66)
"""Angle between two walls from which on the line between middles passes no face so far off, however long cells are."""
_SAMPLES = 400
"""Places along an edge where the size is asked for."""


def finer_at_corners(
    sweep: Sweep,
    walls: Mapping[int, WallLayers],
    sizes: Mapping[int, float],
    divisions: Mapping[int, Division],
    *,
    kept: Collection[int],
) -> tuple[dict[int, float], dict[int, Division]]:
    """Mean sizes and divisions of walls whose segments would be too long at a sharp corner.

    Parameters
    ----------
    walls : mapping of int to WallLayers
        By edge of the source cap, heights in working units.
    sizes : mapping of int to float
        Lengths of the edges' segments without this, in the mean.
    divisions : mapping of int to callable
        How edges divide themselves that are not divided evenly.
    kept : collection of int
        Edges that stay as they are.
    """
    mean_sizes: dict[int, float] = {}
    divided: dict[int, Division] = {}
    for e, ends in _first_segments(sweep, walls).items():
        if e in kept:
            continue
        edge = sweep.solid.edges[e]
        own = _lengths(divisions.get(e), max(1, round(edge.length / sizes[e])), edge.length)
        at = edge.length * np.linspace(0.0, 1.0, _SAMPLES + 1)
        wanted = own
        for at_start, first in ends.items():
            wanted = np.minimum(wanted, first + (GROWTH - 1.0) * (at if at_start else at[::-1]))
        if (wanted < own).any():
            mean_sizes[e], places = divided_by(wanted)
            if places is not None:
                divided[e] = partial(by_density, places=places)
    return mean_sizes, divided


def finer_in_cells(  # noqa: PLR0917
    part: Part,
    plan: Plan,
    layers: Mapping[int, WallLayers],
    sizes: Sequence[float],
    divisions: Mapping[int, Division],
    kept: Collection[int],
) -> tuple[dict[int, float], dict[int, Division]]:
    """The same in cells, by keys: `layers` by face, `sizes` by cell; caps that are grids have no rows of their own."""
    grids = {int(part.solids[cell].face_keys[f]) for cell, way in enumerate(plan.ways) for f in way.grids}
    mean_sizes: dict[int, float] = {}
    divided: dict[int, Division] = {}
    for cell, way in enumerate(plan.ways):
        solid = part.solids[cell]
        if not isinstance(way.fill, Sweep) or all(int(solid.face_keys[f]) in grids for f in way.fill.source):
            continue
        walls = {
            e: layers[key]
            for cap, (e, _), _, _ in joints(way.fill)
            for key in solid.face_keys[[f for f in solid.edges[e].faces if f != cap]].tolist()
            if key in layers
        }
        keys = solid.edge_keys.tolist()
        found = finer_at_corners(
            way.fill,
            walls,
            dict.fromkeys(walls, sizes[cell]),
            {e: divisions[keys[e]] for e in walls if keys[e] in divisions},
            kept=[e for e in walls if keys[e] in kept],
        )
        mean_sizes |= {keys[e]: min(own, mean_sizes.get(keys[e], np.inf)) for e, own in found[0].items()}
        divided |= {keys[e]: own for e, own in found[1].items()}
    return mean_sizes, divided


def _first_segments(sweep: Sweep, walls: Mapping[int, WallLayers]) -> dict[int, dict[bool, float]]:
    """By wall, at its start (True) and its end, how long its segment may be at a sharp corner with another wall."""
    found: dict[int, dict[bool, float]] = {}
    for _, (a, a_forward), (b, b_forward), angle in joints(sweep):
        between = min(angle, 2.0 * np.pi - angle)
        if a not in walls or b not in walls or not 0.0 < between < _SHARP:
            continue
        first = min(walls[a].first, walls[b].first)
        most = _LONGEST * first * column_length(between / 2) / np.cos(between / 2)
        for edge, at_start in ((a, not a_forward), (b, b_forward)):
            ends = found.setdefault(edge, {})
            ends[at_start] = min(most, ends.get(at_start, np.inf))
    return found


def _lengths(division: Division | None, n: int, length: float) -> FloatArray:
    """Lengths of the segments of an edge at even places along it."""
    if division is None:
        return np.full(_SAMPLES + 1, length / n)
    fractions = division(n)
    middles = (fractions[1:] + fractions[:-1]) / 2
    return np.asarray(np.interp(np.linspace(0.0, 1.0, _SAMPLES + 1), middles, length * np.diff(fractions)))
