"""What smoothing must know of nodes on the boundary that may move there."""

from __future__ import annotations

from typing import Protocol

from ..arrays import BoolArray, FloatArray, IntArray


class Slides(Protocol):
    """Nodes on faces of a part that may move on these: :class:`cadsweep.stack_mesh.Slides` is one kind."""

    @property
    def mask(self) -> BoolArray:
        """Nodes (n,) that may."""
        ...

    def projectors(self, nodes: IntArray, points: FloatArray) -> FloatArray:
        """What of a movement (m, 3, 3) nodes (m,) at points (m, 3) can follow; all of it for those that are free."""
        ...

    def snapped(self, nodes: IntArray, points: FloatArray, start: FloatArray) -> FloatArray:
        """Points (m, 3), before smoothing at `start`, brought back to their nodes' faces."""
        ...

    def ways(self, nodes: IntArray, ends: IntArray, points: FloatArray) -> FloatArray:
        """Directions (m, 3) in which `ends` (m,) stay from nodes (m,) at points (m, 3), whatever they do; else NaN."""
        ...
