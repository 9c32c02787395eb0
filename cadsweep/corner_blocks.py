"""A cell as one block of hexahedra at every corner, for what no sweep can be: a tetrahedron, a cut-off corner.

Place in the flow: ``recognition`` makes a :class:`CornerBlocks` of a :class:`~cadsweep.brep.Solid` whose corners all
have three edges; ``plan`` takes it where no sweep of the cell agrees with its neighbours, ``intervals`` counts, and
``surface`` and ``pipeline`` mesh it beside swept cells.

Method: midpoint subdivision. Every corner owns half of its three edges, a quarter or so of its three faces, and a
block between these and the middle of the cell. ::

              corner                 A sheet of hexahedra runs along every face, so many thick: every edge is as many
                /\\                   segments as the two sheets that it crosses, those of the faces across its ends.
               /  \\
              /\\  /\\
             /  \\/  \\
            /___||___\\

Li, McKeag, Armstrong, "Hexahedral meshing using midpoint subdivision and integer programming" (1995).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from .arrays import FloatArray, IntArray
from .brep import Solid
from .sweep import DirectedEdge, LinkingSide


@dataclass(frozen=True, kw_only=True, eq=False)
class View:
    """The places that lie on the inner side of planes: where lines to a whole outline stay inside of it.

    Attributes
    ----------
    normals : (n, 3) float64
        Inward.
    offsets : (n,) float64
        ``normal . x`` of the planes.
    plane : ((3,) float64, float) or None
        A plane that the places lie in.
    """

    normals: FloatArray
    offsets: FloatArray
    plane: tuple[FloatArray, float] | None = None

    @classmethod
    def of(cls, places: FloatArray, normals: FloatArray, plane: tuple[FloatArray, float] | None = None) -> View:
        """Of planes through places (n, 3); those without a normal are left out."""
        known = np.isfinite(normals).all(axis=1)
        return cls(normals=normals[known], offsets=(places * normals).sum(axis=1)[known], plane=plane)

    def depth(self) -> float:
        """The greatest distance of a place from all planes; 0 where there is none."""
        found = scipy.optimize.linprog(
            [0.0, 0.0, 0.0, -1.0],
            np.column_stack([-self.normals, np.ones(len(self.normals))]),
            -self.offsets,
            A_eq=None if self.plane is None else [[*self.plane[0], 0.0]],
            b_eq=None if self.plane is None else [self.plane[1]],
            bounds=[(None, None)] * 3 + [(0.0, None)],
        )
        return float(found.x[3]) if found.success else 0.0

    def nearest(self, wanted: FloatArray) -> FloatArray:
        """The place next to a wanted one (3,) of those half as far inside as any."""
        if not len(self.normals):
            return wanted
        inside = 0.5 * self.depth()
        if (self.normals @ wanted - self.offsets).min() >= inside:
            return wanted
        beside = np.eye(3)  # the distance along the axes, one after another
        rows = [(-self.normals, np.zeros((len(self.normals), 3))), (beside, -beside), (-beside, -beside)]
        found = scipy.optimize.linprog(
            [0.0] * 3 + [1.0] * 3,
            np.concatenate([np.column_stack(row) for row in rows]),
            np.concatenate([-self.offsets - inside, wanted, -wanted]),
            A_eq=None if self.plane is None else [[*self.plane[0], 0.0, 0.0, 0.0]],
            b_eq=None if self.plane is None else [self.plane[1]],
            bounds=[(None, None)] * 6,
        )
        assert found.success, "some place is half as deep as the deepest"
        return np.asarray(found.x[:3])


def balanced(places: FloatArray, counts: IntArray) -> FloatArray:
    """The point (3,) to which lines of as many segments from places (n, 3) pull with the same force a length."""
    return np.asarray(np.average(places, axis=0, weights=1.0 / np.asarray(counts)))


@dataclass(frozen=True, kw_only=True, eq=False)
class CornerBlocks:
    """A cell whose corners have three edges each.

    Attributes
    ----------
    solid : Solid
    corners : tuple of int
        Vertex ids; the other vertices lie inside a chain.
    chains : tuple of tuple of DirectedEdge
        The edges between two corners, one after another.
    ends : tuple of (int, int)
        The corners at the start and at the end of every chain.
    across : tuple of (int, int)
        The faces across the start and the end of every chain: those that meet it there in its corner alone.
    outlines : mapping of int to tuple of (int, bool)
        For every face the chains of its outline, and whether each is run through forward; material on the left, seen
        from outside.
    grids : mapping of int to LinkingSide
        The faces with four corners.
    view : View
        Where all faces are seen from inside.
    face_views : mapping of int to View
        On every face, where all of its outline is seen.
    score : float
        Expected quality; below that of any good sweep.
    """

    solid: Solid
    corners: tuple[int, ...]
    chains: tuple[tuple[DirectedEdge, ...], ...]
    ends: tuple[tuple[int, int], ...]
    across: tuple[tuple[int, int], ...]
    outlines: Mapping[int, tuple[DirectedEdge, ...]]
    grids: Mapping[int, LinkingSide]
    view: View
    face_views: Mapping[int, View]
    score: float

    @property
    def stars(self) -> tuple[int, ...]:
        """Ids of the faces that have not four corners: their quads meet in a star."""
        return tuple(face for face in self.outlines if face not in self.grids)

    def sheets(self, counts: Sequence[int]) -> IntArray:
        """Thickness of the sheet along every face, in hexahedra.

        Parameters
        ----------
        counts : sequence of int
            Segments of every chain; each is the sum of two sheets.

        Returns
        -------
        (n_faces,) int64
            Where the counts leave a choice (they do where no odd number of faces goes around), as even as they can be.
        """
        beside: dict[int, list[tuple[int, int]]] = {}
        for (start, end), count in zip(self.across, counts, strict=True):
            beside.setdefault(start, []).append((end, int(count)))
            beside.setdefault(end, []).append((start, int(count)))
        found = np.zeros(len(self.solid.faces), dtype=np.int64)
        known: set[int] = set()
        for root in beside:
            if root not in known:
                own = _component(root, beside)
                known |= own.keys()
                for face, thickness in _settled(own, beside).items():
                    found[face] = thickness
        return found


def _component(root: int, beside: Mapping[int, Sequence[tuple[int, int]]]) -> dict[int, tuple[int, int]]:
    """Every sheet that hangs together with one as ``constant + sign * root``."""
    own = {root: (0, 1)}
    waiting = [root]
    while waiting:
        face = waiting.pop()
        constant, sign = own[face]
        for other, count in beside[face]:
            if other not in own:
                own[other] = (count - constant, -sign)
                waiting.append(other)
    return own


def _settled(own: Mapping[int, tuple[int, int]], beside: Mapping[int, Sequence[tuple[int, int]]]) -> dict[int, int]:
    """The thickness of every sheet of a component."""
    for face, (constant, sign) in own.items():
        for other, count in beside[face]:
            more, same = own[other]
            if same == sign:  # an odd way around: constant + more + 2 sign root = count
                root = sign * (count - constant - more) // 2
                break
        else:
            continue
        break
    else:
        least = max(1 - constant for constant, sign in own.values() if sign > 0)
        most = min(constant - 1 for constant, sign in own.values() if sign < 0)
        root = (least + most) // 2
    thickness = {face: constant + sign * root for face, (constant, sign) in own.items()}
    sums = all(thickness[a] + thickness[b] == count for a in own for b, count in beside[a])
    assert sums, "the counts are sums of sheets"
    assert min(thickness.values()) > 0, "every sheet is at least one hexahedron thick"
    return thickness
