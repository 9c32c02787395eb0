"""Two meshes in one deck: numbers, names and element types as asked for, tied where they touch, and solved."""

from __future__ import annotations

import shutil
import subprocess

import pytest

import cadsweep as cs

from .calculix import require_calculix

pytestmark = [pytest.mark.solver, pytest.mark.cad]

DECK = """*INCLUDE, INPUT=low.inp
*INCLUDE, INPUT=high.inp
*MATERIAL, NAME=S
*ELASTIC
210000., 0.
*MATERIAL, NAME=B
*ELASTIC
105000., 0.
*SOLID SECTION, ELSET=A_material_steel, MATERIAL=S
*SOLID SECTION, ELSET=B_material_brass, MATERIAL=B
*TIE, NAME=T
B_below, A_above
*STEP
*STATIC
*BOUNDARY
A_foot, 1, 3
*DSLOAD
B_head, P, -100.
*NODE PRINT, NSET=B_head
U
*END STEP
"""


def block(height, below, above, material):
    import cadquery as cq

    work = cq.Workplane().box(10, 10, 10, centered=False).translate((0, 0, height))
    work.faces("<Z").tag(below)
    work.faces(">Z").tag(above)
    work.solids().tag(f"mat:{material}")
    return work


@pytest.mark.parametrize("element", ["C3D8", "C3D8I", "C3D8R", "C3D20R"])
def test_a_tied_bar_of_two_decks_is_pulled(tmp_path, element):
    """u = s h / E1 + s h / E2, without Poisson's effect; brass is half as stiff as steel."""
    require_calculix()
    pytest.importorskip("cadquery")
    order = 2 if element == "C3D20R" else 1
    low = cs.sweep_mesh(block(0, "foot", "above", "steel"), size=5.0, layers=2, order=order)
    high = cs.sweep_mesh(block(10, "below", "head", "brass"), size=5.0, layers=2, order=order)
    low.write(tmp_path / "low.inp", element=element, prefix="A_")
    high.write(tmp_path / "high.inp", element=element, prefix="B_", first_node=1001, first_element=501)
    (tmp_path / "deck.inp").write_text(DECK)
    said = subprocess.run(
        [str(shutil.which("ccx")), "deck"], cwd=tmp_path, capture_output=True, text=True, check=False, timeout=60
    )
    rows = [line.split() for line in (tmp_path / "deck.dat").read_text().splitlines()]
    moved = [float(row[3]) for row in rows if len(row) == 4 and row[0].isdecimal()]
    assert len(moved) == (9 if order == 1 else 21), said.stdout[-500:]
    assert min(int(row[0]) for row in rows if len(row) == 4 and row[0].isdecimal()) > 1000
    assert moved == pytest.approx([100 * 10 / 210000 + 100 * 10 / 105000] * len(moved), rel=1e-5)
