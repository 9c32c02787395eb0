r"""Block-structured quads of caps without holes: a lattice where all corners are right, a square core where none is.

Place in the flow: two of the ways of :mod:`.filling`.

Method: the outline alone tells which quads there are. Between right and re-entrant corners its nodes are places of a
lattice (submapping: Whiteley, White, Benzley and Blacker, "Two and three-quarter dimensional meshing facilitators",
1996); an outline without corners gets rings of quads around a core of p x q of them, with 2 (p + q) nodes around::

    o--o--o--o              o---o---o
    |  |  |  |             / \  |  / \
    o--o--o--o--o--o      o---o-o-o---o
    |  |  |  |  |  |      |   o-o-o   |
    o--o--o--o--o--o      o---o-o-o---o
    |  |  |  |  |  |       \ /  |  \ /
    o--o--o--o--o--o        o---o---o

Inner nodes stand at the mean of their neighbours in a plane chart, by one sparse solve: what is symmetric in the
outline is symmetric inside.

Not handled: caps with holes, and outlines on which quads should grow towards the inside.
"""

from __future__ import annotations

import numpy as np
import scipy

from ..arrays import FloatArray, IntArray
from ..brep import quarter_turns
from .chart import signed_area
from .outline import FaceQuads, Outline

_SMOOTH = np.pi / 6
"""Greatest turn at a vertex of an outline that has no corners."""
_LEAST_AROUND = 6
"""Nodes around a core of 1 x 2 quads; fewer leave no choice."""
_RINGS = 0.45
"""Part of the half width that the rings take: core and rings then have quads of one size, as good as it gets."""

_STEPS = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])


def fill_lattice(outline: Outline) -> FaceQuads | None:
    """A lattice on a face whose corners are all right or re-entrant; None where its outline is none of one."""
    if len(outline.loops) != 1 or outline.grows():
        return None
    loop = outline.loops[0]
    turns = quarter_turns(outline.angles(loop))
    if turns is None or sum(turns) != 4:
        return None
    ways = np.repeat(np.cumsum(turns) % 4, [int(outline.counts[e]) for e, _ in loop])
    places = np.cumsum(_STEPS[ways], axis=0)
    if places[-1].any():
        return None  # the ways there and back have not as many segments
    lattice = np.concatenate([np.zeros((1, 2), dtype=np.int64), places[:-1]])
    lattice -= lattice.min(axis=0)
    if len(np.unique(lattice, axis=0)) < len(lattice):
        return None  # it runs into itself
    return _relaxed(outline, *_inside_of(lattice))


def _inside_of(lattice: IntArray) -> tuple[int, IntArray]:
    """Number of inner nodes, and quads, of a simple lattice polygon (n, 2); its own nodes come first."""
    width, height = lattice.max(axis=0)
    winding = np.zeros((width + 1, height), dtype=np.int64)
    step = np.roll(lattice, -1, axis=0) - lattice
    up, down = (step[:, 1] == 1), (step[:, 1] == -1)
    np.subtract.at(winding, (lattice[up, 0], lattice[up, 1]), 1)
    np.add.at(winding, (lattice[down, 0], lattice[down, 1] - 1), 1)
    cells = np.argwhere(np.cumsum(winding, axis=0)[:-1] > 0)
    number = np.full((width + 1, height + 1), -1, dtype=np.int64)
    number[lattice[:, 0], lattice[:, 1]] = np.arange(len(lattice))
    corners = cells[:, None] + np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    touched = np.zeros(number.shape, dtype=np.bool_)
    touched[corners[..., 0], corners[..., 1]] = True
    inner = np.argwhere(touched & (number < 0))
    number[inner[:, 0], inner[:, 1]] = len(lattice) + np.arange(len(inner))
    return len(inner), number[corners[..., 0], corners[..., 1]]


def fill_round_core(outline: Outline) -> FaceQuads | None:
    """Rings around a rectangular core, on a face whose outline has no corners; None where it has some, or holes."""
    if len(outline.loops) != 1 or outline.grows():
        return None
    n = len(outline.nodes[0])
    if any(abs(angle - np.pi) > _SMOOTH for angle in outline.angles(outline.loops[0])) or n % 2 or n < _LEAST_AROUND:
        return None
    chart = next(outline.charts(outline.nodes), None)
    if chart is None:
        return None
    rim = chart.boundary[0]
    first, p = _core_corners(rim)
    segment = float(np.mean(np.linalg.norm(np.roll(rim, -1, axis=0) - rim, axis=1)))
    half = min(2.0 * signed_area(rim) / (n * segment), float(np.ptp(_turned(rim), axis=0).min()) / 2.0)
    return _relaxed(outline, *_around_core(n, first, p, max(1, round(_RINGS * half / segment))))


def _turned(rim: FloatArray) -> FloatArray:
    """The outline (n, 2) about its centre, along its principal axes; along its first node where these are none."""
    centred = rim - rim.mean(axis=0)
    values, axes = np.linalg.eigh(centred.T @ centred)
    if values[0] > 0.95 * values[1]:
        x = centred[0] / np.linalg.norm(centred[0])
        turned = np.array([x, [-x[1], x[0]]])
        half = np.sqrt(0.5)
        axes = (np.array([[half, half], [-half, half]]) @ turned).T  # the first node is a corner of the core
    return centred @ axes


def _core_corners(rim: FloatArray) -> tuple[int, int]:
    """Node over the core's first corner, and segments up to the second: where the outline reaches farthest aslant."""
    n, places = len(rim), _turned(rim)
    x, y = places.T
    if signed_area(places) < 0:
        y = -y  # the axes are a reflection
    corners = sorted(int(np.argmax(a * x + b * y)) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)))
    sides = np.diff([*corners, corners[0] + n])
    p = int(np.clip(round(float(sides[0] + sides[2]) / 2.0), 1, n // 2 - 1))
    return corners[0], p


def _around_core(n: int, first: int, p: int, rings: int) -> tuple[int, IntArray]:
    """Number of inner nodes, and quads, of rings around a core of p x (n / 2 - p) quads; the rim's n nodes first."""
    q = n // 2 - p
    ring = np.arange((rings + 1) * n, dtype=np.int64).reshape(rings + 1, n)
    after = np.roll(ring, -1, axis=1)
    around = np.stack([ring[:-1], after[:-1], after[1:], ring[1:]], axis=-1).reshape(-1, 4)
    core = np.empty((p + 1, q + 1), dtype=np.int64)
    edge = np.roll(ring[-1], -first)
    core[:, 0] = edge[: p + 1]
    core[-1, :] = edge[p : p + q + 1]
    core[:, -1] = edge[p + q : 2 * p + q + 1][::-1]
    core[0, 1:] = edge[2 * p + q :][::-1]
    n_core = (p - 1) * (q - 1)
    core[1:-1, 1:-1] = (rings + 1) * n + np.arange(n_core).reshape(p - 1, q - 1)
    inside = np.stack([core[:-1, :-1], core[1:, :-1], core[1:, 1:], core[:-1, 1:]], axis=-1).reshape(-1, 4)
    return rings * n + n_core, np.concatenate([around, inside])


def _relaxed(outline: Outline, n_inner: int, quads: IntArray) -> FaceQuads | None:
    """Quads whose inner nodes stand at the mean of their neighbours in the most faithful chart."""
    chart = next(outline.charts(outline.nodes), None)
    if chart is None:
        return None
    rim = chart.boundary[0]
    n = len(rim) + n_inner
    ends = np.unique(np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1), axis=0)
    links = scipy.sparse.coo_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(n, n)).tocsr()
    links = links + links.T
    laplacian = (scipy.sparse.diags_array(links.sum(axis=1)) - links).tocsc()
    free, given = laplacian[len(rim) :, len(rim) :], laplacian[len(rim) :, : len(rim)]
    inner = np.zeros((0, 2)) if n_inner == 0 else scipy.sparse.linalg.spsolve(free, -(given @ rim)).reshape(-1, 2)
    return outline.lift(chart, inner, quads, outline.nodes[0])
