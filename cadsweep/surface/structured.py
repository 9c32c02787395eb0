r"""Block-structured quads of caps: a lattice where all corners are right, rings around a core where there is none.

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

A hole in a lattice takes a rectangle of as many cells around as it has segments. Inner nodes stand at the mean of
their neighbours in a plane chart, by one sparse solve: what is symmetric in the outline is symmetric inside.

Not handled: holes in outlines without corners, and outlines on which quads should grow towards the inside.
"""

from __future__ import annotations

import numpy as np
import scipy

from ..arrays import FloatArray, IntArray, distinct
from ..brep import quarter_turns
from ..polygons import signed_area
from .chart import Chart
from .outline import Outline

SMOOTH = np.pi / 6 + 1e-6
"""Greatest turn at a vertex of an outline that has no corners: a dodecagon's."""
_LEAST_AROUND = 6
"""Nodes around a core of 1 x 2 quads; fewer leave no choice."""
_RINGS = 0.45
"""Part of the half width that the rings take: core and rings then have quads of one size, as good as it gets."""

_EVENING = 3
"""Times that a curved face's links are weighed by their lengths."""

_AROUND = 4.0
"""Nodes of the lattice around a hole, in its longest segments, that tell where in the lattice its own nodes lie."""
_FEWEST = 100
"""Nodes, the nearest ones, that are asked where fewer are so near; all are where the hole reaches out of these."""
_MOST = 2000
"""Nodes up to which all those inside a hole are asked, too: triangles of more take longer than the rest."""
_CELLS_AT = 4
"""Nodes of the lattice next to a point whose cells are looked at for it."""
_SYMMETRIC = 1e-9
"""Distance, in sizes of the outline, up to which a core's corner lies where a mirror carries another one."""
_TIE = 1e-6
"""Cells of the lattice by which a place is nearer than another only by rounding."""
_STEPS = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])
_CELL = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])


def find_lattice(outline: Outline) -> tuple[Chart, int, IntArray] | None:
    """A lattice on a face whose corners are all right or re-entrant, its holes round or of four corners.

    Its chart, the number of inner nodes, and quads in ids of the outline's nodes, then of these.
    """
    if outline.grows():
        return None
    lattice = _lattice_of(outline)
    chart = None if lattice is None else next(outline.charts(outline.nodes), None)
    if lattice is None or chart is None:
        return None
    number, cells = _inside_of(lattice)
    if len(outline.loops) > 1:
        whole = _whole_of(chart.boundary[0], number, cells)
        pierced = pierce(outline, chart, number, cells, whole)
        if pierced is None:
            return None
        number, cells = pierced
    return chart, int(number.max()) + 1 - sum(map(len, outline.nodes)), quads_of(number, cells)


def _lattice_of(outline: Outline) -> IntArray | None:
    """Lattice places (n, 2) of the outer loop's nodes; None where they close to no simple polygon."""
    loop = outline.loops[0]
    turns = quarter_turns(outline.angles(loop))
    if turns is None or sum(turns) != 4:
        return None
    ways = np.repeat(np.cumsum(turns) % 4, [int(outline.counts[e]) for e, _ in loop])
    places = np.cumsum(_STEPS[ways], axis=0)
    lattice: IntArray = places - places.min(axis=0)
    closed = not places[-1].any()  # the ways there and back have as many segments
    return np.roll(lattice, 1, axis=0) if closed and len(np.unique(lattice, axis=0)) == len(lattice) else None


def _inside_of(lattice: IntArray) -> tuple[IntArray, IntArray]:
    """Numbers of the nodes of a simple lattice polygon (n, 2), its own first, by place; and the cells (m, 2) inside."""
    width, height = lattice.max(axis=0)
    winding = np.zeros((width + 1, height), dtype=np.int64)
    step = np.roll(lattice, -1, axis=0) - lattice
    up, down = (step[:, 1] == 1), (step[:, 1] == -1)
    np.subtract.at(winding, (lattice[up, 0], lattice[up, 1]), 1)
    np.add.at(winding, (lattice[down, 0], lattice[down, 1] - 1), 1)
    cells = np.argwhere(np.cumsum(winding, axis=0)[:-1] > 0)
    number = np.full((width + 1, height + 1), -1, dtype=np.int64)
    number[lattice[:, 0], lattice[:, 1]] = np.arange(len(lattice))
    return _numbered(number, cells, len(lattice)), cells


def _whole_of(rim: FloatArray, number: IntArray, cells: IntArray) -> FloatArray:
    """About where the nodes (n, 2) of a lattice without its holes are, the first ones at `rim`."""
    if 2 * (sum(number.shape) - 2) != len(rim):
        return embedded(rim, int(number.max()) + 1 - len(rim), quads_of(number, cells))
    # A rectangle: between its four sides, which is as good to look for holes as a solution for all its nodes.
    south, north, west, east = (rim[side] for side in (number[:, 0], number[:, -1], number[0], number[-1]))
    x, y = (np.linspace(0.0, 1.0, n)[:, None] for n in number.shape)
    at = (1 - y) * south[:, None] + y * north[:, None]
    at += (1 - x)[:, None] * (west - at[0]) + x[:, None] * (east - at[-1])
    places = np.empty((number.size, 2))
    places[number.ravel()] = at.reshape(-1, 2)
    return places


def _numbered(number: IntArray, cells: IntArray, first: int) -> IntArray:
    """The same numbers, and those of the inner nodes of cells, from `first` on; -1 where no cell is."""
    touched = np.zeros(number.shape, dtype=np.bool_)
    corners = cells[:, None] + _CELL
    touched[corners[..., 0], corners[..., 1]] = True
    inner = np.argwhere(touched & (number < 0))
    number[inner[:, 0], inner[:, 1]] = first + np.arange(len(inner))
    return number


def quads_of(number: IntArray, cells: IntArray) -> IntArray:
    corners = cells[:, None] + _CELL
    return number[corners[..., 0], corners[..., 1]]


def pierce(
    outline: Outline, chart: Chart, number: IntArray, cells: IntArray, whole: FloatArray
) -> tuple[IntArray, IntArray] | None:
    """Numbers and cells once the holes have taken their places; None where one has none.

    Each hole takes a rectangle of the lattice, as many cells around as it has segments, about where its middle lies
    among the nodes of the lattice without it, at `whole` (n, 2).
    """
    n_outer = len(outline.nodes[0])
    places = np.argwhere(number >= 0)
    order = number[places[:, 0], places[:, 1]]
    lattice = scipy.spatial.cKDTree(whole[order])
    is_cell = np.zeros(number.shape, dtype=np.bool_)
    is_cell[cells[:, 0], cells[:, 1]] = True
    taken = np.where((number >= 0) & (number < n_outer), number, -1)
    first = n_outer
    for j in range(1, len(outline.loops)):
        own = _places_in_lattice(chart.boundary[j], lattice, places)
        corners = _hole_corners(outline, j, own)
        if not np.isfinite(own).all() or corners is None:
            return None
        begin, q, p, low = _placed(own, *corners, np.array(number.shape) - 1, may_differ=_is_round(outline, j))
        around = low + places_around(p, q)
        x, y = around.T
        # A cell more on each side: quads with all their nodes on outlines could give way to nothing.
        beside = (slice(low[0] - 1, low[0] + p + 2), slice(low[1] - 1, low[1] + q + 2))
        if low.min() < 1 or taken[beside].size < (p + 3) * (q + 3) or (taken[beside] >= 0).any():
            return None
        within = (slice(low[0], low[0] + p), slice(low[1], low[1] + q))
        if (number[beside] < 0).any() or not is_cell[within].all():
            return None
        taken[x, y] = first + (begin + np.arange(len(own))) % len(own)
        is_cell[within] = False
        first += len(own)
    cells = np.argwhere(is_cell)
    return _numbered(taken, cells, first), cells


def _places_in_lattice(hole: FloatArray, lattice: scipy.spatial.cKDTree, places: IntArray) -> FloatArray:
    """Lattice places (m, 2) of the nodes of a hole, between those (n, 2) of the nodes around it; NaN outside of all."""
    middle = hole.mean(axis=0)
    segment = float(np.linalg.norm(np.roll(hole, -1, axis=0) - hole, axis=1).max())
    reach = float(np.linalg.norm(hole - middle, axis=1).max()) + _AROUND * segment
    # Triangles of all nodes take longer than all the rest where a face has ten thousands.
    near = np.array(lattice.query_ball_point(middle, reach, return_sorted=True), dtype=np.int64)
    if len(near) > _MOST:
        found = _in_cells(hole, lattice, places)
        if np.isfinite(found).all():
            return found
        # Those along its outline: what the others inside of it are is not asked.
        beside = lattice.query_ball_point(hole, _AROUND * segment)
        near = distinct(np.concatenate([np.asarray(own, dtype=np.int64) for own in beside]))
    if len(near) < _FEWEST:
        near = np.sort(lattice.query(middle, min(_FEWEST, lattice.n))[1])
    found = _interpolated(hole, lattice.data[near], places[near])
    return found if np.isfinite(found).all() else _interpolated(hole, lattice.data, places)


def _interpolated(at: FloatArray, nodes: FloatArray, places: IntArray) -> FloatArray:
    """Lattice places (m, 2) at points (m, 2), linear in the triangles of nodes (n, 2); NaN outside of these."""
    return np.asarray(scipy.interpolate.LinearNDInterpolator(nodes, places.astype(np.float64))(at))


def _in_cells(at: FloatArray, lattice: scipy.spatial.cKDTree, places: IntArray) -> FloatArray:
    """Lattice places (m, 2) at points (m, 2), linear in the two triangles of each cell; NaN where none was found.

    Only cells at the nodes next to a point are looked at: triangles of all nodes would be made first.
    """
    number = np.full(places.max(axis=0) + 2, -1, dtype=np.int64)
    number[places[:, 0], places[:, 1]] = np.arange(len(places))
    near = places[lattice.query(at, _CELLS_AT)[1]]
    lows = (near[:, :, None] - _CELL).reshape(len(at), -1, 2)
    corners = number[tuple(np.moveaxis(lows[:, :, None] + _CELL, -1, 0))]
    found = np.full((len(at), 2), np.nan)
    for triangle in ([0, 1, 2], [0, 2, 3]):
        nodes = corners[:, :, triangle]
        a, b, c = np.moveaxis(lattice.data[nodes], 2, 0)
        along, across, to = b - a, c - a, at[:, None] - a
        twice = along[..., 0] * across[..., 1] - along[..., 1] * across[..., 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            second = (to[..., 0] * across[..., 1] - to[..., 1] * across[..., 0]) / twice
            third = (along[..., 0] * to[..., 1] - along[..., 1] * to[..., 0]) / twice
            least = np.minimum(np.minimum(second, third), 1.0 - second - third)
        inside = (nodes >= 0).all(axis=2) & (least >= -_TIE)
        rows = np.flatnonzero(inside.any(axis=1) & np.isnan(found[:, 0]))
        which = np.argmax(inside[rows], axis=1)
        steps = _CELL[triangle[1:]] - _CELL[0]
        weights = np.stack([second[rows, which], third[rows, which]], axis=1)
        found[rows] = lows[rows, which] + weights @ steps
    return found


def places_around(p: int, q: int) -> IntArray:
    """Places around a rectangle of p x q cells, clockwise from its lower left corner."""
    steps = np.repeat(_STEPS[[1, 0, 3, 2]], [q, p, q, p], axis=0)
    return np.concatenate([np.zeros((1, 2), dtype=np.int64), np.cumsum(steps, axis=0)[:-1]])


def _placed(
    own: FloatArray, begin: int, q: int, p: int, size: IntArray, *, may_differ: bool
) -> tuple[int, int, int, IntArray]:
    """Where a hole's rectangle begins among its nodes, its cells up and across, and its lower left place.

    Of a round hole (`may_differ`) a cell more or less up, and other corners, are tried: its nodes shall lie as those
    of the rectangle do, and in the middle of the lattice of `size` cells the rectangle, too. What is half way between
    two places lies at the one nearer to the lattice's middle: what is symmetric stays so.
    """
    middle = own.mean(axis=0)
    off = own - middle
    n = len(own)
    best: tuple[float, float, int, int, IntArray] | None = None
    extents = np.abs(off).max(axis=0)
    # Holes that are alike have the same choice, whatever rounding made of their corners.
    wanted = n / 2.0 * float(extents[1] / extents.sum()) if may_differ else float(q)
    first, last = int(np.ceil(wanted - 1.0 - _TIE)), int(np.floor(wanted + 1.0 + _TIE))
    for up in range(first, last + 1) if may_differ else (q,):
        across = n // 2 - up
        if min(up, across) < 1:
            continue
        half = np.array([across, up]) / 2.0
        square = places_around(across, up) - half
        # As seen from its middle, in the shape of the rectangle.
        seen = off / extents * half
        shift = middle - half
        low = np.where(
            np.abs(shift - np.floor(shift) - 0.5) < _TIE,
            np.where(middle > size / 2.0 + _TIE, np.floor(shift), np.ceil(shift)),
            np.round(shift),
        )
        aside = float(np.count_nonzero((np.abs(middle - size / 2.0) < _TIE) & (np.abs(low - shift) > _TIE)))
        for k in range(n) if may_differ else (begin,):
            apart = float(((np.roll(seen, -k, axis=0) - square) ** 2).sum(axis=1).mean())
            found = (round(apart + aside, 6), round(abs(up - wanted), 6), up, k, low.astype(np.int64))
            if best is None or found[:4] < best[:4]:
                best = found
    assert best is not None
    return best[3], best[2], n // 2 - best[2], best[4]


def _is_round(outline: Outline, loop: int) -> bool:
    return all(abs(angle - np.pi) <= SMOOTH for angle in outline.angles(outline.loops[loop]))


def _hole_corners(outline: Outline, loop: int, places: FloatArray) -> tuple[int, int, int] | None:
    """The hole's node at the lower left of its rectangle, and the segments up and across from there."""
    n, angles = len(places), outline.angles(outline.loops[loop])
    if n % 2:
        return None
    if _is_round(outline, loop):
        off = places - places.mean(axis=0)
        x, y = (off / np.abs(off).max(axis=0)).T
        corners = [int(np.argmax(a * x + b * y)) for a, b in ((-1, -1), (-1, 1), (1, 1), (1, -1))]
        sides = [(b - a) % n for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)]
        up = int(np.clip(round((sides[0] + sides[2]) / 2.0), 1, n // 2 - 1))
        return corners[0], up, n // 2 - up
    turns = quarter_turns(angles)
    if turns is None or sum(turns) != -4 or turns.count(-1) != 4:
        return None
    at = np.concatenate([[0], np.cumsum([int(outline.counts[e]) for e, _ in outline.loops[loop]])])[:-1]
    found = at[np.array(turns) == -1]
    start = int(np.argmin(places[found].sum(axis=1)))
    found = np.roll(found, -start)
    sides = [int((b - a) % n) for a, b in zip(found, np.roll(found, -1), strict=True)]
    return (int(found[0]), sides[0], sides[1]) if sides[:2] == sides[2:] else None


def find_round_core(outline: Outline) -> tuple[Chart, int, IntArray] | None:
    """Rings around a rectangular core, on a face whose outline has no corners; None where it has some, or holes.

    As :func:`find_lattice`.
    """
    if len(outline.loops) != 1 or outline.grows():
        return None
    n = len(outline.nodes[0])
    if any(abs(angle - np.pi) > SMOOTH for angle in outline.angles(outline.loops[0])) or n % 2 or n < _LEAST_AROUND:
        return None
    chart = next(outline.charts(outline.nodes), None)
    if chart is None:
        return None
    rim = chart.boundary[0]
    first, p = core_corners(rim)
    segment = float(np.mean(np.linalg.norm(np.roll(rim, -1, axis=0) - rim, axis=1)))
    half = min(2.0 * signed_area(rim) / (n * segment), float(np.ptp(_turned(rim), axis=0).min()) / 2.0)
    if not chart.isometric:  # a dome's rim is farther from its middle than it looks from above
        half *= outline.face.area / signed_area(rim)
    return chart, *_around_core(n, first, p, max(1, round(_RINGS * half / segment)))


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


def core_corners(rim: FloatArray) -> tuple[int, int]:
    """Node over the core's first corner, and segments up to the second: where the outline reaches farthest aslant.

    Or a node beside, where the corners are then as symmetric as the outline.
    """
    n, places = len(rim), _turned(rim)
    x, y = places.T
    if signed_area(places) < 0:
        y = -y  # the axes are a reflection
    corners = sorted(int(np.argmax(a * x + b * y)) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)))
    sides = np.diff([*corners, corners[0] + n])
    p = int(np.clip(round(float(sides[0] + sides[2]) / 2.0), 1, n // 2 - 1))
    beside = [(corners[0] + a, p + b) for a in (0, 1, -1) for b in (0, 1, -1) if 1 <= p + b < n // 2]
    first, p = max(beside, key=lambda tried: _mirrored(places[(tried[0] + _corners_after(n, tried[1])) % n], places))
    return first % n, p


def _corners_after(n: int, p: int) -> IntArray:
    """The corners of a core of p quads on two of its sides, from the first one on, with n nodes around."""
    return np.array([0, p, n // 2, n // 2 + p])


def _mirrored(corners: FloatArray, places: FloatArray) -> int:
    """How many of the two axes mirror the corners (4, 2) of a core."""
    near = _SYMMETRIC * float(np.ptp(places, axis=0).max())
    return sum(
        np.abs(corners * axis - corners[order]).max() < near
        for axis, order in (((-1, 1), [1, 0, 3, 2]), ((1, -1), [3, 2, 1, 0]))
    )


def _around_core(n: int, first: int, p: int, rings: int) -> tuple[int, IntArray]:
    """Number of inner nodes, and quads, of rings around a core of p x (n / 2 - p) quads; the rim's n nodes first."""
    ring = np.arange((rings + 1) * n, dtype=np.int64).reshape(rings + 1, n)
    after = np.roll(ring, -1, axis=1)
    around = np.stack([ring[:-1], after[:-1], after[1:], ring[1:]], axis=-1).reshape(-1, 4)
    core = rectangle(n, first, p)
    n_core = core.size - n
    number = np.concatenate([ring[-1], (rings + 1) * n + np.arange(n_core)])
    inside = quads_of(number[core], every_cell(core))
    return rings * n + n_core, np.concatenate([around, inside])


def every_cell(core: IntArray) -> IntArray:
    """Places (c, 2) of all cells between nodes that are numbered (p + 1, q + 1)."""
    return np.argwhere(np.ones((core.shape[0] - 1, core.shape[1] - 1), dtype=np.bool_))


def rectangle(n: int, first: int, p: int) -> IntArray:
    """Numbers (p + 1, q + 1) of the nodes of p x q quads with n nodes around, these first, a corner at node `first`."""
    q = n // 2 - p
    core = np.empty((p + 1, q + 1), dtype=np.int64)
    edge = np.roll(np.arange(n), -first)
    core[:, 0] = edge[: p + 1]
    core[-1, :] = edge[p : p + q + 1]
    core[:, -1] = edge[p + q : 2 * p + q + 1][::-1]
    core[0, 1:] = edge[2 * p + q :][::-1]
    core[1:-1, 1:-1] = n + np.arange((p - 1) * (q - 1)).reshape(p - 1, q - 1)
    return core


def evened(outline: Outline, chart: Chart, places: FloatArray, quads: IntArray) -> FloatArray:
    """Places (n, 2) of a quad mesh whose links pull the harder, the longer they are on the surface.

    Where sizes are wanted, the longer they are beside these.
    """
    n_rim = sum(map(len, chart.boundary))
    rim = outline.known[np.concatenate(outline.nodes)]
    ends = _links_of(quads)
    weights = np.ones(len(ends))
    for _ in range(_EVENING):
        points = np.concatenate([rim, chart.lift(places[n_rim:])[0]])
        lengths = np.linalg.norm(points[ends[:, 0]] - points[ends[:, 1]], axis=1)
        if outline.sizes is not None:
            lengths /= np.minimum(outline.sizes(points[ends].mean(axis=1)), outline.size)
        weights *= lengths / lengths.mean()
        places = embedded(places[:n_rim], len(places) - n_rim, quads, weights)
    return places


def _links_of(quads: IntArray) -> IntArray:
    """The sides (m, 2) of quads, each once."""
    ends = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    width = int(ends.max(initial=0)) + 1
    return np.stack(np.divmod(distinct(ends[:, 0] * width + ends[:, 1]), width), axis=1)


def embedded(rim: FloatArray, n_inner: int, quads: IntArray, weights: FloatArray | None = None) -> FloatArray:
    """Places (n, 2) of all nodes of a quad mesh, its first at `rim`, the others at the mean of their neighbours.

    `weights`: of the sides, as :func:`_links_of` gives them; all alike without.
    """
    if not n_inner:
        return rim
    n = len(rim) + n_inner
    ends = _links_of(quads)
    pulls = np.ones(len(ends)) if weights is None else weights
    links = scipy.sparse.coo_array((pulls, (ends[:, 0], ends[:, 1])), shape=(n, n)).tocsr()
    links = links + links.T
    laplacian = (scipy.sparse.diags_array(links.sum(axis=1)) - links).tocsc()
    free, given = laplacian[len(rim) :, len(rim) :], laplacian[len(rim) :, : len(rim)]
    factors = scipy.sparse.linalg.splu(free, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    return np.concatenate([rim, factors.solve(np.asarray(-(given @ rim)))])
