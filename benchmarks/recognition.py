"""Time of recognition and intervals as the faces of a part grow.

Run ``python benchmarks/recognition.py``; no CAD kernel is needed. Prints, for plates with holes, long
stacked prisms and gears, the number of faces, the seconds of both stages, and the exponent of growth
between one size and the next.
"""

import sys
import time
from collections.abc import Callable, Sequence
from math import log
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "recognition"))

from recognition_solids import plate_with_square_holes, prism, regular, square

from cadsweep.brep import Solid
from cadsweep.intervals import CellSweep, Wishes, assign_shared_intervals
from cadsweep.recognition import find_sweeps


def stack(n_faces: int) -> Solid:
    """Make a square bar of many stacked spans."""
    return prism(square(), tuple(np.arange(n_faces // 4 + 1.0)))


def cog(n_faces: int) -> Solid:
    """Make a prism whose outline zigzags."""
    outline = regular(n_faces)
    outline[::2] *= 0.8
    return prism(outline)


def plate(n_faces: int) -> Solid:
    """Make a plate with square holes."""
    return plate_with_square_holes(max(1, round((n_faces / 4) ** 0.5)))


def measure(make: Callable[[int], Solid], sizes: Sequence[int]) -> list[tuple[int, float, float]]:
    """Return faces, seconds of recognition, seconds of intervals; the best of three runs."""
    rows = []
    for size in sizes:
        solid = make(size)
        best = [np.inf, np.inf]
        for _ in range(3):
            start = time.perf_counter()
            sweeps = find_sweeps(solid)
            middle = time.perf_counter()
            cell = CellSweep(
                fill=sweeps[0], grids=tuple(sweeps[0].linking_sides), free=sweeps[0].source, by_itself=True
            )
            assign_shared_intervals([cell], Wishes())
            end = time.perf_counter()
            best = [min(best[0], middle - start), min(best[1], end - middle)]
        rows.append((len(solid.faces), *best))
    return rows


def main() -> None:
    """Print the table."""
    sys.stdout.write(f"{'part':8} {'faces':>7} {'recognition':>12} {'intervals':>10} {'growth':>7}\n")
    for make in (plate, cog, stack):
        before = None
        for faces, recognition, intervals in measure(make, (125, 500, 2000)):
            growth = "" if before is None else f"{log(recognition / before[1]) / log(faces / before[0]):7.2f}"
            sys.stdout.write(f"{make.__name__:8} {faces:7d} {recognition:11.3f}s {intervals:9.3f}s {growth}\n")
            before = (faces, recognition)


if __name__ == "__main__":
    main()
