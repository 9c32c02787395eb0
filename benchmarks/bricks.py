"""Bricks in contact, a part of cells and a stack of columns, each beside one box of as many hexahedra.

``python benchmarks/bricks.py --segments 22`` prints seconds of the processor by stage, from the STEP file to the
checked mesh, all threads, and the ratio of the two, which is of one run. ``--kind bond`` moves every other course by
half a brick, so that beds are parts of faces; ``cells`` is one block that is cut into as many cells; ``stack`` one
with as many posts of two heights. ``--load`` only reads and imprints. ``--profile OUT`` writes what :mod:`cProfile`
saw.
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


def block(n_courses: int, n_a_course: int) -> cq.Workplane:
    """The wall as one solid."""
    return cq.Workplane().box(n_a_course * BRICK, BRICK, n_courses * BRICK, centered=False)


def posts(n_courses: int, n_a_course: int) -> cq.Workplane:
    """A plate with a post of one of two heights for every brick."""
    plate = cq.Workplane().box(n_a_course * BRICK, n_courses * BRICK, 0.5 * BRICK, centered=False)
    places = [(i + 0.5, j + 0.5) for j in range(n_courses) for i in range(n_a_course)]
    for places_of_one, height in ((places[::2], 1.0), (places[1::2], 1.5)):
        side = 0.5 * BRICK
        plate = plate.union(cq.Workplane().pushPoints(places_of_one).rect(side, side).extrude(height * BRICK))
    return plate


def made(kind: str, n_courses: int, n_a_course: int) -> tuple[cq.Assembly | cq.Workplane, list[str]]:
    """A part, and the cuts that are asked for."""
    if kind == "cells":
        cuts = [f"plane x={i * BRICK:g}" for i in range(1, n_a_course)]
        cuts += [f"plane z={j * BRICK:g}" for j in range(1, n_courses)]
        return block(n_courses, n_a_course), cuts
    if kind == "stack":
        return posts(n_courses, n_a_course), []
    return wall(n_courses, n_a_course, bond=kind == "bond"), []


def written(part: cq.Assembly | cq.Workplane, path: Path) -> None:
    """Write a STEP file."""
    if isinstance(part, cq.Assembly):
        part.export(str(path))
    else:
        cq.exporters.export(part, str(path))


def seconds_of(path: Path, size: float, cuts: list[str], *, load_only: bool) -> dict[str, float]:
    """Seconds of the processor of every stage, and of all."""
    start = time.process_time()
    part = cs.load(path)
    found = {"load": time.process_time() - start}
    if not load_only:
        mesh = cs.sweep_mesh(part, size=size, cuts=cuts)
        found |= mesh.info["seconds"] | {"hexes": mesh.n_hexes}
    found["all"] = time.process_time() - start
    return found


def main() -> None:
    """Measure, and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--courses", type=int, default=10)
    parser.add_argument("--a-course", type=int, default=10)
    parser.add_argument("--segments", type=int, default=10, help="along the edge of a brick")
    parser.add_argument("--kind", choices=["wall", "bond", "cells", "stack"], default="wall")
    parser.add_argument("--load", action="store_true")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--profile", type=Path)
    options = parser.parse_args()
    size = BRICK / options.segments
    part, cuts = made(options.kind, options.courses, options.a_course)
    cs.sweep_mesh(part, size=BRICK / 2, cuts=cuts)  # kernels are loaded, or compiled
    with tempfile.TemporaryDirectory() as name:
        several, one = Path(name) / "several.step", Path(name) / "one.step"
        written(part, several)
        volume = part.val().Volume() if isinstance(part, cq.Workplane) else options.courses * options.a_course
        written(cq.Workplane().box(options.a_course, 1.0, volume / options.a_course, centered=False), one)
        rows = []
        for _ in range(options.repeats):
            rows.append(
                [seconds_of(path, size, own, load_only=options.load) for path, own in ((several, cuts), (one, []))]
            )
        if options.profile:
            profile = cProfile.Profile(time.process_time)
            profile.runcall(seconds_of, several, size, cuts, load_only=options.load)
            profile.dump_stats(options.profile)
    best = [min((row[k] for row in rows), key=lambda found: found["all"]) for k in (0, 1)]
    ratio = best[0]["all"] / best[1]["all"]
    for label, found in zip((options.kind, "one"), best, strict=True):
        hexes = f"{found.pop('hexes', 0):,} hexes; "
        print(f"{label:7s}{hexes}" + ", ".join(f"{stage} {seconds:.3f}" for stage, seconds in found.items()))
    print(f"{ratio:.1f} x one solid")


if __name__ == "__main__":
    main()
