"""Every part of this folder, without a hint: recognised, counted and meshed, or refused as a sweep with a reason."""

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")

from cadsweep import load, sweep_mesh
from cadsweep.errors import NotSweepableError
from cadsweep.intervals import assign_intervals
from cadsweep.pipeline.attempts import open_and_find

pytestmark = pytest.mark.cad

HERE = Path(__file__).parent
SWEEPABLE = sorted((HERE / "sweepable").glob("*.py"))
FLOORS = json.loads((HERE / "floors.json").read_text())
"""Worst scaled Jacobian that each part is promised: a tenth below what it reached when the floors were laid, in
twentieths. A part that is added gets its own; a floor is only ever raised."""
CORNERED = ("axis_wedge", "cone", "hemisphere", "octahedron", "pyramid", "sphere", "tetrahedron")
UNSWEEPABLE = [*sorted((HERE / "unsweepable").glob("*.py")), *(HERE / "decomposed" / f"{name}.py" for name in CORNERED)]


@cache
def part_of(path):
    """Load a script once for all tests."""
    return load(path)


def name_of(path):
    """Test id."""
    return path.stem


def test_there_are_enough_parts():
    assert len(SWEEPABLE) >= 40
    assert len(UNSWEEPABLE) >= 12


@pytest.mark.parametrize("path", SWEEPABLE, ids=name_of)
def test_sweepable_part_is_recognised(path):
    for sweep in open_and_find(part_of(path), None, None)[1]:
        roles = [*sweep.source, *sweep.target, *(side.face for side in sweep.linking_sides)]
        assert sorted(roles) == list(range(len(sweep.solid.faces)))
        found = assign_intervals(sweep)
        for side in sweep.linking_sides:
            assert sum(found.counts[e] for e, _ in side.bottom) == sum(found.counts[e] for e, _ in side.top)
            assert sum(found.counts[e] for e, _ in side.left) == sum(found.counts[e] for e, _ in side.right)


@pytest.mark.parametrize("path", SWEEPABLE, ids=name_of)
def test_sweepable_part_is_meshed(path):
    mesh = sweep_mesh(part_of(path))
    report = mesh.info["quality"]
    assert report.n_inverted == 0
    assert report.min_scaled_jacobian >= FLOORS[path.stem]
    assert np.isclose(report.volume, mesh.info["cad_volume"], rtol=0.01)


@pytest.mark.parametrize("path", UNSWEEPABLE, ids=name_of)
def test_unsweepable_part_is_refused_with_reasons(path):
    (solid,) = part_of(path).solids
    with pytest.raises(NotSweepableError) as caught:
        open_and_find(part_of(path), None, None)
    assert "\n" not in str(caught.value)
    own, besides = caught.value.reasons[: len(solid.faces)], caught.value.reasons[len(solid.faces) :]
    for face, reason in zip(solid.faces, own, strict=True):
        assert reason.startswith(face.label())
    assert all(reason.startswith("with ") for reason in besides)
