"""Parts that no sweep and no columns fit: cut into cells that agree, each part no worse than its floor."""

import json
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")

from cadsweep import load, sweep_mesh

pytestmark = pytest.mark.cad

HERE = Path(__file__).parent
FLOORS = json.loads((HERE / "decomposed_floors.json").read_text())
"""Worst scaled Jacobian promised, in twentieths, a tenth below what was reached; ``benchmarks/parts.py`` meshes all
parts of the folder, the suite those that are quick."""


@pytest.mark.parametrize("name", FLOORS)
def test_part_is_meshed_no_worse_than_its_floor(name):
    (path,) = HERE.glob(f"*/{name}.py")
    part = load(path)
    mesh = sweep_mesh(part)
    report = mesh.info["quality"]
    assert report.valid, report.problems
    assert report.min_scaled_jacobian >= FLOORS[name]
    assert np.isclose(report.volume, mesh.info["cad_volume"], rtol=0.02)
    named = {face.name for face in part.solids[0].faces if face.name}
    assert named <= set(mesh.boundaries)
    # Every face of the model, and nothing of a cut, is in the boundaries.
    area = sum(face.area for face in part.solids[0].faces) * part.scale**2
    quads = np.concatenate(list(mesh.boundaries.values()))
    diagonals = mesh.points[quads[:, 2:]] - mesh.points[quads[:, :2]]
    assert np.isclose(np.linalg.norm(np.cross(*diagonals.swapaxes(0, 1)), axis=1).sum() / 2, area, rtol=0.02)
