"""A wall of bricks from a STEP file to the checked mesh, beside one solid of as many hexahedra.

``python benchmarks/bricks.py`` prints seconds of the processor by stage, all threads, and the ratio of the two, which
is of one run. ``--bond`` moves every other course by half a brick, so that beds are parts of faces; ``--load`` only
reads and imprints. ``--profile OUT`` writes what :mod:`cProfile` saw of the wall.
"""

from __future__ import annotations

import argparse
import cProfile
import tempfile
import time
from pathlib import Path

import cadquery as cq

import cadsweep as cs

BRICK = 1.0


def wall(n_courses: int, n_a_course: int, *, bond: bool) -> cq.Assembly:
    """A wall of cubes, every one a solid placed by the assembly."""
    whole = cq.Assembly(name="wall")
    brick = cq.Workplane().box(BRICK, BRICK, BRICK, centered=False)
    for j in range(n_courses):
        for i in range(n_a_course):
            shift = 0.5 * (j % 2) if bond else 0.0
            place = cq.Location(cq.Vector((i + shift) * BRICK, 0.0, j * BRICK))
            whole.add(brick, name=f"brick_{j}_{i}", loc=place)
    return whole


def seconds_of(path: Path, size: float, *, load_only: bool) -> dict[str, float]:
    """Seconds of the processor of every stage, and of all."""
    start = time.process_time()
    part = cs.load(path)
    found = {"load": time.process_time() - start}
    if not load_only:
        mesh = cs.sweep_mesh(part, size=size)
        found |= mesh.info["seconds"] | {"hexes": mesh.n_hexes}
    found["all"] = time.process_time() - start
    return found


def main() -> None:
    """Measure, and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--courses", type=int, default=10)
    parser.add_argument("--a-course", type=int, default=10)
    parser.add_argument("--segments", type=int, default=10, help="along the edge of a brick")
    parser.add_argument("--bond", action="store_true")
    parser.add_argument("--load", action="store_true")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--profile", type=Path)
    options = parser.parse_args()
    cs.sweep_mesh(wall(2, 1, bond=True), size=0.5)  # kernels are loaded, or compiled
    size = BRICK / options.segments
    with tempfile.TemporaryDirectory() as name:
        bricks, one = Path(name) / "bricks.step", Path(name) / "one.step"
        wall(options.courses, options.a_course, bond=options.bond).export(str(bricks))
        cq.exporters.export(cq.Workplane().box(options.a_course, 1, options.courses, centered=False), str(one))
        rows = []
        for _ in range(options.repeats):
            rows.append([seconds_of(path, size, load_only=options.load) for path in (bricks, one)])
        if options.profile:
            profile = cProfile.Profile(time.process_time)
            profile.runcall(seconds_of, bricks, size, load_only=options.load)
            profile.dump_stats(options.profile)
    best = [min((row[k] for row in rows), key=lambda found: found["all"]) for k in (0, 1)]
    ratio = best[0]["all"] / best[1]["all"]
    for label, found in zip(("bricks", "one"), best, strict=True):
        hexes = f"{found.pop('hexes', 0):,} hexes; "
        print(f"{label:7s}{hexes}" + ", ".join(f"{stage} {seconds:.3f}" for stage, seconds in found.items()))
    print(f"{ratio:.1f} x one solid")


if __name__ == "__main__":
    main()
