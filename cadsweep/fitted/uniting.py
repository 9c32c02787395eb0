"""A solid whose faces are united where they run smoothly into each other: no mesh needs a line there.

Edges that are left and run smoothly into each other between the same two faces become one. What is left of the model's
topology is what a grid must have; pieces keep their names as patches of their face.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace
from math import pi
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray, IntArray
from ..brep import Edge, Face, FormerFace, Loop, Solid
from .facets import Facets
from .grouping import BRIDGED, SMOOTH, group_faces
from .united import UnitedCurve, UnitedSurface

_SAG = 0.005
"""How far facets are off their faces at most, over the size of the solid."""

Directed = tuple[int, bool]


class United(NamedTuple):
    """The solid with its smooth faces united.

    Attributes
    ----------
    solid : Solid
    of_face : (n_faces,) int64
        The united face of every face of the model.
    angles : dict of (vertex, face) to float
        Angle of every united face at the vertices of its border.
    bridged : tuple of int
        Faces of the model that were united for being narrow.
    """

    solid: Solid
    of_face: IntArray
    angles: dict[tuple[int, int], float]
    bridged: tuple[int, ...]


def unite(solid: Solid, facets: Facets, axes: FloatArray, size: float, *, ridges: bool) -> United:
    """The solid with its faces united as :func:`.grouping.group_faces` says for a grid of some axes and size."""
    of_face, narrow = group_faces(solid, axes, size, ridges=ridges)
    return unite_as(solid, facets, size, of_face, narrow)


def unite_as(solid: Solid, facets: Facets, size: float, of_face: IntArray, narrow: tuple[int, ...]) -> United:
    """The solid with faces united that have the same number, from 0, in `of_face` (n_faces,), some for being narrow."""
    edges = [edge for edge in solid.edges if of_face[edge.faces[0]] != of_face[edge.faces[1]]]
    runs = list(_runs(solid, of_face, edges, BRIDGED * size))
    joined = [_edge(solid, of_face, number, run) for number, run in enumerate(runs)]
    of_edge = {e: number for number, run in enumerate(runs) for e, _ in run}
    faces = [_face(solid, of_face, united, of_edge, joined, facets) for united in range(int(of_face.max()) + 1)]
    ends = {vertex for edge in joined for vertex in (edge.start, edge.end)}
    angles: dict[tuple[int, int], float] = defaultdict(float)
    for face in solid.faces:
        for loop in face.loops:
            for directed, angle in zip(loop.directed, loop.angles, strict=True):
                angles[solid.first_vertex(directed), int(of_face[face.id])] += angle
    united = replace(
        solid,
        edges=tuple(joined),
        faces=tuple(faces),
        edge_keys=np.array([solid.edge_keys[run[0][0]] for run in runs], dtype=np.int64),
        face_keys=np.array(
            [solid.face_keys[np.flatnonzero(of_face == united)[0]] for united in range(len(faces))], dtype=np.int64
        ),
    )
    return United(united, of_face, {place: angle for place, angle in angles.items() if place[0] in ends}, narrow)


def _runs(solid: Solid, of_face: IntArray, edges: list[Edge], short: float) -> Iterator[list[Directed]]:
    """Edges between the same faces that run smoothly on, or are short, head to tail; a ring is two runs."""
    at: dict[int, list[int]] = defaultdict(list)
    for edge in edges:
        at[edge.start].append(edge.id)
        at[edge.end].append(edge.id)

    def following(last: Directed) -> Directed | None:
        edge = solid.edges[last[0]]
        vertex = edge.end if last[1] else edge.start
        others = [e for e in at[vertex] if e != edge.id]
        if len(at[vertex]) != 2 or len(others) != 1 or others[0] not in left:
            return None
        other = solid.edges[others[0]]
        if {int(of_face[f]) for f in other.faces} != {int(of_face[f]) for f in edge.faces}:
            return None
        ahead = edge.tangents[1] if last[1] else -edge.tangents[0]
        beyond = other.tangents[0] if other.start == vertex else -other.tangents[1]
        is_one = ahead @ beyond > np.cos(SMOOTH) or min(edge.length, other.length) < short
        return (other.id, other.start == vertex) if is_one else None

    left = dict.fromkeys(edge.id for edge in edges)
    while left:
        first = next(iter(left))
        del left[first]
        run: list[Directed] = [(first, True)]
        for _ in range(2):
            while (found := following(run[-1])) is not None:
                del left[found[0]]
                run.append(found)
            run = [(e, not forward) for e, forward in reversed(run)]
        if len(run) > 1 and solid.first_vertex(run[0]) == solid.last_vertex(run[-1]):
            lengths = np.cumsum([solid.edges[e].length for e, _ in run])
            half = int(np.clip(np.searchsorted(lengths, 0.5 * lengths[-1]), 1, len(run) - 1))
            yield run[:half]
            yield run[half:]
        else:
            yield run


def _edge(solid: Solid, of_face: IntArray, number: int, run: list[Directed]) -> Edge:
    """The edge that a run of edges becomes."""
    own = [solid.edges[e] for e, _ in run]
    low, high = (int(of_face[f]) for f in own[0].faces)
    if len(run) == 1:
        return replace(own[0], id=number, faces=(low, high))
    (first, forward), (last, onward) = run[0], run[-1]
    starts = solid.edges[first].tangents[0] if forward else -solid.edges[first].tangents[1]
    ends = solid.edges[last].tangents[1] if onward else -solid.edges[last].tangents[0]
    longest = max(own, key=lambda edge: edge.length)
    curve = UnitedCurve([(solid.edges[e].curve, way) for e, way in run], [edge.length for edge in own])
    return replace(
        longest,
        id=number,
        start=solid.first_vertex(run[0]),
        end=solid.last_vertex(run[-1]),
        length=sum(edge.length for edge in own),
        kind="line" if all(edge.kind == "line" for edge in own) else "other",
        faces=(low, high),
        midpoint=curve.evaluate(np.array([0.5]))[0],
        tangents=np.stack([starts, ends]),
        curve=curve,
        gap=max(edge.gap for edge in own),
    )


def _face(  # noqa: PLR0917
    solid: Solid, of_face: IntArray, united: int, of_edge: dict[int, int], joined: list[Edge], facets: Facets
) -> Face:
    """The face that the faces of a group become."""
    members = np.flatnonzero(of_face == united)
    own = [solid.faces[face] for face in members]
    largest = max(own, key=lambda face: face.area)
    inner = {e for face in own for e in face.edges}
    border = dict.fromkeys(of_edge[e] for face in own for e in face.edges if e in of_edge)
    corners = {v for e in inner for v in (solid.edges[e].start, solid.edges[e].end)}
    loops = _loops(joined, list(border))
    ends = {v for e in border for v in (joined[e].start, joined[e].end)}
    # Of a face that is closed, or goes through the solid and back, loops do not say all.
    euler = len(corners) - len(inner) + sum(face.euler for face in own) - len(ends) + len(border)
    handles = 2 - len(loops) - euler
    if len(own) == 1:
        return replace(largest, id=united, number=largest.known, loops=loops, handles=handles)
    numbers = np.full(len(solid.faces), -1, dtype=np.int64)
    numbers[members] = np.arange(len(members))
    mine = facets.of(members)
    surface = UnitedSurface(
        [face.surface for face in own],
        {e: joined[e].curve for e in border},
        mine._replace(faces=numbers[mine.faces]),
        _SAG * solid.size,
    )
    by_key: dict[tuple[str, tuple[str, ...]], list[Face]] = defaultdict(list)
    for face in own:
        by_key[face.key or f"face {face.id}", face.names].append(face)
    pieces = list(by_key.items())
    kept = next(faces for _, faces in pieces if largest in faces)
    return replace(
        largest,
        id=united,
        number=largest.known,
        kind=largest.kind if len({id(face.surface) for face in own}) == 1 else "other",
        area=sum(face.area for face in own),
        loops=loops,
        surface=surface,
        handles=handles,
        former=tuple(
            FormerFace(
                names=names,
                key=key,
                color=faces[0].color,
                area=sum(face.area for face in faces),
                place=_inside(mine, faces),
                piece_at=surface.pieces,
                pieces=tuple(numbers[[face.id for face in faces]].tolist()),
            )
            for (key, names), faces in pieces
            if faces is not kept
        ),
    )


def _inside(facets: Facets, faces: list[Face]) -> np.ndarray:
    """A point of the largest facet of some faces."""
    own = facets.points[facets.of(np.array([face.id for face in faces])).triangles]
    if not len(own):
        return faces[0].center
    areas = np.linalg.norm(np.cross(own[:, 1] - own[:, 0], own[:, 2] - own[:, 0]), axis=1)
    return np.asarray(own[int(np.argmax(areas))].mean(axis=0))


def _loops(edges: list[Edge], border: list[int]) -> tuple[Loop, ...]:
    """The edges of a border in pieces that hang together; what goes round each is not said."""
    left, found = dict.fromkeys(border), []
    while left:
        front = [next(iter(left))]
        own: list[int] = []
        while front:
            e = front.pop()
            if e in left:
                del left[e]
                own.append(e)
                ends = {edges[e].start, edges[e].end}
                front += [o for o in left if ends & {edges[o].start, edges[o].end}]
        found.append(Loop(edges=tuple(own), forward=(True,) * len(own), angles=(pi,) * len(own)))
    return tuple(found)
