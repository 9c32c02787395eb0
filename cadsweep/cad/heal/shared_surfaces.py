"""Faces that share one closed surface get a surface each.

Place in the flow: after healing, before dividing.

Where a boolean operation divides a closed face, all pieces refer to one surface, and an edge between two of
them has its parameter curves there once; one on the seam has two, as if one face used it twice.
``ShapeUpgrade_ShapeDivideClosed`` then moves one piece's edges to a surface of their own, and the other
piece loses its parameter curves.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy
from OCP.Geom import Geom_Plane
from OCP.gp import gp_Vec2d
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopLoc import TopLoc_Location

from ..shapes import EDGE, FACE, explore, subshapes, surface_range, typed
from .tracing import Traced, present


def part_surfaces(traced: Traced) -> None:
    """Give faces that share a surface with a seam a copy of it each, in a copy of the shape."""
    by_surface: dict[int, tuple[Any, list[Any]]] = {}
    for face in subshapes(traced.shape, FACE):
        surface = BRep_Tool.Surface_s(face, TopLoc_Location())
        by_surface.setdefault(id(surface), (surface, []))[1].append(face)  # kept, so that its id is its own
    chosen = [
        face
        for _, faces in by_surface.values()
        if len(faces) > 1 and any(_uses_seam(face) for face in faces)
        for face in faces[1:]
    ]
    if not chosen:
        return
    tool = BRepBuilderAPI_Copy(traced.shape)
    for face in chosen:
        _own_surface(typed(tool.ModifiedShape(face), FACE))
    known = [present(traced, kind) for kind in (FACE, EDGE)]

    def copy_of(old: Any) -> Any:
        """The copy of a face or edge; healing may have left one out of the shape, which has none."""
        return tool.ModifiedShape(old) if any(shapes.Contains(old) for shapes in known) else None

    traced.replace(tool.Shape(), copy_of)


def _uses_seam(face: Any) -> bool:
    return any(BRep_Tool.IsClosed_s(edge, face) for edge in explore(face, EDGE) if not BRep_Tool.Degenerated_s(edge))


def _own_surface(face: Any) -> None:
    change_surface(face, BRep_Tool.Surface_s(face).Copy())  # the location is in it


def change_surface(
    face: Any, surface: Any, move: Callable[[tuple[float, float]], tuple[float, float]] = lambda _: (0.0, 0.0)
) -> None:
    """Put a face on another surface, in place.

    `move` says by how much an edge's curve in the parameters is moved, from where its middle was. On a plane edges need
    no such curves.
    """
    face = typed(face.Oriented(TopAbs_Orientation.TopAbs_FORWARD), FACE)
    here = TopLoc_Location()
    builder = BRep_Builder()
    tolerance = BRep_Tool.Tolerance_s(face)
    todo = []
    is_plane = isinstance(surface, Geom_Plane)
    edges: list[Any] = []
    for edge in [] if is_plane else explore(face, EDGE):
        if not any(edge.IsSame(known) for known in edges):
            edges.append(edge)
    for edge in edges:
        uses = [use for use in explore(face, EDGE) if use.IsSame(edge)]
        uses.sort(key=lambda use: use.Orientation() == TopAbs_Orientation.TopAbs_REVERSED)
        todo.append((edge, [BRep_Tool.CurveOnSurface_s(use, face, 0.0, 1.0) for use in uses]))
    for edge, curves in todo:
        if None not in curves:
            first, last = surface_range(edge, face)
            middles = [curve.Value(0.5 * (first + last)) for curve in curves]
            moved = [
                curve.Translated(gp_Vec2d(*move((middle.X(), middle.Y()))))
                for curve, middle in zip(curves, middles, strict=True)
            ]
            # of a true seam both curves, that of its forward use first
            builder.UpdateEdge(edge, *moved, surface, here, BRep_Tool.Tolerance_s(edge))
            builder.Range(edge, surface, here, first, last)
    builder.UpdateFace(face, surface, here, tolerance)
