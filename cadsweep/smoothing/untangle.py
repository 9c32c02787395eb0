"""Untangling all of a mesh at once, its boundary nodes moving along the faces and edges that they are on.

Place in the flow: ``pipeline`` calls it on a mesh whose nodes were just put on the model, and whose inner edges say
nothing yet about how long they should be; what it leaves is polished by :func:`cadsweep.smoothing.improve`.

Method: the regularised shape energy of :mod:`.energy`, its regularisation fading with what is inverted, over all nodes.
Between rounds nodes go back to their entities exactly, and the directions in which they may move are found again.
Where a round is of no use, the next wants of hexahedra the lengths that they have: then only angles are asked for, and
what was held fast between lengths wanted on several sides comes free. Once none is inverted, only what is around poor
hexahedra is polished.

What it does not handle: a quad of the boundary that its own nodes cannot make convex.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray
from ..brep import Surface
from ..projection.descent import minimise
from .optimise import MovedEnergy, polished, solver_of
from .patch import Patch, edge_lengths, proven_values
from .sliding import Slides

_ROUNDS = 14
"""Rounds at most; what is untangled at all mostly needs five."""
_STEPS = 40
"""Steps of the minimiser a round: directions along faces hold for about as far."""
_IDLE = 4
"""Rounds without fewer inverted hexahedra after which it ends."""
_FEW = 0.02
"""Share of the hexahedra that are inverted below which a round moves only what is around them."""
_FAR = 6
"""Hexahedra around an inverted one whose nodes move for it then."""
_SHORTEST = 0.1
"""Share of the longest edges wanted that is wanted at least where hexahedra are to keep the lengths that they have."""
_REACH = 3
"""Hexahedra around a poor one whose nodes move for it once none is inverted: what is farther off hardly matters."""


class Untangled(NamedTuple):
    """Points (n, 3), and the worst scaled Jacobian; 0 where a hexahedron is not valid or the boundary folds."""

    points: FloatArray
    worst: float


class Guards(NamedTuple):
    """Hexahedra outside, on the quads of the boundary: without them it may fold over an inner edge, all inside valid.

    Attributes
    ----------
    hexes : (q, 8) int64
        Of nodes of the mesh and, numbered after these, of outer ones.
    outer : callable
        Takes points (n, 3) and returns the outer nodes (g, 3), each off its face along the normal.
    """

    hexes: IntArray
    outer: Callable[[FloatArray], FloatArray]


def guards_outside(
    surfaces: Sequence[Surface], n_nodes: int, quads: IntArray, faces: IntArray, height: float
) -> Guards:
    """Guards on quads (q, 4) of a mesh of `n_nodes`, those of each face by themselves, `height` off its surface."""
    hexes, places, first = [], [], n_nodes
    for face in np.unique(faces).tolist():
        nodes, local = np.unique(quads[faces == face], return_inverse=True)
        local = local.reshape(-1, 4)
        hexes.append(np.concatenate([nodes[local], first + local], axis=1))
        places.append((surfaces[face], nodes))
        first += len(nodes)

    def outer(points: FloatArray) -> FloatArray:
        return np.concatenate(
            [points[nodes] + height * surface.normals(surface.project(points[nodes])) for surface, nodes in places]
        )

    return Guards(np.concatenate(hexes), outer)


def _facing(corners: FloatArray) -> FloatArray:
    """The Jacobian in the middle of guards with `corners` (q, 8, 3): positive where a quad faces outward on the whole.

    Of a quad on a face that bends away, or with a corner of more than a straight angle, a guard is not valid in every
    corner; that is no fold.
    """
    u, v, w = (
        corners[:, ahead].sum(axis=1) - corners[:, behind].sum(axis=1)
        for behind, ahead in (([0, 3, 4, 7], [1, 2, 5, 6]), ([0, 1, 4, 5], [3, 2, 7, 6]), ([0, 1, 2, 3], [4, 5, 6, 7]))
    )
    return np.asarray(np.einsum("ij,ij->i", np.cross(u, v), w))


def untangle(
    points: FloatArray,
    hexes: IntArray,
    free: BoolArray,
    lengths: FloatArray,
    slides: Slides,
    *,
    goal: float,
    guards: Guards,
    on_round: Callable[[int], bool] = lambda left: False,
) -> Untangled:
    """Move nodes until no hexahedron is inverted, then on until the worst is at a goal.

    Parameters
    ----------
    points : (n, 3) float64
    hexes : (m, 8) int64
    free : (n,) bool
        Nodes that may move; those of `slides` along their faces and edges only.
    lengths : (m, 3) float64
        Wanted edge lengths of every hexahedron.
    slides : Slides
    guards : Guards
    goal : float
        Scaled Jacobian that every hexahedron should reach.
    on_round : callable
        Told how many hexahedra are inverted; what it returns ends the rounds.
    """
    n = len(points)
    every = np.concatenate([hexes, guards.hexes])
    everywhere = np.ones(len(every), dtype=bool)
    lengths = np.concatenate([lengths, np.repeat(np.median(lengths, axis=0)[None], len(guards.hexes), axis=0)])

    def guarded(points: FloatArray) -> FloatArray:
        return np.concatenate([points, guards.outer(points)])

    def patch_at(points: FloatArray, free: BoolArray, chosen: BoolArray) -> Patch:
        nodes = np.flatnonzero(free)

        def snap(moved: FloatArray) -> FloatArray:
            moved[nodes] = slides.snapped(nodes, moved[nodes], points[nodes])
            return moved

        return Patch(
            points=points,
            hexes=every[chosen],
            free=np.concatenate([free, np.zeros(len(points) - n, dtype=bool)]),
            lengths=lengths[chosen],
            goals=np.full(int(chosen.sum()), goal),
            projectors=slides.projectors(nodes, points[nodes]),
            snap=snap,
        )

    def around(points: FloatArray, poor: BoolArray, among: BoolArray, reach: int) -> Patch:
        """What may move around poor hexahedra, and those among which it does."""
        near = np.zeros(int(every.max()) + 1, dtype=bool)
        near[every[poor]] = True
        for _ in range(reach):
            near[every[near[every].any(axis=1)]] = True
        near[n:] = False
        near[:n] &= free
        return patch_at(guarded(points), near[:n], near[every].any(axis=1) & among)

    def valued(points: FloatArray) -> tuple[FloatArray, tuple[int, float]]:
        """The value of every hexahedron, and how many are inverted and the worst inside: less is better."""
        values = np.concatenate([proven_values(points, hexes), _facing(guarded(points)[guards.hexes])])
        return values, (int((values <= 0).sum()), -float(values[: len(hexes)].min()))

    values, best_key = valued(points)
    best, best_values, idle = points, values, 0
    for _ in range(_ROUNDS):
        if on_round(best_key[0]) or best_key[0] == 0 or idle == _IDLE:
            break
        if (values <= 0).sum() < _FEW * len(every):
            patch = around(points, values <= 0, everywhere, _FAR)
            if idle % 2:
                own = edge_lengths(patch.points, patch.hexes)
                patch = replace(patch, lengths=np.clip(own, _SHORTEST * lengths.max(), lengths.max()))
        else:
            patch = patch_at(guarded(points), free, everywhere)
        energy = MovedEnergy(patch, patch.points)
        x = energy.x[patch.free]
        energy(x)
        energy.eps = np.sqrt(1e-6 + 0.04 * min(energy.least, 0.0) ** 2)
        x, _ = minimise(energy, x, solver_of(patch), n_steps=_STEPS)
        assert patch.snap is not None
        points = patch.snap(energy.positions(x))[:n]
        values, key = valued(points)
        idle = 0 if key[0] < best_key[0] else idle + 1
        if key < best_key:
            best, best_values, best_key = points, values, key
    if best_key[0] == 0 and -best_key[1] < goal and not on_round(0):
        # Guards are to face outward, and no more: their angles mean nothing.
        inside = np.arange(len(every)) < len(hexes)
        patch = around(best, inside & (best_values < goal), inside, _REACH)
        polished_too = polished(patch, patch.points, is_over=lambda: on_round(0))[:n]
        polished_key = valued(polished_too)[1]
        if polished_key < best_key:
            best, best_key = polished_too, polished_key
    return Untangled(best, 0.0 if best_key[0] else -best_key[1])
