"""The study of docs/studies.md: 40 elbows, one mesh, CalculiX on each, a response surface and a derivative.

``python docs/draw_study.py`` runs it in a temporary folder (a few minutes; needs CalculiX, matplotlib), prints the
figures that the page states and draws docs/images/study.png.
"""

import os
import re
import shutil
import subprocess
import tempfile
from dataclasses import replace
from pathlib import Path

import h5py
import matplotlib.pyplot as plt
import numpy as np

import cadsweep as cs
from cadsweep.batch import read_study, run_study

HERE = Path(__file__).parent
RADII, ANGLES = [20, 24, 28, 32, 36, 40, 44, 48], [50, 60, 70, 80, 90]
STUDY = f"""
script = "elbow.py"
format = "none"
same_mesh = true
[options]
size = 4.0
layers = 12
[grid]
bend_radius = {RADII}
angle = {ANGLES}
"""
AT = {"bend_radius": 34.0, "angle": 75.0}


def compliance(mesh: cs.HexMesh, folder: Path) -> float:
    """Work of a force of 1 kN on the target, along the pipe where it is held, the source: mJ (mm, N, MPa)."""
    mesh.write(folder / "part.inp")
    text = (folder / "part.inp").read_text()
    (folder / "part.inp").write_text(re.sub(r"TYPE=C3D8\b", "TYPE=C3D8I", text))
    held, loaded = (np.unique(mesh.boundaries[name]) for name in ("source", "target"))
    fixed = "\n".join(f"{node + 1}, 1, 3" for node in held)
    force = 1000.0 / len(loaded)
    forces = "\n".join(f"{node + 1}, 3, {force}" for node in loaded)
    (folder / "job.inp").write_text(
        f"*INCLUDE, INPUT=part.inp\n*NSET, NSET=EVERY, GENERATE\n1, {mesh.n_nodes}\n*MATERIAL, NAME=STEEL\n"
        f"*ELASTIC\n210000, 0.3\n*SOLID SECTION, ELSET={next(iter(mesh.parts))}, MATERIAL=STEEL\n*STEP\n*STATIC\n"
        f"*BOUNDARY\n{fixed}\n*CLOAD\n{forces}\n*NODE PRINT, NSET=EVERY\nU\n*END STEP\n"
    )
    alone = {**os.environ, "OMP_NUM_THREADS": "1"}
    subprocess.run(["ccx", "job"], cwd=folder, check=True, capture_output=True, env=alone)
    rows = re.findall(r"^\s+(\d+)\s+(\S+)\s+(\S+)\s+(\S+)\s*$", (folder / "job.dat").read_text(), re.MULTILINE)
    moved = {int(row[0]) - 1: float(row[3]) for row in rows}
    return sum(force * moved[node] for node in loaded)


def terms(radius, angle):
    """A cubic in both parameters, about the middle."""
    r, a = (np.asarray(radius) - 34.0) / 14.0, (np.asarray(angle) - 70.0) / 20.0
    return np.stack([r**i * a**j for i in range(4) for j in range(4 - i)], axis=-1)


def main() -> None:
    """Run the study, fit, compare, draw."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        shutil.copy(HERE.parent / "models" / "elbow.py", folder)
        (folder / "study.toml").write_text(STUDY)
        result = run_study(read_study(folder / "study.toml"))
        assert result.n_failed == 0
        with h5py.File(result.together) as file:
            points = file["VTKHDF/Points"][:].reshape(result.n_cases, -1, 3)
            radius, angle = (file[f"VTKHDF/Cases/{key}"][:] for key in ("bend_radius", "angle"))
        derivative = cs.sensitivity(folder / "elbow.py", AT, wrt="bend_radius", size=4.0, layers=12)
        mesh = derivative.mesh
        # The response is of the study's mesh; its connectivity is that of every case.
        first = {"bend_radius": RADII[0], "angle": ANGLES[0]}
        base = cs.sweep_mesh(folder / "elbow.py", params=first, size=4.0, layers=12)
        work = np.array([compliance(replace(base, points=one), folder) for one in points])
        step = 0.5
        ends = [
            compliance(replace(mesh, points=mesh.points + h * derivative.derivative), folder) for h in (step, -step)
        ]
        by_mesh = (ends[0] - ends[1]) / (2 * step)
    fit = np.linalg.lstsq(terms(radius, angle), np.log(work), rcond=None)[0]
    off = np.exp(terms(radius, angle) @ fit) / work - 1
    at = [np.exp(terms(AT["bend_radius"] + h, AT["angle"]) @ fit) for h in (step, -step)]
    by_fit = (at[0] - at[1]) / (2 * step)
    print(f"{result.n_cases} cases of {base.n_hexes} hexahedra; work {work.min():.1f} to {work.max():.1f} mJ")
    print(f"fit off by {np.abs(off).max():.2%} at most; by the mesh {by_mesh:.4f}, by the fit {by_fit:.4f} mJ/mm")
    draw(points, base.boundaries, (radius, angle), fit)


def draw(points, boundaries, cases, fit) -> None:
    """Three variants of the mesh, seen across the bend, and the response surface."""
    radius, angle = cases
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.6), layout="constrained")
    quads = np.concatenate(list(boundaries.values()))
    for number, color in zip((0, 22, 39), ("#7a5195", "#1f5fa8", "#d45087"), strict=True):
        x, y, z = points[number].T
        depth = z if np.ptp(z) < np.ptp(y) else y
        up = y if depth is z else z
        front = quads[depth[quads].mean(axis=1) > np.median(depth)]
        for quad in front:
            left.plot(x[np.append(quad, quad[0])], up[np.append(quad, quad[0])], color=color, lw=0.5)
        left.plot([], [], color=color, label=f"R = {radius[number]:g} mm, {angle[number]:g} degrees")
    left.set_aspect("equal")
    left.set(xlabel="mm", ylabel="mm", title="three of the 40 variants: the same hexahedra")
    left.legend(frameon=False, fontsize=9)
    r, a = np.meshgrid(np.linspace(20, 48, 60), np.linspace(50, 90, 60))
    surface = right.contourf(r, a, np.exp(terms(r, a) @ fit), levels=14, cmap="viridis")
    right.scatter(radius, angle, c="white", edgecolors="black", s=22, clip_on=False, zorder=3)
    figure.colorbar(surface, label="work of 1 kN on the free end, mJ")
    right.set(
        xlabel="bend radius, mm", ylabel="angle, degrees", title="response surface, fitted to 40 runs of CalculiX"
    )
    figure.savefig(HERE / "images" / "study.png", dpi=110)


if __name__ == "__main__":
    main()
