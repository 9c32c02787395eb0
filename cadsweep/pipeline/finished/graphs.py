"""Faces, edges and vertices of a part as plain data: how they hang together, and what they are called.

Place in the flow: what :mod:`.matching` compares, and a file of a mesh keeps of the mesh's part.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...brep import Part, Solid

_MIDDLE = np.array([0.5])


@dataclass(frozen=True, kw_only=True)
class Graph:
    """Faces, edges and vertices of a solid as plain data.

    Attributes
    ----------
    loops : tuple of tuple of tuple of (int, bool)
        Loops of every face, as directed edges.
    face_names, edge_names : tuple of tuple of str
        The user's names of every face and edge, sorted.
    face_keys : tuple of str
        What the faces are called in the input.
    face_labels : tuple of str
        What messages call them.
    ends : tuple of (int, int)
        Start and end vertex of every edge.
    vertices, middles : tuple of (float, float, float)
        Vertices, and middles of the edges, in the bounding box of all of them: 0 to 1. Files of earlier versions have
        no middles.
    shared_faces, shared_edges, shared_vertices : tuple of tuple of int
        Of a part of several solids, whose ids run through them: what is one in several.
    """

    loops: tuple[tuple[tuple[tuple[int, bool], ...], ...], ...]
    face_names: tuple[tuple[str, ...], ...]
    edge_names: tuple[tuple[str, ...], ...]
    face_keys: tuple[str, ...]
    face_labels: tuple[str, ...]
    ends: tuple[tuple[int, int], ...]
    vertices: tuple[tuple[float, ...], ...]
    shared_faces: tuple[tuple[int, int], ...] = ()
    shared_edges: tuple[tuple[int, ...], ...] = ()
    shared_vertices: tuple[tuple[int, ...], ...] = ()
    middles: tuple[tuple[float, ...], ...] = ()


def graph_of_part(part: Part) -> Graph:
    """The graph of all solids of a part, with ids that run through them, and what they share."""
    if len(part.solids) == 1:
        return graph_of(part.solids[0])
    graphs = [graph_of(solid) for solid in part.solids]
    starts = first_ids(part)
    vertices, middles = _in_box(part.solids)
    names = [part.models[owner].name for owner in part.owners]
    edge, vertex = starts.edges, starts.vertices
    return Graph(
        loops=tuple(
            tuple(tuple((e + edge[cell], forward) for e, forward in loop) for loop in loops)
            for cell, graph in enumerate(graphs)
            for loops in graph.loops
        ),
        face_names=tuple(
            (f"solid {names[cell]}", *own) for cell, graph in enumerate(graphs) for own in graph.face_names
        ),
        edge_names=tuple(own for graph in graphs for own in graph.edge_names),
        face_keys=tuple(f"{names[cell]} {key}" for cell, graph in enumerate(graphs) for key in graph.face_keys),
        face_labels=tuple(
            f"{label} of '{names[cell]}'" for cell, graph in enumerate(graphs) for label in graph.face_labels
        ),
        ends=tuple((a + vertex[cell], b + vertex[cell]) for cell, graph in enumerate(graphs) for a, b in graph.ends),
        vertices=vertices,
        middles=middles,
        shared_faces=tuple((a, b) for a, b in _shared(part, "face_keys", starts.faces)),
        shared_edges=_shared(part, "edge_keys", edge),
        shared_vertices=_shared(part, "vertex_keys", vertex),
    )


@dataclass(frozen=True, kw_only=True)
class FirstIds:
    """What is added to the ids of every solid where those of all solids run on: last, how many there are."""

    faces: tuple[int, ...]
    edges: tuple[int, ...]
    vertices: tuple[int, ...]


def first_ids(part: Part) -> FirstIds:
    """First ids of the solids of a part."""

    def starts(counts: Sequence[int]) -> tuple[int, ...]:
        return tuple(np.cumsum([0, *counts]).tolist())

    return FirstIds(
        faces=starts([len(solid.faces) for solid in part.solids]),
        edges=starts([len(solid.edges) for solid in part.solids]),
        vertices=starts([len(solid.vertices) for solid in part.solids]),
    )


def _shared(part: Part, kind: str, starts: Sequence[int]) -> tuple[tuple[int, ...], ...]:
    """Ids, running through all solids, of what is one entity in several solids."""
    users: dict[int, list[int]] = {}
    for cell, solid in enumerate(part.solids):
        for own, key in enumerate(getattr(solid, kind).tolist()):
            users.setdefault(key, []).append(starts[cell] + own)
    return tuple(tuple(ids) for ids in users.values() if len(ids) > 1)


def graph_of(solid: Solid) -> Graph:
    """The graph of a solid."""
    vertices, middles = _in_box([solid])
    return Graph(
        loops=tuple(tuple(tuple(loop.directed) for loop in face.loops) for face in solid.faces),
        face_names=tuple(tuple(sorted(face.names)) for face in solid.faces),
        edge_names=tuple(tuple(sorted(edge.names)) for edge in solid.edges),
        face_keys=tuple(face.key for face in solid.faces),
        face_labels=tuple(face.label() for face in solid.faces),
        ends=tuple((edge.start, edge.end) for edge in solid.edges),
        vertices=vertices,
        middles=middles,
    )


def _in_box(solids: Sequence[Solid]) -> tuple[tuple[tuple[float, ...], ...], tuple[tuple[float, ...], ...]]:
    """Vertices, and middles of edges, of all solids, in the bounding box of all of them."""
    vertices = np.concatenate([solid.vertices for solid in solids])
    middles = np.array([edge.curve.evaluate(_MIDDLE)[0] for solid in solids for edge in solid.edges]).reshape(-1, 3)
    both = np.concatenate([vertices, middles])
    low, high = both.min(axis=0), both.max(axis=0)
    rows = ((both - low) / np.where(high > low, high - low, 1.0)).tolist()
    return tuple(map(tuple, rows[: len(vertices)])), tuple(map(tuple, rows[len(vertices) :]))
