"""OpenFOAM's checkMesh on small meshes; ``scripts/check_openfoam.py`` does the same for every model."""

from __future__ import annotations

import importlib.util
import math
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

from ..io.io_meshes import bent_box, box, twisted_box  # noqa: E402

pytestmark = pytest.mark.solver


@pytest.fixture(scope="module")
def openfoam():
    spec = importlib.util.spec_from_file_location("check_openfoam", ROOT / "scripts" / "check_openfoam.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    if not module.find_openfoam():
        pytest.skip("OpenFOAM (gmshToFoam, checkMesh) is missing: apt-get install openfoam")
    return module


@pytest.mark.parametrize("make", [box, twisted_box, lambda: bent_box(8)], ids=["box", "twisted", "bent"])
def test_mesh_ok(openfoam, tmp_path, make):
    mesh = make()
    del mesh.boundaries["walls"]  # one patch a face; the next test has them
    assert openfoam.check(mesh, tmp_path) == []


def test_overlapping_names_become_groups_of_patches(openfoam, tmp_path):
    from cadsweep import io

    case = openfoam.make_case(tmp_path / "case")
    io.write(box(), case / "constant" / "polyMesh")
    assert "Mesh OK." in openfoam.run(case, "checkMesh")
    patches = (case / "constant" / "polyMesh" / "boundary").read_text()
    assert patches.count("1(walls)") == 4


def test_checkmesh_is_not_content_with_everything(openfoam, tmp_path):
    """The check can fail: a hex turned inside out is seen."""
    mesh = box()
    mesh.points[mesh.hexes[7, 6]] += [0.0, 0.0, -2.0]
    assert openfoam.check(mesh, tmp_path) != []


@pytest.mark.parametrize("angle", [None, 0.6], ids=["translation", "rotation"])
def test_periodic_faces_are_coupled_face_by_face(openfoam, tmp_path, angle):
    """Both patches list answering faces from answering nodes on: checkMesh sees that, and where two changed places.

    Across a translation it does not: it takes every face's own distance from its partner for what is between them.
    """
    import cadsweep

    from ..pipeline.test_periodic import box as plain_box
    from ..pipeline.test_periodic import sector

    work, (one, other) = (plain_box(), ("left", "right")) if angle is None else (sector(angle), ("a", "b"))
    mesh = cadsweep.sweep_mesh(work, size=2.5, periodic={one: other})
    case = openfoam.make_case(tmp_path / "case")
    folder = case / "constant" / "polyMesh"
    mesh.write(folder)
    said = openfoam.run(case, "checkMesh", "-allTopology")
    assert "Mesh OK." in said
    assert "Coupled point location match" in said
    if angle is None:
        return
    start = int(re.search(rf" {other}\s*{{[^}}]*startFace\s+(\d+)", (folder / "boundary").read_text())[1])
    for name in ("faces", "owner"):
        lines = (folder / name).read_text().split("\n")
        first = lines.index("(") + 1 + start
        lines[first], lines[first + 1] = lines[first + 1], lines[first]
        (folder / name).write_text("\n".join(lines))
    assert "Error in coupled point location" in openfoam.run(case, "checkMesh")


@pytest.mark.parametrize(("tip", "degrees"), [(False, 25), (True, 12)], ids=["wedge", "tip"])
def test_layers_at_sharp_corners_are_not_skew(openfoam, tmp_path, tip, degrees):
    """Segments beside the corner are short enough for the faces that the cells on both sides of it share."""
    import cadquery as cq

    import cadsweep

    from ..pipeline.test_walls import around_a_blade, walled

    high = 30 * math.tan(math.radians(degrees))
    work = walled(cq.Workplane().polyline([(0, 0), (30, 0), (30, high)]).close().extrude(6))
    name, work = ("blade", around_a_blade(degrees)) if tip else ("wall", work)
    mesh = cadsweep.sweep_mesh(work, size=2, wall_layers={name: cadsweep.WallLayers(first=0.05, growth=1.2, n=8)})
    case = openfoam.make_case(tmp_path / "case")
    mesh.write(case / "constant" / "polyMesh")
    assert "Mesh OK." in openfoam.run(case, "checkMesh")


def test_zones_of_an_assembly(openfoam, tmp_path):
    """Parts are cell zones, the interface a face zone, for checkMesh as for us."""
    from cadsweep import io

    from ..io.test_io_options import two_solids

    case = openfoam.make_case(tmp_path / "case")
    io.write(two_solids(), case / "constant" / "polyMesh", patch_types={"source": "wall"})
    said = openfoam.run(case, "checkMesh", "-allGeometry")
    assert "Mesh OK." in said
    assert "face zones:       1" in said
    assert "cell zones:       2" in said


def test_fluent_files_are_read_by_openfoam(openfoam, tmp_path):
    import shutil

    import numpy as np

    from cadsweep import io

    from ..io.test_io_options import two_solids

    if shutil.which("fluent3DMeshToFoam") is None:
        pytest.skip("fluent3DMeshToFoam is missing")
    mesh = two_solids()
    case = openfoam.make_case(tmp_path / "case")
    io.write(mesh, case / "mesh.msh", version="fluent")
    openfoam.run(case, "fluent3DMeshToFoam", str(case / "mesh.msh"))
    back = io.read(case / "constant" / "polyMesh")
    assert back.quality().valid
    assert back.quality().volume == pytest.approx(mesh.quality().volume, rel=1e-12)
    disjoint = {name: len(quads) for name, quads in mesh.boundaries.items() if name != "walls"}
    assert {name: len(quads) for name, quads in back.boundaries.items()} == disjoint
    assert {name: len(ids) for name, ids in back.parts.items()} == {"low": 12, "high": 12}
    zones = (case / "constant" / "polyMesh" / "faceZones").read_text()
    assert "low__high" in zones
    for name, quads in back.boundaries.items():
        there = back.points[quads].mean(axis=(0, 1))
        assert np.allclose(there, mesh.points[mesh.boundaries[name]].mean(axis=(0, 1)))
