"""Cells of which two matched faces are divided in different places: cut where the images of their edges are.

Place in the flow: a plan of cells passes here before it is meshed, where periodic faces are asked for. What is cut
gets a plan again, and may be cut further for it.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ... import cad, rows
from ...brep import Part
from ...decomposition.curved import find_cells
from ...options import SweepOptions
from ...surface import Motion
from ..run import Run
from ..wishes.named_faces import Place
from ..wishes.periodic import edge_images, edges_of, find_matches, nearness
from .complex import Complex
from .complexes import as_complex, cutting_tools

log = logging.getLogger(__name__)

CARRIED = "cut: carried to periodic faces"
"""The row of cuts that end on one of two matched faces, and are carried to the other."""
_MOST = 12
"""Cuts that are carried over before a new plan is looked for."""
_ROUNDS = 3
"""Plans that are looked for: what they cut may have to be carried over, too."""
_LOOKED_AT = 20
"""Parts that are looked at for each."""


def answering(found: Complex, options: SweepOptions, run: Run) -> Complex:
    """A plan whose cells divide matched faces in the same places, where cuts that are carried over do that."""
    for _ in range(_ROUNDS if options.periodic and rows.is_on(CARRIED) else 0):
        part = _answered(found.part, found.model, options)
        if part is found.part:
            break
        again, _ = find_cells(part, cutting_tools(run.for_share(1.0 / _ROUNDS)), most_parts=_LOOKED_AT)
        if again.plan is None:
            log.info("cells with cuts carried over between periodic faces have no plan: %s", again.message)
            break
        rows.took([CARRIED])
        found = replace(as_complex(again, replace(found.model, cuts=part.cuts)), model=found.model)
    return found


def _answered(part: Part, model: Part, options: SweepOptions) -> Part:
    """The part after cuts that end on one of two matched faces were carried to the other."""
    n = 0
    for _ in range(_MOST):
        carried = (_carried(part, model, options, gap) for gap in _alone(part, model, options))
        then = next((own for own in carried if own is not None), None)
        if then is None:
            break
        part = then
        n += 1
    note = f"cuts carried from one periodic face to the other: {n}"
    return replace(part, notes=(*part.notes, note)) if n else part


_Gap = tuple[int, int, Motion, np.ndarray, list[Place]]
"""A cell, the face of a cut that ends on a matched one, the motion to the other, where its end should be, and where."""


def _alone(part: Part, model: Part, options: SweepOptions) -> Iterator[_Gap]:
    """Cuts that end on one of two matched faces alone."""
    near = nearness(part)
    for match in find_matches(part, model, options):
        one, other = (edges_of(part, own) for own in match.places)
        _, alone = edge_images(one, other, match.motion, near)
        for places, motion, beyond in (
            (match.places[0], match.motion, match.places[1]),
            (match.places[1], match.motion.inverse(), match.places[0]),
        ):
            for cell, face in sorted(places):
                solid = part.solids[cell]
                for e in solid.faces[face].edges:
                    edge = solid.edges[e]
                    across = next((f for f in edge.faces if f != face), face)
                    if int(solid.edge_keys[e]) in alone and across != face and not solid.faces[across].key:
                        yield cell, across, motion, motion(edge.midpoint[None]), sorted(beyond)


def _carried(part: Part, model: Part, options: SweepOptions, gap: _Gap) -> Part | None:
    """The part with a cell of the other face cut by what divides the first, so that it has an edge where it should."""
    *of, motion, middle, there = gap
    for cell in dict.fromkeys(cell for cell, _ in there):
        then = cad.cut_by_image(part, cell, (of[0], of[1]), motion.matrix, motion.shift)
        if then is not None and _is_there(then, model, options, middle):
            return then
    return None


def _is_there(part: Part, model: Part, options: SweepOptions, middle: np.ndarray) -> bool:
    """Whether a matched face has an edge at a place (1, 3)."""
    near = nearness(part)
    return any(
        float(edge.curve.distance(middle)[0]) <= near
        for match in find_matches(part, model, options)
        for own in match.places
        for edge in edges_of(part, own).values()
    )


__all__ = ["answering"]
