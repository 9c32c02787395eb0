"""Convex blocks that touch in whole faces, edges or corners: shared without the general fuse, which takes far longer.

Place in the flow: :mod:`.fusing` tries it on solids that may touch; where anything is not as said here, it gives
nothing, and the general fuse is made. Bricks, cells of a battery, layers of one outline, boxes that a box was cut into.

Method: a solid of plane faces and straight edges whose vertices all lie behind every face is convex. Where two such
solids lie on two sides of a plane, they touch within it, so only where both have vertices on it; of all face planes
that part them the common part counts. If both have the same vertices, edges and faces there, that is their contact,
whole, and the second takes the entities of the first. Nothing is moved: vertices must agree within OpenCASCADE's own
tolerance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Surface
from OCP.GeomAbs import GeomAbs_CurveType, GeomAbs_SurfaceType
from OCP.TopAbs import TopAbs_Orientation

from ...arrays import FloatArray, IntArray
from ..shapes import (
    EDGE,
    FACE,
    SHELL,
    SOLID,
    VERTEX,
    WIRE,
    children,
    compound,
    index_map,
    space_range,
    subshapes,
    typed,
)

_FORWARD, _REVERSED = TopAbs_Orientation.TopAbs_FORWARD, TopAbs_Orientation.TopAbs_REVERSED
_SAME = 1e-7
"""Distance of vertices that are one: OpenCASCADE's, which every vertex has as its tolerance at least."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Block:
    """A convex solid: its corners, which of them edges and faces have, outward normals (f, 3) and heights (f,)."""

    shape: Any
    vertices: list[Any]
    edges: list[Any]
    faces: list[Any]
    points: FloatArray
    ends: IntArray
    corners: list[frozenset[int]]
    normals: FloatArray
    heights: FloatArray


class WholeFaces:
    """Solids that share the faces, edges and vertices in which they touch.

    Attributes
    ----------
    pieces : list of TopoDS_Solid
        What each solid has become: the same faces, some of them those of a solid before it.
    """

    def __init__(self, shapes: Sequence[Any], blocks: Sequence[_Block], names: Sequence[IntArray]) -> None:
        self._builder = BRep_Builder()
        self._vertices: dict[int, Any] = {}
        self._edges: dict[frozenset[int], tuple[Any, int]] = {}
        self._faces: dict[frozenset[int], Any] = {}
        both = compound(shapes)
        self._maps = {kind: index_map(both, kind) for kind in (FACE, EDGE)}
        self._images: dict[Any, dict[int, Any]] = {FACE: {}, EDGE: {}}
        self.pieces = [self._shared(block, own) for block, own in zip(blocks, names, strict=True)]

    def image(self, sub: Any) -> Any | None:
        """What a face or an edge of the solids has become; None for one of other solids."""
        kind = sub.ShapeType()
        return self._images[kind].get(self._maps[kind].FindIndex(sub))

    def _shared(self, block: _Block, names: IntArray) -> Any:
        """The solid, with what another has already in the place of its own."""
        for vertex, name in zip(block.vertices, names.tolist(), strict=True):
            self._vertices.setdefault(name, vertex.Oriented(_FORWARD))
        own = index_map(block.shape, EDGE)
        edges = [self._edge(edge, names[ends]) for edge, ends in zip(block.edges, block.ends, strict=True)]
        shells = subshapes(block.shape, SHELL)
        solid, shell = (shape.Oriented(_FORWARD).EmptyCopied() for shape in (block.shape, shells[0]))
        for face, corners in zip(block.faces, block.corners, strict=True):
            key = frozenset(names[list(corners)].tolist())
            taken = self._faces.get(key)
            # Outward from the one is inward from the other.
            became = self._face(face, own, edges) if taken is None else taken.Reversed()
            self._faces.setdefault(key, became)
            self._images[FACE][self._maps[FACE].FindIndex(face)] = became
            self._builder.Add(shell, became)
        shell.Closed(True)
        self._builder.Add(solid, shell)
        return typed(solid, SOLID)

    def _edge(self, edge: Any, ends: IntArray) -> tuple[Any, bool]:
        """The edge of the same ends, and whether it runs the same way."""
        key = frozenset(ends.tolist())
        if key not in self._edges:
            made = edge.Oriented(_FORWARD).EmptyCopied()
            for name, orientation in zip(ends.tolist(), (_FORWARD, _REVERSED), strict=True):
                self._builder.Add(made, self._vertices[name].Oriented(orientation))
            self._builder.Range(typed(made, EDGE), *space_range(edge), True)
            self._edges[key] = typed(made, EDGE), int(ends[0])
        made, start = self._edges[key]
        self._images[EDGE][self._maps[EDGE].FindIndex(edge)] = made
        return made, start == int(ends[0])

    def _face(self, face: Any, own: Any, edges: Sequence[tuple[Any, bool]]) -> Any:
        """The face with the edges that it has now."""
        forward = face.Oriented(_FORWARD)
        out = forward.EmptyCopied()
        for wire in children(forward):
            ring = wire.EmptyCopied().Oriented(_FORWARD)
            for use in children(wire.Oriented(_FORWARD)):
                edge, same = edges[own.FindIndex(use) - 1]
                turned = (use.Orientation() == _FORWARD) == same
                self._builder.Add(ring, edge.Oriented(_FORWARD if turned else _REVERSED))
            ring.Closed(True)
            self._builder.Add(out, ring.Oriented(wire.Orientation()))
        return typed(out.Oriented(face.Orientation()), FACE)


def share_whole_faces(shapes: Sequence[Any], boxes: FloatArray, tolerance: float) -> WholeFaces | None:
    """Let solids share what they touch in; None where they are not convex, or touch in parts of faces.

    Parameters
    ----------
    shapes : sequence of TopoDS_Solid
    boxes : (n, 2, 3) float64
        About each of them.
    tolerance : float
        Distance up to which solids touch.
    """
    blocks: dict[int, _Block] = {}
    for pair in _near_pairs(boxes, tolerance):
        for i in pair:  # each when it is asked for: the first pair may be the last
            block = blocks.get(i) or _read(shapes[i], tolerance)
            if block is None:
                return None
            blocks[i] = block
        if not _touch_wholly(blocks[pair[0]], blocks[pair[1]], tolerance):
            return None
    read = [blocks[i] for i in range(len(shapes))]
    points = np.concatenate([block.points for block in read])
    pairs = scipy.spatial.cKDTree(points).query_pairs(_SAME, output_type="ndarray")
    ones = np.ones(len(pairs), dtype=bool)
    graph = scipy.sparse.coo_array((ones, (pairs[:, 0], pairs[:, 1])), shape=(len(points), len(points)))
    _, every = scipy.sparse.csgraph.connected_components(graph, directed=False)
    names = np.split(every.astype(np.int64), np.cumsum([len(block.points) for block in read])[:-1])
    if any(len(np.unique(own)) < len(own) for own in names):
        return None
    return WholeFaces(shapes, read, names)


def _near_pairs(boxes: FloatArray, reach: float) -> list[tuple[int, int]]:
    low, high = boxes[:, 0], boxes[:, 1]
    near = ((low[:, None] <= high[None] + reach) & (low[None] <= high[:, None] + reach)).all(axis=2)
    return [(int(i), int(j)) for i, j in np.argwhere(np.triu(near, 1))]


def _read(shape: Any, tolerance: float) -> _Block | None:
    """A convex solid between planes; None for any other."""
    faces, edges, vertices = (subshapes(shape, kind) for kind in (FACE, EDGE, VERTEX))
    surfaces = [BRepAdaptor_Surface(face, False) for face in faces]
    is_plain = (
        len(subshapes(shape, SHELL)) == 1
        and shape.Orientation() == _FORWARD
        and all(surface.GetType() == GeomAbs_SurfaceType.GeomAbs_Plane for surface in surfaces)
        and all(len(subshapes(face, WIRE)) == 1 for face in faces)
        and all(BRepAdaptor_Curve(edge).GetType() == GeomAbs_CurveType.GeomAbs_Line for edge in edges)
    )
    if not is_plain:
        return None
    points = np.array([(p.X(), p.Y(), p.Z()) for p in map(BRep_Tool.Pnt_s, vertices)])
    of_vertex, of_edge = index_map(shape, VERTEX), index_map(shape, EDGE)
    ends = []
    for edge in edges:
        own = list(children(edge.Oriented(_FORWARD)))
        own.sort(key=lambda vertex: vertex.Orientation() == _REVERSED)
        if [vertex.Orientation() for vertex in own] != [_FORWARD, _REVERSED]:
            return None
        ends.append([of_vertex.FindIndex(vertex) - 1 for vertex in own])
    normals, heights, corners = [], [], []
    for face, surface in zip(faces, surfaces, strict=True):
        around = {v for edge in subshapes(face, EDGE) for v in ends[of_edge.FindIndex(edge) - 1]}
        plane = surface.Plane()
        axis = plane.Axis().Direction()
        sign = (1.0 if plane.Direct() else -1.0) * (1.0 if face.Orientation() == _FORWARD else -1.0)
        normals.append(sign * np.array([axis.X(), axis.Y(), axis.Z()]))
        heights.append(float((points[sorted(around)] @ normals[-1]).mean()))
        corners.append(frozenset(around))
    if (points @ np.array(normals).T > np.array(heights) + tolerance).any():
        return None
    return _Block(
        shape=shape,
        vertices=vertices,
        edges=edges,
        faces=faces,
        points=points,
        ends=np.array(ends),
        corners=corners,
        normals=np.array(normals),
        heights=np.array(heights),
    )


def _touch_wholly(one: _Block, other: _Block, tolerance: float) -> bool:
    """Whether two blocks are apart, or touch in entities that both have, and lie on two sides of them."""
    on_one, on_other = np.ones(len(one.points), dtype=bool), np.ones(len(other.points), dtype=bool)
    parted = False
    for near, far, on_near, on_far in ((one, other, on_one, on_other), (other, one, on_other, on_one)):
        above_near, above_far = (block.points @ near.normals.T - near.heights for block in (near, far))
        least = above_far.min(axis=0)
        if (least > tolerance).any():
            return True
        parting = np.flatnonzero(least >= -_SAME)
        parted |= bool(len(parting))
        np.logical_and(on_near, (above_near[:, parting] >= -tolerance).all(axis=1), out=on_near)
        np.logical_and(on_far, (above_far[:, parting] <= tolerance).all(axis=1), out=on_far)
    mine, theirs = np.flatnonzero(on_one), np.flatnonzero(on_other)
    if not parted or len(mine) != len(theirs):
        return False
    same = np.linalg.norm(one.points[mine][:, None] - other.points[theirs], axis=2) <= _SAME
    if not ((same.sum(axis=0) == 1).all() and (same.sum(axis=1) == 1).all()):
        return False
    answer = np.full(len(other.points), -1)
    answer[theirs] = mine[same.argmax(axis=0)]
    return _within(one, np.arange(len(one.points)), on_one) == _within(other, answer, on_other)


def _within(block: _Block, names: IntArray, chosen: np.ndarray) -> tuple[set[frozenset[int]], set[frozenset[int]]]:
    """Edges and faces of a block between chosen vertices, by the names of these."""
    edges = {frozenset(names[pair].tolist()) for pair in block.ends[chosen[block.ends].all(axis=1)]}
    faces = {frozenset(names[list(own)].tolist()) for own in block.corners if chosen[list(own)].all()}
    return edges, faces


__all__ = ["WholeFaces", "share_whole_faces"]
