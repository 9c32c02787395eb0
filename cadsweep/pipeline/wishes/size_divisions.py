"""Edges divided by sizes that change from place to place, in one sweep or in many cells.

Edges get as many segments as the sizes along them ask for, and are divided by them; edges that answer each other across
a side or from cap to cap, and rails of one span, by the least size of them all at one height, so that rows and layers
stay straight.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import partial

import numpy as np
import scipy

from ...arrays import FloatArray
from ...brep import Edge, Solid
from ...surface import Division
from ...sweep import LinkingSide, Sweep
from .local_sizes import GROWTH, Field

_SAMPLES = 400
"""Places along an edge where the size is asked for."""
_AROUND = 100
"""Places along an edge from which sizes grow."""
_ACROSS = 33
"""Places across a side at which the size is looked at."""
_VARIES = 1.05
"""Greatest size along an edge over the least from which on it is divided unevenly."""

_Pair = tuple[tuple[int, bool], tuple[int, bool]]


def divide_by_sizes(
    solids: Sequence[Solid],
    sweeps: Sequence[Sweep],
    grids: Iterable[tuple[Solid, LinkingSide]],
    field: Field,
    *,
    alike: Iterable[tuple[int, int, bool]] = (),
    only: Collection[int] | None = None,
) -> tuple[dict[int, float], dict[int, Division]]:
    """Mean sizes of all edges, by key, and the divisions of those along which the size changes.

    Parameters
    ----------
    solids : sequence of Solid
        All cells.
    sweeps : sequence of Sweep
        How they are swept, of those that are.
    grids : iterable of (Solid, LinkingSide)
        Their faces that are logical rectangles.
    field : callable
        Wanted lengths, working units.
    alike : iterable of (int, int, bool)
        Edges that are divided alike besides, by key, and whether they run alike.
    only : collection of int, or None
        Edges of which it is asked, by key; others that are not divided as one of them are left out.
    """
    grids = list(grids)
    others = [((a, True), (b, same)) for a, b, same in alike]
    edges: dict[int, Edge] = {}
    for solid in solids:
        edges.update(zip(solid.edge_keys.tolist(), solid.edges, strict=True))
    groups = _groups(edges, [*_across(grids), *_cap_to_cap(sweeps), *_rails(sweeps), *others])
    if only is not None:
        groups = [group for group in groups if not group.keys().isdisjoint(only)]
    on_sides = _along_sides(grids, field, {key for group in groups for key in group})
    at = np.linspace(0.0, 1.0, _SAMPLES + 1)
    sizes: dict[int, float] = {}
    divisions: dict[int, Division] = {}
    for group in groups:
        rows = []
        for key, forward in group.items():
            along = field(edges[key].curve.evaluate(at))
            rows.append(along if forward else along[::-1])
            rows += [row if forward == up else row[::-1] for up, row in on_sides.get(key, ())]
        mean, places = divided_by(np.min(rows, axis=0))
        for key, forward in group.items():
            sizes[key] = mean
            if places is not None:
                divisions[key] = partial(by_density, places=places if forward else 1.0 - places[::-1])
    return sizes, divisions


def divide_beside(
    solids: Sequence[Solid],
    sweeps: Sequence[Sweep],
    grids: Sequence[tuple[Solid, LinkingSide]],
    finer: Mapping[int, float],
    size: float,
    *,
    kept: Collection[int],
) -> tuple[dict[int, float], dict[int, Division]]:
    """Mean sizes and divisions, by key, of the edges that begin where others are to be finer, and grow back.

    Parameters
    ----------
    finer : mapping of int to float
        Sizes of edges by key; those that are no finer than `size` are passed over.
    kept : collection of int
        Edges that stay as they are divided.
    """
    edges = {key: (solid, e) for solid in solids for key, e in zip(solid.edge_keys.tolist(), solid.edges, strict=True)}
    own = {key: wanted for key, wanted in finer.items() if wanted < size and key in edges}
    if not own:
        return {}, {}
    at = np.linspace(0.0, 1.0, _AROUND + 1)
    finest_first = sorted(own.items(), key=lambda item: item[1])
    places = [(scipy.spatial.cKDTree(edges[key][1].curve.evaluate(at)), wanted) for key, wanted in finest_first]

    def field(points: FloatArray) -> FloatArray:
        sizes = np.full(len(points), size)
        for tree, wanted in places:
            # Only places as near to the edge's box as it would have to be to make them finer are asked.
            off = np.maximum(0.0, np.maximum(tree.mins - points, points - tree.maxes))
            near = np.flatnonzero(wanted + (GROWTH - 1.0) * np.sqrt((off * off).sum(axis=1)) < sizes)
            if len(near):
                sizes[near] = np.minimum(sizes[near], wanted + (GROWTH - 1.0) * tree.query(points[near])[0])
        return sizes

    def ends(key: int) -> set[int]:
        solid, edge = edges[key]
        return {int(solid.vertex_keys[v]) for v in (edge.start, edge.end)}

    touched = {v for key in own for v in ends(key)}
    beside = [key for key in edges if key not in kept and key not in finer and not touched.isdisjoint(ends(key))]
    sizes, divisions = divide_by_sizes(solids, sweeps, grids, field, only=beside)
    return (
        {key: sizes[key] for key in beside if key in divisions},
        {key: divisions[key] for key in beside if key in divisions},
    )


def divided_by(sizes: FloatArray) -> tuple[float, FloatArray | None]:
    """Mean size of segments by the sizes wanted at even places along a line, and how they divide the line.

    The division is None where the sizes are as good as the same; else the shares (n,) of all segments that lie before
    each of the even places.
    """
    steps = 2.0 / (sizes[1:] + sizes[:-1])
    run = np.concatenate([[0.0], np.cumsum(steps)]) / len(steps)  # segments a unit length
    varies = sizes.max() > _VARIES * sizes.min()
    return 1.0 / float(run[-1]), run / run[-1] if varies else None


def by_density(n: int, *, places: FloatArray) -> FloatArray:
    """Fractions (n + 1,) of n segments, from the share of them before each of even places."""
    fractions = np.interp(np.linspace(0.0, 1.0, n + 1), places, np.linspace(0.0, 1.0, len(places)))
    fractions[0], fractions[-1] = 0.0, 1.0
    return np.asarray(fractions)


def _along_sides(
    grids: Iterable[tuple[Solid, LinkingSide]], field: Field, rails: Collection[int]
) -> dict[int, list[tuple[bool, FloatArray]]]:
    """Least sizes across sides at every height, by left rail if one of `rails`, and whether that runs upwards."""
    found: dict[int, list[tuple[bool, FloatArray]]] = {}
    t = np.linspace(0.0, 1.0, _SAMPLES + 1)
    s = np.linspace(0.0, 1.0, _ACROSS)[:, None, None]
    for solid, side in grids:
        chains = (side.bottom, side.right, side.top, side.left)
        if any(len(chain) != 1 for chain in chains) or int(solid.edge_keys[side.left[0][0]]) not in rails:
            continue
        curves = [solid.edges[chain[0][0]].curve for chain in chains]
        forward = [chain[0][1] for chain in chains]
        left, right = (curves[j].evaluate(t if forward[j] else 1.0 - t) for j in (3, 1))
        bottom, top = (curves[j].evaluate((s if forward[j] else 1.0 - s).ravel())[:, None] for j in (0, 2))
        high = t[:, None]
        corners = (1 - s) * ((1 - high) * left[0] + high * left[-1]) + s * ((1 - high) * right[0] + high * right[-1])
        patch = (1 - s) * left + s * right + (1 - high) * bottom + high * top - corners  # Coons
        least = field(patch.reshape(-1, 3)).reshape(_ACROSS, -1).min(axis=0)
        found.setdefault(int(solid.edge_keys[side.left[0][0]]), []).append((forward[3], least))
    return found


def _across(grids: Iterable[tuple[Solid, LinkingSide]]) -> Iterable[_Pair]:
    """Opposite edges of logical rectangles, by key and direction."""
    for solid, side in grids:
        keys = solid.edge_keys.tolist()
        for one, other in ((side.bottom, side.top), (side.left, side.right)):
            if len(one) == len(other) == 1:
                yield (keys[one[0][0]], one[0][1]), (keys[other[0][0]], other[0][1])


def _cap_to_cap(sweeps: Iterable[Sweep]) -> Iterable[_Pair]:
    """Edges inside the caps of a sweep that answer each other."""
    for sweep in sweeps:
        keys = sweep.solid.edge_keys.tolist()
        for e, (t, same) in sweep.target_edges.items():
            yield (keys[e], True), (keys[t], same)


def _rails(sweeps: Iterable[Sweep]) -> Iterable[_Pair]:
    """Rails of one span in different loops."""
    for sweep in sweeps:
        keys = sweep.solid.edge_keys.tolist()
        upward = {e: forward for side in sweep.linking_sides for e, forward in (*side.left, *side.right)}
        for loops in zip(*sweep.spans, strict=False):
            whole = [span[0] for span in loops if span and span[0] in upward]
            for e in whole[1:]:
                yield (keys[whole[0]], upward[whole[0]]), (keys[e], upward[e])


def _groups(edges: Collection[int], pairs: Iterable[_Pair]) -> list[Mapping[int, bool]]:
    """Edges that divide themselves alike, and whether each runs the way of the first."""
    neighbours: dict[int, list[tuple[int, bool]]] = {key: [] for key in edges}
    for (a, a_forward), (b, b_forward) in pairs:
        neighbours[a].append((b, a_forward == b_forward))
        neighbours[b].append((a, a_forward == b_forward))
    groups: list[Mapping[int, bool]] = []
    seen: set[int] = set()
    for edge in neighbours:
        if edge in seen:
            continue
        group = {edge: True}
        waiting = [edge]
        while waiting:
            present = waiting.pop()
            for other_edge, same in neighbours[present]:
                if other_edge not in group:
                    group[other_edge] = group[present] == same
                    waiting.append(other_edge)
        seen |= group.keys()
        groups.append(group)
    return groups


def least_along(sweep: Sweep, field: Field) -> Field:
    """The least size on the way from a place of the source to its image on the target: quads go all the way.

    The way is taken to be straight between images under one affine map, which the edges of the caps tell.
    """
    on_source = {e for loop in sweep.source_loops for e, _ in loop}
    on_target = {e for loop in sweep.target_loops for e, _ in loop}
    at = np.linspace(0.0, 1.0, _ACROSS)
    ends: tuple[list[FloatArray], list[FloatArray]] = ([], [])
    for side in sweep.linking_sides:
        if (
            len(side.bottom) == len(side.top) == 1
            and {side.bottom[0][0]} <= on_source
            and {side.top[0][0]} <= on_target
        ):
            for found, (e, forward) in zip(ends, (side.bottom[0], side.top[0]), strict=True):
                found.append(sweep.solid.edges[e].curve.evaluate(at if forward else 1.0 - at))
    if not ends[0]:
        return field  # walls in several storeys: what is asked for counts where the source is
    first, last = (np.concatenate(points) for points in ends)
    begin, end = first.mean(axis=0), last.mean(axis=0)
    linear = np.linalg.lstsq(first - begin, last - end, rcond=_SAME_PLANE)[0]

    def least(points: FloatArray) -> FloatArray:
        image = end + (points - begin) @ linear
        ways = [(1.0 - s) * points + s * image for s in np.linspace(0.0, 1.0, _ON_THE_WAY)]
        return np.asarray(np.min([field(places) for places in ways], axis=0))

    return least


_ON_THE_WAY = 9
"""Places between the caps at which the size is looked at."""
_SAME_PLANE = 1e-6
"""Part of a cap's width up to which its edges lie in one plane: they tell nothing of what is across it."""
