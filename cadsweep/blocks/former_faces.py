"""Which boundary quads belong to a patch of a merged face.

Place in the flow: called by ``finish``. The mesh does not follow a patch's outline, so a quad belongs to it where its
middle does. Who has no such quad gets one of the others', where these are more than one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray, IntArray
from ..brep import Face, lie_in

_EACH = 3
"""Patches up to which every one has a line of its own."""


def own_quads(corners: FloatArray, face: Face) -> IntArray:
    """The owner (q,) of every quad, with corners (q, 4, 3), of a face: 0 for the face, ``j + 1`` for patch ``j``."""
    owners = np.zeros(len(corners), dtype=np.int64)
    middles = corners.mean(axis=1)
    inside = lie_in(face.former, middles)
    for j in sorted(range(len(face.former)), key=lambda j: face.former[j].area):
        patch = face.former[j]
        free = np.flatnonzero(owners == 0)
        own = free[inside[j, free]]
        if not len(own) and len(free) > 1:
            own = free[[np.argmin(np.linalg.norm(middles[free] - patch.place, axis=1))]]
        owners[own] = j + 1
    if len(owners) > 1 and owners.all():  # what is no patch is left out: the patch with most quads has one less
        most = int(np.argmax(np.bincount(owners)))
        own = np.flatnonzero(owners == most)
        if len(own) > 1:
            owners[own[np.argmax(np.linalg.norm(middles[own] - face.former[most - 1].place, axis=1))]] = 0
    return owners


def describe_shares(corners: FloatArray, owners: IntArray, face: Face, names: Sequence[str]) -> list[str]:
    """Lines for the mesh's notes on the patches of a face, `names` by owner: one each, or one for all if many."""
    notes = [
        f"boundary '{name}' has no quads on {face.label()}: it is smaller there than one"
        for owner, name in enumerate(names)
        if not (owners == owner).any()
    ]
    diagonals = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    areas = np.bincount(owners, 0.5 * np.linalg.norm(diagonals, axis=1), len(names))
    shares = {j + 1: areas[j + 1] / patch.area for j, patch in enumerate(face.former) if areas[j + 1] > 0.0}

    def has(owner: int) -> str:
        return f"{100 * shares[owner]:.3g} % of"

    if len(shares) <= _EACH:
        return notes + [
            f"boundary '{names[owner]}': the mesh does not follow its outline on {face.label()}; it has the "
            f"{np.count_nonzero(owners == owner)} quads whose middles lie in it, {has(owner)} its area"
            for owner in sorted(shares, key=lambda owner: face.former[owner - 1].area)
        ]
    ordered = sorted(shares, key=lambda owner: shares[owner])
    least, most = (f"{has(owner)} '{names[owner]}'" for owner in (ordered[0], ordered[-1]))
    return notes + [
        f"the mesh does not follow the outlines of {len(shares)} boundaries on {face.label()}; "
        f"they have the quads whose middles lie in them, from {least} to {most}"
    ]
