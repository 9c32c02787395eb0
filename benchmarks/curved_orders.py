"""How fast meshes of order p come nearer to the CAD: curved_orders.py [--orders 1,2,3,4] [--json OUT]

A cylinder, an elbow, a blade and a shaft with steps and a cross bore, which is meshed as cells. A line a part and an
order: the farthest distance of the quads from the curved faces at places between their nodes, on meshes of three sizes,
and the slope between the two finest: p + 1 where the nodes lie as well as they can. The size is what was made where it
counts, by the distance of the straight sides, which is as its square: by the volume of a hexahedron the slopes of one
mesh would be 3.8, those of another 2.8, as much as their sides were refined more or less than their insides. Order 1 is
the straight-sided mesh, order 2 that of 27 nodes; of 20 the distance is up to three times as great.
"""

from __future__ import annotations

import argparse
import json
import logging
from collections.abc import Callable, Sequence
from pathlib import Path

import cadquery as cq
import numpy as np

import cadsweep as cs
from cadsweep.orders.elevate import elevate


def cylinder() -> cq.Workplane:
    """A plain one."""
    return cq.Workplane().circle(10).extrude(20)


def elbow() -> cq.Workplane:
    """A pipe's quarter turn."""
    return cq.Workplane().circle(6).circle(4).revolve(90, (20, 0, 0), (20, 1, 0))


def blade() -> cq.Workplane:
    """A twisted loft of splines."""
    section = [(0, 0), (5, 2.2), (12, 2.6), (20, 0.6), (12, 0.9), (5, 0.4)]

    def wire(turn: float, share: float, height: float) -> cq.Workplane:
        angle = np.radians(turn)
        spin = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        upper, lower = (np.array(points) @ spin * share for points in (section[:4], [*section[3:], section[0]]))
        plane = cq.Workplane(origin=(0, 0, height)).moveTo(*upper[0])
        return plane.spline(upper[1:].tolist(), includeCurrent=True).spline(lower[1:].tolist(), includeCurrent=True)

    wires = [wire(*own).close().val() for own in ((0, 1.0, 0), (12, 0.9, 15), (24, 0.8, 30))]
    return cq.Workplane(cq.Solid.makeLoft(wires))


def shaft() -> cq.Workplane:
    """Steps along an axis and a bore across."""
    turned = cq.Workplane().circle(10).extrude(12).faces(">Z").workplane().circle(6).extrude(12)
    return turned.cut(cq.Workplane("XZ").center(0, 6).circle(2.5).extrude(12, both=True))


PARTS: dict[str, tuple[Callable[[], cq.Workplane], tuple[float, ...]]] = {
    "cylinder": (cylinder, (5.0, 2.5, 1.25)),
    "elbow": (elbow, (2.4, 1.2, 0.6)),
    "blade": (blade, (2.0, 1.0, 0.5)),
    "shaft": (shaft, (3.0, 1.5, 0.75)),
}


def distances(
    part: cq.Workplane, sizes: Sequence[float], orders: Sequence[int]
) -> dict[int, list[tuple[float, float]]]:
    """Size made and distance, by order, on a mesh of each size; nested meshes would keep their first chords."""
    found: dict[int, list[tuple[float, float]]] = {order: [] for order in orders}
    for size in sizes:
        mesh = cs.sweep_mesh(part, size=size, allow_coarse=True)
        entities = mesh.origin.entities
        made = float(np.sqrt(mesh.info["distance"]))
        for order in orders:
            if order == 1:
                found[order].append((made, float(mesh.info["distance"])))
                continue
            bent = elevate(mesh, order=order, nodes=27, curves=entities.on_curves(), surfaces=entities.on_surfaces())
            found[order].append((made, float(bent.info["curved_distance"])))
    return found


def slope(rows: Sequence[tuple[float, float]]) -> float:
    """Power of the size with which the distance falls over the last two."""
    (coarse, far), (fine, near) = rows[-2:]
    return float(np.log(far / near) / np.log(coarse / fine))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--orders", default="1,2,3,4")
    parser.add_argument("--only", default="")
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    logging.disable(logging.WARNING)
    orders = [int(word) for word in arguments.orders.split(",")]
    table = {}
    for name, (make, sizes) in PARTS.items():
        if arguments.only not in name:
            continue
        for order, rows in distances(make(), sizes, orders).items():
            table[f"{name} {order}"] = {"sizes": rows, "slope": slope(rows)}
            print(
                f"{name:10s} order {order}  " + "  ".join(f"{d:9.2e}" for _, d in rows) + f"  slope {slope(rows):.2f}",
                flush=True,
            )
    if arguments.json:
        arguments.json.write_text(json.dumps(table, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
