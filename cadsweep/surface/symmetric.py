r"""Quads of a plane face whose outline has mirrors: those of the wedge between two of them, copied all around.

Place in the flow: one of the ways of :mod:`.filling`, before a mesher's quads of the whole.

Method: the outline is cut along two rays from its middle, where nodes are laid as far apart as the outline's are; the
mesher fills what is between them, and every copy is the image of that. Relaxed as a whole, each node then stands at the
mean of what its images were moved to, so that the mesh is as symmetric as the outline::

        ____.____                 ____
       /    |    \               |    \        the wedge of a mirror each way:
      |  o  |  o  |              |  o  |       a quarter
      |-----+-----|      ->      +-----|
      |  o  |  o  |
       \____|____/

Not handled: faces with a turn and no mirror, curved faces, outlines that a mirror meets between two nodes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial

import numpy as np
import scipy

from ..arrays import FloatArray, IntArray, distinct
from ..errors import SurfaceMeshError
from .background import GROWTH
from .chart import Chart, signed_area
from .fan import fan_of_polygon
from .gmsh_quads import MANY, Setting, mesh_polygon, settings_for
from .outline import FaceQuads, Outline
from .relax import corner_sines
from .symmetry import Wedge, find_wedges
from .transfinite import grid_of_polygon

_ON_RAY = 1e-7
"""Angle from a ray up to which a node lies on it."""
_SAMPLES = 200
"""Steps along a ray at which the size is looked at."""
_MERGED = 1e-6
"""Distance, in sizes of the outline, of two copies of one node."""


_ENOUGH = 0.6
"""Worst corner sine from which on no smaller symmetry is tried."""
_GOOD = 0.7
"""Worst corner sine from which on no other setting of the mesher is tried: what it makes of a whole is as good."""
_GOOD_OF_MANY = 0.65
"""The same for wedges of many nodes, whose every mesh takes long: a lattice is taken from there on, too."""
_FAIR = 0.55
"""The same for quads much smaller than the outline's segments: they are many, and do not make fair ones good."""
_SHORTEST = 0.25
"""Edge of a quad, as a share of the rim's shortest segment, below which symmetry has squeezed it: its neighbours are
four times as long, and a curved rim beside it may fold it at order 2."""


@dataclass(kw_only=True)
class _Domain:
    """What is cut out of an outline: loops of ids of its nodes and of `new` ones after them."""

    loops: list[list[int]]
    new: list[FloatArray]


def fill_symmetric(outline: Outline) -> FaceQuads | None:
    """Quads with the mirrors of the outline; None where it has none, or its wedge cannot be meshed."""
    if outline.sizes is not None or outline.face.kind != "plane":
        return None
    chart = next(outline.charts(outline.nodes), None)
    if chart is None or not chart.isometric:
        return None
    best: FaceQuads | None = None
    for wedge in find_wedges(chart.boundary):
        domain = _cut(chart.boundary, wedge, outline.largest(outline.nodes))
        made = None if domain is None else _best_of(outline, chart, wedge, domain)
        if made is not None and (best is None or made.better_than(best)):
            best = made
        if best is not None and best.expected >= _ENOUGH:
            break  # as symmetric as can be
    return best


def _best_of(outline: Outline, chart: Chart, wedge: Wedge, domain: _Domain) -> FaceQuads | None:
    boundary = np.concatenate(outline.nodes)
    many = sum(map(len, domain.loops)) > MANY
    good = _GOOD_OF_MANY if many else _GOOD
    best: FaceQuads | None = None
    for size_factor, fill in _fillings(chart, domain):
        if best is not None and best.expected >= (_FAIR if size_factor < 1 else good):
            break
        with suppress(SurfaceMeshError):  # the next setting, or another way
            made = carried_by_mirrors(outline, chart, wedge, boundary, *_copied(chart, wedge, domain, *fill()))
            if made is not None and (best is None or made.better_than(best)):
                best = made
    return best


def _cut(loops: Sequence[FloatArray], wedge: Wedge, largest: float) -> _Domain | None:
    """The part of an outline in a wedge; None where the rays do not cut it in nodes, one at a time."""
    points = np.concatenate(loops)
    angles, radii = wedge.polar(points)
    on_first = np.abs(angles) < _ON_RAY
    on_last = np.abs(angles - wedge.angle) < _ON_RAY
    domain = _Domain(loops=[], new=[])
    chains: dict[int, list[int]] = {}
    first = 0
    for loop in loops:
        ids = np.arange(first, first + len(loop))
        first += len(loop)
        middles, _ = wedge.polar((loop + np.roll(loop, -1, axis=0)) / 2)
        inside = (middles > 0) & (middles < wedge.angle)
        if inside.all():
            domain.loops.append(ids.tolist())
            continue
        for start in np.flatnonzero(inside & ~np.roll(inside, 1)).tolist():
            n = int(np.argmin(np.roll(inside, -start)))
            chain = ids[(start + np.arange(n + 1)) % len(ids)].tolist()
            if chain[0] in chains:
                return None
            chains[chain[0]] = chain
    starts, ends = set(chains), {chain[-1] for chain in chains.values()}
    if starts & ends or len(ends) != len(chains) or not all(on_first[v] or on_last[v] for v in starts | ends):
        return None
    following = _along_rays(wedge, radii, (on_first, on_last), starts, ends)
    if following is None:
        return None
    segments = np.concatenate([np.linalg.norm(np.roll(p, -1, axis=0) - p, axis=1) for p in loops])
    before = np.concatenate([np.roll(np.arange(len(p)), 1) for p in loops])
    offsets = np.repeat(np.cumsum([0, *(len(p) for p in loops)])[:-1], [len(p) for p in loops])
    sizes = (segments + segments[before + offsets]) / 2
    return _assembled(points, wedge, chains, following, sizes, largest, domain)


_CENTRE = -1


def _along_rays(
    wedge: Wedge,
    radii: FloatArray,
    on: tuple[np.ndarray, np.ndarray],
    starts: set[int],
    ends: set[int],
) -> dict[int, int] | None:
    """From each end of a chain, and from the centre, along a ray inside to where the next chain starts."""
    found: dict[int, int] = {}
    for ray, outward in zip(on, (True, False), strict=True):
        own = sorted((v for v in starts | ends if ray[v]), key=lambda v: radii[v])
        # Outward on the first ray, inward on the last one: what is inside lies to the left.
        leaves = ends if outward else starts
        if not own or own[0] not in leaves:
            own = [_CENTRE, *own]
        if len(own) % 2:
            return None
        for near, far in zip(own[::2], own[1::2], strict=True):
            if far in leaves or (near != _CENTRE and near not in leaves):
                return None
            a, b = (near, far) if outward else (far, near)
            found[a] = b
    return found if (_CENTRE in found) == (_CENTRE in found.values()) else None


def _assembled(  # noqa: PLR0917
    points: FloatArray,
    wedge: Wedge,
    chains: dict[int, list[int]],
    following: dict[int, int],
    sizes: FloatArray,
    largest: float,
    domain: _Domain,
) -> _Domain | None:
    """Loops of chains and of what is between them along the rays, each of an even number of segments."""
    left = set(chains)
    while left:
        start = current = min(left)
        pieces: list[tuple[list[int], tuple[int, int] | None]] = []
        while True:
            chain = chains[current]
            left.discard(current)
            pieces.append((chain, None))
            at = chain[-1]
            while True:
                pieces.append(([], (at, following[at])))
                at = following[at]
                if at != _CENTRE:
                    break
            current = at
            if current == start:
                break
            if current not in left:
                return None
        places = {v: points[v] if v != _CENTRE else wedge.centre for _, ray in pieces if ray for v in ray}
        at_nodes = {v: largest if v == _CENTRE else float(sizes[v]) for v in places}
        steps = [
            _steps(places[ray[0]], places[ray[1]], at_nodes[ray[0]], at_nodes[ray[1]], largest)
            for _, ray in pieces
            if ray
        ]
        counts = [max(1, round(float(run[-1]))) for run in steps]
        fixed = sum(len(chain) - 1 for chain, _ in pieces if chain)
        if (fixed + sum(counts)) % 2:
            longest = int(np.argmax(counts))
            counts[longest] += 1
        ids: list[int] = []
        rays = iter(zip(steps, counts, strict=True))
        for chain, ray in pieces:
            if ray is None:
                ids += chain
                continue
            run, n = next(rays)
            at = np.interp(np.arange(1, n) / n * run[-1], run, np.linspace(0.0, 1.0, len(run)))
            for share in at:
                ids.append(len(points) + len(domain.new))
                domain.new.append(places[ray[0]] + share * (places[ray[1]] - places[ray[0]]))
            if ray[1] == _CENTRE:
                ids.append(len(points) + len(domain.new))
                domain.new.append(wedge.centre)
        domain.loops.append(ids)
    if any(len(loop) % 2 for loop in domain.loops):
        return None
    # The outer loop first, as a mesher wants it.
    domain.loops.sort(key=lambda ids: -signed_area(_places(points, domain)[ids]))
    return domain


def _steps(a: FloatArray, b: FloatArray, at_a: float, at_b: float, largest: float) -> FloatArray:
    """Segments before each of even places between two nodes, which grow away from both of them."""
    s = np.linspace(0.0, float(np.linalg.norm(b - a)), _SAMPLES + 1)
    size = np.minimum(np.minimum(at_a + (GROWTH - 1.0) * s, at_b + (GROWTH - 1.0) * (s[-1] - s)), largest)
    return np.concatenate([[0.0], np.cumsum(np.diff(s) * 2.0 / (size[1:] + size[:-1]))])


def _places(points: FloatArray, domain: _Domain) -> FloatArray:
    return np.concatenate([points, np.array(domain.new).reshape(-1, 2)])


def _fillings(chart: Chart, domain: _Domain) -> Iterator[tuple[float, Callable[[], tuple[FloatArray, IntArray]]]]:
    """Ways to fill the wedge, coarse ones first: their size, in sizes of the outline, and what makes the quads.

    That gives inner places, and quads in ids of the domain's nodes, then the inner ones, or raises SurfaceMeshError.
    """
    places = _places(np.concatenate(chart.boundary), domain)
    loops = [places[ids] for ids in domain.loops]
    number = np.concatenate([np.array(ids, dtype=np.int64) for ids in domain.loops])

    def numbered(inner: FloatArray, quads: IntArray) -> tuple[FloatArray, IntArray]:
        return inner, np.concatenate([number, len(places) + np.arange(len(inner), dtype=np.int64)])[quads]

    def meshed(setting: Setting) -> tuple[FloatArray, IntArray]:
        return numbered(*mesh_polygon(loops, setting))

    for found in [grid_of_polygon(loops[0]), fan_of_polygon(loops[0])] if len(loops) == 1 else []:
        if found is not None:
            yield 1.0, partial(numbered, *found)
    for setting in settings_for(loops):
        yield setting.size_factor, partial(meshed, setting)


def _copied(
    chart: Chart, wedge: Wedge, domain: _Domain, inner: FloatArray, quads: IntArray
) -> tuple[FloatArray, IntArray]:
    """Inner places of the whole, and quads in ids of its boundary's nodes, then of these."""
    boundary = np.concatenate(chart.boundary)
    near = _MERGED * float(np.max(np.ptp(boundary, axis=0)))
    own = np.concatenate([_places(boundary, domain), inner])
    elements = wedge.elements()
    every = np.concatenate([wedge.carry(g, own) for g in elements])
    used = distinct(np.concatenate([quads + k * len(own) for k in range(len(elements))]))
    whole = np.concatenate([boundary, every[used]])
    pairs = scipy.spatial.cKDTree(whole).query_pairs(near, output_type="ndarray")
    graph = scipy.sparse.coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(whole), len(whole)))
    _, label = scipy.sparse.csgraph.connected_components(graph, directed=False)
    _, first = np.unique(label, return_index=True)
    order = np.argsort(first)
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    number = np.full(len(every), -1, dtype=np.int64)
    number[used] = rank[label[len(boundary) :]]
    turned = [quads if np.linalg.det(g) > 0 else quads[:, ::-1] for g in elements]
    ids = np.concatenate([number[q + k * len(own)] for k, q in enumerate(turned)])
    return whole[np.sort(first)][len(boundary) :], ids


def _edge_lengths(polygons: FloatArray) -> FloatArray:
    """Lengths (..., k) of the edges of polygons (..., k, 3)."""
    return np.asarray(np.linalg.norm(polygons - np.roll(polygons, 1, axis=-2), axis=-1))


def _images(wedge: Wedge, places: FloatArray, near: float) -> list[IntArray] | None:
    """Of every element of the wedge, the node that it carries each of some nodes to; None where one has none near."""
    tree = scipy.spatial.cKDTree(places)
    found = []
    for g in wedge.elements():
        far, image = tree.query(wedge.carry(g, places))
        if far.max() > near:
            return None
        found.append(image)
    return found


def is_carried(wedge: Wedge, chart: Chart, places: FloatArray) -> bool:
    """Whether every element of a wedge carries nodes (n, 2), those of the outline first, to nodes."""
    near = _MERGED * float(np.max(np.ptp(np.concatenate(chart.boundary), axis=0)))
    return _images(wedge, places, near) is not None


def carried_by_mirrors(  # noqa: PLR0917
    outline: Outline, chart: Chart, wedge: Wedge, boundary: IntArray, inner: FloatArray, quads: IntArray
) -> FaceQuads | None:
    """The quads lifted and relaxed, every node at the mean of its images."""
    made = outline.lift(chart, inner, quads, boundary)
    rim = np.concatenate(chart.boundary)
    before = np.concatenate([rim, inner])
    if not len(inner):
        return made
    origin, x, y = chart.lift(np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]))[0]
    axes = np.stack([x - origin, y - origin])
    relaxed = np.concatenate([rim, (made.inner_points - origin) @ axes.T])
    elements = wedge.elements()
    images = _images(wedge, before, _MERGED * float(np.max(np.ptp(rim, axis=0))))
    if images is None:
        return None
    shortest = min(float(_edge_lengths(outline.known[nodes]).min()) for nodes in outline.nodes)
    best: FaceQuads | None = None
    for places in (relaxed, before):
        mean = np.zeros_like(places)
        for g, image in zip(elements, images, strict=True):
            mean += wedge.carry(g.T, places[image])
        points = origin + (mean / len(elements))[len(rim) :] @ axes
        every = np.concatenate([outline.known[boundary], points])
        normals = np.broadcast_to(-outline.face.surface.normals(chart.boundary_uv[:1]), every.shape)
        worst = float(corner_sines(every, quads, normals).min())
        if _edge_lengths(every[quads]).min() < _SHORTEST * shortest:
            continue
        ids = np.concatenate([boundary, len(outline.known) + np.arange(len(inner), dtype=np.int64)])
        found = outline.judged(points, ids[quads], worst)
        if best is None or found.better_than(best):
            best = found
    return best
