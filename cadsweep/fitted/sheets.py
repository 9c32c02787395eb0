"""Sheets of hexahedra under the skin of a grid, where its own hexahedra would be flat once they lie on the model.

What makes them flat, however fine the grid is: two quads of one hexahedron on one smooth face (their common edge
becomes one of 180 degrees), two sides of one quad on one smooth curve (so does their common corner), one quad in a wide
corner.
One sheet under the whole skin gives every quad a hexahedron of its own: at every edge of the model two meet, each with
half of the angle, whether it is convex, concave or smooth. A sheet around the hexahedra under one face leaves a rim of
quads along the face's border: two of them meet at every node and vertex of it, whatever the angle::

    the grid         a sheet under the skin      and one around those of the face above
    --+--+--         --+--+--                    -+-+--+--     of the face, with a new rim
      |  |            \\ |  |                     \\ \\_|__|_
    --+--+             -+--+                      \\_+__+_     new hexahedra around, to where the
                       |  |                        +  |       next face begins
"""

from __future__ import annotations

import itertools
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import radians
from typing import NamedTuple

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray
from ..brep import Solid
from ..cells import HEX_FACES
from ..harmonic import find_hexes, mean_around
from .rings import Ring
from .skin import keys_of, outward_at, sides_around
from .topology import divide_ring

_THICK = 0.3
"""Thickness of a sheet at first over the size of the grid; untangling evens it out."""
_WIDE = radians(150.0)
"""Angle of one quad in a corner above which the face gets a rim: the sine of it bounds the quality."""
_NARROW = radians(25.0)
"""The same from below, where there are more than the two quads that a rim has there."""
_OPPOSITE = -1.0 + 1e-6
"""Cosine between the normals of two faces of one plane below which they look opposite ways."""
_SAME = 1e-6
"""Distance of two planes over the size of the solid up to which they are one."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Fitted:
    """A mesh of one solid whose boundary knows the solid's faces and edges.

    Attributes
    ----------
    points : (n, 3) float64
    hexes : (m, 8) int64
    quads : (q, 4) int64
        The boundary, outward.
    labels : (q,) int64
        Face of every quad.
    chains : dict of int to int64 array
        Nodes of every edge, by id, from its start to its end.
    has_skin : bool
        Whether a sheet lies under the whole skin.
    """

    points: FloatArray
    hexes: IntArray
    quads: IntArray
    labels: IntArray
    chains: dict[int, IntArray]
    has_skin: bool = False


class Rim(NamedTuple):
    """A mesh with a new rim, the copy (n,) of every node that was there, and the sides (r, 2) along which it lies."""

    mesh: Fitted
    copy: IntArray
    sides: IntArray


def lay_sheets(
    solid: Solid, angles: Mapping[tuple[int, int], float], rings: Sequence[Ring], mesh: Fitted, size: float
) -> Fitted:
    """The mesh with its rings, a sheet under its skin, and around what is under single faces, as far as it needs them.

    Parameters
    ----------
    solid : Solid
    angles : mapping of (vertex, face) to float
        Of its faces at their vertices.
    rings : sequence of Ring
        Faces that the mesh has not yet, in the order in which they were left out.
    mesh : Fitted
    size : float
    """
    if not (mesh.has_skin or rings or _shares_hexes(mesh) or _bent(mesh) or _crowded(solid, angles, mesh)):
        return mesh
    mesh = mesh if mesh.has_skin else with_skin(solid, mesh, size)
    for ring in reversed(rings):
        mesh = _with_ring(solid, mesh, ring)
    for face in sorted(_bent(mesh) | _crowded(solid, angles, mesh)):
        mesh = with_rim(mesh, face).mesh
    return mesh


def _shares_hexes(mesh: Fitted) -> bool:
    """Whether some hexahedron has two quads on one face."""
    both = np.stack([find_hexes(mesh.hexes, mesh.quads), mesh.labels], axis=1)
    return len(np.unique(both, axis=0)) < len(both)


def _bent(mesh: Fitted) -> set[int]:
    """Faces of which some quad has two sides in turn on the border, and no vertex between them."""
    n = len(mesh.points)
    none = np.empty((0, 2), dtype=np.int64)  # a body without a sharp edge
    steps = np.concatenate([none, *(np.stack([chain[:-1], chain[1:]], axis=1) for chain in mesh.chains.values())])
    border = keys_of(np.concatenate([steps, steps[:, ::-1]]), n)
    on = np.isin(keys_of(sides_around(mesh.quads), n), border).reshape(-1, 4)
    inner = ~np.isin(mesh.quads, [int(chain[j]) for chain in mesh.chains.values() for j in (0, -1)])
    return set(np.unique(mesh.labels[(on & np.roll(on, 1, axis=1) & inner).any(axis=1)]).tolist())


def _crowded(solid: Solid, angles: Mapping[tuple[int, int], float], mesh: Fitted) -> set[int]:
    """Faces with too few quads in a corner for its angle, or too many."""
    nodes = {}
    for edge, chain in mesh.chains.items():
        nodes[solid.edges[edge].start], nodes[solid.edges[edge].end] = int(chain[0]), int(chain[-1])
    counts = Counter[tuple[int, int]]()
    near = np.isin(mesh.quads, list(nodes.values())).any(axis=1)
    for quad, label in zip(mesh.quads[near].tolist(), mesh.labels[near].tolist(), strict=True):
        counts.update((node, label) for node in quad)
    found = set()
    for (vertex, face), angle in angles.items():
        n = counts[nodes[vertex], face]
        if angle / n > _WIDE or (n > 2 and angle / n < _NARROW):
            found.add(face)
    return found


def with_skin(solid: Solid, mesh: Fitted, size: float) -> Fitted:
    """A sheet under the whole skin: what was there keeps to a copy of its nodes, hexahedra join the two.

    Of hexahedra on either side of a plane through which it cannot go, each have a sheet around them.
    """
    middles = mesh.points[mesh.hexes].mean(axis=1)
    sides = [(middles - place) @ normal > 0.0 for place, normal in _two_sided(solid)]
    of_hex = np.unique(np.stack([np.zeros(len(middles)), *sides]), axis=1, return_inverse=True)[1].ravel()
    under = of_hex[find_hexes(mesh.hexes, mesh.quads)]
    points, hexes, sheets = [mesh.points], mesh.hexes.copy(), []
    for own in range(of_hex.max() + 1):
        inside = of_hex == own
        walls = mesh.quads[under == own]
        if sides:
            walls = np.concatenate([walls, _walls(mesh, inside)])
        nodes = np.unique(walls)
        inner = np.arange(len(mesh.points))
        inner[nodes] = sum(map(len, points)) + np.arange(len(nodes))
        points.append(mesh.points[nodes] - _THICK * size * outward_at(mesh.points, walls)[nodes])
        hexes[inside] = inner[mesh.hexes[inside]]
        sheets.append(np.concatenate([inner[walls], walls], axis=1))
    return Fitted(
        points=np.concatenate(points),
        hexes=np.concatenate([hexes, *sheets]),
        quads=mesh.quads,
        labels=mesh.labels,
        chains=mesh.chains,
        has_skin=True,
    )


def _two_sided(solid: Solid) -> list[tuple[FloatArray, FloatArray]]:
    """Planes (place and normal) in which two faces meet in a vertex alone and look opposite ways.

    As where a bar passes under a block, flush with its underside: no way leads inward of both faces, and one node of a
    sheet would have to be on both sides of the plane. Faces that meet along an edge there, as where a slit runs out to
    nothing, do have one, within the plane.
    """
    faces_at: dict[int, set[int]] = defaultdict(set)
    adjacent = {(vertex, *sorted(edge.faces)) for edge in solid.edges for vertex in (edge.start, edge.end)}
    for edge in solid.edges:
        for vertex in (edge.start, edge.end):
            faces_at[vertex].update(edge.faces)
    found: list[tuple[FloatArray, FloatArray]] = []

    def is_known(place: FloatArray, normal: FloatArray) -> bool:
        near = _SAME * solid.size
        return any(abs(normal @ other) > -_OPPOSITE and abs((place - at) @ other) < near for at, other in found)

    for vertex, faces in faces_at.items():
        place = solid.vertices[[vertex]]
        surfaces = {face: solid.faces[face].surface for face in sorted(faces)}
        normals = {face: surface.normals(surface.project(place))[0] for face, surface in surfaces.items()}
        apart = [pair for pair in itertools.combinations(normals, 2) if (vertex, *pair) not in adjacent]
        opposite = [normals[one] for one, other in apart if normals[one] @ normals[other] < _OPPOSITE]
        found += [
            (solid.vertices[vertex], normal) for normal in opposite if not is_known(solid.vertices[vertex], normal)
        ]
    return found


def _with_ring(solid: Solid, mesh: Fitted, ring: Ring) -> Fitted:
    """The mesh with a rim that is a ring, and the edges on its other side."""
    beyond = dict.fromkeys((side for e in ring.kept for side in _both_ways(mesh.chains[e])), ring.face)
    rim = with_rim(mesh, ring.inner, beyond)
    following = dict(side for side in rim.sides.tolist() if tuple(side) in beyond)
    path = [next(iter(following))]
    while len(path) <= len(following):
        path.append(following[path[-1]])
    chains = divide_ring(solid, ring.lost, rim.copy[path].tolist(), rim.mesh.points)
    return replace(rim.mesh, chains={**mesh.chains, **chains})


def _both_ways(chain: IntArray) -> list[tuple[int, int]]:
    return [side for a, b in itertools.pairwise(chain.tolist()) for side in ((a, b), (b, a))]


def with_rim(mesh: Fitted, face: int, beyond: Mapping[tuple[int, int], int] | None = None) -> Rim:
    """A sheet around the hexahedra under a face: these get copies of the nodes that they share with others.

    On the face it leaves a rim of quads between its border and what had been there; they are of
    the face too, but for those along the sides that are a key of `beyond`.
    """
    on = mesh.labels == face
    own = mesh.quads[on]
    inside = np.zeros(len(mesh.hexes), dtype=bool)
    inside[find_hexes(mesh.hexes, own)] = True
    walls = _walls(mesh, inside)
    nodes = np.unique(walls)
    copy = np.arange(len(mesh.points))
    copy[nodes] = len(mesh.points) + np.arange(len(nodes))
    copies = 0.5 * (mesh.points + mean_around(mesh.points, mesh.hexes[inside]))
    on_skin = np.unique(own)
    copies[on_skin] = 0.5 * (mesh.points + mean_around(mesh.points, own))[on_skin]
    sides, n = sides_around(own), len(mesh.points)
    sides = sides[np.isin(keys_of(sides, n), keys_of(sides_around(mesh.quads[~on])[:, ::-1], n))]
    a, b = sides.T
    rim = np.array([(beyond or {}).get((one, other), face) for one, other in sides.tolist()], dtype=np.int64)
    hexes = np.where(inside[:, None], copy[mesh.hexes], mesh.hexes)
    found = Fitted(
        points=np.concatenate([mesh.points, copies[nodes]]),
        hexes=np.concatenate([hexes, np.concatenate([copy[walls], walls], axis=1)]),
        quads=np.concatenate([mesh.quads[~on], copy[own], np.stack([a, b, copy[b], copy[a]], axis=1)]),
        labels=np.concatenate([mesh.labels[~on], np.full(len(own), face), rim]),
        chains=mesh.chains,
        has_skin=mesh.has_skin,
    )
    return Rim(found, copy, sides)


def _walls(mesh: Fitted, inside: BoolArray) -> IntArray:
    """Faces (w, 4) between hexahedra that are inside and others, outward from those inside."""
    touched = np.zeros(len(mesh.points), dtype=bool)
    touched[mesh.hexes[inside]] = True
    near = touched[mesh.hexes].any(axis=1)
    every, is_in = mesh.hexes[near][:, HEX_FACES].reshape(-1, 4), np.repeat(inside[near], 6)
    keys = np.sort(every, axis=1)
    order = np.lexsort(keys.T)
    same = (keys[order[1:]] == keys[order[:-1]]).all(axis=1)
    one, other = order[:-1][same], order[1:][same]
    found = np.concatenate([one[is_in[one] & ~is_in[other]], other[is_in[other] & ~is_in[one]]])
    return every[np.sort(found)]
