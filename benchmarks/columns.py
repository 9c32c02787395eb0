"""Columns recognised: columns.py [N ...]

Perforated, bossed plates of N columns (`generators.bossed`), 100, 500 and 2,000 by default. Prints faces, seconds of
processor time of loading and of recognition (all directions looked at, outlines divided, cells, levels), and the
exponent of growth between one number and the next.
"""

import sys
import time
from math import log

from generators import bossed

import cadsweep as cs
from cadsweep.pipeline.columns.stacking import find_stacks


def main() -> None:
    """Print the table."""
    numbers = [int(word) for word in sys.argv[1:]] or [100, 500, 2000]
    find_stacks(cs.load(bossed(10)))
    before = None
    sys.stdout.write(f"{'columns':>7} {'faces':>6} {'load':>8} {'recognition':>12} {'growth':>7}\n")
    for n in numbers:
        model = bossed(n)
        start = time.process_time()
        part = cs.load(model)
        middle = time.process_time()
        found = find_stacks(part)[0]
        seconds = time.process_time() - middle
        assert found.n_columns == n, "every boss, bored boss and blind hole is a column, and so is the plate"
        growth = "" if before is None else f"{log(seconds / before[1]) / log(n / before[0]):7.2f}"
        faces = len(part.solids[0].faces)
        sys.stdout.write(f"{n:7d} {faces:6d} {middle - start:7.2f}s {seconds:11.2f}s {growth}\n")
        sys.stdout.flush()
        before = n, seconds


if __name__ == "__main__":
    main()
