"""Sections made with numpy alone: (points, quads, loops); quads and outer loop counter-clockwise, holes clockwise.

::

    square     annulus      l_shape      disc         star
    +-----+    /-----\\      +--+         .-----.      /\\
    |     |    | (_) |      |  +--+      |  +  |     <  >
    +-----+    \\-----/      +-----+      '-----'      \\/
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Section:
    points: np.ndarray
    quads: np.ndarray
    loops: list[np.ndarray]

    @property
    def ring(self) -> np.ndarray:
        return np.concatenate(self.loops)

    def lifted(self, height) -> Section:
        """The same section with ``z = height(x, y)``."""
        points = self.points.copy()
        points[:, 2] = height(points[:, 0], points[:, 1])
        return Section(points, self.quads, self.loops)


def loops_of(quads: np.ndarray, points: np.ndarray) -> list[np.ndarray]:
    """Boundary cycles of a quad mesh, longest way round first."""
    edges = {(int(a), int(b)) for quad in quads for a, b in zip(quad, np.roll(quad, -1), strict=True)}
    following = {a: b for a, b in edges if (b, a) not in edges}
    loops = []
    while following:
        start, node = next(iter(following.items()))
        loop = [start]
        del following[start]
        while node != start:
            loop.append(node)
            node = following.pop(node)
        loops.append(np.array(loop))
    return sorted(loops, key=lambda loop: -np.ptp(points[loop], axis=0).sum())


def grid_quads(ids: np.ndarray) -> np.ndarray:
    return np.stack([ids[:-1, :-1], ids[:-1, 1:], ids[1:, 1:], ids[1:, :-1]], axis=-1).reshape(-1, 4)


def square(n: int = 6, half: float = 1.0) -> Section:
    u = np.linspace(-half, half, n + 1)
    x, y = np.meshgrid(u, u)
    points = np.c_[x.ravel(), y.ravel(), np.zeros(x.size)]
    quads = grid_quads(np.arange(x.size).reshape(n + 1, n + 1))
    return Section(points, quads, loops_of(quads, points))


def dome(section: Section, height: float = 0.3) -> Section:
    """A section on [-1, 1]^2 with a domed middle and a planar boundary."""
    return section.lifted(lambda x, y: height * (1 - x**2) * (1 - y**2))


def ring_grid(inner: np.ndarray, outer: np.ndarray, n_radial: int) -> Section:
    """Quads between two closed curves of equally many points, both counter-clockwise."""
    m = len(inner)
    t = np.linspace(0.0, 1.0, n_radial + 1)[:, None, None]
    plane = ((1 - t) * inner + t * outer).reshape(-1, 2)
    ids = np.arange((n_radial + 1) * m).reshape(n_radial + 1, m)
    quads = grid_quads(np.c_[ids, ids[:, :1]].T)
    quads = quads.reshape(-1, 4)
    points = np.c_[plane, np.zeros(len(plane))]
    return Section(points, quads, [ids[-1].copy(), ids[0, ::-1].copy()])


def circle(m: int, radius: float, center=(0.0, 0.0)) -> np.ndarray:
    angle = 2 * np.pi * np.arange(m) / m
    return np.c_[np.cos(angle), np.sin(angle)] * radius + np.asarray(center)


def annulus(m: int = 32, n_radial: int = 4, inner: float = 0.4, outer: float = 1.0) -> Section:
    return ring_grid(circle(m, inner), circle(m, outer), n_radial)


def square_boundary(m: int, half: float) -> np.ndarray:
    """m points (a multiple of 8) of a square by angle, corners included."""
    angle = 2 * np.pi * np.arange(m) / m
    direction = np.c_[np.cos(angle), np.sin(angle)]
    return half * direction / np.abs(direction).max(axis=1, keepdims=True)


def plate_with_hole(
    m: int = 48, n_radial: int = 8, half: float = 2.0, radius: float = 0.8, center=(0.0, 0.0)
) -> Section:
    return ring_grid(circle(m, radius, center), square_boundary(m, half), n_radial)


def l_shape(n: int = 5, arm: float = 3.0, width: float = 1.0) -> Section:
    """An L of two arms of length `arm` and width `width`, its corner at the origin."""
    n_arm = round(n * (arm - width) / width)
    u = np.r_[np.linspace(0, width, n + 1), np.linspace(width, arm, n_arm + 1)[1:]]
    x, y = np.meshgrid(u, u)
    points = np.c_[x.ravel(), y.ravel(), np.zeros(x.size)]
    quads = grid_quads(np.arange(x.size).reshape(x.shape))
    middle = points[quads].mean(axis=1)
    quads = quads[(middle[:, 0] < width) | (middle[:, 1] < width)]
    used = np.unique(quads)
    renumbered = np.full(len(points), -1)
    renumbered[used] = np.arange(len(used))
    points, quads = points[used], renumbered[quads]
    return Section(points, quads, loops_of(quads, points))


def blob(boundary: np.ndarray, core: float = 0.5, n_radial: int = 4) -> Section:
    """A star-shaped region with a square core; `boundary` has a multiple of 8 points by angle, from angle 0 on."""
    m = len(boundary)
    n = m // 4
    mean_radius = np.linalg.norm(boundary, axis=1).mean()
    u = np.linspace(-1, 1, n + 1)
    x, y = np.meshgrid(u, u)
    bulge = 1 + 0.2 * (1 - np.maximum(x**2, y**2))
    inside = np.c_[x.ravel(), y.ravel()] * (core * mean_radius / np.sqrt(2)) * bulge.ravel()[:, None]
    ids = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    rim = np.r_[ids[:-1, -1], ids[-1, :0:-1], ids[:0:-1, 0], ids[0, :-1]]
    rim = np.roll(rim, -(n // 2))
    t = np.linspace(0, 1, n_radial + 1)[1:, None, None]
    outward = ((1 - t) * inside[rim] + t * boundary).reshape(-1, 2)
    plane = np.r_[inside, outward]
    rows = np.r_[rim[None], np.arange(n_radial * m).reshape(n_radial, m) + len(inside)]
    quads = np.r_[grid_quads(ids), grid_quads(np.c_[rows, rows[:, :1]].T).reshape(-1, 4)]
    return Section(np.c_[plane, np.zeros(len(plane))], quads, [rows[-1].copy()])


def disc(m: int = 32, radius: float = 1.0, n_radial: int = 4) -> Section:
    return blob(circle(m, radius), n_radial=n_radial)


def star(m: int = 40, tips: int = 5, inner: float = 0.55, n_radial: int = 5) -> Section:
    angle = 2 * np.pi * np.arange(m) / m
    radius = inner + (1 - inner) * np.abs((angle * tips / np.pi) % 2 - 1)
    return blob(np.c_[np.cos(angle), np.sin(angle)] * radius[:, None], core=0.6 * inner, n_radial=n_radial)


def rotation(axis, angle: float) -> np.ndarray:
    """Rotation matrix (Rodrigues)."""
    x, y, z = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def random_rotation(rng: np.random.Generator) -> np.ndarray:
    return rotation(rng.standard_normal(3), rng.uniform(0, 2 * np.pi))


def bent(section: Section, degrees: float, n_layers: int, radius: float = 3.0) -> np.ndarray:
    """Layers (K, n, 3) of a section turned about a line of its own plane, y = radius."""
    center = np.array([0.0, radius, 0.0])
    turns = [rotation([1, 0, 0], a) for a in np.radians(np.linspace(0, degrees, n_layers + 1))]
    return np.array([(section.points - center) @ R.T + center for R in turns])


def corner_sines(points: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Sines (q, 4) of the corners of quads about +z."""
    corners = points[quads]
    a, b = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    lengths = np.linalg.norm(a, axis=-1) * np.linalg.norm(b, axis=-1)
    return np.cross(a, b)[..., 2] / lengths
