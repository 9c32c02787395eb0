"""How far the faces and edges of a part move to those of another: what decides between ways to pair them.

Place in the flow: :mod:`.matching` asks for the cost of a pairing of darts, and takes the least.

Method: a dart is seen at its start and at the middle of its edge, in the bounding box of its part. Distances are
counted by ``d / (d + FAR)``: what is far off is no worse for being further, so that of two ways the one is less that
keeps more where it was. What hangs in a face that is paired already (a hole) is seen through the least-squares affine
map of what is known of that face: there it may lie elsewhere than in the box, because the part is bent or stretched.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ...arrays import FloatArray, IntArray

FAR = 0.05
"""Part of a part's or a face's extent that counts half of the way to being somewhere else."""

_ALL = -1
"""Stands for all known faces together."""


class Places:
    """Where the darts of two parts are.

    Parameters
    ----------
    here, there : (n, k, 3) float64
        Points of every dart of the one part and of the other.
    faces, faces_there : sequence of int
        The face of every dart.
    """

    def __init__(self, here: FloatArray, there: FloatArray, faces: Sequence[int], faces_there: Sequence[int]) -> None:
        self.here, self.there = here, there
        self.faces, self.faces_there = np.array(faces, dtype=np.int64), np.array(faces_there, dtype=np.int64)

    def moved(self, image: Mapping[int, int]) -> float:
        """How far the darts of an image are from their partners, 0 to 1."""
        return float(_far(self.there[list(image.values())] - self.here[list(image)]).mean())

    def known(self, image: Mapping[int, int]) -> FaceMaps:
        """The maps of the faces of an image."""
        return FaceMaps(self, np.array(list(image)), np.array(list(image.values())))


class FaceMaps:
    """The affine maps of what is known of faces, by least squares; made where they are asked for."""

    def __init__(self, places: Places, darts: IntArray, partners: IntArray) -> None:
        self._places, self._darts, self._partners = places, darts, partners
        self._known = set(places.faces[darts].tolist())
        self._maps: dict[int, _AffineMap] = {}

    def distances(
        self, holes: Sequence[Sequence[int]], others: Sequence[Sequence[int]], partners: Mapping[int, int]
    ) -> FloatArray:
        """How far the middle of every hole (h,) is from that of every other one there (o,), 0 to 1, seen through its
        faces' maps; infinite where those do not answer each other. `partners` are the known faces'."""
        places, theirs = self._places, set(partners.values())
        own = [self._middles(darts, places.here, places.faces, self._known) for darts in holes]
        other = [self._middles(darts, places.there, places.faces_there, theirs) for darts in others]
        distances = np.full((len(own), len(other)), np.inf)
        of_partners: dict[frozenset[int], list[int]] = {}
        for j, middles in enumerate(other):
            of_partners.setdefault(frozenset(middles), []).append(j)
        for i, middles in enumerate(own):
            columns = of_partners.get(frozenset(partners.get(face, face) for face in middles), [])
            if columns:
                steps = [
                    (np.array([other[j][partners.get(face, face)] for j in columns]) - self._map(face)(middle))
                    / self._map(face).extent
                    for face, middle in middles.items()
                ]
                distances[i, columns] = np.mean([_far(step) for step in steps], axis=0)
        return distances

    def turned(self, image: Mapping[int, int]) -> float:
        """How differently a hole lies from its partner, both laid middle on middle."""
        places, darts, partners = self._places, np.array(list(image)), np.array(list(image.values()))
        found = []
        of = places.faces[darts]
        for face in self._known.intersection(of.tolist()) or {_ALL}:
            chosen = (of == face) | (face == _ALL)
            map_ = self._map(face)
            steps = places.there[partners[chosen]] - map_(places.here[darts[chosen]])
            steps -= steps.mean(axis=(0, 1))
            found.append(float(np.linalg.norm(steps, axis=-1).mean()) / map_.extent)
        return float(np.mean(found))

    def _middles(
        self, darts: Sequence[int], points: FloatArray, faces: IntArray, known: set[int]
    ) -> dict[int, FloatArray]:
        """Middle of the darts in every known face they are in; of all of them if there is none."""
        numbers = np.array(darts)
        of = faces[numbers]
        chosen = known.intersection(of.tolist())
        if not chosen:
            return {_ALL: points[numbers].mean(axis=(0, 1))}
        return {face: points[numbers[of == face]].mean(axis=(0, 1)) for face in chosen}

    def _map(self, face: int) -> _AffineMap:
        if face not in self._maps:
            chosen = (self._places.faces[self._darts] == face) | (face == _ALL)
            here, there = self._places.here[self._darts[chosen]], self._places.there[self._partners[chosen]]
            self._maps[face] = _AffineMap(here, there)
        return self._maps[face]


class _AffineMap:
    """Takes points (..., 3) to where known ones are; what is across all that they span is lost."""

    def __init__(self, here: FloatArray, there: FloatArray) -> None:
        own, theirs = here.reshape(-1, 3), there.reshape(-1, 3)
        self._from, self._to = own.mean(axis=0), theirs.mean(axis=0)
        self._linear = np.linalg.lstsq(own - self._from, theirs - self._to, rcond=1e-6)[0]
        spread = float(np.linalg.norm(theirs - self._to, axis=1).max())
        self.extent = spread if spread > 0.0 else 1.0

    def __call__(self, points: FloatArray) -> FloatArray:
        return np.asarray(self._to + (points - self._from) @ self._linear)


def _far(steps: FloatArray) -> FloatArray:
    lengths = np.linalg.norm(steps, axis=-1)
    return np.asarray(lengths / (lengths + FAR))
