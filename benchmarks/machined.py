"""Random machined parts: blocks and turned bodies with features in several directions, one for every seed.

Even seeds are blocks, odd ones turned bodies. A body gets two to six features as a workshop makes them: through, blind
and counterbored holes, bosses, slots with round ends, pockets with rounded corners, steps, keyways, flats, rings of
bolt holes, cross holes; then edges are rounded or chamfered. Sizes are multiples of one millimetre, features of one
side keep apart from each other and from its edges, those of different sides may cross but leave no wall thinner than
two millimetres. A feature that would leave no one valid solid, or an edge shorter than a two-hundredth of the part, is
left out.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import cadquery as cq
import numpy as np
from OCP.Standard import Standard_Failure

SHORTEST = 0.005
"""Length of an edge, as a share of the part's diagonal, below which a drawing would not have it."""
THINNEST = 2.0
"""Millimetres of a wall between features that do not cross."""
CLEAR = 3.0
"""Millimetres that features of one side keep from each other and from the edges of the side."""


@dataclass(kw_only=True)
class _Side:
    """A plane side of a block, and the circles around the features that it has."""

    plane: cq.Plane
    width: float
    height: float
    depth: float
    taken: list[tuple[float, float, float]] = field(default_factory=list)

    def place(self, random: np.random.Generator, radius: float) -> tuple[float, float] | None:
        """A place for a feature, on whole millimetres; None where ten tries find none."""
        reach = np.array([self.width, self.height]) / 2.0 - radius - CLEAR
        if (reach < 0).any():
            return None
        for _ in range(10):
            x, y = (float(round(v)) for v in random.uniform(-reach, reach))
            if all(np.hypot(x - u, y - v) > radius + r + CLEAR for u, v, r in self.taken):
                self.taken.append((x, y, radius))
                return x, y
        return None


def _whole(random: np.random.Generator, low: float, high: float) -> float:
    return float(round(random.uniform(low, max(low, high))))


def _sides(width: float, depth: float, height: float) -> list[_Side]:
    """The six sides of a block about the origin; the local z looks outward."""
    half = {"X": width / 2, "Y": depth / 2, "Z": height / 2}
    spans = {"X": (depth, height, width), "Y": (width, height, depth), "Z": (width, depth, height)}
    across = {"X": (0, 1, 0), "Y": (1, 0, 0), "Z": (1, 0, 0)}
    found = []
    for axis, normal in {"X": (1, 0, 0), "Y": (0, 1, 0), "Z": (0, 0, 1)}.items():
        for sign in (1.0, -1.0):
            out = tuple(sign * c for c in normal)
            origin = tuple(half[axis] * c for c in out)
            w, h, d = spans[axis]
            found.append(_Side(plane=cq.Plane(origin, across[axis], out), width=w, height=h, depth=d))
    return found


def _through_hole(side: _Side, random: np.random.Generator) -> cq.Workplane | None:
    radius = _whole(random, 2, min(side.width, side.height) / 4)
    at = side.place(random, radius)
    return None if at is None else cq.Workplane(side.plane).center(*at).circle(radius).extrude(-side.depth)


def _blind_hole(side: _Side, random: np.random.Generator) -> cq.Workplane | None:
    radius = _whole(random, 2, min(side.width, side.height) / 4)
    depth = _whole(random, 3, 0.7 * side.depth)
    at = side.place(random, radius)
    return None if at is None else cq.Workplane(side.plane).center(*at).circle(radius).extrude(-depth)


def _counterbore(side: _Side, random: np.random.Generator) -> cq.Workplane | None:
    radius = _whole(random, 2, min(side.width, side.height) / 7)
    outer, depth = radius + _whole(random, 2, 4), _whole(random, 2, 0.4 * side.depth)
    at = side.place(random, outer)
    if at is None:
        return None
    hole = cq.Workplane(side.plane).center(*at).circle(radius).extrude(-side.depth)
    return hole.union(cq.Workplane(side.plane).center(*at).circle(outer).extrude(-depth))


def _slot(side: _Side, random: np.random.Generator) -> cq.Workplane | None:
    width = 2 * _whole(random, 2, min(side.width, side.height) / 8)
    length = width + _whole(random, 4, max(side.width, side.height) / 3)
    depth = side.depth if random.random() < 0.3 else _whole(random, 2, 0.5 * side.depth)
    turn = float(random.choice([0.0, 90.0]))
    at = side.place(random, length / 2)
    return None if at is None else cq.Workplane(side.plane).center(*at).slot2D(length, width, turn).extrude(-depth)


def _pocket(side: _Side, random: np.random.Generator) -> cq.Workplane | None:
    a, b = (_whole(random, 8, 0.45 * s) for s in (side.width, side.height))
    depth, radius = _whole(random, 2, 0.5 * side.depth), float(random.choice([0.0, 2.0, 3.0]))
    at = side.place(random, float(np.hypot(a, b)) / 2)
    if at is None:
        return None
    tool = cq.Workplane(side.plane).center(*at).rect(a, b).extrude(-depth)
    return tool.edges(cq.selectors.ParallelDirSelector(side.plane.zDir)).fillet(radius) if radius else tool


def _boss(side: _Side, random: np.random.Generator) -> cq.Workplane | None:
    radius, height = _whole(random, 3, min(side.width, side.height) / 4), _whole(random, 3, 15)
    at = side.place(random, radius)
    return None if at is None else cq.Workplane(side.plane).center(*at).circle(radius).extrude(height)


def _bored_boss(side: _Side, random: np.random.Generator) -> tuple[cq.Workplane, cq.Workplane] | None:
    radius, height = _whole(random, 5, min(side.width, side.height) / 4), _whole(random, 3, 15)
    bore = _whole(random, 2, radius - 2)
    at = side.place(random, radius)
    if at is None:
        return None
    boss = cq.Workplane(side.plane).center(*at).circle(radius).extrude(height)
    through = side.depth if random.random() < 0.5 else 0.5 * side.depth
    lifted = cq.Workplane(side.plane).workplane(offset=height).center(*at)
    return boss, lifted.circle(bore).extrude(-height - round(through))


def _step(side: _Side, random: np.random.Generator) -> cq.Workplane | None:
    """Material taken off along one edge of the side."""
    if side.taken:
        return None
    share, depth = _whole(random, 5, 0.35 * side.width), _whole(random, 3, 0.4 * side.depth)
    end = float(random.choice([-1.0, 1.0]))
    side.width -= share
    side.plane.origin -= side.plane.xDir.normalized() * (end * share / 2)
    edge = cq.Workplane(side.plane).center(end * (side.width + share) / 2, 0)
    return edge.rect(share, side.height).extrude(-depth)


CUTS: list[Callable[[_Side, np.random.Generator], cq.Workplane | None]] = [
    _through_hole, _blind_hole, _counterbore, _slot, _pocket, _step,
]  # fmt: skip


def _is_sound(part: cq.Workplane) -> bool:
    solids = part.solids().vals()
    if len(solids) != 1 or not solids[0].isValid():
        return False
    return min(edge.Length() for edge in solids[0].Edges()) > SHORTEST * solids[0].BoundingBox().DiagonalLength


def _with(part: cq.Workplane, change: Callable[[cq.Workplane], cq.Workplane]) -> cq.Workplane:
    """A part with a change that leaves it sound, else as it was."""
    try:
        found = cq.Workplane(obj=change(part).val())
    except (Standard_Failure, ValueError):
        return part
    return found if _is_sound(found) else part


def _is_clear(tool: cq.Workplane, others: list[cq.Workplane]) -> bool:
    """Whether a feature leaves a wall between itself and every other that it does not cross."""
    return not any(1e-6 < tool.val().distance(other.val()) < THINNEST for other in others)


def block(seed: int) -> cq.Workplane:
    """A block with holes, bosses, slots, pockets and steps on two or three of its sides."""
    random = np.random.default_rng(seed)
    width, depth, height = (5.0 * round(v / 5.0) for v in random.uniform((50, 40, 20), (100, 80, 50)))
    part = cq.Workplane().box(width, depth, height)
    sides = [_sides(width, depth, height)[j] for j in random.permutation(6)[: int(random.integers(2, 4))]]
    wanted, tools = int(random.integers(2, 7)), list[cq.Workplane]()
    for j in range(wanted):
        side = sides[j % len(sides)]
        if random.random() < 0.25:
            pair = _bored_boss(side, random) if random.random() < 0.5 else (_boss(side, random), None)
            if pair is None or pair[0] is None:
                continue
            boss, bore = pair
            if bore is not None and not _is_clear(bore, tools):
                continue
            tools += [boss] if bore is None else [boss, bore]
            part = _with(part, lambda p, a=boss, b=bore: p.union(a) if b is None else p.union(a).cut(b))
            continue
        tool = CUTS[int(random.integers(len(CUTS)))](side, random)
        if tool is not None and _is_clear(tool, tools):
            tools.append(tool)
            part = _with(part, lambda p, tool=tool: p.cut(tool))
    return _dressed(part, random, ["|X", "|Y", "|Z"], 0.5)


def _dressed(part: cq.Workplane, random: np.random.Generator, selectors: list[str], chance: float) -> cq.Workplane:
    """Some outer edges rounded or chamfered."""
    if random.random() > chance:
        return part
    selector, size = selectors[int(random.integers(len(selectors)))], _whole(random, 1, 4)
    box = part.val().BoundingBox()
    low, high = np.array([box.xmin, box.ymin, box.zmin]), np.array([box.xmax, box.ymax, box.zmax])

    def is_outer(edge: cq.Edge) -> bool:
        at = np.array(edge.Center().toTuple())
        return int(((np.abs(at - low) < 1e-6) | (np.abs(at - high) < 1e-6)).sum()) >= 2

    edges = [edge for edge in part.edges(selector).vals() if edge.geomType() == "LINE" and is_outer(edge)]
    if not edges:
        return part
    if random.random() < 0.5:
        return _with(part, lambda p: cq.Workplane(p.val().fillet(size, edges)))
    return _with(part, lambda p: cq.Workplane(p.val().chamfer(size, None, edges)))


def turned(seed: int) -> cq.Workplane:
    """A stepped body of revolution with keyways, flats, cross holes and rings of bolt holes."""
    random = np.random.default_rng(seed)
    radii = [float(r) for r in random.permutation([8, 11, 14, 18, 24, 30])[: int(random.integers(1, 5))]]
    lengths = [_whole(random, 10, 40) if r < 22 else _whole(random, 8, 16) for r in radii]
    ends = np.concatenate([[0.0], np.cumsum(lengths)])
    part = cq.Workplane().circle(radii[0]).extrude(lengths[0])
    for radius, low, length in zip(radii[1:], ends[1:], lengths[1:], strict=False):
        part = part.union(cq.Workplane().workplane(offset=low).circle(radius).extrude(length))
    bore = 0.0
    if random.random() < 0.5:
        bore = _whole(random, 2, 0.6 * min(radii))
        part = part.cut(cq.Workplane().circle(bore).extrude(float(ends[-1])))
    dress = int(random.integers(4))
    for selector in (">Z", "<Z")[:dress]:
        size = _whole(random, 1, 2)
        outer = part.faces(selector).edges(cq.selectors.RadiusNthSelector(-1))
        part = _with(part, lambda p, o=outer, s=size, d=dress: o.chamfer(s) if d == 1 else o.fillet(s))
    tools: list[cq.Workplane] = []
    for j in random.integers(0, 5, int(random.integers(1, 4))):
        k = int(random.integers(len(radii)))
        radius, low, length = radii[k], float(ends[k]), lengths[k]
        tool = _TURNED[j](random, radius, low, length, bore)
        if tool is not None and _is_clear(tool, tools):
            tools.append(tool)
            part = _with(part, lambda p, tool=tool: p.cut(tool))
    return part


def _keyway(random: np.random.Generator, radius: float, low: float, length: float, bore: float) -> cq.Workplane | None:
    width = 2 * _whole(random, 1, radius / 4)
    if length < width + 6 or radius - bore < 5:
        return None
    floor = radius - _whole(random, 2, min(5, 0.4 * (radius - bore)))
    plane = cq.Plane((floor, 0, low + length / 2), (0, 0, 1), (1, 0, 0))
    return cq.Workplane(plane).slot2D(length - 4, width).extrude(radius)


def _flat(random: np.random.Generator, radius: float, low: float, length: float, bore: float) -> cq.Workplane | None:
    depth = _whole(random, 1, 0.4 * (radius - bore))
    sides = (1.0,) if random.random() < 0.5 else (1.0, -1.0)
    tool = cq.Workplane()
    for sign in sides:
        box = cq.Workplane().box(radius, 4 * radius, length, centered=(False, True, False))
        box = box.translate((radius - depth, 0, low)) if sign > 0 else box.translate((-2 * radius + depth, 0, low))
        tool = tool.union(box) if tool.objects else box
    return tool


def _cross_hole(
    random: np.random.Generator, radius: float, low: float, length: float, bore: float
) -> cq.Workplane | None:
    size = _whole(random, 2, 0.5 * radius)
    if length < 2 * size + 6:
        return None
    reach = 80.0 if random.random() < 0.6 else 40.0
    plane = cq.Plane((0, -40, low + length / 2), (1, 0, 0), (0, 1, 0))
    return cq.Workplane(plane).circle(size).extrude(reach)


def _bolt_holes(
    random: np.random.Generator, radius: float, low: float, length: float, bore: float
) -> cq.Workplane | None:
    if radius < 20:
        return None
    n, size = int(random.integers(3, 7)), _whole(random, 1, 3)
    return cq.Workplane().polarArray(radius - size - 4, 0, 360, n).circle(size).extrude(200)


def _end_hole(
    random: np.random.Generator, radius: float, low: float, length: float, bore: float
) -> cq.Workplane | None:
    if bore:
        return cq.Workplane().circle(bore + 2).extrude(_whole(random, 3, 8))
    return cq.Workplane().circle(_whole(random, 2, 0.5 * min(radius, 12))).extrude(_whole(random, 5, 20))


_TURNED = [_keyway, _flat, _cross_hole, _bolt_holes, _end_hole]


def machined(seed: int) -> cq.Workplane:
    """The part of a seed: a block where it is even, a turned body where it is odd."""
    return block(seed) if seed % 2 == 0 else turned(seed)
