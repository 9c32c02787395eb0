"""How long a mesh takes: the table of ``docs/performance.md``, with the machine, the versions and the ratios.

    python benchmarks/figures.py              some minutes
    python benchmarks/figures.py --write      puts the table in its place on the page, too

Every part is measured in a process of its own that has meshed a small block before, from the STEP file to the checked
mesh in memory. Seconds are of the processor, all threads, so that a busy machine shows little more. gmsh imports the
same file and meshes its surfaces in the same process; of the command line `import OCP` is what it is held against. The
other scripts of this folder look at one thing each.
"""

from __future__ import annotations

import argparse
import importlib.metadata
import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from datetime import date
from pathlib import Path

import cadquery as cq
from cad import attempt, start_up, surfaces_by_gmsh
from generators import FAMILIES

import cadsweep as cs

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "performance.md"
BEGIN, END = "<!-- python benchmarks/figures.py --write -->\n", "<!-- end -->\n"
CASES = {
    "a bent pipe (one sweep)": ("models/elbow.step", {}),
    "the same": ("models/elbow.step", {"size": 0.22}),
    "a bracket (cells between cuts)": ("models/bracket.step", {}),
    "the same, finer": ("models/bracket.step", {"size": 0.25}),
    "a block with pockets (columns)": ("models/block.step", {}),
    "flanges with bolts (an assembly)": ("models/flanges.step", {}),
    "a manifold (crossing bores)": ("models/manifold.step", {}),
    "a helical gear of 15 teeth": ("gear:15", {}),
    "a plate with 100 holes": ("plate:100", {}),
    "a sheet with 25 embossings": ("embossed:25", {}),
    "a spring of 5 turns": ("spring:5", {}),
}
LIBRARIES = ("cadsweep", "cadquery", "cadquery-ocp", "gmsh", "numpy", "scipy", "numba")


def machine() -> str:
    """Processor, cores, memory, system, versions."""
    named = [line.partition(":")[2].strip() for line in _lines("/proc/cpuinfo") if line.startswith("model name")]
    kilobytes = next((int(line.split()[1]) for line in _lines("/proc/meminfo") if line.startswith("MemTotal")), 0)
    versions = ", ".join(f"{name} {importlib.metadata.version(name)}" for name in LIBRARIES if _is_there(name))
    return (
        f"{date.today():%d %B %Y}: {named[0] if named else platform.machine()}, {os.cpu_count()} cores, "
        f"{kilobytes / 2**20:.0f} GiB, load {os.getloadavg()[0]:.1f}; {platform.system()}, "
        f"Python {platform.python_version()}, {versions}"
    )


def _lines(path: str) -> list[str]:
    place = Path(path)
    return place.read_text(encoding="utf-8").splitlines() if place.exists() else []


def _is_there(name: str) -> bool:
    try:
        importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return False
    return True


def measure(source: str, options: dict[str, float]) -> dict[str, float | str]:
    """Seconds of one part, least of two turns, and gmsh's."""
    with tempfile.TemporaryDirectory() as folder:
        path = ROOT / source
        if ":" in source:
            family, n = source.split(":")
            path = Path(folder) / "part.step"
            cq.exporters.export(FAMILIES[family](int(n)), str(path))
        attempt(ROOT / "models" / "block.step")
        surfaces_by_gmsh(ROOT / "models" / "block.step")
        faces = sum(len(solid.faces) for solid in cs.load(path).solids)
        spent = []
        for _ in range(2):
            begun = time.process_time()
            mesh = cs.sweep_mesh(path, **options)
            spent.append(time.process_time() - begun)
        gmsh = min(float(str(surfaces_by_gmsh(path)["gmsh"])) for _ in range(2))
        way = mesh.record.way
        return {
            "faces": faces, "hexes": mesh.n_hexes, "seconds": min(spent), "gmsh": gmsh,
            "worst": mesh.quality().min_scaled_jacobian, "way": way if isinstance(way, str) else "assembly",
        }  # fmt: skip


def table() -> list[str]:
    """The lines of the table."""
    rows = [
        "| part | faces | hexahedra | seconds | worst scaled Jacobian | against gmsh's surfaces |",
        "|---|---|---|---|---|---|",
    ]
    for name, (source, options) in CASES.items():
        command = [sys.executable, __file__, "--one", source, json.dumps(options)]
        environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}  # as in the processes of the command line
        done = subprocess.run(command, check=True, capture_output=True, text=True, env=environment)
        row = json.loads(done.stdout.splitlines()[-1])
        # A size is asked of this package alone: gmsh's surfaces at its own are no measure of it.
        ratio = "" if options else f"{row['seconds'] / row['gmsh']:.1f} x"
        rows.append(
            f"| {name} | {row['faces']} | {row['hexes']:,} | {row['seconds']:.2f} | {row['worst']:.2f} | {ratio} |"
        )
        print(rows[-1], flush=True)
    return rows


def main() -> None:
    """Measure, print, and write."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--write", action="store_true", help=f"put the table into {PAGE.relative_to(ROOT)}")
    parser.add_argument("--one", nargs=2, metavar=("SOURCE", "OPTIONS"), help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.one:
        print(json.dumps(measure(given.one[0], json.loads(given.one[1]))))
        return
    said = machine()
    print(said, flush=True)
    rows = table()
    with tempfile.TemporaryDirectory() as folder:
        start = start_up(Path(folder), 3)
    whole = (
        f"`cadsweep mesh` of a box takes {start['command']:.2f} s with all its processes, "
        f"{start['command'] / start['import OCP']:.2f} x `import OCP` ({start['import OCP']:.2f} s)."
    )
    print(whole)
    if given.write:
        before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
        text = "\n".join([said + ".", "", *rows, "", whole, ""])
        PAGE.write_text(f"{before}{BEGIN}{text}{END}{rest.partition(END)[2]}", encoding="utf-8")


if __name__ == "__main__":
    main()
