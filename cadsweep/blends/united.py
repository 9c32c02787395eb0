"""The model as a mesh of its design has it: patches are its faces, lines of the mesh its edges.

Place in the flow: what a carried mesh (:mod:`.carrying`) is named after, checked against and smoothed on. The faces of
the model are patches of these faces (``Face.former``), so every quad belongs to the face that its middle is on.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace
from math import pi

import numpy as np

from ..arrays import FloatArray, IntArray
from ..brep import Edge, Face, FormerFace, Loop, Solid, Surface
from ..errors import SurfaceMeshError
from ..harmonic import sides_of
from .carrying import Carried
from .patches import PatchSurface
from .runs import LaidLine

_STEP = 1e-4
"""Share of a line over which its tangents at its ends are measured."""


def patch_surfaces(solid: Solid, patch_of: IntArray) -> dict[int, Surface]:
    """The surface of every patch: a face's own where it is one face."""
    found: dict[int, Surface] = {}
    for patch in np.unique(patch_of).tolist():
        members = np.flatnonzero(patch_of == patch).tolist()
        found[patch] = solid.faces[patch].surface if len(members) == 1 else PatchSurface(solid, members)
    return found


def unite(solid: Solid, patch_of: IntArray, carried: Carried, quads: IntArray) -> tuple[Solid, IntArray]:
    """The solid of patches, and the face of it (q,) that each quad is on.

    Raises
    ------
    SurfaceMeshError
        The skin of the mesh has not the topology of the model.
    """
    patches = np.unique(patch_of)
    quad_faces = np.searchsorted(patches, carried.patches)
    ends = sorted({int(node) for line in carried.lines for node in line.nodes[[0, -1]]})
    vertex_of = {node: v for v, node in enumerate(ends)}
    edges = [_edge(solid, j, line, vertex_of, patches, carried.points) for j, line in enumerate(carried.lines)]
    euler = _open_eulers(carried, quads, quad_faces, len(patches))
    faces = []
    for number, patch in enumerate(patches.tolist()):
        loops = _loops(quads[quad_faces == number], carried.lines, edges)
        members = [solid.faces[f] for f in np.flatnonzero(patch_of == patch)]
        handles = 2 - len(loops) - euler[number]
        if handles % 2 or handles < 0:
            raise SurfaceMeshError(f"{members[0].label()}: its border in the mesh of the design is not closed")
        faces.append(_face(number, members, carried.surfaces[patch], loops, handles))
    found = replace(
        solid,
        vertices=carried.points[ends] if ends else np.zeros((0, 3)),
        edges=tuple(edges),
        faces=tuple(faces),
        vertex_keys=np.arange(len(ends)),
        edge_keys=np.arange(len(edges)),
        face_keys=np.arange(len(faces)),
        kernel=None,
    )
    own = len(ends) - len(edges) + sum(face.euler for face in faces)
    model = len(solid.vertices) - len(solid.edges) + sum(face.euler for face in solid.faces)
    if own != model:
        raise SurfaceMeshError("the mesh of the design has other holes than the model")
    return found, quad_faces


def _edge(  # noqa: PLR0917
    solid: Solid, number: int, line: LaidLine, vertex_of: dict[int, int], patches: IntArray, points: FloatArray
) -> Edge:
    whole = line.run.edges[0]
    at = np.array([0.0, _STEP, 0.5, 1.0 - _STEP, 1.0])
    places = line.curve.evaluate(at)
    tangents = np.stack([places[1] - places[0], places[4] - places[3]])
    fine = line.curve.evaluate(np.linspace(0.0, 1.0, 65))
    low, high = (int(f) for f in np.searchsorted(patches, line.run.pair))
    straight = len(line.run.edges) == 1 and whole.kind == "line"
    return replace(
        whole,
        id=number,
        start=vertex_of[int(line.nodes[0])],
        end=vertex_of[int(line.nodes[-1])],
        length=float(np.linalg.norm(np.diff(fine, axis=0), axis=1).sum()),
        kind="line" if straight else "other",
        faces=(low, high),
        midpoint=places[2],
        tangents=tangents / np.linalg.norm(tangents, axis=1, keepdims=True),
        curve=line.curve,
        gap=max(edge.gap for edge in line.run.edges),
    )


def _loops(quads: IntArray, lines: Sequence[LaidLine], edges: Sequence[Edge]) -> list[Loop]:
    """Loops of lines around the quads of a patch; where it touches itself each goes on around the quads there."""
    following, line_of = dict[tuple[int, int], tuple[int, int]](), dict[tuple[int, int], tuple[int, bool]]()
    for a, b, c, d in quads.tolist():
        following |= {(a, b): (b, c), (b, c): (c, d), (c, d): (d, a), (d, a): (a, b)}
    for line, edge in zip(lines, edges, strict=True):
        for ahead, nodes in ((True, line.nodes.tolist()), (False, line.nodes.tolist()[::-1])):
            if (nodes[0], nodes[1]) in following:
                line_of |= dict.fromkeys(itertools.pairwise(nodes), (edge.id, ahead))
    left, loops = dict.fromkeys(line_of.values()), []
    last = {line_of[segment]: segment for segment in line_of}  # segments of a line come in their order
    while left:
        chain = [next(iter(left))]
        while chain[-1] in left:
            del left[chain[-1]]
            segment = following[last[chain[-1]]]
            while segment not in line_of:
                segment = following[segment[::-1]]
            chain.append(line_of[segment])
        loops.append(
            Loop(
                edges=tuple(e for e, _ in chain[:-1]),
                forward=tuple(ahead for _, ahead in chain[:-1]),
                angles=(pi,) * (len(chain) - 1),
            )
        )
    return loops


def _open_eulers(carried: Carried, quads: IntArray, quad_faces: IntArray, n_faces: int) -> list[int]:
    """Nodes - segments + quads of each patch without its border."""
    segments, pairs = sides_of(quads)
    on_line = np.zeros(len(carried.points), dtype=bool)
    ways = [np.sort(np.column_stack([line.nodes[:-1], line.nodes[1:]]), axis=1) for line in carried.lines]
    of_lines = {tuple(segment) for way in ways for segment in way.tolist()}
    is_line = np.array([tuple(segment) in of_lines for segment in segments.tolist()], dtype=bool)
    on_line[segments[is_line]] = True
    found = np.bincount(quad_faces, minlength=n_faces)
    found = found - np.bincount(quad_faces[pairs[~is_line, 0]], minlength=n_faces)
    nodes, first = np.unique(quads, return_index=True)
    own = ~on_line[nodes]
    found = found + np.bincount(quad_faces[first[own] // 4], minlength=n_faces)
    return [int(number) for number in found]


def _face(number: int, members: Sequence[Face], surface: Surface, loops: Sequence[Loop], handles: int) -> Face:
    """A patch; its largest face gives it its name, the others are patches of it."""
    largest = max(members, key=lambda face: face.area)
    area = sum(face.area for face in members)
    if not isinstance(surface, PatchSurface):
        return replace(largest, id=number, loops=tuple(loops), handles=handles)
    by_key: dict[tuple[str, tuple[str, ...]], list[Face]] = {}
    for face in members:
        by_key.setdefault((face.key or f"face {face.id}", face.names), []).append(face)
    middle = surface.evaluate(surface.project(np.average([face.center for face in members], axis=0)[None]))[0]
    former = []
    for (key, names), own in by_key.items():
        if largest in own:
            continue
        biggest = max(own, key=lambda face: face.area)
        former.append(
            FormerFace(
                names=names, key=key, color=biggest.color, area=sum(face.area for face in own),
                place=biggest.surface.evaluate(biggest.surface.project(biggest.center[None]))[0],
                piece_at=surface.face_at, pieces=tuple(face.id for face in own),
            )
        )  # fmt: skip
    return replace(
        largest,
        id=number,
        kind="other",
        area=area,
        center=middle,
        normal=surface.normals(surface.project(middle[None]))[0],
        loops=tuple(loops),
        surface=surface,
        former=tuple(former),
        handles=handles,
    )


__all__ = ["patch_surfaces", "unite"]
