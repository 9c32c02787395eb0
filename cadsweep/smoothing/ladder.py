"""Check, relax, untangle, polish, check: :func:`improve` mends the worst places of a swept mesh.

Place in the flow: after projection, where the mesh's worst scaled Jacobian is below the goal.

Method. The hexahedra below the goal, or below what their fixed nodes allow, and their neighbours form patches, those
that are inverted first; the
nodes inside a patch move, all others stay where they are. Each step is kept only where it raises the patch's worst
scaled Jacobian, or the least share that a hexahedron has of what it can reach:

relax
    Every node at the weighted mean of its neighbours along edges (one sparse solve).
untangle
    A regularised shape energy that is finite for inverted hexahedra (:mod:`.energy`).
polish
    A high power of one over the scaled Jacobian: the worst corner counts most.

Patches are cut anew in every round, so what is polished is small. Where a round gains nothing the
patches grow, twice, before the mesh is given back as it is.

Why not gmsh's or MFEM's smoothers: on patches of real parts none brought a mesh further. `Relocate3D` and TMOP left
hexahedra inverted that these steps mend, and `UntangleMeshGeometry` took ten times as long (``benchmarks/smoothers.py``
and the table in ``docs/quality.md``).

Not handled: a boundary quad that is itself inverted: no inner node can mend the hexahedron on it
(:func:`cadsweep.quality.boundary_limit` says how good a mesh can become at all).
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from .. import rows
from ..arrays import FloatArray, IntArray, distinct
from ..quality import Ways, corner_limits
from .alike import Alike
from .cutting import Blocks, Connected, grown, hex_nodes, patches, touches_others
from .laplacian import relaxed
from .optimise import polished, untangled
from .patch import BoolArray, Patch, edge_lengths, proven_values
from .sliding import Slides

_log = logging.getLogger(__name__)

GOAL = 0.3
"""Scaled Jacobian that every hexahedron should reach."""

AIM = 0.5
"""Where the worst hexahedron should come when all have reached the goal, and inner nodes can still raise it."""

MOST_AIMED = 5_000
"""Hexahedra of the largest patch that is worked on to that end."""

OF_LIMIT = 0.97
"""Share of what a corner of fixed nodes allows that its hexahedron should reach."""

HOPELESS = 1e-6
"""What fixed nodes must allow a hexahedron, or nothing is tried for it."""

GROWTH = (2, 4, 8)
"""Rings of neighbours around the bad hexahedra, tried in turn."""

FARTHEST = 20.0
"""Factor by which a wanted length may differ from the patch's median."""

MOST_ROUNDS = 10
"""Rounds at most, so that a patch that gains a little each time comes to an end."""

LEAST_GAIN = 0.02
"""A round that brings no patch nearer to its goal, by this share of it, makes the patches grow."""

MOST_GROWN = 10_000
"""Hexahedra of the largest patch that grows for the last time, or at all where nothing is inverted."""

MOST_HEXES = 300_000
"""Hexahedra of the largest patch that is optimised."""


STEPS: dict[bool, tuple[tuple[str, Callable[[Patch, FloatArray], FloatArray]], ...]] = {
    True: (("relax", relaxed), ("untangle", untangled)),
    False: (("polish", polished),),
}
"""Steps by name, of a patch with inverted hexahedra and of one without."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Smoothed:
    """What :func:`improve` did.

    Attributes
    ----------
    nodes : (m,) int64
        Nodes that moved, ascending.
    positions : (m, 3) float64
        Where to.
    steps : tuple of str
        One readable line for each step that was tried, kept or rolled back.
    before, after : float
        Worst scaled Jacobian of the whole mesh.
    n_inverted_before, n_inverted_after : int
        Hexahedra with a corner that is not positive.
    """

    nodes: IntArray
    positions: FloatArray
    steps: tuple[str, ...]
    before: float
    after: float
    n_inverted_before: int
    n_inverted_after: int


def improve(
    points: FloatArray,
    structure: Connected,
    *,
    fixed: BoolArray,
    goal: float = GOAL,
    slides: Slides | None = None,
    is_over: Callable[[bool], bool] = lambda is_valid: False,
) -> Smoothed:
    """Raise the worst scaled Jacobian of a mesh to a goal, where that can be done.

    Parameters
    ----------
    points : (n, 3) float64
        All nodes, numbered as `structure` says. Not changed.
    structure : SweptStructure or Blocks
        Layers of one sweep, or the hexahedra of several blocks.
    fixed : (n,) bool
        Nodes that must not move: those on the boundary.
    goal : float
        Scaled Jacobian that every hexahedron should reach.
    slides : Slides, optional
        Nodes on the boundary that may move on its faces, `fixed` or not.
    is_over : callable
        Whether a mesh stays as it is, told whether it is valid.

    Returns
    -------
    Smoothed
        ``after >= before``; no node moves where nothing is below the goal or nothing helps.
    """
    points = np.array(points, dtype=np.float64)
    fixed = np.asarray(fixed, dtype=bool) if slides is None else fixed & ~slides.mask
    values = hex_values(points, structure)
    before, inverted = float(np.min(values, initial=1.0)), int(np.count_nonzero(values <= 0))
    given, steps = points.copy(), list[str]()
    raised = partial(_raised, points, structure, fixed=fixed, steps=steps, slides=slides, is_over=is_over)
    # Few are inverted, and many may be poor: patches around the few are small, and what is poor is polished anyway.
    if inverted:
        values = raised(values, goal=goal, growths=GROWTH, largest=MOST_HEXES, inverted=True)
    # A mesh with an inverted hexahedron is not handed over, however good the others are.
    if not inverted or np.all(values > 0):
        values = raised(values, goal=goal, growths=GROWTH, largest=MOST_HEXES)
    if steps and goal < AIM and _can_rise(points, structure, values, fixed, slides):
        values = raised(values, goal=AIM, growths=GROWTH[:1], largest=MOST_AIMED)
    for line in steps:
        _log.info("%s", line)
    nodes = np.flatnonzero(np.any(points != given, axis=1))
    return Smoothed(
        nodes=nodes,
        positions=points[nodes],
        steps=tuple(steps),
        before=before,
        after=float(np.min(values, initial=1.0)),
        n_inverted_before=inverted,
        n_inverted_after=int(np.count_nonzero(values <= 0)),
    )


def _raised(
    points: FloatArray,
    structure: Connected,
    values: FloatArray,
    *,
    fixed: BoolArray,
    steps: list[str],
    slides: Slides | None,
    goal: float,
    growths: tuple[int, ...],
    largest: int,
    is_over: Callable[[bool], bool],
    inverted: bool = False,
) -> FloatArray:
    """Work on the hexahedra below a goal, in place, until none is left or nothing helps; return all values.

    On those that are `inverted` alone, or on the others alone.
    """
    growth = 0
    idle: set[bytes] = set()  # patches that gained nothing: the next round would end as the last one did
    alike = Alike()
    settled = np.zeros(values.size, dtype=bool)  # hexahedra of patches that gain nothing more as large as they are
    for _ in range(MOST_ROUNDS):
        bad = _below_goal(points, structure, values, fixed, goal, slides) & ((values <= 0) == inverted)
        if growth == len(growths) or not np.any(bad):
            break
        region = grown(bad, structure, growths[growth])
        if not inverted:
            region &= values > 0  # what nothing could mend must not keep its neighbours from being polished
        gain, for_the_worst = 0.0, not inverted and (growth > 0 or goal > GOAL)
        for hexes in _in_turn(patches(region, structure), values, bad.ravel() & ~settled, worst_first=for_the_worst):
            if is_over(not inverted):
                growth = len(growths)
                steps.append("smoothing was ended with the time that a run has")
                break
            if growth >= (len(GROWTH) - 1 if inverted else 1) and len(hexes) > MOST_GROWN:
                continue
            if len(hexes) > largest:
                steps.append(f"a patch of {len(hexes)} hexahedra is too large to be optimised")
                continue
            places = hexes.tobytes() + points[distinct(hex_nodes(structure, hexes))].tobytes()
            if places in idle:
                continue
            mended = _mend(points, structure, hexes, fixed, goal, steps, slides, alike)
            points[mended.nodes] = mended.positions
            gain = max(gain, mended.gain)
            settled[hexes] |= mended.gain < LEAST_GAIN
            if not len(mended.nodes):
                idle.add(places)
            if for_the_worst and mended.gain < LEAST_GAIN:
                break  # the mesh is as poor as its worst patch, whatever the others become
        if gain < LEAST_GAIN and growth < len(growths):
            # A patch that was the whole mesh cannot grow.
            growth = len(growths) if np.all(region) else growth + 1
            settled[:] = False
        if gain > 0:
            values = hex_values(points, structure)
    return values


def _in_turn(found: Sequence[IntArray], values: FloatArray, wanting: BoolArray, *, worst_first: bool) -> list[IntArray]:
    """The patches that have a hexahedron that wants something, in the order in which they are worked on."""
    chosen = [hexes for hexes in found if wanting[hexes].any()]
    return sorted(chosen, key=lambda hexes: float(values.ravel()[hexes].min())) if worst_first else chosen


def _can_rise(
    points: FloatArray, structure: Connected, values: FloatArray, fixed: BoolArray, slides: Slides | None
) -> bool:
    """Whether the worst hexahedron is not held down by its fixed nodes, and no other one is as low for good."""
    worst = float(np.min(values))
    near = np.flatnonzero(values.ravel() < worst / OF_LIMIT)
    limits = corner_limits(points, hex_nodes(structure, near), fixed, _ways(points, slides, None))
    return worst > 0 and bool(np.all(limits * OF_LIMIT > worst))


def _below_goal(  # noqa: PLR0917
    points: FloatArray,
    structure: Connected,
    values: FloatArray,
    fixed: BoolArray,
    goal: float,
    slides: Slides | None,
) -> BoolArray:
    """Hexahedra below what they should reach and can, in the shape of `values`."""
    below = np.flatnonzero(values.ravel() < goal)
    goals = _goals(points, hex_nodes(structure, below), fixed, goal, slides)
    bad = np.zeros(values.size, dtype=bool)
    bad[below] = values.ravel()[below] < goals
    return bad.reshape(values.shape)


def _goals(  # noqa: PLR0917
    points: FloatArray,
    hexes: IntArray,
    fixed: BoolArray,
    goal: float,
    slides: Slides | None,
    nodes: IntArray | None = None,
) -> FloatArray:
    """The goal of each hexahedron: no more than `OF_LIMIT` of what its fixed nodes allow.

    A hexahedron whose fixed nodes invert it cannot be mended; nothing is asked of it. `nodes` are their numbers in the
    whole mesh where they have others here.
    """
    limits = corner_limits(points, hexes, fixed, _ways(points, slides, nodes))
    return np.where(limits > HOPELESS, np.minimum(goal, OF_LIMIT * limits), -np.inf)


def _ways(points: FloatArray, slides: Slides | None, nodes: IntArray | None) -> Ways | None:
    """What is known of nodes that slide, for :func:`~cadsweep.quality.corner_limits`."""
    if slides is None:
        return None
    names = np.arange(len(points)) if nodes is None else nodes
    return lambda here, ends: slides.ways(names[here], names[ends], points[here])


@dataclass(frozen=True, kw_only=True, eq=False)
class _Mended:
    """Nodes of a patch that moved, their places, and how much nearer the patch came to its goal."""

    nodes: IntArray
    positions: FloatArray
    gain: float


def _mend(  # noqa: PLR0917
    points: FloatArray,
    structure: Connected,
    hexes: IntArray,
    fixed: BoolArray,
    goal: float,
    steps: list[str],
    slides: Slides | None,
    alike: Alike,
) -> _Mended:
    """Relax and untangle a patch, or polish it where nothing is inverted."""
    nodes, local = np.unique(hex_nodes(structure, hexes), return_inverse=True)
    local = local.reshape(-1, 8)
    free = ~fixed[nodes] & ~touches_others(structure, hexes, nodes)
    start = points[nodes]
    if not np.any(free):
        return _Mended(nodes=nodes[:0], positions=start[:0], gain=0.0)
    patch = Patch(
        points=start,
        hexes=local,
        free=free,
        lengths=_wanted_lengths(points, structure, hexes, start[local]),
        goals=_goals(start, local, fixed[nodes], goal, slides, nodes),
        projectors=None if slides is None else slides.projectors(nodes[free], start[free]),
        snap=None if slides is None else partial(_snapped, slides, nodes, free, start),
    )
    if isinstance(structure, Blocks):
        where = f"{len(hexes)} hexahedra from {int(hexes[0])} to {int(hexes[-1])}"
    else:
        first, last = (int(h) // len(structure.quads) for h in (hexes[0], hexes[-1]))
        where = f"{len(hexes)} hexahedra of layers {first} to {last}"
    current, score = start, patch.score(start)
    before = score.reached
    # What is polished is cut anew after untangling: around few hexahedra rather than around all.
    for name, step in STEPS[score.worst <= 0]:
        if not rows.is_on(f"mend: {name}"):
            continue
        candidate = alike.stepped(step, patch, current)
        value = patch.score(candidate)
        if value.beats(score):
            steps.append(f"{name} {where}: worst scaled Jacobian {score.worst:.3g} to {value.worst:.3g}")
            current, score = candidate, value
            rows.took([f"mend: {name}"])
        else:
            steps.append(f"{name} {where}: rolled back, worst stays {score.worst:.3g}")
        if score.reached >= 1:
            break
    changed = free & np.any(current != start, axis=1)
    return _Mended(nodes=nodes[changed], positions=current[changed], gain=min(score.reached, 1.0) - before)


def _snapped(slides: Slides, nodes: IntArray, free: BoolArray, start: FloatArray, points: FloatArray) -> FloatArray:
    """The free nodes of a patch brought back to their faces."""
    points[free] = slides.snapped(nodes[free], points[free], start[free])
    return points


def _wanted_lengths(points: FloatArray, structure: Connected, hexes: IntArray, corners: FloatArray) -> FloatArray:
    """Edge lengths (m, 3) that the hexahedra should have.

    Across the sweep those that they have. Along it the height of their layer on the rings, which
    nothing has disturbed, times what is usual in their column; their own height only shades it.
    """
    lengths = edge_lengths(corners.reshape(-1, 3), np.arange(8 * len(hexes)).reshape(-1, 8))
    if isinstance(structure, Blocks):  # xi, eta and zeta mean other things in each block: only its own are to be had
        middle = np.median(lengths, axis=0)
        return np.clip(lengths, middle / FARTHEST, middle * FARTHEST)
    layer, quad = np.divmod(hexes, len(structure.quads))
    layers, at = np.unique(layer, return_inverse=True)
    ring = np.concatenate(structure.loops)
    lower = ring + layers[:, None] * structure.n_nodes
    upper = (
        ring + ((layers + 1) % structure.n_layers if structure.periodic else layers + 1)[:, None] * structure.n_nodes
    )
    heights = np.median(np.linalg.norm(points[upper] - points[lower], axis=2), axis=1)[at]
    if np.all(heights > 0):
        ratio = lengths[:, 2] / heights
        order = np.lexsort((ratio, quad))
        _, first, column, count = np.unique(quad[order], return_index=True, return_inverse=True, return_counts=True)
        usual = np.empty_like(ratio)
        usual[order] = ratio[order][first + (count - 1) // 2][column]
        lengths[:, 2] = heights * usual * np.clip(ratio / np.where(usual > 0, usual, 1.0), 0.8, 1.25)
    middle = np.median(lengths, axis=0)
    return np.clip(lengths, middle / FARTHEST, middle * FARTHEST)


def hex_values(points: FloatArray, structure: Connected) -> FloatArray:
    """Proven scaled Jacobians (m,), or (n_layers, q) of a swept mesh, made layer by layer without an (m, 8) array."""
    if isinstance(structure, Blocks):
        return proven_values(points, structure.hexes)
    n, q = structure.n_nodes, structure.quads
    values = np.empty((structure.n_layers, len(q)))
    local = np.hstack([q, q + n])
    for k in range(structure.n_layers):
        if structure.periodic and k == structure.n_layers - 1:
            values[k] = proven_values(np.concatenate([points[k * n :], points[:n]]), local)
        else:
            values[k] = proven_values(points[k * n : (k + 2) * n], local)
    return values
