"""cadsweep beside gmsh's extrusion and SMESH's Prism_3D, in one run, as ratios.

    python benchmarks/peers.py [--json] [--repeats 5] [--large] [--figure docs/images/performance.png]

Every case is a process of its own in which cadsweep and gmsh take turns; the medians are compared. A time is that
from the CAD shape in memory to the checked mesh in memory; imports and compilation are left out (each has made a
small mesh before). SMESH runs in the Python that Debian's ``freecad-python3`` belongs to, where there is one, a process
a turn. Memory is the peak above that before the mesh was begun, by the kernel's count.

``--large`` adds cadsweep alone at 1e7 and 5e7 hexahedra, and a streamed mesh of 1e8.
"""

from __future__ import annotations

import argparse
import datetime
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
FREECAD = Path("/usr/lib/freecad-python3/lib")
BOX = 10.0
PLATE, HOLE, THICKNESS = 40.0, 16.0, 10.0


def peak_above(work: Callable[[], Any]) -> tuple[Any, float, int]:
    """Result, seconds, and bytes of memory above the start at the peak."""
    import psutil

    with open("/proc/self/clear_refs", "w", encoding="ascii") as file:
        file.write("5")  # forget the peak so far
    before = psutil.Process().memory_info().rss
    start = time.perf_counter()
    result = work()
    seconds = time.perf_counter() - start
    with open("/proc/self/status", encoding="ascii") as status:
        peak = next(int(line.split()[1]) * 1024 for line in status if line.startswith("VmHWM"))
    return result, seconds, peak - before


def shape_of(part: str) -> Any:
    """The part as a CadQuery shape."""
    import cadquery as cq

    if part == "box":
        return cq.Workplane().box(BOX, BOX, BOX)
    return cq.Workplane().box(PLATE, PLATE, THICKNESS).faces(">Z").workplane().hole(HOLE)


def divisions(part: str, n_hexes: float) -> tuple[float, int]:
    """Edge length and layers that make about so many hexahedra."""
    if part == "box":
        n = round(n_hexes ** (1 / 3))
        return BOX / n, n
    layers = max(4, round(100 * (n_hexes / 1e6) ** (1 / 3)))
    area = PLATE**2 - math.pi * HOLE**2 / 4
    return math.sqrt(area * layers / n_hexes), layers


def mesh_here(shape: Any, size: float, layers: int) -> dict[str, Any]:
    """Mesh with cadsweep, every check included."""
    import cadsweep as cs

    mesh, seconds, used = peak_above(lambda: cs.sweep_mesh(shape, size=size, layers=layers))
    stages = dict(mesh.info["seconds"])
    return {"hexes": mesh.n_hexes, "seconds": seconds, "bytes": used, "stages": stages}


def mesh_by_gmsh(part: str, size: float, layers: int) -> dict[str, Any]:
    """Extrude with gmsh's OpenCASCADE kernel, recombined."""
    import gmsh

    def work() -> int:
        gmsh.initialize(interruptible=False, readConfigFiles=False)
        try:
            gmsh.option.setNumber("General.Terminal", 0)
            occ = gmsh.model.occ
            if part == "box":
                cap = occ.addRectangle(0, 0, 0, BOX, BOX)
                height = BOX
            else:
                whole = occ.addRectangle(-PLATE / 2, -PLATE / 2, 0, PLATE, PLATE)
                disk = occ.addDisk(0, 0, 0, HOLE / 2, HOLE / 2)
                cap = occ.cut([(2, whole)], [(2, disk)])[0][0][1]
                height = THICKNESS
            occ.extrude([(2, cap)], 0, 0, height, numElements=[layers], recombine=True)
            occ.synchronize()
            gmsh.option.setNumber("Mesh.MeshSizeMin", size)
            gmsh.option.setNumber("Mesh.MeshSizeMax", size)
            if part == "box":
                gmsh.model.mesh.setTransfiniteSurface(cap)
            gmsh.model.mesh.setRecombine(2, cap)
            gmsh.model.mesh.generate(3)
            types, tags, _ = gmsh.model.mesh.getElements(3)
            return sum(len(t) for kind, t in zip(types, tags, strict=True) if kind == 5)
        finally:
            gmsh.finalize()

    hexes, seconds, used = peak_above(work)
    return {"hexes": hexes, "seconds": seconds, "bytes": used}


def mesh_by_smesh(n: int) -> dict[str, Any] | None:
    """SMESH's Prism_3D on the box, in the Python of FreeCAD; None where there is none."""
    if not FREECAD.exists() or not Path("/usr/bin/python3").exists():
        return None
    done = subprocess.run(
        ["/usr/bin/python3", str(HERE / "smesh_prism.py"), str(n), str(n)],
        env={**os.environ, "PYTHONPATH": str(FREECAD)},
        capture_output=True,
        text=True,
        check=False,
    )
    return json.loads(done.stdout) if done.returncode == 0 else None


def run_case(part: str, n_hexes: float, repeats: int, *, alone: bool) -> dict[str, Any]:
    """One case: all turns of all meshers."""
    shape = shape_of(part)
    size, layers = divisions(part, n_hexes)
    mesh_here(shape, size * (n_hexes / 1e3) ** (1 / 3), 10)
    turns: dict[str, list[dict[str, Any]]] = {"cadsweep": [], "gmsh": [], "smesh": []}
    for _ in range(repeats):
        turns["cadsweep"].append(mesh_here(shape, size, layers))
        if not alone:
            turns["gmsh"].append(mesh_by_gmsh(part, size, layers))
            if part == "box" and (smesh := mesh_by_smesh(layers)) is not None:
                turns["smesh"].append(smesh)
    return {"part": part, "wanted": n_hexes, **{name: median(runs) for name, runs in turns.items() if runs}}


def median(runs: list[dict[str, Any]]) -> dict[str, Any]:
    """Medians of the turns of one mesher, and its largest memory: what a turn has freed, the next may find again."""
    middle = sorted(runs, key=lambda run: run["seconds"] / run["hexes"])[len(runs) // 2]
    return {
        **middle,
        "seconds": statistics.median(run["seconds"] for run in runs),
        "bytes_per_hex": max(run["bytes"] / run["hexes"] for run in runs),
        "hexes_per_second": statistics.median(run["hexes"] / run["seconds"] for run in runs),
    }


def add_ratios(case: dict[str, Any]) -> dict[str, Any]:
    """How many times faster per hexahedron cadsweep is, and what is left after the surface meshes."""
    ours = case["cadsweep"]
    rest = sum(ours["stages"].get(stage, 0.0) for stage in ("projection", "assembly", "quality", "smoothing"))
    case["after_surfaces_seconds"] = rest
    for peer in ("gmsh", "smesh"):
        if peer in case:
            case[f"times_faster_than_{peer}"] = ours["hexes_per_second"] / case[peer]["hexes_per_second"]
            case[f"after_surfaces_times_faster_than_{peer}"] = case[peer]["seconds"] / rest
    return case


def run_stream(n_hexes: float) -> dict[str, Any]:
    """A mesh larger than what is allowed to be in memory, written slab by slab."""
    import cadsweep as cs

    side = 500
    layers = round(n_hexes / side**2)
    cs.sweep_mesh(shape_of("box"), size=1.0, layers=10)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "big.vtkhdf"
        figures, seconds, used = peak_above(
            lambda: cs.stream_mesh(shape_of("box"), path, size=BOX / side, layers=layers, source="<Z")
        )
        written = path.stat().st_size
    return {
        "part": "box, streamed",
        "hexes": figures["n_hexes"],
        "seconds": seconds,
        "bytes": used,
        "gigabytes_written": written / 1e9,
        "n_inverted": figures["n_inverted"],
    }


def in_own_process(*arguments: str) -> dict[str, Any]:
    """Run one case in a fresh interpreter."""
    done = subprocess.run([sys.executable, __file__, "--case", *arguments], capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"case {' '.join(arguments)} failed:\n{done.stderr[-2000:]}")
    return json.loads(done.stdout.splitlines()[-1])


def draw(cases: list[dict[str, Any]], path: Path) -> None:
    """Seconds over hexahedra, for every part and mesher."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
    for axis, part in zip(axes, ("box", "plate"), strict=True):
        for mesher, marker in (("cadsweep", "o"), ("gmsh", "s"), ("smesh", "^")):
            done = [c for c in cases if c.get("part") == part and mesher in c]
            if done:
                hexes, seconds = [c[mesher]["hexes"] for c in done], [c[mesher]["seconds"] for c in done]
                axis.loglog(hexes, seconds, marker=marker, label=mesher)
        axis.set(title=part, xlabel="hexahedra", ylabel="seconds, CAD shape to checked mesh")
        axis.grid(visible=True, which="both", alpha=0.3)
        axis.legend()
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--large", action="store_true", help="also 1e7, 5e7, and 1e8 streamed")
    parser.add_argument("--figure", type=Path)
    parser.add_argument("--case", nargs="+", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.case:
        part, hexes, repeats, alone = given.case
        if part == "stream":
            print(json.dumps(run_stream(float(hexes))))
        else:
            print(json.dumps(add_ratios(run_case(part, float(hexes), int(repeats), alone=alone == "alone"))))
        return
    wanted = [(part, n, given.repeats, "peers") for n in (1e5, 1e6) for part in ("box", "plate")]
    if given.large:
        wanted += [("box", 1e7, 3, "alone"), ("plate", 1e7, 3, "alone"), ("box", 5e7, 1, "alone")]
    cases = [in_own_process(part, str(n), str(repeats), alone) for part, n, repeats, alone in wanted]
    if given.large:
        cases.append(in_own_process("stream", "1e8", "1", "alone"))
    if given.figure:
        draw(cases, given.figure)
    answer = {"date": datetime.date.today().isoformat(), "cores": os.cpu_count(), "cases": cases}
    print(json.dumps(answer, indent=None if given.json else 2))


if __name__ == "__main__":
    main()
