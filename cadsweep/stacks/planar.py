"""How good the quads of every cell of an arrangement are, beside what its corners allow.

Place in the flow: after the arrangement has been meshed. Columns are straight, so the worst corner of a hexahedron is
that of its quad, but for the lean of its caps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray
from ..mesh import QuadMesh
from ..stack import Levels, Stack
from ..sweep import DirectedEdge
from .along import across
from .blocks import find_presence
from .places import find_places
from .sides import LEAST_ACROSS, MOST_ACROSS

_ENDS_ALONG = 1e-3
"""1 - cosine to the direction up to which an edge ends along it."""
WANTED = 0.35
"""Worst corner sine below which a cell is worth shorter segments: somewhat more than is promised of hexahedra."""
_GAIN = np.radians(0.5)
"""Angle by which a corner must open for twice the segments to be worth it."""
_SHARP = np.radians(20.0)
"""Interior angle of a cell below which the chords beside it matter: those of an arc may be as much off its tangent."""
_BLUNT = np.radians(8.0)
"""Angle between the chords at a corner that is sharper still, where outlines are tangent: a corner sine of 0.14."""
_KEPT = 0.7
"""Part of a sharp corner's angle that the chords beside it should leave."""
_SHARE = 0.9
"""Part of what a cell's own corners allow that is good enough."""


def corner_sines(corners: FloatArray) -> FloatArray:
    """Least sine of the corners of quads (..., 4, 2), counter-clockwise in the frame; negative where folded."""
    after, before = np.roll(corners, -1, axis=-2) - corners, np.roll(corners, 1, axis=-2) - corners
    area = after[..., 0] * before[..., 1] - after[..., 1] * before[..., 0]
    lengths = np.sqrt((after**2).sum(axis=-1) * (before**2).sum(axis=-1))
    return np.asarray((area / np.maximum(lengths, 1e-300)).min(axis=-1))


@dataclass(frozen=True, kw_only=True, eq=False)
class Judged:
    """How good the quads of an arrangement are where the part has them.

    Attributes
    ----------
    poor : set of int
        Edges of the arrangement by the quads that are worse than their cells ask.
    around : set of int
        All edges of the cells that have such quads.
    folded : set of int
        Those of `poor` by quads that are folded.
    worst : float
        Worst corner sine of all quads.
    n_folded : int
        Cells with folded quads.
    lacks : (n_faces,) float64
        What the worst quad over each face of the prism lacks of what its cell allows.
    """

    poor: set[int]
    around: set[int]
    folded: set[int]
    worst: float
    n_folded: int
    lacks: FloatArray

    @property
    def lacking(self) -> float:
        """What all cells lack, in sum."""
        return float(self.lacks.sum())

    @property
    def rank(self) -> tuple[int, float]:
        """Cells with folded quads, then what all cells lack: of two meshes of one plane the less is the better."""
        return self.n_folded, self.lacking


def judge_plane(stack: Stack, levels: Levels, mesh: QuadMesh) -> Judged:
    """Judge the quads of every cell, on the levels where it has material: outlines may be elsewhere on each."""
    arrangement = stack.arrangement
    frame = across(stack.direction)
    sines = corner_sines((mesh.points @ frame.T)[mesh.quads])
    if arrangement.claims:
        sines[:] = 1.0  # outlines that were laid together need not be there on any level
        for places, there in zip(find_places(stack, levels, mesh), find_presence(stack, levels, mesh), strict=True):
            sines[there] = np.minimum(sines[there], corner_sines((places @ frame.T)[mesh.quads[there]]))
    worst = np.ones(len(arrangement.prism.faces))
    np.minimum.at(worst, mesh.faces, sines)
    wanted = np.zeros(len(worst))
    for f in arrangement.bottoms:
        face = arrangement.prism.faces[f]
        sharpest = min([np.pi / 2, *(angle for loop in face.loops for angle in loop.angles)])
        wanted[f] = min(WANTED, _SHARE * float(np.sin(sharpest)))
    around = {e for f in np.flatnonzero(worst < wanted).tolist() for e in arrangement.prism.faces[f].edges}
    poor, folded = (
        {e for e in around if near[mesh.edge_nodes[e]].any()}
        for near in (_near(mesh, sines < wanted[mesh.faces]), _near(mesh, sines <= 0.0))
    )
    return Judged(
        poor=poor,
        around=around,
        folded=folded,
        worst=float(sines.min()),
        n_folded=int(np.count_nonzero(worst <= 0.0)),
        lacks=np.maximum(wanted - worst, 0.0),
    )


def _near(mesh: QuadMesh, chosen: BoolArray) -> BoolArray:
    """Nodes (n,) of some quads, and of those beside them."""
    near = np.zeros(len(mesh.points), dtype=bool)
    near[mesh.quads[chosen]] = True
    near[mesh.quads[near[mesh.quads].any(axis=1)]] = True
    return near


def sizes_across(stack: Stack, size: float) -> dict[int, float]:
    """Lengths of the segments of edges across roundings, where the plane shows nothing of their turn.

    Returns
    -------
    dict of int to float
        By edge of the arrangement: such that a quarter of a circle has two chords or more, and three at most, since of
        more the one at the wall would be too steep.
    """
    solid, rounded = stack.solid, set(stack.rounded)
    sizes: dict[int, float] = {}
    for own, over in stack.arrangement.over.items():
        for e in over:
            edge = solid.edges[e]
            if not rounded.intersection(edge.faces):
                continue
            quarters = int(np.sum(np.abs(edge.tangents @ stack.direction) > 1.0 - _ENDS_ALONG))
            if quarters:
                length = stack.arrangement.prism.edges[own].length
                sizes[own] = length / min(max(round(length / size), LEAST_ACROSS * quarters), MOST_ACROSS * quarters)
    return sizes


def divide_at_cusps(stack: Stack, counts: IntArray) -> dict[int, float]:
    """Shorter segments for edges whose chords close the sharp corners of cells, or cross there.

    Outlines that are tangent, or nearly so, part only by their curvature: a chord is off its tangent by half of what
    the edge turns over it. Finer segments on the flatter edge open the corner; on both, they leave it as it is.

    Parameters
    ----------
    stack : Stack
    counts : (n_edges,) int64
        Segments of the edges of the arrangement.

    Returns
    -------
    dict of int to float
        Wanted lengths; empty where nothing is gained.
    """
    solid = stack.arrangement.prism
    sizes: dict[int, float] = {}
    for f in stack.arrangement.bottoms:
        for loop in solid.faces[f].loops:
            directed = loop.directed
            for j, angle in enumerate(loop.angles):
                if angle >= _SHARP:
                    continue
                sides = (directed[j - 1], directed[j])
                n = [int(counts[e]) for e, _ in sides]
                wanted = max(_KEPT * angle, _BLUNT)
                now = _chord_angle(stack, sides, n)
                options = [(_chord_angle(stack, sides, [n[0] * (2 - k), n[1] * (1 + k)]), k) for k in (0, 1)]
                opened, k = max(options)
                if now < wanted and opened > now + _GAIN:
                    e = sides[k][0]
                    sizes[e] = solid.edges[e].length / (2 * n[k])
    return sizes


def _chord_angle(stack: Stack, sides: tuple[DirectedEdge, DirectedEdge], counts: Sequence[int]) -> float:
    """Interior angle between the last chord of one edge and the first of the next; negative where they cross."""
    edges = stack.arrangement.prism.edges
    (one, one_forward), (other, other_forward) = sides
    first, last = 1.0 / counts[0], 1.0 / counts[1]
    into = edges[one].curve.evaluate(np.array([1.0 - first, 1.0] if one_forward else [first, 0.0]))
    out = edges[other].curve.evaluate(np.array([0.0, last] if other_forward else [1.0, 1.0 - last]))
    back, ahead = into[0] - into[1], out[1] - out[0]
    # The loop runs counter-clockwise seen from outside, from below.
    return float(np.arctan2(np.cross(ahead, back) @ -stack.direction, ahead @ back))
