r"""The part of a symmetric outline of which the whole is made, as loops of nodes for a mesher.

Place in the flow: :mod:`.symmetric` has it meshed and copied.

Method: of an outline with mirrors it is what lies between two rays from the middle, where nodes are laid as far apart
as the outline's are. Of one with turns alone it is what lies between a line from the innermost loop to the outermost
and the image of that line. First the middle may get a core of kites, and corners on mirrors a quad each: halves of
these would be too sharp::

        \    |    /              \ c /       a corner c on a mirror: its quad, and what
      ___\___|___/___             a\ /b       is left has d in its place
          \__|__/                   d
          /  |  \      a core of three kites would have one quad where six met
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from ..arrays import FloatArray, IntArray
from ..polygons import is_inside, mean_sides, next_corners, signed_area
from .background import GROWTH
from .chart import Chart, is_simple
from .embedding import embedded
from .kites import ROUNDEST, kites
from .symmetry import Wedge

_ON_RAY = 1e-7
"""Angle from a ray up to which a node lies on it."""
_SAMPLES = 200
"""Steps along a ray at which the size is looked at."""
_SHARP = np.radians(82.0)
"""Interior angle of a corner on a mirror below which its half is too sharp for a quad."""
_ROOM = 0.6
"""Radius of a core over the distance of the nearest node from the middle, at most."""
_SMALLEST = 0.35
"""Edge of a core over the size wanted there, at least."""


@dataclass(kw_only=True)
class Domain:
    """What is cut out of an outline: loops of ids of its nodes and of `new` ones after them."""

    loops: list[list[int]]
    new: list[FloatArray]

    @property
    def n_nodes(self) -> int:
        """Nodes of all loops."""
        return sum(map(len, self.loops))

    def places(self, points: FloatArray) -> FloatArray:
        """Of the outline's nodes `points`, then of the new ones, (n, 2)."""
        return np.concatenate([points, np.array(self.new).reshape(-1, 2)])


@dataclass(kw_only=True, eq=False)
class Core:
    """An outline with quads laid in it already.

    Attributes
    ----------
    points : (n, 2) float64
        The outline's own nodes first, then those of the quads.
    loops : list of (m,) int64
        What is left to be filled: the outer loop first, counter-clockwise, then holes, clockwise.
    quads : (q, 4) int64
    n_kites : int
        Kites that meet in the middle, zero where there are none: a divisor of the outline's turns.
    """

    points: FloatArray
    loops: list[IntArray]
    quads: IntArray = field(default_factory=lambda: np.empty((0, 4), dtype=np.int64))
    n_kites: int = 0

    @staticmethod
    def of(chart: Chart) -> Core:
        """Without quads."""
        ends = np.cumsum([0, *(len(loop) for loop in chart.boundary)])
        ids = [np.arange(a, b, dtype=np.int64) for a, b in pairwise(ends.tolist())]
        return Core(points=np.concatenate(chart.boundary), loops=ids)

    def sizes(self) -> FloatArray:
        """Of every node the mean of its segments in the loops, zero where it is in none."""
        found = np.zeros(len(self.points))
        found[np.concatenate(self.loops)] = mean_sides([self.points[ids] for ids in self.loops])
        return found

    def is_centre_inside(self, wedge: Wedge) -> bool:
        """Whether the middle lies in what is left."""
        return bool(is_inside([self.points[ids] for ids in self.loops], wedge.centre[None])[0])

    def sharpest(self, wedge: Wedge) -> float:
        """Sine of the sharpest corner that cutting leaves to the mesher: the wedge's own, where the middle is left."""
        return float(np.sin(min(wedge.angle, np.pi / 2))) if self.is_centre_inside(wedge) else 1.0

    def symmetry(self, wedge: Wedge) -> Wedge:
        """The wedge of what carries the quads laid already to themselves, too: fewer kites have fewer turns."""
        return replace(wedge, n=self.n_kites) if self.n_kites else wedge

    def with_kites(self, wedge: Wedge, largest: float) -> Core | None:
        """The same with a core of kites in the middle; None where no number of them fits, or they would be small."""
        k = next((k for k in range(min(wedge.n, ROUNDEST), 2, -1) if wedge.n % k == 0), 0)
        if not k or not self.is_centre_inside(wedge):
            return None
        away = np.linalg.norm(self.points - wedge.centre, axis=1)
        nearest = float(away.min())
        size = min(largest, float(self.sizes()[int(np.argmin(away))]) + (GROWTH - 1.0) * nearest)
        n = 2 * wedge.n
        radius = min(n * size / (2.0 * np.pi), _ROOM * nearest)
        if radius < _SMALLEST * n * size / (2.0 * np.pi):
            return None
        turns = wedge.start + 2.0 * np.pi * np.arange(n) / n
        ring = wedge.centre + radius * np.stack([np.cos(turns), np.sin(turns)], axis=1)
        n_inside, inside = kites(n, k, 0)
        first = len(self.points)
        places = embedded(ring, n_inside, inside)[n:]
        return Core(
            points=np.concatenate([self.points, ring, places]),
            loops=[*self.loops, first + np.arange(n)[::-1]],
            quads=np.concatenate([self.quads, first + inside]),
            n_kites=k,
        )

    def with_tips(self, wedge: Wedge) -> Core:
        """The same with a quad in each sharp corner of the outer loop that a mirror halves."""
        ids = self.loops[0]
        at = self.points[ids]
        ahead, back = np.roll(at, -1, axis=0) - at, np.roll(at, 1, axis=0) - at
        cross = ahead[:, 0] * back[:, 1] - ahead[:, 1] * back[:, 0]
        interior = np.mod(np.arctan2(cross, (ahead * back).sum(axis=1)), 2.0 * np.pi)
        angles, _ = wedge.polar(at)
        off = np.mod(angles + wedge.angle / 2.0, wedge.angle) - wedge.angle / 2.0
        sharp = np.flatnonzero((interior < _SHARP) & (np.abs(off) < _ON_RAY))
        if not len(sharp) or not wedge.has_mirrors:
            return self
        first = len(self.points)
        left = ids.copy()
        left[sharp] = first + np.arange(len(sharp))
        points = np.concatenate([self.points, (at + ahead + back)[sharp]])
        if not is_simple([points[left]]):
            return self
        tips = np.stack([ids[sharp], np.roll(ids, -1)[sharp], left[sharp], np.roll(ids, 1)[sharp]], axis=1)
        return replace(self, points=points, loops=[left, *self.loops[1:]], quads=np.concatenate([self.quads, tips]))


def cut_turned(core: Core, wedge: Wedge, largest: float) -> Domain | None:
    """The part of an outline between a line from its innermost loop to its outermost and that line's image.

    None where the middle has no loop about it, or no straight line between two nodes goes.
    """
    points = core.points
    about = [j for j, ids in enumerate(core.loops[1:], start=1) if is_inside([points[ids]], wedge.centre[None])[0]]
    if not about:
        return None
    outer, inner = core.loops[0], core.loops[about[0]]
    turn = wedge.elements()[1]
    edges = np.concatenate([np.stack([points[ids], points[np.roll(ids, -1)]], axis=1) for ids in core.loops])
    sizes = core.sizes()
    away = np.linalg.norm(points[outer] - wedge.centre, axis=1)
    for a in outer[np.argsort(away, kind="stable")][: len(outer) // wedge.n].tolist():
        b = int(inner[np.argmin(np.linalg.norm(points[inner] - points[a], axis=1))])
        if _meets(points[a], points[b], edges):
            continue
        images = [_image_of(points, ids, wedge.carry(turn, points[v])) for ids, v in ((outer, a), (inner, b))]
        run = _steps(points[b], points[a], float(sizes[b]), float(sizes[a]), largest)
        n = max(1, round(float(run[-1])))
        along, back = _way(outer, a, images[0]), _way(inner, images[1], b)
        n += (len(along) + len(back)) % 2
        at = np.interp(np.arange(1, n) / n * run[-1], run, np.linspace(0.0, 1.0, len(run)))
        line = points[b] + at[:, None] * (points[a] - points[b])
        new = [*line, *wedge.carry(turn, line)]
        first = len(points)
        out, home = first + np.arange(n - 1), first + n - 1 + np.arange(n - 1)[::-1]
        domain = Domain(loops=[[*along, *home.tolist(), *back, *out.tolist()]], new=new)
        places = domain.places(points)
        rim = places[domain.loops[0]]
        if signed_area(rim) <= 0 or not is_simple([rim]):
            continue
        holes = [ids for j, ids in enumerate(core.loops[1:], start=1) if j != about[0]]
        inside = [ids for ids in holes if is_inside([rim], points[ids[:1]])[0]]
        if len(inside) * wedge.n != len(holes):
            continue
        domain.loops += [ids.tolist() for ids in inside]
        return domain
    return None


def _meets(a: FloatArray, b: FloatArray, edges: FloatArray) -> bool:
    """Whether a line from a to b meets any of segments (m, 2, 2) but at its ends."""

    def side(p: FloatArray, q: FloatArray, r: FloatArray) -> FloatArray:
        way, off = q - p, r - p
        return np.asarray(way[..., 0] * off[..., 1] - way[..., 1] * off[..., 0])

    p, q = edges[:, 0], edges[:, 1]
    ends = (np.stack([(p == a).all(1), (q == a).all(1), (p == b).all(1), (q == b).all(1)])).any(axis=0)
    crossed = (side(a, b, p) * side(a, b, q) <= 0) & (side(p, q, a) * side(p, q, b) <= 0)
    return bool((crossed & ~ends).any())


def _image_of(points: FloatArray, ids: IntArray, place: FloatArray) -> int:
    return int(ids[np.argmin(np.linalg.norm(points[ids] - place, axis=1))])


def _way(loop: IntArray, start: int, end: int) -> list[int]:
    """Ids from one node of a loop to another, both included."""
    turned = np.roll(loop, -int(np.flatnonzero(loop == start)[0]))
    n = int(np.flatnonzero(turned == end)[0])
    return [int(v) for v in turned[: n + 1]]


def cut_wedge(core: Core, wedge: Wedge, largest: float) -> Domain | None:
    """The part of an outline in a wedge; None where the rays do not cut it in nodes, one at a time."""
    points = core.points
    angles, radii = wedge.polar(points)
    on_first = np.abs(angles) < _ON_RAY
    on_last = np.abs(angles - wedge.angle) < _ON_RAY
    domain = Domain(loops=[], new=[])
    chains: dict[int, list[int]] = {}
    begin = np.concatenate(core.loops)
    middles, _ = wedge.polar((points[begin] + points[begin[next_corners(core.loops)]]) / 2)
    is_inside_wedge = (middles > 0) & (middles < wedge.angle)
    firsts = np.cumsum([len(ids) for ids in core.loops])[:-1]
    for ids, inside in zip(core.loops, np.split(is_inside_wedge, firsts), strict=True):
        if not inside.any():
            continue
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
    sizes = core.sizes()
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
        if not own:
            continue  # the middle is outside, as that of a channel, and its web on the other ray
        if own[0] not in leaves:
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
    domain: Domain,
) -> Domain | None:
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
    domain.loops.sort(key=lambda ids: -signed_area(domain.places(points)[ids]))
    return domain


def _steps(a: FloatArray, b: FloatArray, at_a: float, at_b: float, largest: float) -> FloatArray:
    """Segments before each of even places between two nodes, which grow away from both of them."""
    s = np.linspace(0.0, float(np.linalg.norm(b - a)), _SAMPLES + 1)
    size = np.minimum(np.minimum(at_a + (GROWTH - 1.0) * s, at_b + (GROWTH - 1.0) * (s[-1] - s)), largest)
    return np.concatenate([[0.0], np.cumsum(np.diff(s) * 2.0 / (size[1:] + size[:-1]))])
