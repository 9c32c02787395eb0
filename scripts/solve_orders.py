"""Does a mesh of order p solve as it should? solve_orders.py [--orders 1-6] [--json OUT]

Needs PyMFEM (pip install mfem), which solves Poisson's equation on a piece of a pipe elbow, with a solution that is
zero on the pipe's walls and with elements of order p, on a mesh and on the same refined once. On meshes of order p the
error in the mean square falls with the power p + 1 of the size; on those of straight sides the walls are not where the
solution is zero, and it falls with the power 2, whatever the order of the elements. A line an order: both errors and
the power, curved and straight.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from pathlib import Path
from typing import Any

import cadquery as cq
import mfem.ser as mfem
import numpy as np

import cadsweep as cs
from cadsweep.mesh import HexMesh
from cadsweep.orders.elevate import elevate

BEND, INNER, OUTER = 10.0, 3.0, 6.0
"""Radius of the bend about the line x = BEND along y, and of the pipe's walls."""


class _Exact(mfem.PyCoefficient):
    """(g - a)(b - g) of the square g of the distance from the pipe's centre line, over its greatest value."""

    def EvalValue(self, place: Any) -> float:  # noqa: N802
        """At a place (x, y, z)."""
        along = np.hypot(place[0] - BEND, place[2]) - BEND
        g = along * along + place[1] * place[1]
        return float((g - INNER**2) * (OUTER**2 - g) / ((OUTER**2 - INNER**2) / 2) ** 2)


class _Load(mfem.PyCoefficient):
    """Minus the Laplacian of that."""

    def EvalValue(self, place: Any) -> float:  # noqa: N802
        """At a place (x, y, z)."""
        radius = np.hypot(place[0] - BEND, place[2])
        along = radius - BEND
        g = along * along + place[1] * place[1]
        slope = INNER**2 + OUTER**2 - 2.0 * g
        laplacian = -8.0 * g + 4.0 * slope + 2.0 * slope * along / radius
        return float(-laplacian / ((OUTER**2 - INNER**2) / 2) ** 2)


def error(mesh: HexMesh, order: int) -> float:
    """Error in the mean square of the solution with elements of an order on a mesh of any."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "elbow.mesh"
        mesh.write(file)
        read = mfem.Mesh(str(file), 1, 1)
    # Attributes of boundaries stand in the mesh's order; the ends of the elbow are free.
    names = list(mesh.boundaries)
    walls = mfem.intArray([int(name.startswith("side")) for name in names])
    space = mfem.FiniteElementSpace(read, mfem.H1_FECollection(order, 3))
    fixed = mfem.intArray()
    space.GetEssentialTrueDofs(walls, fixed)
    rule = mfem.IntRules.Get(mfem.Geometry.CUBE, 2 * order + 3)
    load, exact = _Load(), _Exact()
    right = mfem.LinearForm(space)
    part = mfem.DomainLFIntegrator(load)
    part.SetIntRule(rule)
    right.AddDomainIntegrator(part)
    right.Assemble()
    left = mfem.BilinearForm(space)
    left.SetAssemblyLevel(mfem.AssemblyLevel_PARTIAL)
    left.AddDomainIntegrator(mfem.DiffusionIntegrator(mfem.ConstantCoefficient(1.0)))
    left.Assemble()
    found = mfem.GridFunction(space)
    found.Assign(0.0)
    system, unknown, known = mfem.OperatorPtr(), mfem.Vector(), mfem.Vector()
    left.FormLinearSystem(fixed, found, right, system, unknown, known)
    mfem.PCG(system.Ptr(), mfem.OperatorJacobiSmoother(left, fixed), known, unknown, 0, 4000, 1e-22, 0.0)
    left.RecoverFEMSolution(unknown, right, found)
    return float(found.ComputeL2Error(exact))


def rates(orders: list[int]) -> dict[int, dict[str, float]]:
    """Errors on the coarse and the fine mesh, curved and straight, and the powers of the size."""
    elbow = cq.Workplane().circle(OUTER).circle(INNER).revolve(30, (BEND, 0, 0), (BEND, 1, 0))
    coarse = cs.sweep_mesh(elbow, size=2.0, layers=2, allow_coarse=True)
    meshes = [coarse, cs.refine(coarse, 1)]
    found = {}
    for order in orders:
        row = {}
        for kind in ("curved", "straight"):
            pair = []
            for mesh in meshes:
                on = mesh.origin.entities
                is_bent = kind == "curved" and order > 1
                bent = (
                    elevate(mesh, order=order, curves=on.on_curves(), surfaces=on.on_surfaces(), nodes=27)
                    if is_bent
                    else mesh
                )
                pair.append(error(bent, order))
            row |= {f"{kind} coarse": pair[0], f"{kind} fine": pair[1]}
            row[f"{kind} power"] = float(np.log2(pair[0] / pair[1]))
        found[order] = row
    return found


def main() -> None:
    """Solve and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--orders", default="1-6")
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    first, _, last = arguments.orders.partition("-")
    table = rates(list(range(int(first), int(last or first) + 1)))
    for order, row in table.items():
        words = (
            f"{kind} {row[f'{kind} coarse']:.2e} {row[f'{kind} fine']:.2e} power {row[f'{kind} power']:.2f}"
            for kind in ("curved", "straight")
        )
        print(f"order {order}  " + "   ".join(words))
    if arguments.json:
        arguments.json.write_text(json.dumps(table, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
