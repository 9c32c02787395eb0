"""Hand-made solids and sweeps for the surface stage: lines, bilinear sides, planes; a piece of a torus.

polygon_prism(loops, levels)          seen from the side, two levels above the source:

    level 2   o-----o-----o           loops   polygons, outer counter-clockwise, holes clockwise
              |     |     |           levels  one map of a level's (m, 2) corners to (m, 3) each
    level 1   o-----o     |           merged  columns (loop, side) whose faces are one face over
              |     |     |                   all levels: a T-junction on each of their rails
    source    o-----o-----o
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cadsweep.brep import Edge, Face, Loop, Solid
from cadsweep.sweep import Intervals, LinkingSide, Sweep


@dataclass(frozen=True)
class Line:
    """A straight edge."""

    start: np.ndarray
    end: np.ndarray

    def evaluate(self, fractions):
        s = np.asarray(fractions, dtype=float)[:, None]
        return (1 - s) * self.start + s * self.end

    def project(self, points):
        step = self.end - self.start
        return np.clip((points - self.start) @ step / (step @ step), 0, 1)


@dataclass(frozen=True)
class Arc:
    """``center + cos t * x + sin t * y`` from angle a to b."""

    center: np.ndarray
    x: np.ndarray
    y: np.ndarray
    a: float
    b: float

    def evaluate(self, fractions):
        s = np.asarray(fractions, dtype=float)
        t = ((1 - s) * self.a + s * self.b)[:, None]
        return self.center + np.cos(t) * self.x + np.sin(t) * self.y

    def project(self, points):
        raise NotImplementedError


class EdgesOnSurface:
    """Edges' parameters as straight lines of the parameter plane."""

    periods = (None, None)

    def __init__(self):
        self.ends = {}

    def edge_uv(self, edge, fractions):
        a, b = self.ends[edge]
        s = np.asarray(fractions, dtype=float)[:, None]
        return (1 - s) * np.asarray(a) + s * np.asarray(b)

    def normals(self, uv):
        by_u, by_v = self.derivatives(uv)
        cross = np.cross(by_u, by_v)
        return cross / np.linalg.norm(cross, axis=1, keepdims=True)

    def integrals(self, edges, loops):
        """Area, centroid times area, and flux of the position through the face: the box of its edges' parameters."""
        ends = np.array(list(self.ends.values()), dtype=float).reshape(-1, 2)
        low, high = ends.min(axis=0), ends.max(axis=0)
        x, w = np.polynomial.legendre.leggauss(8)
        place = [(b - a) / 2 * x + (a + b) / 2 for a, b in zip(low, high, strict=True)]
        uv = np.stack(np.meshgrid(*place, indexing="ij"), axis=-1).reshape(-1, 2)
        by_u, by_v = self.derivatives(uv)
        normal = np.cross(by_u, by_v) * np.outer(w, w).reshape(-1, 1) * np.prod(high - low) / 4
        points, area = self.evaluate(uv), np.linalg.norm(normal, axis=1)
        return area.sum(), area @ points, float((points * normal).sum())


class Bilinear(EdgesOnSurface):
    """A side between four corners; (u, v) in the unit square, normal along u x v."""

    def __init__(self, p00, p10, p11, p01):
        super().__init__()
        self.p = [np.asarray(p, dtype=float) for p in (p00, p10, p11, p01)]

    def evaluate(self, uv):
        u, v = uv[:, :1], uv[:, 1:]
        a, b, c, d = self.p
        return (1 - u) * (1 - v) * a + u * (1 - v) * b + u * v * c + (1 - u) * v * d

    def derivatives(self, uv):
        u, v = uv[:, :1], uv[:, 1:]
        a, b, c, d = self.p
        return (1 - v) * (b - a) + v * (c - d), (1 - u) * (d - a) + u * (c - b)

    def project(self, points):
        uv = np.full((len(points), 2), 0.5)
        for _ in range(50):
            off = points - self.evaluate(uv)
            by_u, by_v = self.derivatives(uv)
            jacobian = np.stack([by_u, by_v], axis=2)
            uv = uv + np.einsum("mij,mj->mi", np.linalg.pinv(jacobian), off)
        return uv


class Plane(EdgesOnSurface):
    """A plane in its own orthonormal frame; `normal` points out of the solid."""

    def __init__(self, origin, normal):
        super().__init__()
        self.origin = np.asarray(origin, dtype=float)
        normal = np.asarray(normal, dtype=float) / np.linalg.norm(normal)
        axis = np.eye(3)[np.argmin(np.abs(normal))]
        first = np.cross(normal, axis)
        first /= np.linalg.norm(first)
        self.frame = np.stack([first, np.cross(normal, first)])

    def evaluate(self, uv):
        return self.origin + uv @ self.frame

    def derivatives(self, uv):
        return np.tile(self.frame[0], (len(uv), 1)), np.tile(self.frame[1], (len(uv), 1))

    def project(self, points):
        return (points - self.origin) @ self.frame.T

    def integrals(self, edges, loops):
        """The same by triangles from the origin to a fine polyline along each loop."""
        area, moment, normal = 0.0, np.zeros(3), np.cross(*self.frame)
        for loop in loops:
            for e, forward in loop.directed:
                points = edges[e].curve.evaluate(np.linspace(0.0, 1.0, 2001))[:: 1 if forward else -1]
                parts = np.cross(points[:-1] - self.origin, points[1:] - self.origin) @ normal / 2
                area += parts.sum()
                moment += parts @ (points[:-1] + points[1:] + self.origin) / 3
        return area, moment, area * float(self.origin @ normal)


class Disc(Plane):
    """A plane face of curved edges."""

    def __init__(self, origin, normal, edges):
        super().__init__(origin, normal)
        self.edges = edges

    def edge_uv(self, edge, fractions):
        return self.project(self.edges[edge].curve.evaluate(np.asarray(fractions, dtype=float)))


class Torus(EdgesOnSurface):
    """Circle of radius `minor` about a circle of radius `major` around z: u around z, v around the tube."""

    periods = (2 * np.pi, 2 * np.pi)

    def __init__(self, major, minor):
        super().__init__()
        self.major, self.minor = major, minor

    def evaluate(self, uv):
        u, v = uv.T
        rho = self.major + self.minor * np.cos(v)
        return np.stack([rho * np.cos(u), rho * np.sin(u), self.minor * np.sin(v)], axis=1)

    def derivatives(self, uv):
        u, v = uv.T
        rho = self.major + self.minor * np.cos(v)
        by_u = np.stack([-rho * np.sin(u), rho * np.cos(u), 0 * u], axis=1)
        sin = self.minor * np.sin(v)
        by_v = np.stack([-sin * np.cos(u), -sin * np.sin(u), self.minor * np.cos(v)], axis=1)
        return by_u, by_v


@dataclass(frozen=True)
class Outline:
    """A face before its figures are known: its surface, its loops of directed edges, its kind."""

    surface: EdgesOnSurface
    loops: tuple[tuple[tuple[int, bool], ...], ...]
    kind: str


def make_edge(i, start, end, curve, length):
    """An edge whose faces and dihedral angle are not known yet: :func:`make_solid` tells them."""
    points = curve.evaluate(np.array([0.0, 0.01, 0.5, 0.99, 1.0]))
    tangents = np.stack([points[1] - points[0], points[4] - points[3]])
    return Edge(
        id=i,
        start=start,
        end=end,
        length=length,
        kind="line" if isinstance(curve, Line) else "circle",
        faces=(-1, -1),
        dihedral=np.nan,
        midpoint=points[2],
        tangents=tangents / np.linalg.norm(tangents, axis=1, keepdims=True),
        curve=curve,
    )


def _angle(normal, before, after):
    """Angle inside a face, at a corner that is reached along `before` and left along `after`."""
    return float(np.arctan2(np.cross(after, -before) @ normal, -(after @ before)) % (2 * np.pi))


def _make_loop(surface, edges, directed):
    ways = [edges[e].tangents if forward else -edges[e].tangents[::-1] for e, forward in directed]
    angles = []
    for j, (e, forward) in enumerate(directed):
        uv = surface.edge_uv(e, np.array([0.0 if forward else 1.0]))
        angles.append(_angle(surface.normals(uv)[0], ways[j - 1][1], ways[j][0]))
    return Loop(edges=tuple(e for e, _ in directed), forward=tuple(way for _, way in directed), angles=tuple(angles))


def make_solid(vertices, edges, outlines):
    """A solid whose areas, angles and volume are those of its surfaces, every edge with its two faces."""
    vertices = np.asarray(vertices, dtype=float)
    users = {edge.id: [] for edge in edges}
    faces, flux = [], 0.0
    for f, outline in enumerate(outlines):
        for directed in [d for loop in outline.loops for d in loop]:
            users[directed[0]].append((f, directed[1]))
        loops = tuple(_make_loop(outline.surface, edges, loop) for loop in outline.loops)
        area, moment, through = outline.surface.integrals(edges, loops)
        flux += through
        center = moment / area
        normal = outline.surface.normals(outline.surface.project(center[None]))[0] if outline.kind != "torus" else None
        faces.append(
            Face(
                id=f,
                kind=outline.kind,
                area=area,
                center=center,
                normal=np.zeros(3) if normal is None else normal,
                loops=loops,
                surface=outline.surface,
            )
        )
    done = []
    for edge in edges:
        (one, forward), (other, backward) = users[edge.id]
        assert forward != backward, "neighbours run an edge against each other"
        n, m = (faces[f].surface.normals(faces[f].surface.edge_uv(edge.id, np.array([0.5])))[0] for f in (one, other))
        along = edge.curve.evaluate(np.array([0.501]))[0] - edge.curve.evaluate(np.array([0.499]))[0]
        along *= (1 if forward else -1) / np.linalg.norm(along)
        dihedral = np.pi - np.arctan2(np.cross(n, m) @ along, n @ m)
        done.append(replace(edge, faces=(one, other), dihedral=float(dihedral)))
    return Solid(
        vertices=vertices,
        edges=tuple(done),
        faces=tuple(faces),
        volume=flux / 3,
        size=float(np.linalg.norm(np.ptp(vertices, axis=0))),
        vertex_keys=np.arange(len(vertices)),
        edge_keys=np.arange(len(edges)),
        face_keys=np.arange(len(faces)),
    )


def around(side):
    """The loop of a linking side: up its right, down its left."""
    back = [(e, not forward) for chain in (side.top, side.left) for e, forward in reversed(chain)]
    return (*side.bottom, *side.right, *back)


def polygon_angles(polygon):
    """Interior angle at each corner, the inside on the left."""
    after, before = np.roll(polygon, -1, axis=0) - polygon, np.roll(polygon, 1, axis=0) - polygon
    return np.mod(np.arctan2(before[:, 1], before[:, 0]) - np.arctan2(after[:, 1], after[:, 0]), 2 * np.pi)


def polygon_prism(
    loops: Sequence[np.ndarray],
    levels: Sequence[Callable[[np.ndarray], np.ndarray]],
    *,
    merged: Collection[tuple[int, int]] = (),
) -> Sweep:
    """A sweep of polygons through levels of planes, its sides bilinear (see the module's picture)."""
    sizes = [len(loop) for loop in loops]
    first = np.concatenate([[0], np.cumsum(sizes)]).astype(int)
    n, n_levels = int(first[-1]), len(levels)
    vertices = np.concatenate([level(np.concatenate(loops)) for level in levels])
    following = np.concatenate([first[j] + (np.arange(m) + 1) % m for j, m in enumerate(sizes)])
    columns = {first[j] + i for j, i in merged}
    edges, ring, rail = [], {}, {}

    def add(a, b):
        line = Line(vertices[a], vertices[b])
        edges.append(make_edge(len(edges), int(a), int(b), line, float(np.linalg.norm(vertices[b] - vertices[a]))))
        return len(edges) - 1

    for k in range(n_levels):
        for i in range(n):
            if i not in columns or k in (0, n_levels - 1):
                ring[k, i] = add(k * n + i, k * n + following[i])
    for k in range(n_levels - 1):
        for i in range(n):
            rail[k, i] = add(k * n + i, (k + 1) * n + i)

    faces, sides = [], []
    for i in range(n):
        spans = [(0, n_levels - 1)] if i in columns else [(k, k + 1) for k in range(n_levels - 1)]
        for low, high in spans:
            corners = [low * n + i, low * n + following[i], high * n + following[i], high * n + i]
            surface = Bilinear(*vertices[corners])
            surface.ends[ring[low, i]] = ((0, 0), (1, 0))
            surface.ends[ring[high, i]] = ((0, 1), (1, 1))
            left = tuple((rail[k, i], True) for k in range(low, high))
            right = tuple((rail[k, int(following[i])], True) for k in range(low, high))
            for u, chain in ((0, left), (1, right)):
                lengths = np.array([edges[e].length for e, _ in chain])
                cuts = np.concatenate([[0], np.cumsum(lengths)]) / lengths.sum()
                for j, (e, _) in enumerate(chain):
                    surface.ends[e] = ((u, cuts[j]), (u, cuts[j + 1]))
            sides.append(
                LinkingSide(
                    face=len(faces),
                    bottom=((ring[low, i], True),),
                    right=right,
                    top=((ring[high, i], True),),
                    left=left,
                )
            )
            faces.append(Outline(surface, (around(sides[-1]),), "other"))

    caps = []
    for k, sign in ((0, -1), (n_levels - 1, 1)):
        outer = vertices[k * n : k * n + sizes[0]]
        area = np.cross(outer - outer[0], np.roll(outer, -1, axis=0) - outer[0]).sum(axis=0)
        plane = Plane(outer.mean(axis=0), sign * area)
        cap_loops = []
        for j in range(len(loops)):
            ids = [ring[k, first[j] + i] for i in range(sizes[j])]
            cap_loops.append(tuple((e, sign > 0) for e in ids[:: 1 if sign > 0 else -1]))
            for e in ids:
                plane.ends[e] = tuple(plane.project(vertices[[edges[e].start, edges[e].end]]))
        caps.append(len(faces))
        faces.append(Outline(plane, tuple(cap_loops), "plane"))

    def cap_edges(k):
        return tuple(tuple((ring[k, first[j] + i], True) for i in range(m)) for j, m in enumerate(sizes))

    stations = [
        tuple(ring[k, first[j] + i] for i in range(m))
        for k in range(1, n_levels - 1)
        for j, m in enumerate(sizes)
        if all((k, first[j] + i) in ring for i in range(m))
    ]
    return Sweep(
        solid=make_solid(vertices, edges, faces),
        source=(caps[0],),
        target=(caps[1],),
        linking_sides=tuple(sides),
        source_loops=cap_edges(0),
        target_loops=cap_edges(n_levels - 1),
        rails=tuple(rail.values()),
        stations=tuple(stations),
    )


def count_segments(sweep: Sweep, around: int | Sequence[int], along: int | Sequence[int]) -> Intervals:
    """Counts of a polygon prism: `around` for each ring edge or one for all, `along` for each span or all."""
    solid = sweep.solid
    counts = np.zeros(len(solid.edges), dtype=np.int64)
    rails = set(sweep.rails)
    n = sum(len(loop) for loop in sweep.source_loops)
    for edge in solid.edges:
        if edge.id in rails:
            counts[edge.id] = along if isinstance(along, int) else along[edge.start // n]
        else:
            counts[edge.id] = around if isinstance(around, int) else around[edge.start % n]
    per_column = [counts[e] for e in rails if solid.edges[e].start % n == 0]
    return Intervals(counts=counts, n_layers=int(sum(per_column)), size=1.0)


def square(side: float = 1.0) -> np.ndarray:
    """A square about the origin, counter-clockwise."""
    return side / 2 * np.array([[-1.0, -1], [1, -1], [1, 1], [-1, 1]])


def l_shape() -> np.ndarray:
    """An L of arm 3 and width 1, counter-clockwise."""
    return np.array([[0.0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]])


def raised(height: float, matrix=((1.0, 0.0), (0.0, 1.0)), shift=(0.0, 0.0)):
    """The level at a height, its plane an affine image."""

    def place(corners: np.ndarray) -> np.ndarray:
        return np.column_stack([corners @ np.asarray(matrix, float).T + shift, np.full(len(corners), height)])

    return place


def torus_piece(angle: float, major: float = 3.0, minor: float = 1.0) -> Sweep:
    """A bent round bar, its sides two halves of a torus."""
    x, z = np.eye(3)[0], np.eye(3)[2]

    def at(u):
        return np.array([np.cos(u), np.sin(u), 0.0])

    vertices = [at(u) * (major + s * minor) for u in (0.0, angle) for s in (1, -1)]
    edges = []
    for k, u in enumerate((0.0, angle)):
        for half in (0, 1):
            arc = Arc(major * at(u), minor * at(u), -minor * z, half * np.pi, (half + 1) * np.pi)
            edges.append(make_edge(len(edges), 2 * k + half, 2 * k + (1 - half), arc, np.pi * minor))
    for half, s in ((0, 1), (1, -1)):
        radius = major + s * minor
        arc = Arc(np.zeros(3), radius * x, radius * np.eye(3)[1], 0.0, angle)
        edges.append(make_edge(len(edges), half, 2 + half, arc, radius * angle))
    faces, sides = [], []
    for half in (0, 1):
        surface = Torus(major, minor)
        low, high = -half * np.pi, -(half + 1) * np.pi  # clockwise seen from the tip of u
        surface.ends = {half: ((0, low), (0, high)), 2 + half: ((angle, low), (angle, high))}
        surface.ends[4 + half] = ((0, low), (angle, low))
        surface.ends[5 - half] = ((0, high), (angle, high))
        sides.append(
            LinkingSide(
                face=half,
                bottom=((half, True),),
                right=((5 - half, True),),
                top=((2 + half, True),),
                left=((4 + half, True),),
            )
        )
        faces.append(Outline(surface, (around(sides[-1]),), "torus"))
    for k, u in enumerate((0.0, angle)):
        normal = np.array([-np.sin(u), np.cos(u), 0.0]) * (1 if k else -1)
        loop = ((2, True), (3, True)) if k else ((1, False), (0, False))
        faces.append(Outline(Disc(major * at(u), normal, edges), (loop,), "plane"))
    return Sweep(
        solid=make_solid(vertices, edges, faces),
        source=(2,),
        target=(3,),
        linking_sides=tuple(sides),
        source_loops=(((0, True), (1, True)),),
        target_loops=(((2, True), (3, True)),),
        rails=(4, 5),
    )
