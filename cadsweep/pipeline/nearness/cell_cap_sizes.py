"""Lengths that keep the quads of curved caps of cells near to them.

Place in the flow: :mod:`.cells_accuracy` asks for them where quads of a cap sag too much.

Method: as for the caps of one sweep (:mod:`.cap_sizes`). Quads of a cap are those of the one across, and of all caps of
the column of cells that they are carried through: so what is wanted at a place of a cap is wanted at all places over
and under it, which are found by the way from the middle of each cap to that of the next.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

import numpy as np

from ...arrays import FloatArray
from ...blocks.cells import CellBlocks
from ...blocks.finish import by_face
from ...blocks.joined import neighbours_of
from ...brep import Part
from ...plan import Plan
from ...quality.deviation import quad_sags
from ...sweep import Intervals, Sweep
from .cap_sizes import InsideSizes, sizes_of_quads

_MOST_FINER = 3.0
"""Factor by which edges of a cap are made shorter than they are in one round."""
_LITTLE = 1.05
"""Factor that is not worth a round."""
_SAMPLES = 100
"""Places along an edge where the length is asked for."""

Place = tuple[int, int]


def caps_of(part: Part, plan: Plan) -> set[Place]:
    """Cells and faces that are caps of free quads."""
    grids = {int(part.solids[cell].face_keys[f]) for cell, way in enumerate(plan.ways) for f in way.grids}
    return {
        (cell, f)
        for cell, way in enumerate(plan.ways)
        if isinstance(way.fill, Sweep)
        for f in (*way.fill.source, *way.fill.target)
        if int(part.solids[cell].face_keys[f]) not in grids
    }


def sizes_in_caps(  # noqa: PLR0917
    part: Part,
    plan: Plan,
    made: CellBlocks,
    needed: Mapping[Place, float],
    greatest: Mapping[Place, float],
    before: InsideSizes | None,
) -> InsideSizes | None:
    """Wanted lengths at points of caps; None where no cap sags too much.

    Parameters
    ----------
    needed : mapping of (int, int) to float
        How many times shorter the quads should be that sag most, by cell and face of those that are too far off.
    greatest : mapping of (int, int) to float
        How far these are off.
    """
    caps = caps_of(part, plan)
    middles, lengths, factors = [], [], []
    for place, quads in by_face(made):
        if place not in needed or place not in caps:
            continue
        corners = made.points[quads[:, :4]]
        sags = quad_sags(part.solids[place[0]].faces[place[1]].surface, corners)
        long = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).mean(axis=1)
        factor = needed[place] * np.sqrt(np.minimum(sags / greatest[place], 1.0))
        for shift in _along_column(part, plan, place):
            middles.append(corners.mean(axis=1) + shift)
            lengths.append(long)
            factors.append(factor)
    if not middles:
        return None
    return sizes_of_quads(np.concatenate(middles), np.concatenate(lengths), np.concatenate(factors), before)


def _along_column(part: Part, plan: Plan, place: Place) -> Iterator[FloatArray]:
    """Ways from a cap to itself and to the other caps of its column."""
    beyond = neighbours_of(part)
    waiting = [(own, np.zeros(3)) for own in (place, beyond.get(place)) if own is not None]
    seen: set[int] = set()
    yield np.zeros(3)
    while waiting:
        (cell, face), way = waiting.pop()
        sweep, solid = plan.ways[cell].fill, part.solids[cell]
        if cell in seen or not isinstance(sweep, Sweep) or face not in (*sweep.source, *sweep.target):
            continue
        seen.add(cell)
        own, other = (sweep.source, sweep.target) if face in sweep.source else (sweep.target, sweep.source)
        here, there = (
            np.average([solid.faces[f].center for f in cap], axis=0, weights=[solid.faces[f].area for f in cap])
            for cap in (own, other)
        )
        yield way + there - here
        waiting += [(beyond[cell, f], way + there - here) for f in other if (cell, f) in beyond]


def sizes_at_rims(
    part: Part,
    counts: list[Intervals],
    places: Collection[Place],
    inside: InsideSizes,
    *,
    kept: Collection[int],
) -> dict[int, float]:
    """Sizes of edges of caps, by key, whose segments are longer than is wanted there."""
    found: dict[int, float] = {}
    at = np.linspace(0.0, 1.0, _SAMPLES + 1)
    for cell, face in places:
        solid = part.solids[cell]
        for e in solid.faces[face].edges:
            key, edge = int(solid.edge_keys[e]), solid.edges[e]
            present = edge.length / max(1, int(counts[cell].counts[e]))
            wanted = max(float(inside(edge.curve.evaluate(at)).min()), present / _MOST_FINER)
            if key not in kept and present > _LITTLE * wanted:
                found[key] = min(wanted, found.get(key, np.inf))
    return found
