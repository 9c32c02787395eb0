"""Solids that recognition cannot tell apart: copies of one, moved.

Place in the flow: ``pipeline`` asks for the sweeps of every cell; a wall of a hundred bricks has few different ones.

What recognition reads of a solid, besides names for its messages: which edges bound which faces, angles, kinds, areas,
and where vertices and the middles of edges and faces are. Solids that agree in all of it from their first vertex on
have the same sweeps. Copies that are turned, or numbered otherwise, count as different, which only costs time.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import replace

import numpy as np

from ..brep import Solid
from ..sweep import Sweep
from .find import search_sweeps

_ALIKE = 1e-9
"""Difference of lengths, as a share of the solid's size, and of angles, that is rounding: what is no more than ten
times the noise of coordinates in double precision at the far side of a part of a million of them."""


def sweeps_of_each(solids: Sequence[Solid]) -> list[list[Sweep]]:
    """Sweeps of each of several solids, best first; none where there are none. Copies are looked at once.

    Parameters
    ----------
    solids : sequence of Solid

    Returns
    -------
    list of list of Sweep
    """
    known: dict[Hashable, list[Sweep]] = {}
    found = []
    for solid in solids:
        key = _signature(solid)
        if key not in known:
            known[key] = search_sweeps(solid).sweeps
        found.append([sweep if sweep.solid is solid else replace(sweep, solid=solid) for sweep in known[key]])
    return found


def _signature(solid: Solid) -> Hashable:
    """What recognition reads of a solid, lengths to a billionth of its size and from its first vertex on."""
    if any(face.former for face in solid.faces):
        return solid  # what a merged face is made of is known to callables alone
    origin = solid.vertices[0]
    edges, faces = solid.edges, solid.faces
    topology = (
        tuple((edge.start, edge.end, edge.kind, edge.faces) for edge in edges),
        tuple((face.kind, tuple((loop.edges, loop.forward) for loop in face.loops)) for face in faces),
        solid.opened,
    )
    step = _ALIKE * solid.size
    points = np.concatenate([solid.vertices, [edge.midpoint for edge in edges], [face.center for face in faces]])
    angles = [loop.angles for face in faces for loop in face.loops]
    pure = np.concatenate(
        [
            [edge.dihedral for edge in edges],
            *angles,
            np.ravel([edge.tangents for edge in edges]),
            np.ravel([face.normal for face in faces]),
            [face.area / solid.size**2 for face in faces],
            [edge.length / solid.size for edge in edges],
        ]
    )
    rounded = np.concatenate([np.rint((points - origin) / step).ravel(), np.rint(pure / _ALIKE)])
    return topology, float(np.rint(np.log(solid.size) / _ALIKE)), rounded.astype(np.int64).tobytes()


__all__ = ["sweeps_of_each"]
