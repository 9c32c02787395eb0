"""Every part of this folder, without a hint: recognised, counted and meshed, or refused as a sweep with a reason."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")

from cadsweep import load, sweep_mesh
from cadsweep.brief import MOST_LINES
from cadsweep.errors import CadError, NotSweepableError
from cadsweep.pipeline import attempts
from cadsweep.pipeline.attempts import open_and_find

from ..lone import assign_intervals

pytestmark = pytest.mark.cad

HERE = Path(__file__).parent
SWEEPABLE = sorted((HERE / "sweepable").glob("*.py"))
FLOORS = json.loads((HERE / "floors.json").read_text())
"""Worst scaled Jacobian that each part is promised: a tenth below what it reached when the floors were laid, in
twentieths. A part that is added gets its own; a floor is only ever raised."""
CORNERED = (
    "axis_wedge",
    "cone",
    "cross_drilled_bar",
    "crossing_holes",
    "hemisphere",
    "octahedron",
    "pyramid",
    "sphere",
    "t_pipe",
    "tetrahedron",
)
SHARP_OR_SMOOTH = ("flat_pyramid", "lens", "pebble")
"""Parts that cuts do not help either."""
NO_BODY = "touching_pockets"
"""The part that is no body, so that it is refused before a sweep is looked for."""
UNSWEEPABLE = [
    *sorted(path for path in (HERE / "unsweepable").glob("*.py") if path.stem != NO_BODY),
    *(HERE / "decomposed" / f"{name}.py" for name in CORNERED),
]


def name_of(path):
    """Test id."""
    return path.stem


def test_there_are_enough_parts():
    assert len(SWEEPABLE) >= 40
    assert len(UNSWEEPABLE) >= 15


@pytest.mark.parametrize("path", SWEEPABLE, ids=name_of)
def test_sweepable_part_is_recognised_and_meshed(path, monkeypatch):
    found = []
    monkeypatch.setattr(attempts, "open_and_find", lambda *args: found.append(open_and_find(*args)) or found[-1])
    mesh = sweep_mesh(load(path))
    report = mesh.info["quality"]
    assert report.n_inverted == 0
    assert report.min_scaled_jacobian >= FLOORS[path.stem]
    assert np.isclose(report.volume, mesh.info["cad_volume"], rtol=0.01)
    # Every candidate that recognition gave of the part itself, not only the one that was meshed.
    _, sweeps = found[0]
    for sweep in sweeps:
        roles = [*sweep.source, *sweep.target, *(side.face for side in sweep.linking_sides)]
        assert sorted(roles) == list(range(len(sweep.solid.faces)))
        counts = assign_intervals(sweep).counts
        for side in sweep.linking_sides:
            assert sum(counts[e] for e, _ in side.bottom) == sum(counts[e] for e, _ in side.top)
            assert sum(counts[e] for e, _ in side.left) == sum(counts[e] for e, _ in side.right)


@pytest.mark.parametrize(("name", "thickness"), [("drawn_box", 1.5), ("drawn_pan", 1.5), ("embossed_tray", 2.0)])
def test_a_sheet_is_swept_through_its_thickness_from_one_skin_to_the_other(name, thickness):
    mesh = sweep_mesh(load(HERE / "sweepable" / f"{name}.py"))
    (sweep,) = mesh.info["sweeps"]
    assert mesh.info["way"] == "sweep"
    assert len(sweep["source"]) == len(sweep["target"]) > 8
    # Whatever face of one skin a node is on, its column ends on the other skin, a thickness away.
    columns = mesh.points.reshape(sweep["layers"] + 1, -1, 3)
    across = np.linalg.norm(columns[-1] - columns[0], axis=1)
    assert across.min() > 0.99 * thickness
    assert np.median(across) < 1.05 * thickness


@pytest.mark.parametrize("path", UNSWEEPABLE, ids=name_of)
def test_unsweepable_part_is_refused_with_reasons(path):
    part = load(path)
    (solid,) = part.solids
    with pytest.raises(NotSweepableError) as caught:
        open_and_find(part, None, None)
    assert len(str(caught.value).splitlines()) <= MOST_LINES
    own, besides = caught.value.reasons[: len(solid.faces)], caught.value.reasons[len(solid.faces) :]
    for face, reason in zip(solid.faces, own, strict=True):
        assert reason.startswith(face.label())
    assert all(reason.startswith("with ") for reason in besides)


@pytest.mark.parametrize("name", SHARP_OR_SMOOTH)
def test_part_that_nothing_fits_is_refused_whole_with_the_cell_and_a_face(name):
    part = load(HERE / "unsweepable" / f"{name}.py")
    (solid,) = part.solids
    with pytest.raises(NotSweepableError) as caught:
        sweep_mesh(part)
    assert any(f"where: {face.label()}" in str(caught.value) for face in solid.faces)
    said = f"a cell at .* of {len(solid.faces)} faces has no sweep, though it has no re-entrant edge"
    assert any(re.match(said, reason) for reason in caught.value.reasons)


def test_pockets_that_touch_along_an_edge_are_no_body_and_the_edge_is_named():
    with pytest.raises(CadError, match=r"(?s)more than two faces meet at 1 of .* first at \(0, 0, 0\), where 4"):
        load(HERE / "unsweepable" / f"{NO_BODY}.py")
