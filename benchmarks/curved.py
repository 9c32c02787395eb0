"""How near meshes come to curved CAD faces: distance reached against distance asked on twenty parts.

Run ``python benchmarks/curved.py`` (all parts), or name some. Every part is meshed by its defaults, and with a
``tolerance`` of a thousandth of its size: volume, area and greatest distance of the boundary's nodes, middles of sides
and of quads from the CAD faces, the worst scaled Jacobian, and of the default mesh the edges of the caps' quads over
the size that the mesh was made with: of the cap that is farther from plane, and of the other.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Callable
from typing import Any

import cadquery as cq
import numpy as np

import cadsweep as cs


def _surface(height: Callable[[float, float], float], half: float, n: int = 13) -> cq.Face:
    at = np.linspace(-half, half, n)
    return cq.Face.makeSplineApprox([[cq.Vector(x, y, height(x, y)) for y in at] for x in at], tol=1e-4)


def _under(height: Callable[[float, float], float], section: cq.Workplane, *, top: float) -> cq.Workplane:
    """A prism of a section cut off by a freeform surface."""
    box = section.val().BoundingBox()
    half = 1.3 * max(abs(v) for v in (box.xmin, box.xmax, box.ymin, box.ymax))
    body = section.extrude(top)
    pieces = cq.Workplane(obj=body.val().split(_surface(height, half))).solids().vals()
    return cq.Workplane(obj=min(pieces, key=lambda piece: piece.Center().z))


def _star(n: int, outer: float, inner: float) -> cq.Workplane:
    """A smooth star; its seam is away from the points."""
    at = 2 * np.pi * (np.arange(12 * n) + 3) / (12 * n)
    radii = (outer + inner) / 2 + (outer - inner) / 2 * np.cos(n * at)
    return _closed(np.column_stack([radii * np.cos(at), radii * np.sin(at)]))


def _closed(points: np.ndarray) -> cq.Workplane:
    return cq.Workplane().spline([tuple(p) for p in points.tolist()], periodic=True).wire()


def _blade(twist: float, thick: float) -> cq.Workplane:
    at = 2 * np.pi * (np.arange(48) + 12) / 48
    points = np.column_stack([10 * np.cos(at), thick * np.sin(at) * (1 - 0.35 * np.cos(at))])
    return _closed(points).twistExtrude(40, twist)


def _tube(points: list[tuple[float, float, float]], radius: float, wall: float = 0.0) -> cq.Workplane:
    path = cq.Workplane().spline([cq.Vector(*p) for p in points])
    plane = cq.Plane(origin=points[0], normal=path.val().tangentAt(0))
    section = cq.Workplane(plane).circle(radius)
    return (section.circle(radius - wall) if wall else section).sweep(path)


def _loft(*sections: tuple[float, float, float]) -> cq.Workplane:
    work = cq.Workplane()
    z = 0.0
    for a, b, height in sections:
        work = work.workplane(offset=height - z).ellipse(a, b) if height else work.ellipse(a, b)
        z = height
    return work.loft()


PARTS: dict[str, Callable[[], cq.Workplane]] = {
    "dome": lambda: _under(lambda x, y: 12 - 0.06 * (x * x + y * y), cq.Workplane().circle(9), top=20),
    "hat": lambda: _under(
        lambda x, y: 3 + 9 * math.exp(-(x * x + y * y) / 12), cq.Workplane().circle(10), top=20
    ),
    "saddle": lambda: _under(lambda x, y: 8 + 0.04 * (x * x - y * y), cq.Workplane().rect(20, 16), top=20),
    "waves": lambda: _under(
        lambda x, y: 6 + math.sin(0.6 * x) * math.cos(0.5 * y), cq.Workplane().rect(20, 20), top=12
    ),
    "bump on a hexagon": lambda: _under(
        lambda x, y: 4 + 5 * math.exp(-((x - 2) ** 2 + y * y) / 8), cq.Workplane().polygon(6, 20), top=20
    ),
    "star with a dome": lambda: _under(
        lambda x, y: 8 - 0.04 * (x * x + y * y), _star(5, 10, 5), top=20
    ),
    "star, twisted": lambda: _star(5, 10, 6).twistExtrude(20, 50),
    "star with seven points": lambda: _star(7, 10, 6.5).extrude(4),
    "blade": lambda: _blade(30, 1.5),
    "thin blade": lambda: _blade(60, 0.5),
    "loft of ellipses": lambda: _loft((10, 4, 0), (6, 6, 15), (4, 9, 30)),
    "bottle": lambda: _loft((8, 8, 0), (10, 10, 10), (4, 4, 25), (4.5, 4.5, 32)),
    "bent rod": lambda: _tube([(0, 0, 0), (10, 5, 10), (25, 0, 15), (40, 10, 25)], 2.5),
    "bent pipe": lambda: _tube([(0, 0, 0), (0, 10, 12), (15, 15, 20), (30, 10, 20)], 3.0, 0.6),
    "horn": lambda: cq.Workplane("XZ").ellipse(3, 2).revolve(140, (12, 0, 0), (12, 1, 0)),
    "twisted square": lambda: cq.Workplane().rect(10, 10).twistExtrude(30, 90),
    "barrel": lambda: cq.Workplane("XZ").moveTo(0, 0).lineTo(6, 0).threePointArc((9, 10), (6, 20)).lineTo(0, 20)
    .close().revolve(360),
    "cam": lambda: cq.Workplane().spline([(10, 0), (0, 6), (-5, 0), (0, -6)], periodic=True).wire().extrude(6)
    .faces(">Z").workplane().hole(4),
    "tapered hub": lambda: cq.Workplane().circle(10).extrude(15, taper=8).faces(">Z").workplane().hole(6),
    "arched plate": lambda: cq.Workplane("XZ").moveTo(-15, 0).threePointArc((0, 7), (15, 0)).lineTo(15, -2)
    .threePointArc((0, 5), (-15, -2)).close().extrude(20),
}  # fmt: skip


def _row(part: cq.Workplane, **options: Any) -> dict[str, Any]:
    mesh = cs.sweep_mesh(part, **options)
    size = float(np.linalg.norm(np.ptp(mesh.points, axis=0)))
    quality = mesh.info["quality"]
    return {
        "hexes": mesh.n_hexes,
        "volume": quality.volume / mesh.info["cad_volume"] - 1.0,
        "distance": mesh.info.get("distance"),
        "size": size,
        "worst": quality.min_scaled_jacobian,
        "edges": _spread(mesh),
    }


def _spread(mesh: cs.HexMesh) -> list[tuple[float, float]]:
    """Shortest and longest edge of a cap's quads over the median edge, of the cap that is farther from plane first.

    The median is that of the farther one: a cap that answers it has shorter edges where the other is steep.
    """
    n = mesh.structure.n_nodes if mesh.structure is not None else 0
    if not n or mesh.structure.periodic:
        return []
    caps = [points[mesh.structure.quads] for points in (mesh.points[:n], mesh.points[-n:])]
    caps.sort(key=lambda corners: -_height(corners.reshape(-1, 3)))
    lengths = [np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2) for corners in caps]
    middle = np.median(lengths[0])
    return [(round(float(own.min() / middle), 3), round(float(own.max() / middle), 3)) for own in lengths]


def _height(points: np.ndarray) -> float:
    """How far points are from plane, over how far they reach."""
    spans = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return float(spans[2] / spans[0])


def main() -> None:
    """Print a row for every part."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help="parts to be measured")
    parser.add_argument("--asked", type=float, default=1e-3, help="tolerance in sizes of the part")
    chosen = parser.parse_args()
    for name in chosen.names or PARTS:
        part = PARTS[name]()
        box = part.val().BoundingBox()
        row: dict[str, Any] = {"part": name}
        for kind, options in (("default", {}), ("tolerance", {"tolerance": chosen.asked * box.DiagonalLength})):
            try:
                row[kind] = {**_row(part, **options), "asked": options.get("tolerance")}
            except cs.CadSweepError as error:
                row[kind] = str(error)
        print(json.dumps(row), flush=True)


if __name__ == "__main__":
    main()
