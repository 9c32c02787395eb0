"""Cells of a planar complex as :class:`~cadsweep.brep.Solid`: what recognition and the plan read.

Place in the flow: between the steps of the search and the callables it is given. The keys are the pool's numbers, so
they tell shared entities in every state of the search.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi

import numpy as np

from ..arrays import FloatArray
from ..brep import Edge, Face, Loop, Solid
from .planar import Cell, Pool, Use
from .tracing import basis
from .vectors import Vector, cross, distance, minus, times, turn, unit


@dataclass(frozen=True, eq=False)
class LineCurve:
    """A straight edge from `start` to `end`, each (3,)."""

    start: FloatArray
    end: FloatArray

    def evaluate(self, fractions: FloatArray) -> FloatArray:
        """Points (m, 3); the ends are met exactly."""
        f = np.asarray(fractions, dtype=float)[:, None]
        return (1.0 - f) * self.start + f * self.end

    def project(self, points: FloatArray) -> FloatArray:
        """Fractions (m,) of the nearest points."""
        along = self.end - self.start
        return np.clip((points - self.start) @ along / (along @ along), 0.0, 1.0)

    def nearest(self, points: FloatArray) -> FloatArray:
        """Nearest places (m, 3)."""
        return self.evaluate(self.project(points))

    def distance(self, points: FloatArray) -> FloatArray:
        """Distances (m,) from the edge."""
        return np.linalg.norm(points - self.nearest(points), axis=1)


@dataclass(frozen=True, eq=False)
class PlaneSurface:
    """A plane face.

    Attributes
    ----------
    origin, u_axis, v_axis, outward : (3,) float64
    curves : dict of int to LineCurve
        Edges of the face.
    """

    origin: FloatArray
    u_axis: FloatArray
    v_axis: FloatArray
    outward: FloatArray
    curves: dict[int, LineCurve]

    @property
    def periods(self) -> tuple[None, None]:
        """A plane has none."""
        return (None, None)

    def evaluate(self, uv: FloatArray) -> FloatArray:
        """Points (m, 3)."""
        return self.origin + uv[:, :1] * self.u_axis + uv[:, 1:] * self.v_axis

    def derivatives(self, uv: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Partial derivatives, each (m, 3)."""
        shape = (len(uv), 3)
        return np.broadcast_to(self.u_axis, shape), np.broadcast_to(self.v_axis, shape)

    def normals(self, uv: FloatArray) -> FloatArray:
        """Unit normals (m, 3) out of the cell."""
        return np.broadcast_to(self.outward, (len(uv), 3))

    def project(self, points: FloatArray) -> FloatArray:
        """Parameters (m, 2) of the nearest points of the plane."""
        return np.stack([(points - self.origin) @ self.u_axis, (points - self.origin) @ self.v_axis], axis=1)

    def distance(self, points: FloatArray, *, close: float = np.inf) -> FloatArray:
        """Distances (m,) from the plane."""
        return np.abs((points - self.origin) @ self.outward)

    def edge_uv(self, edge: int, fractions: FloatArray) -> FloatArray:
        """Parameters (m, 2) of an edge of the face."""
        return self.project(self.curves[edge].evaluate(fractions))


def to_solid(pool: Pool, cell: Cell, model: Solid) -> Solid:
    """Read a cell; `model` is the solid of which it is a piece, whose faces give their names."""
    uses = pool.uses(cell)
    pairs = list(uses)
    edge_id = {pair: j for j, pair in enumerate(pairs)}
    numbers = sorted({v for pair in pairs for v in pair})
    local = {v: j for j, v in enumerate(numbers)}
    vertices = np.array([pool.points[v] for v in numbers])
    face_id = {use: j for j, use in enumerate(cell)}
    curves = [LineCurve(vertices[local[a]], vertices[local[b]]) for a, b in pairs]
    edges = tuple(
        _edge(
            pool,
            model=model,
            number=j,
            pair=pair,
            uses=uses[pair],
            local=local,
            face_id=face_id,
            curve=curves[j],
        )
        for j, pair in enumerate(pairs)
    )
    faces = tuple(
        _face(pool, model=model, number=j, use=use, edge_id=edge_id, curves=curves) for j, use in enumerate(cell)
    )
    box = vertices.max(axis=0) - vertices.min(axis=0)
    return Solid(
        vertices=vertices,
        edges=edges,
        faces=faces,
        volume=pool.volume(cell),
        size=float(np.linalg.norm(box)),
        vertex_keys=np.array(numbers, dtype=np.int64),
        edge_keys=np.array([pool.edge_key(a, b) for a, b in pairs], dtype=np.int64),
        face_keys=np.array([f for f, _ in cell], dtype=np.int64),
        name=model.name,
        material=model.material,
        color=model.color,
        units=model.units,
    )


def _edge(
    pool: Pool,
    *,
    model: Solid,
    number: int,
    pair: tuple[int, int],
    uses: Sequence[Use],
    local: dict[int, int],
    face_id: dict[Use, int],
    curve: LineCurve,
) -> Edge:
    a, b = pool.points[pair[0]], pool.points[pair[1]]
    along = unit(minus(b, a))
    first, second = sorted(uses, key=lambda use: (pair if use[1] > 0 else pair[::-1]) not in pool.facets[use[0]].pairs)
    inward, out = cross(pool.outward(first), along), pool.outward(first)
    angle = turn(inward, times(-1.0, out), cross(along, pool.outward(second)))
    return Edge(
        id=number,
        start=local[pair[0]],
        end=local[pair[1]],
        length=distance(a, b),
        kind="line",
        faces=(face_id[first], face_id[second]),
        dihedral=angle,
        midpoint=(curve.start + curve.end) / 2.0,
        tangents=np.array([along, along]),
        curve=curve,
        units=model.units,
    )


def _face(
    pool: Pool, *, model: Solid, number: int, use: Use, edge_id: dict[tuple[int, int], int], curves: Sequence[LineCurve]
) -> Face:
    facet = pool.facets[use[0]]
    out = pool.outward(use)
    loops = []
    for loop in pool.directed_loops(use):
        pairs = list(zip(loop, loop[1:] + loop[:1], strict=True))
        directed = [((a, b), True) if a < b else ((b, a), False) for a, b in pairs]
        loops.append(
            Loop(
                edges=tuple(edge_id[pair] for pair, _ in directed),
                forward=tuple(forward for _, forward in directed),
                angles=tuple(_angle(pool, loop, j, out) for j in range(len(loop))),
            )
        )
    u_axis, v_axis = basis(facet.normal)
    source = model.faces[facet.origin] if facet.origin >= 0 else None
    own = {edge for loop in loops for edge in loop.edges}
    return Face(
        id=number,
        kind="plane",
        area=facet.area,
        center=np.array(facet.center),
        normal=np.array(out),
        loops=tuple(loops),
        surface=PlaneSurface(
            np.array(times(facet.offset, facet.normal)),
            np.array(u_axis),
            np.array(v_axis),
            np.array(out),
            {e: curves[e] for e in own},
        ),
        name=source.name if source else None,
        groups=source.groups if source else (),
        color=source.color if source else None,
        key=source.key if source else "",
        number=max(facet.origin, -1),
        units=model.units,
    )


def _angle(pool: Pool, loop: tuple[int, ...], j: int, out: Vector) -> float:
    """Interior angle of a face at the j-th vertex of a loop that has the face on its left."""
    at = pool.points[loop[j]]
    leaving = unit(minus(pool.points[loop[(j + 1) % len(loop)]], at))
    back = minus(pool.points[loop[j - 1]], at)
    found = turn(leaving, cross(out, leaving), back)
    return found if found > 0 else 2.0 * pi


__all__ = ["LineCurve", "PlaneSurface", "to_solid"]
