"""From a CAD file to the checked mesh: parts of hundreds of faces beside gmsh, and the start of the command.

``python benchmarks/cad.py`` prints a row for each part of the cheap half and one for the start-up, ``--all`` takes the
other half, too (gears of 120 teeth, 500 holes: many minutes), ``--growth`` plates from 50 to 2,000 faces with the power
of n by which each stage grows, ``--growth-gears`` gears up to 450, ``--refusal`` parts of 500 to 1,100 faces that are
no sweep, no stack and not cut either. ``--profile`` adds the functions
of this package that took longest, ``--json`` prints one object for ``benchmarks/compare.py``.

Seconds are of the processor, all threads, so that a busy machine shows less. Every part is measured in a process of
its own, in which a small part of its family has been meshed before (kernels are loaded, or compiled, by then), and
gmsh imports and meshes the same file in the same process: each ratio is of one run.
"""

from __future__ import annotations

import argparse
import cProfile
import json
import math
import os
import pstats
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import cadquery as cq
from generators import FAMILIES

import cadsweep as cs
from cadsweep.gmsh_session import gmsh_session

CHEAP = ["gear:15", "gear:60", "spring:5", "rack:25", "plate:25", "plate:100", "embossed:25", "pits:25"]
DEAR = ["gear:120", "herringbone:30", "spring:20", "rack:100", "plate:500", "embossed:100", "pits:512"]
GROWTH = ["plate:22", "plate:100", "plate:225", "plate:484", "plate:1000"]
"""Plates with 50, 206, 456, 974 and 2,006 faces."""
GROWTH_OF_GEARS = ["gear:8", "gear:17", "gear:34", "gear:75"]
REFUSAL = ["crossed:240", "slanted:250", "undercut:100", "drilled:75"]
SMALL = {
    **{"gear": "gear:6", "herringbone": "herringbone:6", "spring": "spring:1", "embossed": "embossed:4"},
    **{"plate": "plate:4", "crossed": "crossed:4", "rack": "rack:3", "pits": "pits:4"},
    **{"slanted": "pits:4", "undercut": "pits:4", "drilled": "pits:4", "scattered": "plate:4"},
}
"""Of every family the part that is meshed before the clock runs; for what is refused one that is not looked at long."""
LONG = 10.0
"""Seconds from which on one turn is enough."""
STAGES = ("load", "all", "gmsh")


def attempt(path: Path) -> dict[str, object]:
    """Processor seconds from the file to the mesh, or to the refusal, and which of the two it was."""
    start = time.process_time()
    try:
        outcome: dict[str, object] = {"hexes": cs.sweep_mesh(path).n_hexes}
    except cs.CadSweepError as error:
        outcome = {"refused": " ".join(str(error).split())[:120]}
    return outcome | {"all": time.process_time() - start}


def surfaces_by_gmsh(path: Path) -> dict[str, object]:
    """Processor seconds in which gmsh imports a file and meshes its surfaces."""
    with gmsh_session("cad") as gmsh:
        start = time.process_time()
        gmsh.model.occ.importShapes(str(path))
        gmsh.model.occ.synchronize()
        gmsh.model.mesh.generate(2)
        return {"gmsh": time.process_time() - start}


def quicker(turn: Callable[[], dict[str, object]], figure: str) -> dict[str, object]:
    """The better of two turns; of one that takes long, that one."""
    first = turn()
    if first[figure] > LONG:  # type: ignore[operator]
        return first
    return min(first, turn(), key=lambda row: row[figure])  # type: ignore[arg-type, return-value]


def longest(profile: cProfile.Profile, n: int) -> list[str]:
    """The n functions of the package with the most time of their own and of what they call."""
    entries = pstats.Stats(profile).stats.items()  # type: ignore[attr-defined]
    ours = [
        (total, own, calls, f"{Path(file).stem}.{name}")
        for (file, _, name), (_, calls, own, total, _) in entries
        if f"{os.sep}cadsweep{os.sep}" in file
    ]
    return [f"{total:8.2f} {own:8.2f} {calls:8d}  {name}" for total, own, calls, name in sorted(ours, reverse=True)[:n]]


def measure(part: str, folder: Path, *, n_profiled: int) -> dict[str, object]:
    """Seconds of one part: loaded, meshed, and imported and meshed on its surfaces by gmsh."""
    family, _, n = part.partition(":")
    paths = []
    for kind, _, count in (SMALL[family].partition(":"), part.partition(":")):
        paths.append(folder / f"{kind}{count}.step")
        cq.exporters.export(FAMILIES[kind](int(count)), str(paths[-1]))
    small, path = paths
    attempt(small)
    start = time.process_time()
    loaded = cs.load(path)
    row: dict[str, object] = {"part": f"{family} {n}", "load": time.process_time() - start}
    row["faces"] = sum(len(solid.faces) for solid in loaded.solids)
    del loaded
    row |= quicker(lambda: attempt(path), "all") | quicker(lambda: surfaces_by_gmsh(path), "gmsh")
    if n_profiled:
        profile = cProfile.Profile(time.process_time)
        profile.runcall(attempt, path)
        row["profile"] = longest(profile, n_profiled)
    return row


def in_its_own_process(part: str, *, timeout: float, n_profiled: int) -> dict[str, object]:
    """The row of a part, measured by another process, or why there is none."""
    command = [sys.executable, __file__, "--one", part, "--profile", str(n_profiled)]
    try:
        answer = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, timeout=timeout)
    except subprocess.TimeoutExpired:
        return {"part": part.replace(":", " "), "failed": f"no answer in {timeout:.0f} s by the clock"}
    except subprocess.CalledProcessError as error:
        return {"part": part.replace(":", " "), "failed": f"the process ended with {error.returncode}"}
    return dict(json.loads(answer.stdout.splitlines()[-1]))


def children_seconds(command: list[str]) -> float:
    """Processor time of a command and of all that it starts."""
    before = os.times()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def start_up(folder: Path, repeats: int) -> dict[str, float]:
    """Least seconds of ``cadsweep mesh`` on a box, and of ``import OCP`` alone."""
    path = folder / "box.step"
    cq.exporters.export(cq.Workplane().box(3, 4, 5), str(path))
    mesh = [sys.executable, "-m", "cadsweep", "mesh", str(path), "-o", str(folder / "box.vtu"), "--quiet"]
    found: dict[str, list[float]] = {"command": [], "import OCP": []}
    for _ in range(repeats + 1):
        found["import OCP"].append(children_seconds([sys.executable, "-c", "import OCP"]))
        found["command"].append(children_seconds(mesh))
    return {name: min(values) for name, values in found.items()}


def show(row: dict[str, object]) -> None:
    """Print the row of a part."""
    if "failed" in row:
        print(f"{row['part']:16s} {row['failed']}", flush=True)
        return
    outcome = row.get("refused") or f"{row['hexes']:,} hexes"
    print(
        f"{row['part']:16s} {row['faces']:5d} faces: load {row['load']:.2f} s, all {row['all']:.2f} s, "
        f"{row['all'] / row['gmsh']:.1f} x gmsh's surfaces ({row['gmsh']:.2f} s); {outcome}",  # type: ignore[operator]
        flush=True,
    )
    for line in row.get("profile", []):  # type: ignore[attr-defined]
        print("    " + line)


def show_growth(rows: list[dict[str, object]]) -> None:
    """Print, from row to row, the power of the number of faces by which each figure grows."""
    for before, after in pairwise(rows):
        if "failed" in before or "failed" in after:
            continue
        grown = math.log(after["faces"] / before["faces"])  # type: ignore[operator]
        powers = [f"{name} {math.log(after[name] / before[name]) / grown:.2f}" for name in STAGES]  # type: ignore[operator]
        print(f"{before['faces']:5d} -> {after['faces']:5d} faces: power of n of {', '.join(powers)}")


def main() -> None:
    """Measure, and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--parts", nargs="*", default=CHEAP, metavar="FAMILY:N", help=f"default: {' '.join(CHEAP)}")
    which.add_argument("--all", action="store_const", dest="parts", const=CHEAP + DEAR)
    which.add_argument("--growth", action="store_const", dest="parts", const=GROWTH)
    which.add_argument("--growth-gears", action="store_const", dest="parts", const=GROWTH_OF_GEARS)
    which.add_argument("--refusal", action="store_const", dest="parts", const=REFUSAL)
    which.add_argument("--one", metavar="FAMILY:N", help=argparse.SUPPRESS)
    parser.add_argument("--repeats", type=int, default=3, help="turns of the start-up")
    parser.add_argument("--timeout", type=float, default=900.0, help="seconds by the clock for one part")
    parser.add_argument("--profile", type=int, nargs="?", const=40, default=0, metavar="N", help="longest N functions")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        if options.one:
            print(json.dumps(measure(options.one, Path(name), n_profiled=options.profile)))
            return
        rows = []
        for part in options.parts:
            rows.append(in_its_own_process(part, timeout=options.timeout, n_profiled=options.profile))
            if not options.json:
                show(rows[-1])
        if options.parts in (GROWTH, GROWTH_OF_GEARS) and not options.json:
            show_growth(rows)
        start = start_up(Path(name), options.repeats) if options.repeats else None
    if options.json:
        print(json.dumps({"parts": rows, "start": start}))
    elif start:
        ratio = start["command"] / start["import OCP"]
        print(
            f"cadsweep mesh box.step: {start['command']:.2f} s, {ratio:.2f} x import OCP ({start['import OCP']:.2f} s)"
        )


if __name__ == "__main__":
    main()
