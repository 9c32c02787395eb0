"""From a CAD file to the checked mesh: parts of hundreds of faces beside gmsh, and the start of the command.

``python benchmarks/cad.py`` prints a row for each part and one for the start-up; ``--json`` one object for
``benchmarks/compare.py``. Seconds are of the processor, all threads, so that a busy machine shows less; each ratio is
of one run.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import cadquery as cq
from generators import FAMILIES

import cadsweep as cs
from cadsweep.gmsh_session import gmsh_session

PARTS = [
    ("gear", 15),
    ("gear", 60),
    ("herringbone", 30),
    ("spring", 5),
    ("rack", 25),
    ("plate", 25),
    ("plate", 100),
    ("embossed", 25),
]


def measure(family: str, n: int, folder: Path) -> dict[str, object]:
    """Seconds of one part: loaded, meshed (better of two turns), and imported and meshed on its surfaces by gmsh."""
    part = FAMILIES[family](n)
    path = folder / f"{family}{n}.step"
    cq.exporters.export(part, str(path))
    row: dict[str, object] = {"part": f"{family} {n}", "load": math.inf, "all": math.inf}
    for _ in range(2):  # the first turn may compile, or import, what no part before has asked for
        start = time.process_time()
        loaded = cs.load(path)
        row["faces"] = sum(len(solid.faces) for solid in loaded.solids)
        row["load"] = min(row["load"], time.process_time() - start)  # type: ignore[type-var]
        start = time.process_time()
        try:
            row["hexes"] = cs.sweep_mesh(path).n_hexes
        except cs.CadSweepError as error:
            row["refused"] = " ".join(str(error).split())[:120]
        row["all"] = min(row["all"], time.process_time() - start)  # type: ignore[type-var]
    with gmsh_session("cad") as gmsh:
        start = time.process_time()
        gmsh.model.occ.importShapes(str(path))
        gmsh.model.occ.synchronize()
        gmsh.model.mesh.generate(2)
        row["gmsh"] = time.process_time() - start
    return row


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


def main() -> None:
    """Measure, and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--parts", nargs="*", default=[f"{family}:{n}" for family, n in PARTS], metavar="FAMILY:N")
    parser.add_argument("--repeats", type=int, default=3, help="turns of the start-up")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    cs.sweep_mesh(cq.Workplane().box(1, 1, 1))  # kernels are loaded, or compiled
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        rows = [measure(family, int(n), folder) for family, _, n in (part.partition(":") for part in options.parts)]
        start = start_up(folder, options.repeats) if options.repeats else None
    if options.json:
        print(json.dumps({"parts": rows, "start": start}))
        return
    for row in rows:
        outcome = row.get("refused") or f"{row['hexes']:,} hexes"
        print(
            f"{row['part']:14s} {row['faces']:5d} faces: load {row['load']:.2f} s, all {row['all']:.2f} s, "
            f"{row['all'] / row['gmsh']:.1f} x gmsh's surfaces ({row['gmsh']:.2f} s); {outcome}"  # type: ignore[operator]
        )
    if start:
        ratio = start["command"] / start["import OCP"]
        print(
            f"cadsweep mesh box.step: {start['command']:.2f} s, {ratio:.2f} x import OCP ({start['import OCP']:.2f} s)"
        )


if __name__ == "__main__":
    main()
