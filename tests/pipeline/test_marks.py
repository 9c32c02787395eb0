"""Low embossing is left out of the mesh: within `bridge`, its names on the quads below it, and said so."""

import cadquery as cq
import numpy as np
import pytest

import cadsweep as cs
from cadsweep import cad
from cadsweep.pipeline.tips import HIGHER, HIGHER_NOTE, MARKS

SIZE = 2.0
HEIGHT = 0.05


def plate():
    return cq.Workplane().box(40, 30, 10).faces("<Z").workplane(centerOption="CenterOfBoundBox").hole(6)


def marked(height=HEIGHT, *, sunk=False):
    """A plate with a bore, and a bar and a ring that stand on it or are sunk into it."""
    up = -height if sunk else height
    marks = cq.Workplane("XY", (-12, 0, 5)).rect(3, 17).extrude(up)
    marks = marks.union(cq.Workplane("XY", (12, 0, 5)).circle(5).circle(3).extrude(up))
    return plate().cut(marks) if sunk else plate().union(marks)


@pytest.mark.parametrize("sunk", [False, True], ids=["embossed", "engraved"])
def test_the_mesh_is_that_of_the_plate_alone(sunk):
    mesh, alone = (cs.sweep_mesh(shape, size=SIZE) for shape in (marked(sunk=sunk), plate()))
    assert np.allclose(np.sort(mesh.points, axis=0), np.sort(alone.points, axis=0), atol=1e-9)
    assert MARKS in mesh.info["rows"]
    (note,) = [note for note in mesh.info["notes"] if note.startswith("marks flattened")]
    assert f"of at most {HEIGHT}, on face" in note


def test_what_is_higher_than_bridge_stays():
    part = cs.load(marked())
    assert len(cad.flatten_marks(part, 0.9 * HEIGHT).solids[0].faces) == len(part.solids[0].faces)
    assert cad.flatten_marks(part, 0.9 * HEIGHT) is part
    mesh = cs.sweep_mesh(marked(), size=SIZE, bridge=0)
    assert MARKS not in mesh.info["rows"]
    assert mesh.points[:, 2].max() == pytest.approx(5 + HEIGHT)


@pytest.fixture(scope="module")
def part_and_top():
    """The plate, and the number of the bar's top."""
    part = cs.load(marked())
    places = np.array([face.center for face in part.solids[0].faces]) * part.scale + part.offset
    return part, int(np.argmin(np.linalg.norm(places - (-12, 0, 5 + HEIGHT), axis=1)))


def test_names_of_marks_are_on_the_quads_below_them(part_and_top):
    part, top = part_and_top
    mesh = cs.sweep_mesh(part, size=1.0, bridge=1.01 * HEIGHT, names={"bar": top})
    middles = mesh.points[mesh.boundaries["bar"]].mean(axis=1)
    assert np.allclose(middles[:, 2], 5.0)
    assert np.all(np.abs(middles[:, 0] + 12) < 1.5)
    assert np.all(np.abs(middles[:, 1]) < 8.5)


def test_faces_and_edges_keep_the_numbers_that_they_had_with_marks(part_and_top):
    part, top = part_and_top
    flat = cad.flatten_marks(part, 1.01 * HEIGHT)
    old, new = part.solids[0], flat.solids[0]
    (below,) = cad.select_faces(flat, top)
    assert new.faces[below].center[2] * flat.scale + flat.offset[2] == pytest.approx(5.0)
    for kind, many, choose in (("face", old.faces, cad.select_faces), ("edge", old.edges, cad.select_edges)):
        left = getattr(new, f"{kind}s")
        assert [one.id for one in left] != [one.known for one in left]
        for one in left:
            assert choose(flat, f"{kind} {one.known}") == (one.id,)
            was = many[one.known]
            if kind == "edge":
                assert np.allclose(was.midpoint, one.midpoint)
            else:
                assert was.kind == one.kind


def test_holes_rims_contacts_and_imprints_are_no_marks():
    thin = cq.Workplane().box(40, 30, 0.04).faces(">Z").workplane().hole(6)
    patch = cs.load(plate().union(cq.Workplane("XY", (-12, 0, 0)).rect(8, 8).extrude(5), clean=False))
    assert len(patch.solids[0].faces) > len(cs.load(plate()).solids[0].faces)
    dimple = cs.load(plate().cut(cq.Workplane().sphere(2).translate((-12, 0, 5 + 2 - 1.5 * HEIGHT))))
    lid = cq.Assembly().add(plate(), name="plate")
    lid.add(cq.Workplane("XY", (12, 0, 5)).rect(8, 8).extrude(0.04), name="film")
    for part in (*map(cs.load, (thin, lid, plate())), patch, dimple):
        assert cad.flatten_marks(part, HEIGHT) is part


def test_marks_on_marks_and_on_cylinders():
    tower = marked().union(cq.Workplane("XY", (-12, 0, 5.05)).rect(1, 4).extrude(0.02))
    assert len(cad.flatten_marks(cs.load(tower), 0.1).solids[0].faces) == len(cs.load(plate()).solids[0].faces)
    shaft = cq.Workplane().circle(10).extrude(30)
    dot = cq.Workplane("XZ", (0, 10.05, 15)).circle(0.5).extrude(0.15)
    part = cs.load(shaft.union(dot))
    bare = cad.flatten_marks(part, 0.1)
    assert len(bare.solids[0].faces) < len(part.solids[0].faces)
    assert bare.models[0].volume * bare.scale**3 == pytest.approx(shaft.val().Volume(), rel=1e-6)


def lettered(depth):
    """A bored plate with a ring engraved on two sides: nothing sweeps it, and no columns fit it, but without these."""
    shape = plate()
    for plane, middle in (("XZ", (0, 15, 0)), ("YZ", (20 - depth, 0, 0))):
        shape = shape.cut(cq.Workplane(plane, middle).circle(3).circle(2).extrude(depth))
    return shape


QUICK = {"size": SIZE, "decompose": False, "fitted": False}


def test_higher_marks_are_flattened_rather_than_refused_and_said_so():
    mesh, alone = (cs.sweep_mesh(shape, **QUICK) for shape in (lettered(0.3), plate()))
    assert np.allclose(np.sort(mesh.points, axis=0), np.sort(alone.points, axis=0), atol=1e-9)
    assert HIGHER in mesh.info["rows"]
    assert any(note.startswith(HIGHER_NOTE) for note in mesh.info["notes"])
    like = cs.sweep_mesh(lettered(0.2), like=mesh)
    assert np.array_equal(like.hexes, mesh.hexes)
    assert np.allclose(like.points, mesh.points)


def test_a_mesh_with_flattened_marks_can_be_like_another_with_marks_only():
    mesh = cs.sweep_mesh(marked(), size=SIZE)
    like = cs.sweep_mesh(marked(0.5 * HEIGHT), like=mesh)
    assert {name: quads.tolist() for name, quads in like.boundaries.items()} == {
        name: quads.tolist() for name, quads in mesh.boundaries.items()
    }
    with pytest.raises(cs.CadError, match="has no patches, as of marks"):
        cs.sweep_mesh(plate(), like=mesh)


@pytest.mark.parametrize("asked", [{"bridge": 0}, {"bridge": 0.1}, {"tolerance": 0.1}, {"without": [HIGHER]}])
def test_higher_marks_stay_where_the_user_says_so(asked):
    with pytest.raises(cs.NotSweepableError):
        cs.sweep_mesh(lettered(0.3), **QUICK, **asked)


def test_what_is_high_for_the_part_is_no_mark_however_large_the_size():
    with pytest.raises(cs.NotSweepableError):
        cs.sweep_mesh(lettered(2.0), **{**QUICK, "size": 20.0})


def test_marks_stay_where_there_is_a_good_mesh_with_them():
    mesh = cs.sweep_mesh(marked(0.3), size=SIZE)
    assert HIGHER not in mesh.info["rows"]
    assert mesh.points[:, 2].max() == pytest.approx(5.3)
