"""What the command line says of how a part was filled: in the numbers and names of the part, not of its cells."""

from pathlib import Path

import cadquery as cq
import pytest

import cadsweep as cs
from cadsweep.cli.show import mesh_lines

from ..commands import exit_code


@pytest.fixture(scope="module")
def angle() -> cq.Workplane:
    """A plate with a wall on it, and a bore through each."""
    base = cq.Workplane().box(30, 20, 5, centered=(True, True, False)).faces(">Z").workplane().center(0, -4).hole(5)
    return base.union(cq.Workplane().box(30, 5, 25, centered=(True, False, False)).translate((0, 5, 0)))


def test_caps_of_cells_are_faces_of_the_part_or_cuts(angle: cq.Workplane) -> None:
    part = cs.load(angle)
    cut = cs.sweep_mesh(part, size=4.0, cuts=["plane z=5"])
    (z,) = [face.id for face in part.solids[0].faces if abs(face.center[2]) < 1e-9]
    caps = [cap for sweep in cut.info["sweeps"] for end in ("source", "target") for cap in sweep[end]]
    assert z in caps
    assert all(cap == "a cut" or cap in range(len(part.solids[0].faces)) for cap in caps)


def test_cells_that_are_filled_alike_are_counted() -> None:
    alike = {"source": [1], "target": ["a cut", "a cut"], "layers": 4, "solid": "a"}
    summary = {
        "seconds": {},
        "n_hexes": 1,
        "n_nodes": 8,
        "min_scaled_jacobian": 1.0,
        "mean_scaled_jacobian": 1.0,
        "n_inverted": 0,
        "cad_volume": None,
        "sweeps": [alike, alike, {"corners": 3, "solid": "a"}],
    }
    assert mesh_lines(summary, "x.vtu")[2:] == [
        "sweep: 1 to a cut, 4 layers, 2 cells",
        "cell: a block of hexahedra at each of 3 corners",
    ]
    summary["sweeps"] = [alike, alike | {"solid": "b"}]
    assert mesh_lines(summary, "x.vtu")[2:] == [
        "sweep: 'a', 1 to a cut, 4 layers",
        "sweep: 'b', 1 to a cut, 4 layers",
    ]

    columns = {"source": [0], "target": ["top", 7], "layers": 9, "columns": 5, "direction": "0, 0, 1"}
    summary["sweeps"] = [columns]
    assert mesh_lines(summary, "x.vtu")[2:] == ["stack along (0, 0, 1): 5 columns, 0 to top, 7, 9 layers"]


def test_info_says_what_happens_to_a_part_without_sweep(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "angle.step"
    crossed = cq.Workplane().box(20, 20, 20)
    for axis, middle in (("XY", (6, 0)), ("XZ", (-6, 0)), ("YZ", (-6, 6))):
        crossed = crossed.cut(cq.Workplane(axis).center(*middle).circle(2).extrude(15, both=True))
    cq.exporters.export(crossed, str(path))
    assert exit_code(["info", str(path)], monkeypatch) == 0
    assert "'cadsweep mesh' tries to cut it into cells that sweep" in " ".join(capsys.readouterr().out.split())
