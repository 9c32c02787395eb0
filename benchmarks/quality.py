"""Worst and mean scaled Jacobian of parts that swept meshes are known to fail on.

Run ``python benchmarks/quality.py`` (all cases), or name some; ``--full`` adds the large ones.
Every part is built here with CadQuery, meshed by :func:`cadsweep.sweep_mesh` with its defaults, and
measured by :func:`cadsweep.quality.check_mesh`. ``limit`` is the worst corner of boundary nodes
alone, which no inner node can mend.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from collections.abc import Callable
from typing import Any

import cadquery as cq
import numpy as np

import cadsweep as cs
from cadsweep.quality import boundary_limit, quad_scaled_jacobians

GOAL = 0.3


def domed(wire: cq.Wire, top: cq.Vector) -> cq.Face:
    """A smooth face on a wire, through the point `top`."""
    surface = cq.Face.makeNSidedSurface(wire.Edges(), [top], nbPtsOnCur=40, nbIter=4, tol2d=1e-7, tol3d=1e-7)
    return cq.Face.constructOn(surface, wire)


def polygon(points: list[tuple[float, float]], z: float) -> cq.Wire:
    """A closed polygon in the plane at height `z`."""
    return cq.Wire.makePolygon([cq.Vector(x, y, z) for x, y in points], close=True)


def loft(*wires: cq.Wire, ruled: bool = True) -> cq.Solid:
    """A solid through sections with the same number of edges."""
    return cq.Solid.makeLoft(list(wires), ruled)


def torus_square() -> cq.Solid:
    """Half a torus of square section 2 x 2, its axis 3 away, with a dome of height 0.6 on one end."""
    ring = cq.Workplane("XY").center(3, 0).rect(2, 2).revolve(180, (-3, 0), (-3, 1)).val()
    return _torus(ring)


def _torus(ring: cq.Shape) -> cq.Solid:
    """Dome the cap of a half torus that lies at positive x in the plane z = 0."""
    cap = max((f for f in ring.Faces() if f.geomType() == "PLANE"), key=lambda f: f.Center().x - abs(f.Center().z))
    outward = cap.normalAt()
    top = cap.Center() + outward * 0.6
    kept = [f for f in ring.Faces() if f.hashCode() != cap.hashCode()]
    return cq.Solid.makeSolid(cq.Shell.makeShell([*kept, domed(cap.outerWire(), top)]))


def torus_round() -> cq.Solid:
    """Half a torus of round section of radius 1, with a dome on one end."""
    arcs = cq.Workplane("XY").center(3, 0).moveTo(-1, 0)
    arcs = arcs.threePointArc((0, -1), (1, 0)).threePointArc((0, 1), (-1, 0)).close()
    return _torus(arcs.revolve(180, (-3, 0), (-3, 1), clean=False).val())


def l_section() -> cq.Solid:
    """An L whose arms grow from 3 to 7 over a length of 10; both are 1 thick."""

    def section(arm: float, z: float) -> cq.Wire:
        return polygon([(0, 0), (arm, 0), (arm, 1), (1, 1), (1, arm), (0, arm)], z)

    return loft(section(3, 0), section(7, 10))


def barrel() -> cq.Solid:
    """Square caps 2 x 2, four units apart; half way a square of 3 x 3 with sides that bulge by 0.3."""

    def square(half: float, bulge: float, z: float) -> cq.Wire:
        corners = [(-half, -half), (half, -half), (half, half), (-half, half)]
        edges = []
        for (ax, ay), (bx, by) in zip(corners, [*corners[1:], corners[0]], strict=True):
            middle = ((ax + bx) / 2, (ay + by) / 2)
            scale = (half + bulge) / half
            ends = cq.Vector(ax, ay, z), cq.Vector(middle[0] * scale, middle[1] * scale, z), cq.Vector(bx, by, z)
            edges.append(cq.Edge.makeThreePointArc(*ends) if bulge else cq.Edge.makeLine(ends[0], ends[2]))
        return cq.Wire.assembleEdges(edges)

    return loft(square(1, 0, 0), square(1.5, 0.3, 2), square(1, 0, 4), ruled=False)


def twist() -> cq.Solid:
    """A square of 2 x 2 that turns by 90 degrees over a length of 4."""
    return cq.Workplane("XY").rect(2, 2).twistExtrude(4, 90).val()


def bend_with_domes() -> cq.Solid:
    """A bend of 90 degrees, square section 2 x 2, with a dome of 0.6 out of one end and of 0.5 into the other."""
    bend = cq.Workplane("XY").center(3, 0).rect(2, 2).revolve(90, (-3, 0), (-3, 1)).val()
    planes = sorted((f for f in bend.Faces() if f.geomType() == "PLANE"), key=lambda f: abs(f.normalAt().y))[:2]
    tops = [f.Center() + f.normalAt() * h for f, h in zip(planes, (0.6, -0.5), strict=True)]
    hashes = {f.hashCode() for f in planes}
    kept = [f for f in bend.Faces() if f.hashCode() not in hashes]
    caps = [domed(f.outerWire(), top) for f, top in zip(planes, tops, strict=True)]
    return cq.Solid.makeSolid(cq.Shell.makeShell([*kept, *caps]))


def moving_hole() -> cq.Solid:
    """A plate of 4 x 4 x 4 whose hole of radius 0.8 moves by 2.3 and shrinks to 0.32."""

    def circle(x: float, radius: float, z: float) -> cq.Wire:
        places = [cq.Vector(x + radius * math.cos(a), radius * math.sin(a), z) for a in np.arange(0, 8) * math.pi / 4]
        return cq.Wire.assembleEdges(
            [cq.Edge.makeThreePointArc(places[i], places[i + 1], places[(i + 2) % 8]) for i in range(0, 8, 2)]
        )

    plate = cq.Workplane("XY").rect(4, 4).extrude(4).val()
    return plate.cut(loft(circle(-1, 0.8, 0), circle(1.3, 0.32, 4))).Solids()[0]


def star() -> cq.Solid:
    """A star of five points, radii 2 and 0.9, that shrinks to 0.7 and turns by 20 degrees over a length of 4."""

    def section(scale: float, turn: float, z: float) -> cq.Wire:
        places = []
        for i in range(10):
            radius, angle = scale * (2.0 if i % 2 == 0 else 0.9), math.pi * i / 5 + math.radians(turn)
            places.append((radius * math.cos(angle), radius * math.sin(angle)))
        return polygon(places, z)

    return loft(section(1, 0, 0), section(0.7, 20, 4))


def circle_to_square() -> cq.Solid:
    """A circle of radius 1 that becomes a square of 2 x 2 over a length of 3."""
    corners = [cq.Vector(x, y, 3) for x, y in ((1, -1), (1, 1), (-1, 1), (-1, -1))]
    angles = [math.radians(a) for a in (-45, 45, 135, 225)]
    arcs = [
        cq.Edge.makeThreePointArc(
            *(cq.Vector(math.cos(a + d), math.sin(a + d), 0) for d in (0, math.pi / 4, math.pi / 2))
        )
        for a in angles
    ]
    square = [cq.Edge.makeLine(corners[i], corners[(i + 1) % 4]) for i in range(4)]
    return loft(cq.Wire.assembleEdges(arcs), cq.Wire.assembleEdges(square))


def skewed_ellipses() -> str:
    """The paper's third example."""
    from pathlib import Path

    return str(Path(__file__).parents[1] / "models" / "skewed_ellipses.py")


Case = tuple[Callable[[], Any], dict[str, Any], float]

CASES: dict[str, Case] = {
    "half torus, square, dome, 20 layers": (torus_square, {"size": 0.25, "layers": 20}, GOAL),
    "half torus, square, dome, 40 layers": (torus_square, {"size": 0.25, "layers": 40}, GOAL),
    "half torus, square, dome, 80 layers": (torus_square, {"size": 0.25, "layers": 80}, GOAL),
    "half torus, round, dome, 20 layers": (torus_round, {"size": 0.25, "layers": 20}, GOAL),
    "half torus, round, dome, 40 layers": (torus_round, {"size": 0.25, "layers": 40}, GOAL),
    "half torus, round, dome, 80 layers": (torus_round, {"size": 0.25, "layers": 80}, GOAL),
    "skewed ellipses, 1e5": (skewed_ellipses, {"size": 0.076, "layers": 122}, GOAL),
    "skewed ellipses, 1e6": (skewed_ellipses, {"size": 0.0355, "layers": 275}, GOAL),
    "L-section, arm 3 to 7": (l_section, {"size": 0.2, "layers": 40}, GOAL),
    "barrel between squares": (barrel, {"size": 0.2, "layers": 20}, GOAL),
    "twist of 90 degrees": (twist, {"size": 0.2, "layers": 20}, GOAL),
    "bend with unlike domes": (bend_with_domes, {"size": 0.2, "layers": 20}, GOAL),
    "hole that moves and shrinks": (moving_hole, {"size": 0.2, "layers": 40}, 0.15),
    "star": (star, {"size": 0.15, "layers": 20}, GOAL),
    "circle to square": (circle_to_square, {"size": 0.15, "layers": 20}, GOAL),
}
LARGE = ("skewed ellipses, 1e6",)


def measure(name: str) -> dict[str, Any]:
    """Mesh one case and return its figures."""
    build, options, goal = CASES[name]
    solid = build()
    start = time.perf_counter()
    try:
        mesh = cs.sweep_mesh(solid, allow_inverted=True, **options)
    except cs.CadSweepError as error:
        return {"case": name, "error": f"{type(error).__name__}: {error}"}
    seconds = time.perf_counter() - start
    start = time.perf_counter()
    report = mesh.quality()
    checks = time.perf_counter() - start
    structure = mesh.structure
    assert structure is not None
    limit = boundary_limit(mesh.points, structure).value
    n = structure.n_nodes
    return {
        "case": name,
        "hexes": mesh.n_hexes,
        "inverted": report.n_inverted,
        "worst": report.min_scaled_jacobian,
        "mean": report.mean_scaled_jacobian,
        "limit": limit,
        "wanted": min(goal, 0.9 * limit) if limit < goal else goal,
        "worst cap quads": tuple(
            float(np.min(quad_scaled_jacobians(mesh.points[at : at + n], structure.quads)))
            for at in (0, structure.n_layers * n)
        ),
        "seconds": seconds,
        "checks": checks,
        "problems": report.problems,
        "notes": [str(note) for note in mesh.info.get("notes", ())],
        "stages": mesh.info.get("seconds", {}),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cases", nargs="*", help="parts of the names of cases; all where none is given")
    parser.add_argument("--full", action="store_true", help="the large cases as well")
    parser.add_argument("--json", action="store_true", help="one JSON object a case")
    chosen = parser.parse_args()
    if not chosen.json:
        print(
            f"{'case':38}{'hexes':>9}{'inverted':>9}{'worst':>8}{'mean':>7}{'limit':>7}{'wanted':>7}{'s':>7}{'checks':>8}"
        )
    for name in CASES:
        if chosen.cases and not any(part in name for part in chosen.cases):
            continue
        if name in LARGE and not chosen.full and not chosen.cases:
            continue
        row = measure(name)
        if chosen.json:
            print(json.dumps(row, default=str), flush=True)
        elif "error" in row:
            print(f"{name:38}{row['error']}", flush=True)
        else:
            mark = "" if row["worst"] >= row["wanted"] and not row["problems"] else "  MISSED"
            print(
                f"{name:38}{row['hexes']:9,}{row['inverted']:9}{row['worst']:8.3f}{row['mean']:7.3f}"
                f"{row['limit']:7.3f}{row['wanted']:7.3f}{row['seconds']:7.1f}{row['checks']:8.2f}{mark}",
                flush=True,
            )


if __name__ == "__main__":
    main()
