r"""Quads of a plane face whose outline has mirrors: those of the wedge between two of them, copied all around.

Place in the flow: one of the ways of :mod:`.filling`, before a mesher's quads of the whole.

Method: the outline is cut along two rays from its middle, or a line and its image (:mod:`.wedge_domain`); the
mesher fills what is between them, and every copy is the image of that. Relaxed as a whole, each node then stands at the
mean of what its images were moved to, so that the mesh is as symmetric as the outline::

        ____.____                 ____
       /    |    \               |    \        the wedge of a mirror each way:
      |  o  |  o  |              |  o  |       a quarter
      |-----+-----|      ->      +-----|
      |  o  |  o  |
       \____|____/

Not handled: curved faces; an outline that its mirrors meet between two nodes keeps its turns alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial

import numpy as np
import scipy

from ..arrays import FloatArray, IntArray, distinct
from ..errors import SurfaceMeshError
from .background import Background
from .chart import Chart
from .fan import fan_of_polygon
from .gmsh_quads import MANY, Setting, mesh_polygon, settings_for
from .outline import FaceQuads, Outline
from .relax import corner_sines
from .symmetry import Wedge, find_turns, find_wedges
from .transfinite import grid_of_polygon
from .wedge_domain import Core, Domain, cut_turned, cut_wedge

_MERGED = 1e-6
"""Distance, in sizes of the outline, of two copies of one node."""


_ENOUGH = 0.6
"""Worst corner sine from which on no smaller symmetry is tried."""
_GOOD = 0.7
"""Worst corner sine from which on no other setting of the mesher is tried: what it makes of a whole is as good."""
_GOOD_OF_MANY = 0.65
"""The same for wedges of many nodes, whose every mesh takes long: a lattice is taken from there on, too."""
_LARGE = 1000
"""Nodes of a wedge from which on each setting takes seconds, and `_ENOUGH` is good."""
_FAIR = 0.55
"""The same for quads much smaller than the outline's segments: they are many, and do not make fair ones good."""
_FAIR_OF_LARGE = 0.3
"""The same for what takes longer in a large wedge than a mesh of the whole, which is tried as well: Blossom's matching,
and wedges of fewer mirrors."""
_LEAST = 0.3
"""Sine of the corner in the middle of a wedge below which a mesher's quads of the whole are better."""
_SHORTEST = 0.25
"""Edge of a quad, as a share of the rim's shortest segment, below which symmetry has squeezed it: its neighbours are
four times as long, and a curved rim beside it may fold it at order 2."""


def fill_symmetric(outline: Outline) -> FaceQuads | None:
    """Quads with the mirrors of the outline; None where it has none, or its wedge cannot be meshed."""
    if outline.sizes is not None or outline.face.kind != "plane":
        return None
    chart = next(outline.charts(outline.nodes), None)
    if chart is None or not chart.isometric:
        return None
    largest = outline.largest(outline.nodes)
    cut = [(wedge, core) for wedge in find_wedges(chart.boundary) for core in _cores(chart, wedge, largest)]
    best: FaceQuads | None = None
    # Of one symmetry grids come first, of whatever is cut out: they are the most regular, and cost nothing.
    order = sorted((-core.symmetry(wedge).n, freely) for wedge, core in cut for freely in (False, True))
    for n, freely in dict.fromkeys(order):
        for wedge, core in cut:
            # Quads in the middle are no better than its corner, which stays where it is.
            if core.symmetry(wedge).n != -n or core.sharpest(wedge) < max(_LEAST, best.expected if best else 0.0):
                continue
            domain = cut_wedge(core, wedge, largest)
            made = None if domain is None else _best_of(outline, chart, wedge, core, domain, freely=freely)
            if made is not None and (best is None or made.better_than(best)):
                best = made
            large = domain is not None and domain.n_nodes > _LARGE
            if best is not None and best.expected >= (_FAIR_OF_LARGE if large else _ENOUGH):
                return best  # as symmetric as can be
    if best is None:
        return _fill_turned(outline, chart, largest)
    return best


def _cores(chart: Chart, wedge: Wedge, largest: float) -> list[Core]:
    """An outline without quads, and with quads in its sharp corners, and with kites in its middle; the best first."""
    plain = Core.of(chart)
    tipped = plain.with_tips(wedge)
    kites = tipped.with_kites(wedge, largest) if wedge.n > 2 else None
    return [*([] if kites is None else [kites]), *([] if tipped is plain else [tipped]), plain]


def _fill_turned(outline: Outline, chart: Chart, largest: float) -> FaceQuads | None:
    """Quads with the turns of an outline alone; None where it has none, or no cut goes from its middle to its rim."""
    wedge = find_turns(chart.boundary)
    if wedge is None:
        return None
    core = Core.of(chart)
    if core.is_centre_inside(wedge):
        core = core.with_kites(wedge, largest) or core
    domain = cut_turned(core, wedge, largest)
    return None if domain is None else _best_of(outline, chart, wedge, core, domain, freely=True)


def _best_of(
    outline: Outline, chart: Chart, wedge: Wedge, core: Core, domain: Domain, *, freely: bool
) -> FaceQuads | None:
    """The best quads of a wedge copied: by a mesher (`freely`), or else grids."""
    boundary = np.concatenate(outline.nodes)
    limit = 0.95 * core.sharpest(wedge)
    kept = core.symmetry(wedge)
    background = outline.background(chart, outline.nodes)
    best: FaceQuads | None = None
    for good, fill in _fillings(core, domain, background, freely=freely):
        if best is not None and best.expected >= min(good, limit):
            break
        with suppress(SurfaceMeshError):  # the next setting, or another way
            made = carried_by_mirrors(outline, chart, kept, boundary, *_copied(chart, core, wedge, domain, *fill()))
            if made is not None and (best is None or made.better_than(best)):
                best = made
    return best


def _fillings(
    core: Core, domain: Domain, background: Background | None, *, freely: bool
) -> Iterator[tuple[float, Callable[[], tuple[FloatArray, IntArray]]]]:
    """Ways to fill the wedge: the worst corner sine from which on each is not worth it, and what makes the quads.

    That gives inner places, and quads in ids of the domain's nodes, then the inner ones, or raises SurfaceMeshError.
    """
    large = domain.n_nodes > _LARGE
    good = _ENOUGH if large else _GOOD_OF_MANY if domain.n_nodes > MANY else _GOOD
    places = domain.places(core.points)
    loops = [places[ids] for ids in domain.loops]
    number = np.concatenate([np.array(ids, dtype=np.int64) for ids in domain.loops])

    def numbered(inner: FloatArray, quads: IntArray) -> tuple[FloatArray, IntArray]:
        return inner, np.concatenate([number, len(places) + np.arange(len(inner), dtype=np.int64)])[quads]

    def meshed(setting: Setting) -> tuple[FloatArray, IntArray]:
        return numbered(*mesh_polygon(loops, setting, background=background))

    for found in [grid_of_polygon(loops[0]), fan_of_polygon(loops[0])] if len(loops) == 1 and not freely else []:
        if found is not None:
            yield good, partial(numbered, *found)
    for setting in settings_for(loops) if freely else ():
        worth = _FAIR if setting.size_factor < 1 else _FAIR_OF_LARGE if large and setting.is_matching else good
        yield worth, partial(meshed, setting)


def _copied(  # noqa: PLR0917
    chart: Chart, core: Core, wedge: Wedge, domain: Domain, inner: FloatArray, quads: IntArray
) -> tuple[FloatArray, IntArray]:
    """Inner places of the whole, and quads in ids of its boundary's nodes, then of these."""
    near = _MERGED * float(np.max(np.ptp(core.points, axis=0)))
    own = np.concatenate([domain.places(core.points), inner])
    elements = wedge.elements()
    every = np.concatenate([wedge.carry(g, own) for g in elements])
    used = distinct(np.concatenate([quads + k * len(own) for k in range(len(elements))]))
    whole = np.concatenate([core.points, every[used]])
    pairs = scipy.spatial.cKDTree(whole).query_pairs(near, output_type="ndarray")
    graph = scipy.sparse.coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(whole), len(whole)))
    _, label = scipy.sparse.csgraph.connected_components(graph, directed=False)
    _, first = np.unique(label, return_index=True)
    order = np.argsort(first)
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    number = np.full(len(every), -1, dtype=np.int64)
    number[used] = rank[label[len(core.points) :]]
    turned = [quads if np.linalg.det(g) > 0 else quads[:, ::-1] for g in elements]
    ids = np.concatenate([core.quads, *(number[q + k * len(own)] for k, q in enumerate(turned))])
    return whole[np.sort(first)][sum(map(len, chart.boundary)) :], ids


def _edge_lengths(polygons: FloatArray) -> FloatArray:
    """Lengths (..., k) of the edges of polygons (..., k, 3)."""
    return np.asarray(np.linalg.norm(polygons - np.roll(polygons, 1, axis=-2), axis=-1))


def _orbits(wedge: Wedge, places: FloatArray, near: float) -> IntArray | None:
    """Of every element of the wedge, the node that it carries each node of one wedge to, (n_elements, k).

    Together these are all nodes. None where an element carries one to none, or a node is no image.
    """
    angles, radii = wedge.polar(places)
    width = near / np.maximum(radii, near)
    own = places[(angles <= wedge.angle + width) | (angles >= 2.0 * np.pi - width) | (radii <= near)]
    carried = np.concatenate([wedge.carry(g, own) for g in wedge.elements()])
    far, image = scipy.spatial.cKDTree(places).query(carried)
    if not len(own) or far.max() > near or not np.bincount(image, minlength=len(places)).all():
        return None
    return np.asarray(image, dtype=np.int64).reshape(-1, len(own))


def is_carried(wedge: Wedge, chart: Chart, places: FloatArray) -> bool:
    """Whether every element of a wedge carries nodes (n, 2), those of the outline first, to nodes."""
    near = _MERGED * float(np.max(np.ptp(np.concatenate(chart.boundary), axis=0)))
    return _orbits(wedge, places, near) is not None


def _symmetric_mean(wedge: Wedge, orbits: IntArray, places: FloatArray) -> FloatArray:
    """Every node at the mean of what the elements carry to it."""
    elements = np.array(wedge.elements())
    off = np.einsum("gkj,gji->gki", places[orbits] - wedge.centre, elements)  # each carried back to the one wedge
    mean = np.empty_like(places)
    mean[orbits] = wedge.centre + np.einsum("kj,gij->gki", off.mean(axis=0), elements)
    return mean


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
    orbits = _orbits(wedge, before, _MERGED * float(np.max(np.ptp(rim, axis=0))))
    if orbits is None:
        return None
    shortest = min(float(_edge_lengths(outline.known[nodes]).min()) for nodes in outline.nodes)
    best: FaceQuads | None = None
    for places in (relaxed, before):
        points = origin + _symmetric_mean(wedge, orbits, places)[len(rim) :] @ axes
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
