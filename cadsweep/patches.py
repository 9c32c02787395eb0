"""Which boundary quads belong to a patch of a merged face.

Place in the flow: called by ``assembly``. The mesh does not follow a patch's outline, so a quad belongs to
it where its middle does, and a patch too small for that has the one quad nearest to it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from .topology import Face, FloatArray, IntArray


@dataclass(frozen=True, kw_only=True)
class Share:
    """What the patch of a face got: how many quads, and their area. ``owner`` is the patch's."""

    face: int
    patch: int
    owner: int
    n_quads: int
    area: float

    def describe(self, faces: Sequence[Face], names: Sequence[str]) -> str:
        """One line for the mesh's notes."""
        face = faces[self.face]
        return (
            f"boundary '{names[self.owner]}': the mesh does not follow its outline on {face.label()}; it has the "
            f"{self.n_quads} quads whose middles lie in it, {100 * self.area / face.patches[self.patch].area:.3g} % "
            "of its area"
        )


def own_quads(
    face_ids: IntArray,
    corners: FloatArray,
    faces: Sequence[Face],
    table: IntArray,
    patches: Mapping[tuple[int, int], int],
) -> tuple[IntArray, list[Share]]:
    """Give every quad its owner.

    Parameters
    ----------
    face_ids : (...) int64
        Face of each quad.
    corners : (..., 4, 3) float64
        Working units.
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
    for f in sorted({f for f, _ in patches}):
        mine = np.nonzero(face_ids == f)
        if not len(mine[0]):
            continue
        quads = corners[mine]
        middles = quads.mean(axis=1)
        areas = 0.5 * np.linalg.norm(np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1]), axis=1)
        free = np.ones(len(quads), dtype=bool)
        for j in sorted(range(len(faces[f].patches)), key=lambda j: faces[f].patches[j].area):
            patch = faces[f].patches[j]
            chosen = patch.contains(middles) & free
            if not chosen.any() and free.any():
                away = np.linalg.norm(middles - patch.place, axis=1)
                chosen[np.argmin(np.where(free, away, np.inf))] = True
            free &= ~chosen
            owners[tuple(axis[chosen] for axis in mine)] = patches[f, j]
            shares.append(
                Share(
                    face=f,
                    patch=j,
                    owner=patches[f, j],
                    n_quads=int(chosen.sum()),
                    area=float(areas[chosen].sum()),
                )
            )
    return owners, shares
