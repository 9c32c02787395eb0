"""Which boundary quads belong to a patch of a merged face.

Place in the flow: called by ``assembly``. The mesh does not follow a patch's outline, so a quad belongs to
it where its middle does, and a patch too small for that has the one quad nearest to it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray, IntArray
from ..brep import Face


@dataclass(frozen=True, kw_only=True)
class Share:
    """What the patch of a face got: how many quads, and their area. ``owner`` is the patch's."""

    face: int
    patch: int
    owner: int
    n_quads: int
    area: float


_EACH = 3
"""Patches up to which every one has a line of its own."""


def describe_shares(shares: Sequence[Share], faces: Sequence[Face], names: Sequence[str]) -> list[str]:
    """Lines for the mesh's notes on the patches of a face: one each, or one for all where there are many."""

    def has(share: Share) -> str:
        return f"{100 * share.area / faces[share.face].former[share.patch].area:.3g} % of"

    if len(shares) <= _EACH:
        return [
            f"boundary '{names[share.owner]}': the mesh does not follow its outline on {faces[share.face].label()}; "
            f"it has the {share.n_quads} quads whose middles lie in it, {has(share)} its area"
            for share in shares
        ]
    ordered = sorted(shares, key=lambda share: share.area / faces[share.face].former[share.patch].area)
    least, most = (f"{has(share)} '{names[share.owner]}'" for share in (ordered[0], ordered[-1]))
    return [
        f"the mesh does not follow the outlines of {len(shares)} boundaries on {faces[shares[0].face].label()}; "
        f"they have the quads whose middles lie in them, from {least} to {most}"
    ]


def own_quads(
    face_ids: IntArray,
    corners_of: Callable[[tuple[IntArray, ...]], FloatArray],
    faces: Sequence[Face],
    table: IntArray,
    patches: Mapping[tuple[int, int], int],
) -> tuple[IntArray, list[Share]]:
    """Give every quad its owner.

    Parameters
    ----------
    face_ids : (...) int64
        Face of each quad.
    corners_of : callable
        Corners (m, 4, 3), working units, of the quads at some places among `face_ids`: few ask for them.
    faces : sequence of Face
        All faces of the solid.
    table : (n_faces,) int64
        Owner by face.
    patches : mapping of (face id, number of the patch) to int
        Owner by patch.

    Returns
    -------
    owners : (...) int64
    shares : list of Share
    """
    owners, shares = table[face_ids], []
    by_patch: dict[int, list[tuple[int, int]]] = {}  # a face that was divided has its patches on both parts
    for f, j in sorted(patches, key=lambda place: faces[place[0]].former[place[1]].area):
        by_patch.setdefault(id(faces[f].former[j]), []).append((f, j))
    taken = np.zeros(face_ids.shape, dtype=bool)
    for places in by_patch.values():
        f, j = places[0]
        patch = faces[f].former[j]
        mine = np.nonzero(np.isin(face_ids, [f for f, _ in places]) & ~taken)
        if not len(mine[0]):
            continue
        quads = corners_of(mine)
        middles = quads.mean(axis=1)
        chosen = patch.contains(middles)
        if not chosen.any():
            chosen[np.argmin(np.linalg.norm(middles - patch.place, axis=1))] = True
        where = tuple(axis[chosen] for axis in mine)
        owners[where], taken[where] = patches[f, j], True
        diagonals = np.cross(quads[chosen, 2] - quads[chosen, 0], quads[chosen, 3] - quads[chosen, 1])
        area = 0.5 * float(np.linalg.norm(diagonals, axis=1).sum())
        shares.append(Share(face=f, patch=j, owner=patches[f, j], n_quads=int(chosen.sum()), area=area))
    return owners, shares
