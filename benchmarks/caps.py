"""Quads of one large cap by gmsh's algorithms: ``python benchmarks/caps.py [--holes 100 400] [--largest 0.8]``.

The cap is a square with a square pattern of round holes of 24 segments. Each setting is timed with sizes that grow
away from the holes, as the surface stage wants them, and told with its seconds of the processor per 100,000 quads and
its worst corner.
"""

from __future__ import annotations

import argparse
import math
import time

import numpy as np

from cadsweep.errors import SurfaceMeshError
from cadsweep.surface.background import make_background
from cadsweep.surface.gmsh_quads import Setting, mesh_polygon

SEGMENTS, RADIUS, PITCH = 24, 1.5, 6.0
SETTINGS = {
    f"algorithm {algorithm}, {name}": Setting(
        algorithm=algorithm, recombination=recombination, even_loops=recombination == 3, good_enough=0.3
    )
    for recombination, name in ((3, "subdivided"), (1, "Blossom"))
    for algorithm in (6, 8, 5)
}


def make_loops(n_holes: int) -> list[np.ndarray]:
    """Outer loop counter-clockwise, holes clockwise, each (m, 2)."""
    side = math.ceil(math.sqrt(n_holes))
    n = 2 * round(PITCH * side / (4.0 * np.pi * RADIUS / SEGMENTS) / 2)
    along = np.arange(n) / n - 0.5
    low, high = np.full(n, -0.5), np.full(n, 0.5)
    rim = np.concatenate([[along, low], [high, along], [-along, high], [low, -along]], axis=1).T
    turn = -2.0 * np.pi * np.arange(SEGMENTS) / SEGMENTS
    circle = RADIUS * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    middles = PITCH * (np.stack(np.divmod(np.arange(n_holes), side), axis=1) - (side - 1) / 2)
    return [PITCH * side * rim, *(circle + middle for middle in middles)]


def worst_corner(points: np.ndarray, quads: np.ndarray) -> float:
    """Least sine of the corners of quads in the plane."""
    ahead = np.roll(points[quads], -1, axis=1) - points[quads]
    ahead /= np.linalg.norm(ahead, axis=2, keepdims=True)
    back = np.roll(ahead, 1, axis=1)
    return float((back[..., 0] * ahead[..., 1] - back[..., 1] * ahead[..., 0]).min())


def main() -> None:
    """Measure, and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--holes", type=int, nargs="+", default=[100, 400])
    parser.add_argument("--largest", type=float, default=0.8, help="greatest length of an edge away from the holes")
    options = parser.parse_args()
    for n_holes in options.holes:
        loops = make_loops(n_holes)
        sizes = make_background(loops, largest=options.largest)
        for name, setting in SETTINGS.items():
            start = time.process_time()
            try:
                inner, quads = mesh_polygon(loops, setting, background=sizes)
            except SurfaceMeshError as error:
                print(f"{n_holes:5d} holes, {name:24s}: {error}", flush=True)
                continue
            seconds = time.process_time() - start
            worst = worst_corner(np.concatenate([*loops, inner]), quads)
            print(
                f"{n_holes:5d} holes, {name:24s}: {len(quads):7,} quads in {seconds:.2f} s, "
                f"{1e5 * seconds / len(quads):.1f} s per 100,000, worst corner {worst:.2f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
