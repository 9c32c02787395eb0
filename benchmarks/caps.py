"""Quads of one large cap by gmsh's algorithms: ``python benchmarks/caps.py [--holes 100 400] [--largest 0.8]``.

The cap is a square with a square pattern of round holes of 24 segments, or ``--segments``. Each setting is timed with
sizes that grow away from the holes, as the surface stage wants them, and told with its seconds of the processor per
100,000 quads and its worst corner. ``--first`` takes only the first so many settings.

``--collars 1 2`` lays so many rings of quads around every hole first and meshes what is left; ``--pieces 2 4`` cuts the
square along so many equal rows and columns and meshes the pieces in two processes, each without the others' holes.
Both are measured with the first setting.

``--parts plate:1000 scattered:1000 --quads 1e5 1e6`` times whole parts of ``generators.py``, from the solid to the
checked mesh of two layers, with about so many quads on a cap, as the package fills it.
"""

from __future__ import annotations

import argparse
import math
import multiprocessing
import os
import time
from concurrent.futures import ProcessPoolExecutor

import cadquery as cq
import numpy as np
from generators import FAMILIES

import cadsweep as cs
from cadsweep.errors import SurfaceMeshError
from cadsweep.surface.background import make_background
from cadsweep.surface.gmsh_quads import Setting, mesh_polygon

RADIUS, PITCH = 1.5, 6.0
SETTINGS = {
    f"algorithm {algorithm}, {name}": Setting(
        algorithm=algorithm, recombination=recombination, even_loops=recombination == 3, good_enough=0.3
    )
    for recombination, name in ((3, "subdivided"), (1, "Blossom"))
    for algorithm in (6, 8, 5)
}


def make_loops(n_holes: int, segments: int, *, n_collars: int = 0) -> list[np.ndarray]:
    """Outer loop counter-clockwise, holes with so many rings about them clockwise, each (m, 2)."""
    side = math.ceil(math.sqrt(n_holes))
    n = 2 * round(PITCH * side / (4.0 * np.pi * RADIUS / segments) / 2)
    along = np.arange(n) / n - 0.5
    low, high = np.full(n, -0.5), np.full(n, 0.5)
    rim = np.concatenate([[along, low], [high, along], [-along, high], [low, -along]], axis=1).T
    middles = PITCH * (np.stack(np.divmod(np.arange(n_holes), side), axis=1) - (side - 1) / 2)
    return [PITCH * side * rim, *(circle(segments, n_collars) + middle for middle in middles)]


def circle(segments: int, ring: int) -> np.ndarray:
    """A hole's nodes, or those of a ring about it, each as wide as a segment of the one before."""
    turn = -2.0 * np.pi * np.arange(segments) / segments
    radius = RADIUS * (1.0 + 2.0 * np.pi / segments) ** ring
    return radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)


def mesh_piece(loops: list[np.ndarray], setting: Setting, largest: float) -> tuple[int, float, float]:
    """Number of quads, worst corner and seconds of the processor, the sizes' among them."""
    start = time.process_time()
    inner, quads = mesh_polygon(loops, setting, background=make_background(loops, largest=largest))
    return len(quads), worst_corner(np.concatenate([*loops, inner]), quads), time.process_time() - start


def with_collars(n_holes: int, segments: int, n_collars: int, largest: float) -> None:
    """Measure rings of quads about the holes and a mesher's between them."""
    setting = next(iter(SETTINGS.values()))
    n_quads, worst, seconds = mesh_piece(make_loops(n_holes, segments, n_collars=n_collars), setting, largest)
    show(n_holes, f"{n_collars} collars", n_quads + n_collars * segments * n_holes, seconds, worst)


def in_pieces(n_holes: int, segments: int, n_rows: int, largest: float) -> None:
    """Measure squares of the square, in two processes that have meshed a small one before."""
    own = round(math.sqrt(n_holes) / n_rows) ** 2
    setting = next(iter(SETTINGS.values()))
    loops = make_loops(own, segments)
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        list(pool.map(mesh_piece, [make_loops(1, segments)] * 4, [setting] * 4, [largest] * 4))
        start = time.perf_counter()
        n = n_rows**2
        found = list(pool.map(mesh_piece, [loops] * n, [setting] * n, [largest] * n))
        waited = time.perf_counter() - start
    n_quads, seconds = sum(n for n, _, _ in found), sum(each for _, _, each in found)
    show(own * n_rows**2, f"{n_rows} x {n_rows} pieces", n_quads, seconds, min(worst for _, worst, _ in found))
    print(f"{'':12s} {waited:.2f} s by the clock at a load of {os.getloadavg()[0]:.1f}", flush=True)


def mesh_whole(part: str, wanted: list[int]) -> None:
    """Measure a part with several numbers of quads on its cap, once it has been meshed coarsely."""
    family, _, n = part.partition(":")
    solid = FAMILIES[family](int(n)).val()
    area = cq.Workplane(solid).faces(">Z").val().Area()
    for n_quads in [0, *wanted]:
        size = None if not n_quads else math.sqrt(area / n_quads)
        start = time.process_time()
        mesh = cs.sweep_mesh(solid, size=size, layers=2)
        seconds, stages = time.process_time() - start, mesh.info["seconds"]
        if n_quads:
            share, worst = stages["surface"] / sum(stages.values()), mesh.quality().min_scaled_jacobian
            print(
                f"{part:14s}: {mesh.n_hexes // 2:9,} quads on a cap, {seconds:.1f} s with all checks of "
                f"{mesh.n_hexes:,} hexahedra, {100 * share:.0f} % of it surfaces, worst {worst:.2f}",
                flush=True,
            )


def show(n_holes: int, name: str, n_quads: int, seconds: float, worst: float) -> None:
    """Print a row."""
    print(
        f"{n_holes:5d} holes, {name:24s}: {n_quads:7,} quads in {seconds:.2f} s, "
        f"{1e5 * seconds / n_quads:.1f} s per 100,000, worst corner {worst:.2f}",
        flush=True,
    )


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
    parser.add_argument("--collars", type=int, nargs="*", default=[], help="rings of quads about every hole")
    parser.add_argument("--pieces", type=int, nargs="*", default=[], help="rows and columns of pieces")
    parser.add_argument("--segments", type=int, default=24, help="of every hole")
    parser.add_argument("--first", type=int, default=len(SETTINGS), help="how many settings are measured")
    parser.add_argument("--parts", nargs="*", default=[], metavar="FAMILY:N", help="whole parts instead")
    parser.add_argument("--quads", type=float, nargs="*", default=[1e5], help="on a cap of the whole parts")
    parser.add_argument("--largest", type=float, default=0.8, help="greatest length of an edge away from the holes")
    options = parser.parse_args()
    for part in options.parts:
        mesh_whole(part, [int(n_quads) for n_quads in options.quads])
    if options.parts:
        return
    for n_holes in options.holes:
        loops = make_loops(n_holes, options.segments)
        for name, setting in list(SETTINGS.items())[: options.first]:
            try:
                n_quads, worst, seconds = mesh_piece(loops, setting, options.largest)
            except SurfaceMeshError as error:
                print(f"{n_holes:5d} holes, {name:24s}: {error}", flush=True)
                continue
            show(n_holes, name, n_quads, seconds, worst)
        for n_collars in options.collars:
            with_collars(n_holes, options.segments, n_collars, options.largest)
        for n_rows in options.pieces:
            in_pieces(n_holes, options.segments, n_rows, options.largest)


if __name__ == "__main__":
    main()
