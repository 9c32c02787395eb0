"""Draw the caps of ``docs/hints.md``: flanges with the mirrors of their holes, and plates that are fine somewhere.

    python docs/draw_caps.py

Writes ``docs/images/caps.png`` and ``growth.png``; inner nodes at which not four quads meet are red.
"""

from __future__ import annotations

from pathlib import Path

import cadquery as cq
import matplotlib
import numpy as np

import cadsweep as cs

matplotlib.use("Agg")
import matplotlib.pyplot as plt

HERE = Path(__file__).parent


def flange(n_holes: int) -> cq.Workplane:
    """A ring with holes on a circle."""
    ring = cq.Workplane().circle(10).extrude(3).faces(">Z").workplane().hole(8).faces(">Z").workplane()
    return ring.polarArray(7, 0, 360, n_holes).circle(0.9).cutThruAll()


def draw(axes: plt.Axes, mesh: cs.HexMesh, title: str) -> None:
    """The upper cap of a mesh."""
    quads = np.concatenate(list(mesh.boundaries.values()))
    high = mesh.points[:, 2] > mesh.points[:, 2].max() - 1e-9
    quads = quads[high[quads].all(axis=1)]
    sides = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    found, count = np.unique(sides, axis=0, return_counts=True)
    uses = np.bincount(quads.ravel(), minlength=mesh.n_nodes)
    irregular = (uses > 0) & (uses != 4)
    irregular[found[count == 1]] = False
    for quad in quads:
        axes.fill(*mesh.points[quad][:, :2].T, fc="#eef3f8", ec="#24405c", lw=0.3)
    axes.plot(*mesh.points[irregular][:, :2].T, "r.", ms=3)
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set_title(title)


def main() -> None:
    """Mesh and draw."""
    plate = cq.Workplane().box(24, 18, 4).edges("|Z").fillet(3).faces(">Z").workplane()
    plate = plate.rect(15, 10, forConstruction=True).vertices().hole(3)
    fine = [1.2, {"at": (0, 0, 2), "radius": 1, "size": 0.3}]
    figure, panels = plt.subplots(1, 3, figsize=(12, 4.2))
    draw(panels[0], cs.sweep_mesh(flange(6), source="<Z", size=0.5), "six holes: six mirrors")
    draw(panels[1], cs.sweep_mesh(flange(4), source="<Z", size=0.7), "four holes: four mirrors")
    draw(panels[2], cs.sweep_mesh(plate, source="<Z", size=fine), "fine around a place")
    figure.tight_layout()
    figure.savefig(HERE / "images" / "caps.png", dpi=80)
    wall = cq.Workplane().box(100, 60, 10)
    wall.faces("<X").tag("wall")
    fine = cs.sweep_mesh(wall, source=">Z", size=5, sizes={"wall": 1})
    bored = wall.faces(">Z").workplane().center(20, 10).hole(16)
    bored.faces("%CYLINDER").tag("bore")
    figure, panels = plt.subplots(1, 3, figsize=(12, 2.9))
    draw(panels[0], fine, '"wall": 1, at size 5')
    draw(panels[1], cs.sweep_mesh(bored, source=">Z", size=5, sizes={"wall": 1}), "the same with a bore")
    draw(panels[2], cs.sweep_mesh(bored, source=">Z", size=5, sizes={"bore": 1}), '"bore": 1, at size 5')
    figure.tight_layout()
    figure.savefig(HERE / "images" / "growth.png", dpi=80)


if __name__ == "__main__":
    main()
