"""Mesh the ducts of ``docs/cfd.md``, have OpenFOAM check them, and draw their sections.

    python docs/draw_wall_layers.py [FOLDER]

Writes the cases to FOLDER (or a temporary one), prints a row of the table each, and ``docs/images/wall_layers.png``.
"""

from __future__ import annotations

import math
import re
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import cadquery as cq
import matplotlib

import cadsweep as cs

matplotlib.use("Agg")
import matplotlib.pyplot as plt

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "scripts"))
import check_openfoam  # noqa: E402

LAYERS = cs.WallLayers(first=0.1, growth=1.2, n=8)


def ducts() -> dict[str, tuple[cq.Workplane, str]]:
    """Parts in millimetres, and what chooses their walls."""
    angle = cq.Workplane().polyline([(0, 0), (50, 0), (50, 20), (20, 20), (20, 50), (0, 50)]).close()
    return {
        "pipe": (cq.Workplane().circle(25).extrude(200), "%CYLINDER"),
        "elbow": (cq.Workplane().circle(25).revolve(90, (-75, 0, 0), (-75, 1, 0)), "%TORUS"),
        "loft": (cq.Workplane().rect(60, 40).workplane(offset=120).circle(20).loft(), "not |Z"),
        "taper": (cq.Workplane().rect(60, 40).workplane(offset=120).rect(30, 24).loft(), "not |Z"),
        "angle": (angle.extrude(60), "#Z"),
        "wedge of 30 degrees": (_wedge(30), "#Z"),
        "wedge of 12 degrees": (_wedge(12), "#Z"),
        "around a rhomb, tips of 30 degrees": (_around_rhomb(30), "#Z and (not |X) and (not |Y)"),
        "around a rhomb, tips of 12 degrees": (_around_rhomb(12), "#Z and (not |X) and (not |Y)"),
    }


def _wedge(degrees: float) -> cq.Workplane:
    end = (60 * math.cos(math.radians(degrees)), 60 * math.sin(math.radians(degrees)))
    return cq.Workplane().polyline([(0, 0), (60, 0), end]).close().extrude(30)


def _around_rhomb(degrees: float) -> cq.Workplane:
    high = 20 * math.tan(math.radians(degrees / 2))
    rhomb = cq.Workplane().polyline([(-20, 0), (0, -high), (20, 0), (0, high)]).close().extrude(20)
    return cq.Workplane().rect(120, 80).extrude(20).cut(rhomb)


def verdict(mesh: cs.HexMesh, case: Path) -> dict[str, str]:
    """What ``checkMesh`` says of a mesh in millimetres."""
    check_openfoam.make_case(case)
    replace(mesh, points=1e-3 * mesh.points).write(case / "constant" / "polyMesh")
    said = check_openfoam.run(case, "checkMesh")
    found = {"verdict": "Mesh OK" if "Mesh OK." in said else "failed"}
    for name, pattern in (
        ("non-orthogonality", r"non-orthogonality Max: ([\d.]+)"),
        ("skewness", r"Max skewness = ([\d.]+)"),
        ("aspect", r"Max aspect ratio = ([\d.]+)"),
    ):
        match = re.search(pattern, said)
        found[name] = match[1] if match else "?"
    return found


def draw(axes: plt.Axes, mesh: cs.HexMesh, layer: int, title: str) -> None:
    """One layer of nodes, seen along the z axis."""
    points = mesh.origin.factored.sweep.points(slice(layer, layer + 1))[0]
    for quad in mesh.origin.surfaces.source.quads:
        axes.fill(*points[quad][:, :2].T, fc="#eef3f8", ec="#24405c", lw=0.3)
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set_title(title)


def main(folder: Path) -> None:
    """Mesh, check and draw."""
    figure, axes = plt.subplots(1, 4, figsize=(14, 4.2))
    for name, (work, selector) in ducts().items():
        work.faces(selector).tag("wall")
        mesh = cs.sweep_mesh(work, size=5, wall_layers={"wall": LAYERS})
        said = verdict(mesh, folder / re.sub(r"\W+", "_", name))
        quality = mesh.info["quality"]
        print(
            f"| {name} | {mesh.n_hexes} | {quality.min_scaled_jacobian:.2f} | {said['verdict']} | "
            f"{said['non-orthogonality']} | {said['skewness']} | {said['aspect']} |"
        )
        last = mesh.structure.n_layers
        pictures = {"pipe": [(0, 0, "a pipe")], "angle": [(1, 0, "corners of both kinds")]}
        pictures["loft"] = [(2, 0, "a loft, from here"), (3, last, "to here")]
        for place, layer, title in pictures.get(name, ()):
            draw(axes[place], mesh, layer, title)
    figure.tight_layout()
    figure.savefig(HERE / "images" / "wall_layers.png", dpi=110)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        main(Path(sys.argv[1]))
    else:
        with tempfile.TemporaryDirectory() as place:
            main(Path(place))
