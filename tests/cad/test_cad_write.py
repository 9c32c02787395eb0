"""Cells written to STEP come back as they are: solids, names, colours, shared faces; other programs see them touch."""

import subprocess
import sys

import numpy as np
import pytest

from cadsweep.errors import CadError

pytestmark = pytest.mark.cad


@pytest.fixture(scope="module")
def cq():
    return pytest.importorskip("cadquery")


@pytest.fixture(scope="module")
def pinned(cq):
    """A plate with a pin in its hole, a block on it, and a name on a face."""
    plate = cq.Workplane().box(6, 6, 2).faces(">Z").workplane().hole(2)
    plate.faces("<Z").tag("bottom")
    block = cq.Workplane().box(1, 1, 1).translate((2, 2, 1.5))
    pin = cq.Workplane().circle(1).extrude(3).translate((0, 0, -1))
    return (
        cq.Assembly(name="all")
        .add(plate, name="plate", color=cq.Color("red"))
        .add(block, name="block")
        .add(pin, name="pin")
    )


def keys_shared(part, kind):
    keys = [set(getattr(solid, f"{kind}_keys").tolist()) for solid in part.solids]
    return [[len(a & b) for b in keys] for a in keys]


@pytest.mark.parametrize("scale", [1.0, 1e-4])
def test_written_cells_are_read_again_with_what_they_share(cq, pinned, tmp_path, scale):
    from cadsweep.cad import load, write_step

    source = (
        pinned if scale == 1.0 else cq.Compound.makeCompound([s.scale(scale) for s in pinned.toCompound().Solids()])
    )
    part = load(source)
    path = tmp_path / "pieces.step"
    assert write_step(part, path) == [solid.name for solid in part.solids]
    again = load(path)
    assert [solid.name for solid in again.solids] == [solid.name for solid in part.solids]
    for kind in ("face", "edge", "vertex"):
        assert keys_shared(again, kind) == keys_shared(part, kind)
    for old, new in zip(part.solids, again.solids, strict=True):
        assert new.volume * again.scale**3 == pytest.approx(old.volume * part.scale**3, rel=1e-9)
        corners = [np.sort(p.to_model(s.vertices).round(9), axis=0) for p, s in ((part, old), (again, new))]
        assert corners[0] == pytest.approx(corners[1], abs=1e-9)


def test_names_and_colours_go_with_them(pinned, tmp_path):
    from cadsweep.cad import load, write_step

    part = load(pinned)
    write_step(part, tmp_path / "pieces.step")
    again = load(tmp_path / "pieces.step")
    assert again.models[0].color == "#ff0000"
    assert len({model.color for model in again.models}) == 3
    assert {name for face in again.solids[0].faces for name in face.names} == {"plate_bottom"}


FIRST = """
from OCP.Interface import Interface_Static
from cadsweep.cad.quiet import kernel_setting
with kernel_setting("write.stepcaf.subshapes.name", 1):
    print(Interface_Static.IVal_s("write.stepcaf.subshapes.name"))
"""


def test_settings_are_there_before_a_process_has_written_anything():
    # The command writes one file: without them, the names of its faces were lost.
    assert subprocess.run([sys.executable, "-c", FIRST], check=True, capture_output=True).stdout.strip() == b"1"


def test_faces_of_a_solid_that_is_placed_as_a_whole_keep_their_names(cq, tmp_path):
    from cadsweep.cad import load, write_step

    box = cq.Workplane().box(4, 3, 2)
    assert not box.val().wrapped.Location().IsIdentity()
    box.faces(">Z").tag("top")
    write_step(load(box), tmp_path / "box.step")
    again = load(tmp_path / "box.step")
    (top,) = (face for face in again.solids[0].faces if "top" in face.names)
    assert again.to_model(top.center) == pytest.approx([0, 0, 1], abs=1e-9)


def test_gmsh_and_cadquery_see_the_solids_touch(cq, pinned, tmp_path):
    gmsh = pytest.importorskip("gmsh")
    from cadsweep.cad import load, write_step

    path = tmp_path / "pieces.step"
    part = load(pinned)
    write_step(part, path)
    solids = cq.importers.importStep(str(path)).solids().vals()
    assert sum(solid.Volume() for solid in solids) == pytest.approx(sum(s.volume for s in part.solids), rel=1e-9)
    gmsh.initialize(interruptible=False, readConfigFiles=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.occ.importShapes(str(path))
        gmsh.model.occ.fragment(gmsh.model.occ.getEntities(3), [])
        gmsh.model.occ.synchronize()
        n_faces = len({int(key) for solid in part.solids for key in solid.face_keys})
        assert len(gmsh.model.getEntities(3)) == 3
        assert len(gmsh.model.getEntities(2)) == n_faces
    finally:
        gmsh.finalize()


def test_cells_without_a_shape_are_made_of_their_planes(cq, tmp_path):
    from dataclasses import replace

    from cadsweep.cad import load, write_step

    boxes = [cq.Workplane().box(2, 1, 1).translate((3 * j, 0, 0)) for j in range(2)]
    frame = cq.Workplane().box(1, 3, 3).faces(">X").workplane().rect(1, 1).cutThruAll().translate((1.5, 0, 0))
    part = load(cq.Compound.makeCompound([s for w in (*boxes, frame) for s in w.solids().vals()]))

    bare = replace(part, solids=tuple(replace(solid, kernel=None) for solid in part.solids))
    write_step(bare, tmp_path / "pieces.step")
    again = load(tmp_path / "pieces.step")
    assert keys_shared(again, "face") == keys_shared(part, "face")
    assert [solid.volume for solid in again.solids] == pytest.approx([solid.volume for solid in part.solids], rel=1e-12)


def test_where_a_file_cannot_be_written_nothing_is_left(pinned, tmp_path):
    from cadsweep.cad import load, write_step

    part = load(pinned)
    with pytest.raises(CadError, match="missing"):
        write_step(part, tmp_path / "missing" / "pieces.step")
    write_step(part, tmp_path / "pieces.step")
    assert [file.name for file in tmp_path.iterdir()] == ["pieces.step"]


def test_a_round_cell_without_a_shape_is_refused(cq, tmp_path):
    from dataclasses import replace

    from cadsweep.cad import load, write_step

    part = load(cq.Workplane().circle(1).extrude(1))
    bare = replace(part, solids=(replace(part.solids[0], kernel=None),))
    with pytest.raises(CadError, match="not plane"):
        write_step(bare, tmp_path / "pieces.step")
