"""Edges of a prism over the cells of a plane: lines at the bottom and at the top, and rails between them.

Place in the flow: third step of :mod:`.prism`.
"""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from ...brep import Edge
from ...errors import CadError
from ..geometry.angles import dihedral_angles
from .prism_numbers import Numbers
from .prism_plane import PlaneCells


def edges_of(cells: PlaneCells, numbers: Numbers) -> tuple[Edge, ...]:
    """All edges of the prism, by id.

    Raises
    ------
    CadError
        The rim touches itself.
    """
    samples, ends = cells.shared.samples, cells.shared.ends
    gaps = np.linalg.norm(samples.points[:, ::2] - cells.shared.vertices[ends], axis=2).max(axis=1, initial=0.0)
    found: dict[int, Edge] = {}
    facing = cells.facing()
    for top, ids, vertices, own in (
        (False, numbers.lower, numbers.lower_vertex, numbers.bottoms),
        (True, numbers.upper, numbers.upper_vertex, numbers.tops),
    ):
        turned = cells.up if top else -cells.up
        sides, normals = np.empty((len(cells.curves), 2), dtype=np.int64), np.empty((2, len(cells.curves), 3))
        for j, (left, right) in enumerate(cells.beside):
            for k, cell in enumerate((left, right) if top else (right, left)):
                sides[j, k] = own[cell] if cell >= 0 else j
                normals[k, j] = turned if cell >= 0 else facing[j]
        dihedrals = dihedral_angles(samples.tangents[:, 1], *normals)
        for j, e in ids.items():
            found[e] = Edge(
                id=e,
                start=vertices[int(ends[j, 0])],
                end=vertices[int(ends[j, 1])],
                length=float(samples.lengths[j]),
                kind=cells.kinds[j],
                faces=(int(sides[j, 0]), int(sides[j, 1])),
                dihedral=float(dihedrals[j]),
                midpoint=samples.points[j, 1] + (cells.along if top else 0.0),
                tangents=samples.end_tangents[j],
                curve=cells.lifted[j] if top else cells.curves[j],
                key=f"edge {e}",
                gap=float(gaps[j]),
                units=cells.overhead.units,
                stands_for=cells.overhead.edges[j],
            )
    for rail in _rails(cells, numbers):
        found[rail.id] = rail
    return tuple(found[e] for e in range(len(found)))


def _rails(cells: PlaneCells, numbers: Numbers) -> list[Edge]:
    """Lines up from the corners of the rim; refuse a corner where the rim comes twice."""
    beside: dict[int, dict[bool, tuple[int, FloatArray]]] = {v: {} for v in numbers.rails}
    units, positions = cells.overhead.units, cells.shared.positions
    for j in range(cells.n_rim):
        sense = cells.sense(j)
        own = zip(cells.shared.ends[j].tolist(), cells.shared.samples.end_tangents[j], strict=True)
        for at_end, (v, tangent) in enumerate(own):
            # A side's loop goes up the rail at the end of its line, as the rim runs.
            goes_up = bool(at_end) == (sense > 0)
            if goes_up in beside[v]:
                raise CadError(_touching(cells, v, beside[v][goes_up][0], j))
            beside[v][goes_up] = j, sense * cells.right(tangent[None])[0]
    vertices = list(numbers.rails)
    normals = [np.array([beside[v][way][1] for v in vertices]) for way in (True, False)]
    dihedrals = dihedral_angles(np.broadcast_to(cells.up, (len(vertices), 3)), *normals)
    return [
        Edge(
            id=numbers.rails[v],
            start=numbers.lower_vertex[v],
            end=numbers.upper_vertex[v],
            length=cells.height,
            kind="line",
            faces=(beside[v][True][0], beside[v][False][0]),
            dihedral=float(dihedral),
            midpoint=positions[v] + cells.along / 2.0,
            tangents=np.array([cells.up, cells.up]),
            curve=cells.rail_curve(v),
            key=f"edge {numbers.rails[v]}",
            units=units,
        )
        for v, dihedral in zip(vertices, dihedrals, strict=True)
    ]


def _touching(cells: PlaneCells, vertex: int, one: int, other: int) -> str:
    """That the rim comes twice to a vertex, and by which edges of the part."""
    where = cells.overhead.units.place(cells.shared.positions[vertex])
    edges = [edge.label() for j in (one, other) for edge in cells.overhead.edges[j][:1]]
    named = f", {edges[0]} and {edges[1]}" if len(edges) == 2 else ""
    return (
        f"its outline{named}, touches itself at ({where}) as seen along the columns: move one of the two by more than "
        "the mesh is to tell apart, or cut the part there"
    )


__all__ = ["edges_of"]
