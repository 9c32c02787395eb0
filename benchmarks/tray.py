"""A tray with posts, meshed as columns, against a plain sweep and gmsh: tray.py [--size S] [--turns N]

The plate has the same outlines, and a height that gives as many hexahedra. A line a mesh: hexahedra, seconds of
processor time and by the clock; then the best microseconds a hexahedron of each, and their ratios.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable

import cadquery as cq
import gmsh

import cadsweep as cs

HEIGHT = 7.2
"""Of the plate: as many layers as the tray has in the mean of its places."""


def tray() -> cq.Workplane:
    """Make a tray with a rim and twelve posts that stand higher than the rim."""
    part = cq.Workplane().box(60, 40, 12, centered=(True, True, False))
    part = part.cut(cq.Workplane().box(54, 34, 10, centered=(True, True, False)).translate((0, 0, 3)))
    return part.union(cq.Workplane().rarray(14, 11, 4, 3).circle(2.2).extrude(12).translate((0, 0, 2)))


def plate() -> cq.Workplane:
    """Make a plate with holes where the tray has posts."""
    holes = cq.Workplane().rarray(14, 11, 4, 3).circle(2.2).extrude(40)
    return cq.Workplane().box(60, 40, HEIGHT, centered=(True, True, False)).cut(holes)


def extruded_by_gmsh(size: float) -> int:
    """Mesh the plate as gmsh extrudes it; return its hexahedra."""
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    try:
        kernel = gmsh.model.occ
        sheet = kernel.addRectangle(-30, -20, 0, 60, 40)
        places = [(-21 + 14 * i, -11 + 11 * j) for i in range(4) for j in range(3)]
        kernel.cut([(2, sheet)], [(2, kernel.addDisk(x, y, 0, 2.2, 2.2)) for x, y in places])
        kernel.extrude(kernel.getEntities(2), 0, 0, HEIGHT, [round(HEIGHT / size)], recombine=True)
        kernel.synchronize()
        for name, value in (("MeshSizeMin", size), ("MeshSizeMax", size), ("RecombineAll", 1)):
            gmsh.option.setNumber(f"Mesh.{name}", value)
        gmsh.model.mesh.generate(3)
        return sum(len(tags) for tags in gmsh.model.mesh.getElements(3)[1])
    finally:
        gmsh.finalize()


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--size", type=float, default=0.25)
    parser.add_argument("--turns", type=int, default=3)
    arguments = parser.parse_args()
    parts = {"plate": cs.load(plate()), "tray": cs.load(tray())}
    for part in parts.values():
        cs.sweep_mesh(part, size=2.0)
    makers: dict[str, Callable[[], int]] = {
        name: lambda part=part: cs.sweep_mesh(part, size=arguments.size).n_hexes for name, part in parts.items()
    }
    makers["gmsh"] = lambda: extruded_by_gmsh(arguments.size)
    best = dict.fromkeys(makers, float("inf"))
    for _ in range(arguments.turns):
        for name, make in makers.items():
            start, clock = time.process_time(), time.perf_counter()
            n = make()
            seconds, by_clock = time.process_time() - start, time.perf_counter() - clock
            best[name] = min(best[name], 1e6 * seconds / n)
            sys.stdout.write(f"{name:6} {n:9,d} hexahedra {seconds:7.2f} s {by_clock:7.2f} s by the clock\n")
            sys.stdout.flush()
    rates = ", ".join(f"{name} {value:.2f}" for name, value in best.items())
    sys.stdout.write(f"us a hexahedron: {rates}; tray over plate {best['tray'] / best['plate']:.2f}, ")
    sys.stdout.write(f"gmsh over tray {best['gmsh'] / best['tray']:.1f}\n")


if __name__ == "__main__":
    main()
