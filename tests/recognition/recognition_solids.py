"""Polyhedra as :class:`cadsweep.brep.Solid`, made by hand so that no CAD kernel is needed."""

from dataclasses import dataclass

import numpy as np

from cadsweep.brep import Edge, Face, Loop, Solid


@dataclass
class Line:
    """A straight curve."""

    a: np.ndarray
    b: np.ndarray

    def evaluate(self, fractions):
        t = np.asarray(fractions)[:, None]
        return (1 - t) * self.a + t * self.b

    def project(self, points):
        d = self.b - self.a
        return np.clip((points - self.a) @ d / (d @ d), 0, 1)


@dataclass
class Plane:
    """A plane in its own orthonormal parameters."""

    origin: np.ndarray
    normal: np.ndarray
    periods = (None, None)

    def __post_init__(self):
        x = np.cross(self.normal, np.eye(3)[np.argmin(np.abs(self.normal))])
        self.axes = np.stack([x / np.linalg.norm(x), np.cross(self.normal, x / np.linalg.norm(x))])

    def evaluate(self, uv):
        return self.origin + uv @ self.axes

    def normals(self, uv):
        return np.broadcast_to(self.normal, (len(uv), 3))

    def project(self, points):
        return (points - self.origin) @ self.axes.T


def polyhedron(points, faces, *, name=None) -> Solid:
    """Make a solid of plane faces.

    ``faces[i]`` is a list of loops of vertex ids, outer loop first, counter-clockwise seen from
    outside (holes clockwise).
    """
    points = np.asarray(points, dtype=float)
    ids: dict[tuple[int, int], int] = {}
    users: dict[int, list[int]] = {}
    normals, loops_of = [], []
    for f, loops in enumerate(faces):
        area = sum(np.cross(points[loop], points[np.roll(loop, -1)]).sum(axis=0) for loop in loops)
        normals.append(area / np.linalg.norm(area))
        made = []
        for loop in loops:
            edges, forward = [], []
            for a, b in zip(loop, np.roll(loop, -1), strict=True):
                key = (int(min(a, b)), int(max(a, b)))
                e = ids.setdefault(key, len(ids))
                users.setdefault(e, []).append(f)
                edges.append(e)
                forward.append(bool(a < b))
            made.append((loop, edges, forward))
        loops_of.append(made)
    solid_faces = []
    for f, made in enumerate(loops_of):
        n = normals[f]
        loops = []
        for loop, edges, forward in made:
            p = points[loop]
            before, after = np.roll(p, 1, axis=0) - p, np.roll(p, -1, axis=0) - p
            angles = np.arctan2(np.cross(after, before) @ n, (after * before).sum(axis=1)) % (2 * np.pi)
            loops.append(Loop(edges=tuple(edges), forward=tuple(forward), angles=tuple(angles.tolist())))
        outer = points[made[0][0]]
        area = sum(0.5 * np.cross(points[q[0]], points[np.roll(q[0], -1)]).sum(axis=0) @ n for q in made)
        solid_faces.append(
            Face(
                id=f,
                kind="plane",
                area=float(area),
                center=outer.mean(axis=0),
                normal=n,
                loops=tuple(loops),
                surface=Plane(outer.mean(axis=0), n),
                key=f"face {f}",
            )
        )
    solid_edges = []
    for (a, b), e in ids.items():
        first, second = users[e]
        if dict(d for loop in solid_faces[second].loops for d in loop.directed)[e]:
            first, second = second, first
        d = (points[b] - points[a]) / np.linalg.norm(points[b] - points[a])
        bend = np.arctan2(np.cross(normals[first], normals[second]) @ d, normals[first] @ normals[second])
        forward = dict(d for loop in solid_faces[first].loops for d in loop.directed)[e]
        solid_edges.append(
            Edge(
                id=e,
                start=a,
                end=b,
                length=float(np.linalg.norm(points[b] - points[a])),
                kind="line",
                faces=tuple(users[e]),
                dihedral=float(np.pi - (bend if forward else -bend)),
                midpoint=(points[a] + points[b]) / 2,
                tangents=np.stack([d, d]),
                curve=Line(points[a], points[b]),
            )
        )
    corners = [np.cross(points[q], points[np.roll(q, -1)]).sum(axis=0) @ points[q[0]] / 6 for fs in faces for q in fs]
    return Solid(
        vertices=points,
        edges=tuple(solid_edges),
        faces=tuple(solid_faces),
        volume=float(sum(corners)),
        size=float(np.linalg.norm(np.ptp(points, axis=0))),
        vertex_keys=np.arange(len(points)),
        edge_keys=np.arange(len(solid_edges)),
        face_keys=np.arange(len(solid_faces)),
        name=name,
    )


def prism(polygon, heights=(0.0, 1.0), *, shifts=None) -> Solid:
    """Make a prism over a plane polygon (counter-clockwise); every height in between is a station."""
    polygon = np.asarray(polygon, dtype=float)
    n, m = len(polygon), len(heights)
    shifts = np.zeros((m, 2)) if shifts is None else np.asarray(shifts, dtype=float)
    points = np.concatenate([np.column_stack([polygon + shifts[k], np.full(n, heights[k])]) for k in range(m)])
    faces = [[list(range(n))[::-1]], [[(m - 1) * n + i for i in range(n)]]]
    for k in range(m - 1):
        for i in range(n):
            j = (i + 1) % n
            faces.append([[k * n + i, k * n + j, (k + 1) * n + j, (k + 1) * n + i]])
    return polyhedron(points, faces)


def square(size=1.0):
    """Corners of a square about the origin."""
    h = size / 2
    return np.array([[-h, -h], [h, -h], [h, h], [-h, h]])


def regular(n, radius=1.0):
    """Corners of a regular polygon."""
    t = 2 * np.pi * np.arange(n) / n
    return radius * np.column_stack([np.cos(t), np.sin(t)])


def box(x=1.0, y=1.0, z=1.0) -> Solid:
    """Make a box."""
    return prism(np.array([[0, 0], [x, 0], [x, y], [0, y]]), (0.0, z))


def plate_with_square_holes(n, *, pitch=3.0, hole=1.0, height=1.0) -> Solid:
    """Make a plate with n by n square holes: 6 + 4 n^2 faces."""
    width = n * pitch
    bottom = [[0, 0], [width, 0], [width, width], [0, width]]
    for i in range(n):
        for j in range(n):
            bottom += ((np.array([i + 0.5, j + 0.5]) * pitch) + square(hole)).tolist()
    flat = np.array(bottom)
    n_flat = len(flat)
    points = np.concatenate([np.column_stack([flat, np.full(n_flat, z)]) for z in (0.0, height)])
    outer, holes = [0, 1, 2, 3], [list(range(k, k + 4)) for k in range(4, n_flat, 4)]
    faces = [[outer[::-1], *holes], [[n_flat + i for i in outer], *([n_flat + i for i in h[::-1]] for h in holes)]]
    for ring in [outer, *(h[::-1] for h in holes)]:
        for a, b in zip(ring, ring[1:] + ring[:1], strict=True):
            faces.append([[a, b, n_flat + b, n_flat + a]])
    return polyhedron(points, faces)


def box_with_split_side(height=0.5) -> Solid:
    """Make a unit box whose front is split across at a height: T-junctions on two rails."""
    points = [*np.column_stack([square(), np.zeros(4)]), *np.column_stack([square(), np.ones(4)])]
    points += [[-0.5, -0.5, height], [0.5, -0.5, height]]
    faces = [
        [[3, 2, 1, 0]],
        [[4, 5, 6, 7]],
        [[0, 1, 9, 8]],
        [[8, 9, 5, 4]],
        [[1, 2, 6, 5, 9]],
        [[2, 3, 7, 6]],
        [[3, 0, 8, 4, 7]],
    ]
    return polyhedron(points, faces)


def bevelled_bar() -> Solid:
    """Make a bar with a pentagonal side: two of its corners have 135 degrees, and one of them is no corner."""
    outline = np.array([[0, 0], [4, 0], [4, 2], [3, 3], [0, 3]], dtype=float)
    n = len(outline)
    points = np.concatenate([np.column_stack([outline[:, 0], np.full(n, y), outline[:, 1]]) for y in (0.0, 2.0)])
    faces = [[list(range(n))], [[n + i for i in range(n)][::-1]]]
    for i in range(n):
        j = (i + 1) % n
        faces.append([[j, i, n + i, n + j]])
    return polyhedron(points, faces)


def sharp_bracket() -> Solid:
    """Make an angle bracket with a square hole in each flange: it can only be swept through its thickness."""
    profile = np.array([[0, 0], [6, 0], [6, 1], [1, 1], [1, 6], [0, 6]], dtype=float)
    n = len(profile)
    points = [[x, y, z] for y in (0.0, 4.0) for x, z in profile]
    first = len(points)
    for z in (0.0, 1.0):
        points += [[4 + a, 2 + b, z] for a, b in square(1.5)]
    for x in (0.0, 1.0):
        points += [[x, 2 + b, 4 + a] for a, b in square(1.5)]
    b0, b1, c0, c1 = (list(range(first + 4 * k, first + 4 * k + 4)) for k in range(4))
    faces = [
        [list(range(n))],
        [[n + i for i in range(n)][::-1]],
        [[0, n, n + 1, 1], b0],
        [[1, n + 1, n + 2, 2]],
        [[2, n + 2, n + 3, 3], b1[::-1]],
        [[3, n + 3, n + 4, 4], c1[::-1]],
        [[4, n + 4, n + 5, 5]],
        [[5, n + 5, n, 0], c0],
    ]
    for low, high in ((b0, b1), (c0, c1)):
        for i in range(4):
            j = (i + 1) % 4
            faces.append([[low[j], low[i], high[i], high[j]]])
    return polyhedron(points, faces)


def tetrahedron() -> Solid:
    """Make a tetrahedron."""
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    return polyhedron(points, [[[0, 2, 1]], [[0, 1, 3]], [[1, 2, 3]], [[0, 3, 2]]])


def block_with_pocket() -> Solid:
    """Make a block with a blind square pocket in its top."""
    outer, inner = square(4.0), square(1.0)
    points = [*np.column_stack([outer, np.zeros(4)]), *np.column_stack([outer, np.full(4, 2.0)])]
    points += [*np.column_stack([inner, np.full(4, 1.0)]), *np.column_stack([inner, np.full(4, 2.0)])]
    faces = [[[3, 2, 1, 0]], [[4, 5, 6, 7], [15, 14, 13, 12]], [[8, 9, 10, 11]]]
    for i in range(4):
        j = (i + 1) % 4
        faces.append([[i, j, 4 + j, 4 + i]])
        faces.append([[8 + j, 8 + i, 12 + i, 12 + j]])
    return polyhedron(points, faces)


def renumbered(solid: Solid, seed: int) -> tuple[Solid, np.ndarray]:
    """Return the same solid with its faces in another order, and the new id of every old face."""
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(solid.faces))
    faces = []
    for f in order:
        loops = []
        for loop in solid.faces[f].loops:
            ids = [solid.edges[e].start if fwd else solid.edges[e].end for e, fwd in loop.directed]
            turn = int(rng.integers(len(ids)))
            loops.append(ids[turn:] + ids[:turn])
        faces.append(loops)
    return polyhedron(solid.vertices, faces), np.argsort(order)
