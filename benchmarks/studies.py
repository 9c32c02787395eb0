"""What a case of a study costs beside the same call in a loop: `python benchmarks/studies.py`.

A plate with a hole of another diameter in every case. Loop and study run one after the other, each with few cases and
with many, so that starts and imports fall out of the difference: processor time is compared, of the workers as well,
because it says the same on a busy machine; the clock is shown beside it. One thread each: threads that wait for each
other burn time of the processor.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

FEW, MANY = 2, 42

SCRIPT = """
import cadquery as cq
d = 4.0
show_object(cq.Workplane().box(30, 20, 3).faces(">Z").workplane().hole(d))
"""

LOOP = """
import sys
from pathlib import Path
import cadsweep as cs
for number, d in enumerate(map(float, sys.argv[1:])):
    folder = Path("loop") / str(number)
    folder.mkdir(parents=True)
    cs.sweep_mesh("plate.py", params={"d": d}).write(folder / "mesh.vtu")
"""


def measure(folder: Path, command: list[str]) -> tuple[float, float]:
    """Processor time of a command and its children, and time by the clock, seconds."""
    before, start = os.times(), time.perf_counter()
    alone = {**os.environ, "OMP_NUM_THREADS": "1"}
    subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL, env=alone)
    after = os.times()
    used = after.children_user + after.children_system - before.children_user - before.children_system
    return used, time.perf_counter() - start


def run(kind: str, n_cases: int) -> tuple[float, float]:
    """The cost of a loop ("loop") or of a study on "1" or "2" workers."""
    diameters = [f"{3.0 + 0.05 * i:.2f}" for i in range(n_cases)]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "plate.py").write_text(SCRIPT)
        if kind == "loop":
            return measure(folder, [sys.executable, "-c", LOOP, *diameters])
        grid = f'script = "plate.py"\nformat = "vtu"\n[grid]\nd = [{", ".join(diameters)}]\n'
        (folder / "study.toml").write_text(grid)
        command = [sys.executable, "-m", "cadsweep", "batch", "study.toml", "--output", "out", "--jobs", kind, "-q"]
        return measure(folder, command)


def main() -> None:
    """Print a row a way."""
    print(f"{'':>10} {'start, s':>9} {'a case, s':>10} {f'{MANY} cases by the clock, s':>28}")
    for kind in ("loop", "1", "2"):
        few, many = run(kind, FEW), run(kind, MANY)
        case = (many[0] - few[0]) / (MANY - FEW)
        name = kind if kind == "loop" else f"{kind} worker{'s' * (kind != '1')}"
        print(f"{name:>10} {few[0] - FEW * case:9.2f} {case:10.3f} {many[1]:28.1f}")


if __name__ == "__main__":
    main()
