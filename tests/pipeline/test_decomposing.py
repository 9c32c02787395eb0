"""Solids that no sweep fits are cut unasked, and their mesh is as good as any."""

import math

import numpy as np
import pytest

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")

import cadquery as cq

from cadsweep import cad, decompose, load, sweep_mesh
from cadsweep.errors import NotSweepableError
from cadsweep.options import SweepOptions
from cadsweep.pipeline.complexes.decomposing import mesh_decomposed
from cadsweep.pipeline.run import Run, silent

pytestmark = pytest.mark.cad


def cut_and_mesh(shape, **options):
    """Mesh by cells, also what could be meshed otherwise."""
    refused = NotSweepableError("asked for")
    return mesh_decomposed(load(shape), SweepOptions(**options), Run(on_progress=silent), refused)


def boxes_cross():
    """Three bars that cross in one place; every cell can be a box."""
    return cq.Workplane().box(30, 8, 8).union(cq.Workplane().box(8, 30, 8)).union(cq.Workplane().box(8, 8, 30))


def pockets_in_adjacent_sides():
    """A block with one pocket from above and one from a side."""
    block = cq.Workplane().box(20, 20, 20).faces(">Z").workplane().rect(10, 10).cutBlind(-6)
    return block.faces(">X").workplane(centerOption="CenterOfMass").rect(8, 6).cutBlind(-4)


def test_crossing_bars_are_cubes_all_through():
    mesh = cut_and_mesh(boxes_cross(), size=4.0)
    report = mesh.info["quality"]
    assert report.min_scaled_jacobian == pytest.approx(1.0)
    assert report.volume == pytest.approx(mesh.info["cad_volume"], rel=1e-12)
    # Seven cubes of 8 x 8 x 8 and six ends of 3 x 8 x 8 more: 2 layers of 4 in 8, 3 in the arms of 11.
    assert mesh.n_hexes == 2**3 + 6 * 3 * 2 * 2
    assert list(mesh.parts) == ["part"]


def test_pockets_in_two_sides_keep_their_faces():
    mesh = cut_and_mesh(pockets_in_adjacent_sides(), size=2.0)
    report = mesh.info["quality"]
    assert report.valid
    assert report.min_scaled_jacobian > 0.3
    assert any(note.startswith("cut ") for note in mesh.info["notes"])
    quads = np.concatenate(list(mesh.boundaries.values()))
    p = mesh.points[quads]
    area = 0.5 * np.linalg.norm(np.cross(p[:, 2] - p[:, 0], p[:, 3] - p[:, 1]), axis=1).sum()
    # a cube's six faces, and the walls of a pocket of 10 x 10 x 6 and of one of 8 x 6 x 4
    assert area == pytest.approx(6 * 400 + 4 * 60 + 2 * (8 + 6) * 4, rel=1e-9)


def rotated_pockets():
    """A block with a pocket in each of two sides, neither square to its edges: no stack in any direction."""
    block = cq.Workplane().box(20, 20, 20)
    for face, angle, place in ((">X", 20, (0, 5)), (">Y", 30, (0, -5))):
        work = block.faces(face).workplane(centerOption="CenterOfMass").center(*place)
        block = work.transformed(rotate=(0, 0, angle)).rect(7, 5).cutBlind(-4)
    return block


def test_a_block_with_rotated_pockets_is_cut_unasked():
    mesh = sweep_mesh(rotated_pockets(), size=2.0)
    assert mesh.info["quality"].valid
    assert any(note.startswith("cut ") for note in mesh.info["notes"])


def test_a_flange_with_a_full_round_around_it_is_parted_from_its_rim():
    profile = cq.Workplane("XZ").lineTo(20, 0).threePointArc((23, 3), (20, 6)).lineTo(0, 6).close()
    flange = profile.revolve(360, (0, 0, 0), (0, 1, 0)).faces(">Z").workplane().polygon(6, 24).extrude(10)
    mesh = sweep_mesh(flange.faces(">Z").workplane().hole(12), size=2.0)
    # Where a cap or a wall took half of the rounding two quads of a hexahedron would lie in one plane: below 0.1.
    assert (mesh.info["way"], mesh.info["quality"].valid) == ("cells", True)
    assert mesh.info["quality"].min_scaled_jacobian > 0.5


def test_poor_cells_are_cut_again_before_they_are_smoothed():
    # The flange has a sweep between its flat and its conical side, whose round rim is tangent to both.
    lean = math.radians(25)
    end = (18 + 1.5 * math.sin(lean), 1.5 + 1.5 * math.cos(lean))
    top = end[1] + (end[0] - 9) * math.tan(lean)
    profile = (
        cq.Workplane("XZ").lineTo(18, 0).threePointArc((18 + 1.5 * math.cos(0.35), 1.5 - 1.5 * math.sin(0.35)), end)
    )
    flange = profile.lineTo(9, top).lineTo(0, top).close().revolve(360, (0, 0, 0), (0, 1, 0))
    bolt = flange.union(cq.Workplane().polygon(6, 24).extrude(20)).union(cq.Workplane().circle(6).extrude(-20))
    mesh = sweep_mesh(bolt)
    assert mesh.info["quality"].valid
    assert "cut: poor cells again" in mesh.info["rows"]
    assert mesh.info["quality"].min_scaled_jacobian > 0.4, "0.31 at best where its cells are smoothed"


def test_what_is_asked_of_one_sweep_is_refused_as_before():
    with pytest.raises(NotSweepableError, match="no pair of its"):
        sweep_mesh(boxes_cross(), source=0)


def test_cells_beside_a_rounding_can_be_written(tmp_path):
    # Meshed they have caps that are joined to their roundings, which no file can say.
    block = cq.Workplane().box(60, 40, 30).edges("|Z").fillet(8).faces(">Z").edges().fillet(3)
    cq.exporters.export(
        block.cut(cq.Workplane("XZ", origin=(0, 20, 0)).circle(6).extrude(40)), str(tmp_path / "a.step")
    )
    part = load(tmp_path / "a.step")
    cells = decompose(part)
    assert len(cells.solids) > 1
    cad.write_step(cells, tmp_path / "cells.step")
    again = load(tmp_path / "cells.step")
    volume = sum(solid.volume for solid in again.solids) * again.scale**3
    volume = sum(solid.volume for solid in again.solids) * again.scale**3
    assert np.isclose(volume, part.solids[0].volume * part.scale**3, rtol=1e-5)
