"""A cell of a planar complex cut by a plane, and the faces of its neighbours with it.

Place in the flow: the step of the search (:mod:`.search`) on planar solids.

Method: edges that cross the plane get a vertex there, in every facet that has them; facets that cross it are divided
along their line with it; the edges in the plane that have material on their left bound the new facets. The pieces of
the cell are what hangs together on either side. Nothing is approximated, and nothing is kept that does not close.

Not handled: cuts that leave a cell whose faces touch at an edge; they are refused.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from ..disjoint import DisjointSets
from .planar import Cell, Facet, Pair, Pool, Use
from .tracing import TracingError, flattened, is_inside, trace
from .vectors import Vector, between, cross, distance, dot, minus, norm, plus, times, turn, unit

ON_PLANE = 1e-7
"""Distance, as a share of the part's size, up to which a vertex lies on a cut."""
SHORTEST = 1e-3
"""Length of a new edge, as a share of the part's size, below which a cut is refused."""
THINNEST = 1e-6
"""Volume of a piece, as a share of the part's size cubed, below which a cut is refused."""
_ANGLE = 1e-7
"""Radians: nearer than this a ray lies on a side of the wedge; angles are good to 1e-12."""
_PARALLEL = 1e-6
"""Sine of the angle between planes that count as parallel: their line would lie a million sizes away."""
_KEPT = 1e-9
"""Change of the volume, as a share of the part's size cubed, that rounding explains."""


@dataclass(frozen=True, kw_only=True)
class Plane:
    """``normal . x = offset``."""

    normal: Vector
    offset: float

    def side(self, point: Vector, grain: float) -> int:
        """1 above, -1 below, 0 on the plane."""
        d = dot(self.normal, point) - self.offset
        return 0 if abs(d) <= grain else (1 if d > 0 else -1)


def divide(pool: Pool, cells: Sequence[Cell], number: int, plane: Plane, cut: int) -> tuple[Cell, ...] | None:
    """Cut one cell of a complex by a plane.

    Parameters
    ----------
    pool : Pool
    cells : sequence of Cell
        The complex.
    number : int
        Which cell is cut.
    plane : Plane
    cut : int
        Origin of the new facets, below zero.

    Returns
    -------
    tuple of Cell or None
        The complex with the pieces of the cell last, its neighbours' facets divided where the cut meets them. None
        where the plane does not divide the cell, or not well: pinched, slivers, edges shorter than :data:`SHORTEST`.
    """
    cell = cells[number]
    sides = {v: plane.side(pool.points[v], ON_PLANE * pool.size) for f, _ in cell for v in pool.facets[f].vertices}
    if min(sides.values()) >= 0 or max(sides.values()) <= 0:
        return None
    new_vertices = _cross_edges(pool, cell, sides, plane)
    if new_vertices is None:
        return None
    images: dict[int, list[int]] = {}

    def image(f: int) -> list[int]:
        if f not in images:
            images[f] = [_with_vertices(pool, f, new_vertices)]
        return images[f]

    try:
        for f, _ in cell:
            images[f] = _split_facet(pool, image(f)[0], sides, plane)
        pieces = _pieces(pool, _replaced(cell, image), sides, plane, cut)
    except TracingError:
        return None
    if pieces is None or not _is_good(pool, pieces, cell):
        return None
    others = [_replaced(other, image) for j, other in enumerate(cells) if j != number]
    return (*others, *pieces)


def divide_on(pool: Pool, cells: Sequence[Cell], number: int, plane: Plane, cut: int) -> tuple[Cell, ...] | None:
    """Cut one cell of a complex by a plane, and on through every neighbour whose faces the cut divides.

    Parameters and result are those of :func:`divide`. Where the plane does not divide a neighbour well it ends.
    """
    found = divide(pool, cells, number, plane, cut)
    if found is None:
        return None
    waiting = _imprinted(cells, number, found)
    while waiting:
        cell = waiting.pop()
        if cell not in found:
            continue
        at = found.index(cell)
        then = divide(pool, found, at, plane, cut)
        if then is not None:
            waiting += _imprinted(found, at, then)
            found = then
    return found


def _imprinted(before: Sequence[Cell], number: int, after: Sequence[Cell]) -> list[Cell]:
    """Cells beside one that was cut that have more faces now."""
    others = [cell for j, cell in enumerate(before) if j != number]
    return [new for old, new in zip(others, after[: len(others)], strict=True) if len(new) > len(old)]


def _is_good(pool: Pool, pieces: Sequence[Cell], cell: Cell) -> bool:
    """Whether the pieces are the whole cell, and none of them thin or with a short new edge."""
    cube = pool.size**3
    volumes = [pool.volume(piece) for piece in pieces]
    if abs(sum(volumes) - pool.volume(cell)) > _KEPT * cube or min(volumes) < THINNEST * cube:
        return False
    return _shortest(pool, pieces, cell) >= SHORTEST * pool.size


def _replaced(cell: Cell, image: Callable[[int], list[int]]) -> Cell:
    return tuple((new, sign) for f, sign in cell for new in image(f))


def _cross_edges(pool: Pool, cell: Cell, sides: dict[int, int], plane: Plane) -> dict[Pair, int] | None:
    """A vertex where each edge of the cell crosses the plane; None where one is no new point of it."""
    found: dict[Pair, int] = {}
    for a, b in pool.uses(cell):
        if sides[a] * sides[b] < 0:
            p, q = pool.points[a], pool.points[b]
            da, db = dot(plane.normal, p) - plane.offset, dot(plane.normal, q) - plane.offset
            v = pool.vertex(between(p, q, da / (da - db)))
            if v in (a, b):
                return None
            found[a, b] = v
            sides[v] = 0
    return found


def _with_vertices(pool: Pool, f: int, new: Mapping[Pair, int]) -> int:
    """The facet with the new vertices on its edges."""
    facet = pool.facets[f]
    if not new or not any(((a, b) if a < b else (b, a)) in new for a, b in facet.pairs):
        return f
    loops = []
    for loop in facet.loops:
        run: list[int] = []
        for a, b in zip(loop, loop[1:] + loop[:1], strict=True):
            run.append(a)
            v = new.get((a, b) if a < b else (b, a))
            if v is not None:
                run.append(v)
        loops.append(tuple(run))
    return pool.facet(tuple(loops), facet.normal, facet.offset, facet.origin)


def _split_facet(pool: Pool, f: int, sides: Mapping[int, int], plane: Plane) -> list[int]:
    """Pieces of a facet along its line with the plane."""
    facet = pool.facets[f]
    own = {sides[v] for v in facet.vertices}
    if not {1, -1} <= own:
        return [f]
    along = cross(plane.normal, facet.normal)
    if norm(along) < _PARALLEL:
        raise TracingError("a facet lies nearly in the plane")
    on = sorted((v for v in facet.vertices if sides[v] == 0), key=lambda v: dot(pool.points[v], along))
    flat = flattened(pool.points, facet.vertices, facet.normal)
    outlines = [[flat[v] for v in loop] for loop in facet.loops]
    chords = []
    for a, b in pairwise(on):
        if (a, b) in facet.pairs or (b, a) in facet.pairs:
            continue
        middle = ((flat[a][0] + flat[b][0]) / 2.0, (flat[a][1] + flat[b][1]) / 2.0)
        if is_inside(middle, outlines):
            chords += [(a, b), (b, a)]
    regions = trace([*facet.pairs, *chords], flat)
    return [pool.facet(tuple(loops), facet.normal, facet.offset, facet.origin) for loops in regions]


def _pieces(pool: Pool, cell: Cell, sides: Mapping[int, int], plane: Plane, cut: int) -> list[Cell] | None:
    """The cells on both sides of the plane."""
    uses = pool.uses(cell)
    bounding = []
    for (a, b), own in uses.items():
        if sides[a] == sides[b] == 0:
            if len(own) != 2:
                return None
            bounding += [pair for pair in ((a, b), (b, a)) if _has_material(pool, pair, own, plane.normal)]
    if not bounding:
        return None
    flat = flattened(pool.points, {v for pair in bounding for v in pair}, plane.normal)
    new = []
    for loops in trace(bounding, flat):
        pairs = [pair for loop in loops for pair in zip(loop, loop[1:] + loop[:1], strict=True)]
        if any((b, a) in pairs for a, b in pairs):
            return None
        new.append(pool.facet(tuple(loops), plane.normal, plane.offset, cut))
    halves: dict[int, list[Use]] = {1: [(f, -1) for f in new], -1: [(f, 1) for f in new]}
    for use in cell:
        halves[_half(pool, use, sides, plane)].append(use)
    found: list[Cell] = []
    for half in halves.values():
        shells = _shells(pool, half)
        if shells is None:
            return None
        found += shells
    return found


def _half(pool: Pool, use: Use, sides: Mapping[int, int], plane: Plane) -> int:
    """The side of the plane that a facet belongs to; one in the plane goes with the material beside it."""
    for v in pool.facets[use[0]].vertices:
        if sides[v]:
            return sides[v]
    return -1 if dot(pool.outward(use), plane.normal) > 0 else 1


def _has_material(pool: Pool, pair: Pair, uses: Sequence[Use], normal: Vector) -> bool:
    """Whether the plane runs inside the cell on the left of a directed edge in it."""
    along = unit(minus(pool.points[pair[1]], pool.points[pair[0]]))
    left = cross(normal, along)
    first, second = sorted(uses, key=lambda use: not _runs(pool, use, pair))
    inward = cross(pool.outward(first), along)
    into = times(-1.0, pool.outward(first))
    wedge = turn(inward, into, cross(along, pool.outward(second)))
    at = turn(inward, into, left)
    return _ANGLE < at < wedge - _ANGLE


def _runs(pool: Pool, use: Use, pair: Pair) -> bool:
    """Whether a facet, seen from outside the cell, runs along an edge in this direction."""
    return (pair if use[1] > 0 else pair[::-1]) in pool.facets[use[0]].pairs


def _shells(pool: Pool, half: Sequence[Use]) -> list[Cell] | None:
    """Cells of facets that hang together by edges; a shell around a void joins the cell it lies in."""
    sets = DisjointSets(range(len(half)))
    number = {use: j for j, use in enumerate(half)}
    for own in pool.uses(tuple(half)).values():
        if len(own) != 2:
            return None
        sets.merge(number[own[0]], number[own[1]])
    groups: dict[int, list[Use]] = {}
    for j, use in enumerate(half):
        groups.setdefault(sets.find(j), []).append(use)
    shells = [tuple(group) for group in groups.values()]
    solid = [shell for shell in shells if pool.volume(shell) > 0]
    for void in (shell for shell in shells if pool.volume(shell) <= 0):
        inside = [j for j, shell in enumerate(solid) if _contains(pool, shell, void)]
        if not inside:
            return None
        j = min(inside, key=lambda k: pool.volume(solid[k]))
        solid[j] = solid[j] + void
    return solid


def _contains(pool: Pool, shell: Cell, void: Cell) -> bool:
    """Whether a shell lies around another that it does not touch."""
    start = pool.points[next(iter(pool.facets[void[0][0]].vertices))]
    direction = unit((0.5377, 0.6321, 0.5579))  # along no direction that parts are drawn in
    crossings = 0
    for f, _ in shell:
        facet = pool.facets[f]
        rate = dot(direction, facet.normal)
        if abs(rate) < 1e-12:
            continue
        along = (facet.offset - dot(facet.normal, start)) / rate
        if along > 0 and _in_facet(pool, facet, plus(start, times(along, direction))):
            crossings += 1
    return crossings % 2 == 1


def _in_facet(pool: Pool, facet: Facet, point: Vector) -> bool:
    flat = flattened([*pool.points, point], [*facet.vertices, len(pool.points)], facet.normal)
    return is_inside(flat[len(pool.points)], [[flat[v] for v in loop] for loop in facet.loops])


def _shortest(pool: Pool, pieces: Sequence[Cell], cell: Cell) -> float:
    """Length of the shortest new edge."""
    old = pool.uses(cell)
    new = {pair for piece in pieces for pair in pool.uses(piece)} - old.keys()
    return min((distance(pool.points[a], pool.points[b]) for a, b in new), default=pool.size)


def narrowest(pool: Pool, cells: Sequence[Cell], cut: int) -> float:
    """Least distance of a facet of a cut from a vertex that stands over it without touching it."""
    least = pool.size
    for cell in cells:
        vertices = {v for f, _ in cell for v in pool.facets[f].vertices}
        for f, _ in cell:
            facet = pool.facets[f]
            if facet.origin != cut:
                continue
            for v in vertices - facet.vertices:
                away = dot(facet.normal, pool.points[v]) - facet.offset
                if ON_PLANE * pool.size < abs(away) < least:
                    foot = minus(pool.points[v], times(away, facet.normal))
                    if _in_facet(pool, facet, foot):
                        least = abs(away)
    return least


__all__ = ["Plane", "divide", "divide_on", "narrowest"]
