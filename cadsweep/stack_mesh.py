"""The mesh of a stack of columns, as arrays or as products, and the nodes of it that may slide on the part's faces.

Place in the flow: ``stacks`` makes them of a :class:`~cadsweep.stack.Stack` and its levels; ``pipeline`` hands them on.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Protocol

import numpy as np
import scipy

from .arrays import BoolArray, FloatArray, IntArray
from .brep import Curve


@dataclass(frozen=True, kw_only=True, eq=False)
class StackMesh:
    """Nodes and hexahedra of a stack, in working units.

    Attributes
    ----------
    points : (n, 3) float64
    hexes : (m, 8) int64
        Column by column, and layer by layer.
    columns : tuple of int
        How many hexahedra every column has.
    quads : (q, 4) int64
        The boundary, outward.
    faces : (q,) int64
        Face of the solid that each of them lies on.
    edge_nodes : dict of int to (k,) int64
        Nodes along every edge of the solid, from its start to its end.
    levels, places : (n,) int64
        Level of every node, and which node of the arrangement's mesh it is over.
    """

    points: FloatArray
    hexes: IntArray
    columns: tuple[int, ...]
    quads: IntArray
    faces: IntArray
    edge_nodes: dict[int, IntArray] = field(default_factory=dict)
    levels: IntArray
    places: IntArray


@dataclass(frozen=True, kw_only=True, eq=False)
class StraightColumn:
    """One column of a straight stack; nodes of a layer are those of its cell of the arrangement.

    Attributes
    ----------
    nodes : (n,) int64
        Nodes of the arrangement's mesh.
    quads : (q, 4) int64
        By places in `nodes`, as are the loops.
    loops : tuple of int64 arrays
        Around the cell, the outer one first.
    low : int
        Level of its lower cap.
    points : (n, 3) float64
        Places in the plane, without heights.
    rises : (n_layers + 1,) float64
        Height of every layer of nodes.
    rims : (n_layers + 1, b) float64
        Heights of the nodes on the loops.
    modes, amounts : (n, r), (n_layers + 1, r) float64
        What the layers inside rise by besides.
    bottom, top, rings : (n,), (n,), (n_layers + 1, b) int64
        Nodes of the skeleton.
    seen : (s,) int64
        Which of the quads of its two caps and its sides, one after the other, are boundary.
    """

    nodes: IntArray
    quads: IntArray
    loops: tuple[IntArray, ...]
    low: int
    points: FloatArray
    rises: FloatArray
    rims: FloatArray
    modes: FloatArray
    amounts: FloatArray
    bottom: IntArray
    top: IntArray
    rings: IntArray
    seen: IntArray

    @property
    def n_layers(self) -> int:
        """Layers of hexahedra."""
        return len(self.rises) - 1

    @property
    def inside(self) -> IntArray:
        """Nodes that are on no loop, by their places in `nodes`."""
        return np.setdiff1d(np.arange(len(self.nodes)), np.concatenate(self.loops))


@dataclass(frozen=True, kw_only=True, eq=False)
class StraightStack:
    """A stack as products: its columns, and the skeleton of nodes that they share, in working units.

    Attributes
    ----------
    points : (s, 3) float64
        The skeleton: nodes on lines and on caps. Those inside of columns are numbered after these, column by column.
    columns : tuple of StraightColumn
    quads : (q, 4) int64
        The boundary, outward, column by column.
    faces : (q,) int64
    edge_nodes : dict of int to (k,) int64
    skeleton_levels, skeleton_places : (s,) int64
    """

    points: FloatArray
    columns: tuple[StraightColumn, ...]
    quads: IntArray
    faces: IntArray
    edge_nodes: dict[int, IntArray]
    skeleton_levels: IntArray
    skeleton_places: IntArray

    @property
    def levels(self) -> IntArray:
        """Level of every node, those inside of columns included."""
        inner = [
            np.repeat(np.arange(own.low + 1, own.low + own.n_layers), len(own.nodes) - own.rings.shape[1])
            for own in self.columns
        ]
        return np.concatenate([self.skeleton_levels, *inner])

    @property
    def places(self) -> IntArray:
        """Node of the arrangement's mesh that every node is over."""
        inner = [np.tile(own.nodes[own.inside], own.n_layers - 1) for own in self.columns]
        return np.concatenate([self.skeleton_places, *inner])


class Placed(Protocol):
    """Where every node of a stack's mesh is, and its boundary: :class:`StackMesh` and :class:`StraightStack`."""

    @property
    def levels(self) -> IntArray: ...
    @property
    def places(self) -> IntArray: ...
    @property
    def quads(self) -> IntArray: ...
    @property
    def faces(self) -> IntArray: ...


@dataclass(frozen=True, kw_only=True, eq=False)
class Slides:
    """Nodes on the faces of a part that may move on these: on flat caps, on walls, and along edges.

    Attributes
    ----------
    mask : (n,) bool
        Nodes that may.
    up : (3,) float64
        Unit vector along all walls, across all of these caps.
    rises : (n,) bool
        Those of them that may move along `up`.
    curve : (n,) int64
        The curve over which, or under which, a node must stay; -1 for none.
    curves : mapping of int to Curve
        Seen along `up`, each is the foot of walls; it may lean, as the rim of a slanted cap does.
    """

    mask: BoolArray
    up: FloatArray
    rises: BoolArray
    curve: IntArray
    curves: Mapping[int, Curve]

    def projectors(self, nodes: IntArray, points: FloatArray) -> FloatArray:
        """What of a movement (m, 3, 3) nodes (m,) at points (m, 3) can follow; all of it for those that are free."""
        found = np.repeat(np.eye(3)[None], len(nodes), axis=0)
        sliding = self.mask[nodes]
        upright = np.outer(self.up, self.up)
        found[sliding] -= upright
        for number, at in self._by_curve(nodes):
            curve = self.curves[number]
            fractions = self._fractions(curve, points[at])
            low, high = np.clip(fractions - _STEP, 0.0, 1.0), np.clip(fractions + _STEP, 0.0, 1.0)
            tangents = self._seen(curve.evaluate(high) - curve.evaluate(low))
            tangents /= np.maximum(np.linalg.norm(tangents, axis=1, keepdims=True), 1e-300)
            found[at] = tangents[:, :, None] * tangents[:, None, :]
        found[sliding & self.rises[nodes]] += upright
        return found

    def snapped(self, nodes: IntArray, points: FloatArray, start: FloatArray) -> FloatArray:
        """Points (m, 3) brought back to their nodes' curves; those that may not rise, to their heights at `start`."""
        level = self.mask[nodes] & ~self.rises[nodes]
        found = points + np.where(level, (start - points) @ self.up, 0.0)[:, None] * self.up
        points = found.copy()
        for number, at in self._by_curve(nodes):
            curve = self.curves[number]
            places = curve.evaluate(self._fractions(curve, points[at]))
            found[at] = places + ((points[at] - places) @ self.up)[:, None] * self.up
        return found

    def ways(self, nodes: IntArray, ends: IntArray, points: FloatArray) -> FloatArray:
        """Directions (m, 3), seen along `up`, in which `ends` (m,) stay from nodes (m,) at points (m, 3), or NaN.

        Those are the tangents of curves on which the ends must stay and on which the nodes lie, too.
        """
        found = np.full((len(nodes), 3), np.nan)
        for number, at in self._by_curve(ends):
            curve = self.curves[number]
            fractions = self._fractions(curve, points[at])
            low, high = np.clip(fractions - _STEP, 0.0, 1.0), np.clip(fractions + _STEP, 0.0, 1.0)
            along = self._seen(curve.evaluate(high) - curve.evaluate(low))
            off = np.linalg.norm(self._seen(curve.evaluate(fractions) - points[at]), axis=1)
            on = off <= _ON * np.linalg.norm(along, axis=1) / (high - low)
            found[at[on]] = along[on]
        return found

    def _by_curve(self, nodes: IntArray) -> list[tuple[int, IntArray]]:
        own = np.where(self.mask[nodes], self.curve[nodes], -1)
        return [(int(number), np.flatnonzero(own == number)) for number in np.unique(own[own >= 0])]

    def _seen(self, points: FloatArray) -> FloatArray:
        """Points or vectors (m, 3) without their heights."""
        return points - np.outer(points @ self.up, self.up)

    def _sampled(self, curve: Curve) -> tuple[float | None, Any]:
        """The height of a curve, None where it leans, and a tree of samples of it seen along `up`."""
        if curve not in self._samples:
            samples = curve.evaluate(_AT)
            heights = samples @ self.up
            flat = np.ptp(heights) <= _LEVEL * np.ptp(samples, axis=0).max()
            self._samples[curve] = heights[0] if flat else None, scipy.spatial.cKDTree(self._seen(samples))
        return self._samples[curve]

    @cached_property
    def _samples(self) -> dict[Curve, tuple[float | None, Any]]:
        """What is known of the curves that were asked for."""
        return {}

    def _fractions(self, curve: Curve, points: FloatArray) -> FloatArray:
        """Fractions (m,) of a curve at which, seen along `up`, it is nearest to points (m, 3)."""
        level, tree = self._sampled(curve)
        if level is not None:
            return curve.project(points + (level - points @ self.up)[:, None] * self.up)
        # A curve that leans comes nearer to a point at its own height than to one over or under it.
        target = self._seen(points)
        fractions = _AT[tree.query(target)[1]]
        for _ in range(_ROUNDS):
            low, high = np.clip(fractions - _STEP, 0.0, 1.0), np.clip(fractions + _STEP, 0.0, 1.0)
            tangents = self._seen(curve.evaluate(high) - curve.evaluate(low)) / (high - low)[:, None]
            gaps = target - self._seen(curve.evaluate(fractions))
            moves = (gaps * tangents).sum(axis=1) / np.maximum((tangents**2).sum(axis=1), 1e-300)
            moves = np.clip(fractions + moves, 0.0, 1.0) - fractions
            fractions = fractions + moves
            if float(np.abs(moves).max(initial=0.0)) < _STILL:
                break
        return fractions


_AT = np.linspace(0.0, 1.0, 65)
"""Fractions of a curve's samples."""
_LEVEL = 1e-12
"""Rise of a curve, in its extents, up to which it is level."""
_ROUNDS = 30
_ON = 1e-6
"""Distance from a curve, in lengths of it, up to which a place is on it."""
_STILL = 1e-13
"""Move, as a fraction of a curve, below which a place on it has been found."""
_STEP = 1e-6
"""Fraction of a curve's length over which its tangent is measured."""
