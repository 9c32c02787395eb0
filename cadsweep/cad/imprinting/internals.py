"""Edges and vertices inside a face that bound nothing: where a solid only rests on it, along a line or at a point.

Place in the flow: called by :mod:`.joining` after the fuse. A cylinder that lies on a plane leaves its line in the
plane's face, both of whose sides are that face; no loop has it, and the face is taken without it.
"""

from __future__ import annotations

from typing import Any

from OCP.BRep import BRep_Builder
from OCP.BRepTools import BRepTools_ReShape
from OCP.TopAbs import TopAbs_Orientation, TopAbs_ShapeEnum

from ..heal.tracing import Traced
from ..shapes import EDGE, FACE, children, subshapes, typed

_BOUNDING = (TopAbs_Orientation.TopAbs_FORWARD, TopAbs_Orientation.TopAbs_REVERSED)


def drop_internals(traced: Traced) -> int:
    """Take such edges and vertices out of the faces, in place; returns the number of faces that had some."""
    reshape = BRepTools_ReShape()
    n_faces = 0
    for face in subshapes(traced.shape, FACE):
        forward = typed(face.Oriented(TopAbs_Orientation.TopAbs_FORWARD), FACE)
        kept = [_bounding(wire) for wire in children(forward)]
        if any(now is None or not now.IsSame(was) for now, was in zip(kept, children(forward), strict=True)):
            reshape.Replace(forward, _rebuilt(forward, [wire for wire in kept if wire is not None]))
            n_faces += 1
    if n_faces:
        traced.replace(reshape.Apply(traced.shape), reshape.Apply)
    return n_faces


def _bounding(wire: Any) -> Any:
    """A wire without the edges that bound nothing: itself where it has none, None where it has no others."""
    if wire.ShapeType() != TopAbs_ShapeEnum.TopAbs_WIRE:
        return None
    edges = list(children(wire))
    bounding = [edge for edge in edges if edge.ShapeType() == EDGE and edge.Orientation() in _BOUNDING]
    if len(bounding) == len(edges):
        return wire
    return _rebuilt(wire, bounding) if bounding else None


def _rebuilt(shape: Any, parts: list[Any]) -> Any:
    """The same wire or face with other parts."""
    out = shape.EmptyCopied()
    builder = BRep_Builder()
    for part in parts:
        builder.Add(out, part)
    return out


__all__ = ["drop_internals"]
