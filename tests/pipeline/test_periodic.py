"""Matched faces: every node of the one has its image on the other, and files say so."""

import re
from math import cos, pi, sin

import numpy as np
import pytest

import cadsweep as cs
from cadsweep.errors import InputError, SurfaceMeshError
from cadsweep.pipeline.complexes.answering import CARRIED

pytestmark = pytest.mark.cad
cq = pytest.importorskip("cadquery")


def box():
    work = cq.Workplane().box(20, 10, 8).faces(">Z").workplane().center(3, 1).hole(4)
    for name, selector in {"left": "<X", "right": ">X", "low": "<Y", "high": ">Y", "floor": "<Z", "roof": ">Z"}.items():
        work.faces(selector).tag(name)
    return work


def sector(angle):
    """A piece of a ring with a hole, its ends `a` and `b`."""
    at = [
        (r * cos(t), r * sin(t)) for r, t in ((4, 0), (12, 0), (12, angle / 2), (12, angle), (4, angle), (4, angle / 2))
    ]
    work = cq.Workplane().moveTo(*at[0]).lineTo(*at[1]).threePointArc(at[2], at[3]).lineTo(*at[4])
    work = work.threePointArc(at[5], at[0]).close().extrude(3)
    work = work.cut(cq.Workplane().center(8 * cos(angle / 2), 8 * sin(angle / 2)).circle(1).extrude(3))
    for face in work.faces("%PLANE").vals():
        normal = face.normalAt()
        if abs(normal.z) < 1e-6:
            work.newObject([face]).tag("a" if abs(normal.x) < 1e-6 else "b")
    return work


def rotation(angle):
    return np.array([[cos(angle), -sin(angle), 0], [sin(angle), cos(angle), 0], [0, 0, 1]])


def check_pairs(mesh, key, matrix, shift):
    first, second = key.split("__")
    pairs = mesh.periodic[key]
    for column, name in enumerate((first, second)):
        assert sorted(pairs[:, column]) == np.unique(mesh.boundaries[name]).tolist()
    assert mesh.points[pairs[:, 0]] @ np.transpose(matrix) + shift == pytest.approx(mesh.points[pairs[:, 1]], abs=1e-9)


def test_sides_and_caps_answer_each_other_under_a_translation():
    mesh = cs.sweep_mesh(box(), size=1.7, source="floor", periodic={"left": "right", "low": "high", "roof": "floor"})
    check_pairs(mesh, "left__right", np.eye(3), (20, 0, 0))
    check_pairs(mesh, "low__high", np.eye(3), (0, 10, 0))
    check_pairs(mesh, "roof__floor", np.eye(3), (0, 0, -8))


def test_a_bias_on_the_one_is_a_bias_on_the_other():
    bias = {"edges:|Y and <X and <Z": {"towards": "<Y", "ratio": 5}}
    mesh = cs.sweep_mesh(box(), size=1.7, source="floor", biases=bias, periodic={"left": "right"})
    check_pairs(mesh, "left__right", np.eye(3), (20, 0, 0))
    right = mesh.points[np.unique(mesh.boundaries["right"])]
    steps = np.diff(np.unique(right[:, 1].round(9)))
    assert steps[-1] / steps[0] == pytest.approx(5)


@pytest.mark.parametrize("source", ["<Z", "a"])
def test_a_sector_is_matched_by_rotation_as_sides_and_as_caps(source):
    work = sector(pi / 3) if source == "<Z" else sector(pi / 3).intersect(cq.Workplane().circle(6.5).extrude(3))
    if source == "a":
        for face in work.faces("%PLANE").vals():
            normal = face.normalAt()
            if abs(normal.z) < 1e-6:
                work.newObject([face]).tag("a" if abs(normal.x) < 1e-6 else "b")
    mesh = cs.sweep_mesh(work, size=1.0, source=source, periodic={"a": "b"})
    check_pairs(mesh, "a__b", rotation(pi / 3), 0)
    fine = cs.refine(mesh)
    check_pairs(fine, "a__b", rotation(pi / 3), 0)


def tagged(work):
    for name, selector in {"left": "<X", "right": ">X", "low": "<Y", "high": ">Y", "floor": "<Z", "roof": ">Z"}.items():
        work.faces(selector).tag(name)
    return work


def test_half_a_ring_is_matched_by_half_a_turn_though_its_ends_are_one_plane():
    work = cq.Workplane("XZ").center(10, 0).rect(4, 6).revolve(180, (-10, 0, 0), (-10, 1, 0))
    for name, face in zip("ab", [f for f in work.faces("%PLANE").vals() if abs(f.normalAt().y) > 0.99], strict=True):
        work.newObject([face]).tag(name)
    check_pairs(cs.sweep_mesh(work, size=2, periodic={"a": "b"}), "a__b", rotation(pi), 0)


def test_walls_and_caps_of_a_stack_answer_each_other():
    """A boss and a pocket away from the walls, whose outlines the plane's quads follow unlike on both sides."""
    work = cq.Workplane().box(40, 30, 8).faces(">Z").workplane().center(3, 2).circle(6).extrude(10)
    work = tagged(work.faces("<Z").workplane().center(-8, -5).rect(9, 7).cutBlind(-3))
    place = {"at": (-20, 4, 4), "radius": 1, "size": 1.0}
    mesh = cs.sweep_mesh(work, size=[4, place], periodic={"left": "right", "low": "high"})
    check_pairs(mesh, "left__right", np.eye(3), (40, 0, 0))
    check_pairs(mesh, "low__high", np.eye(3), (0, 30, 0))
    with pytest.raises(InputError, match="no translation or rotation"):
        cs.sweep_mesh(work, size=4, periodic={"floor": "roof"})
    slot = tagged(cq.Workplane().box(40, 30, 8).faces(">Z").workplane().center(-15, 2).rect(10, 6).cutBlind(-3))
    with pytest.raises(InputError, match="no translation or rotation"):
        cs.sweep_mesh(slot, size=4, periodic={"left": "right"})


def test_cells_of_a_cut_part_answer_each_other():
    """Pieces of the matched faces belong to several cells; a cut across the corner divides them in other places."""
    mesh = cs.sweep_mesh(box(), size=2, cuts=["plane x=-4", "plane z=1"], periodic={"left": "right", "low": "high"})
    assert len(mesh.record.sweeps) == 4
    check_pairs(mesh, "left__right", np.eye(3), (20, 0, 0))
    check_pairs(mesh, "low__high", np.eye(3), (0, 10, 0))
    with pytest.raises(
        SurfaceMeshError, match=r"(?s)divides face \d+ 'low' .* of 'low' \(cell .*nothing divides 'high'.*cut"
    ):
        cs.sweep_mesh(box(), size=2, cuts=["plane 1,0.2,0,-6"], periodic={"low": "high"}, without=[CARRIED])
    slanted = cs.sweep_mesh(box(), size=2, cuts=["plane 1,0.2,0,-6"], periodic={"low": "high"})
    check_pairs(slanted, "low__high", np.eye(3), (0, 10, 0))


def test_a_representative_volume_of_two_solids_is_matched_and_stays_so_when_it_is_refined():
    fibre = cq.Workplane().circle(6).extrude(8)
    matrix = tagged(cq.Workplane().box(20, 20, 8, centered=(True, True, False)).cut(fibre))
    assembly = cq.Assembly()
    assembly.add(matrix, name="matrix")
    assembly.add(fibre, name="fibre")
    graded = {"edges:|Y and <X and <Z": {"towards": "<Y", "ratio": 3}}
    mesh = cs.sweep_mesh(assembly, size=3, periodic={"left": "right", "low": "high"}, biases=graded)
    for one in (mesh, cs.refine(mesh)):
        check_pairs(one, "matrix_left__matrix_right", np.eye(3), (20, 0, 0))
        check_pairs(one, "matrix_low__matrix_high", np.eye(3), (0, 20, 0))
    with pytest.raises(InputError, match="no face of any solid is called 'lefft'"):
        cs.sweep_mesh(assembly, size=3, periodic={"lefft": "right"})
    with pytest.raises(InputError, match="no face of any solid"):
        cs.sweep_mesh(assembly, size=3, periodic={"left": "77"})


def test_files_say_which_faces_are_periodic(tmp_path):
    mesh = cs.sweep_mesh(box(), size=2.5, source="floor", periodic={"left": "right"})
    folder = tmp_path / "polyMesh"
    mesh.write(folder)
    text = (folder / "boundary").read_text()
    for name, partner in (("left", "right"), ("right", "left")):
        assert re.search(rf"{name}\s*{{\s*type\s+cyclic;[^}}]*neighbourPatch\s+{partner};", text)
    ranges = {}
    for name in ("left", "right"):
        found = re.search(rf" {name}\s*{{[^}}]*nFaces\s+(\d+);\s*startFace\s+(\d+)", text)
        ranges[name] = [int(number) for number in found.groups()]
    rows = re.findall(r"^4\((\d+) (\d+) (\d+) (\d+)\)", (folder / "faces").read_text(), re.MULTILINE)
    faces = np.array(rows, dtype=int)
    left, right = (faces[start : start + count] for count, start in (ranges["left"], ranges["right"]))
    image = dict(mesh.periodic["left__right"].tolist())
    # Face by face, from the same node on, the other way round.
    assert [[image[n] for n in quad] for quad in left.tolist()] == right[:, [0, 3, 2, 1]].tolist()
    mesh.write(tmp_path / "part.msh", binary=False)
    text = (tmp_path / "part.msh").read_text()
    links = text[text.index("$Periodic") : text.index("$EndPeriodic")].splitlines()
    pairs = [tuple(map(int, line.split())) for line in links if len(line.split()) == 2]
    assert [(b - 1, a - 1) for a, b in pairs] == [tuple(pair) for pair in mesh.periodic["left__right"].tolist()]


def test_gmsh_knows_the_pairs_and_the_turn_between_them(tmp_path):
    import gmsh

    mesh = cs.sweep_mesh(sector(np.pi / 5), size=2.5, periodic={"a": "b"})
    mesh.write(tmp_path / "part.msh")
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.open(str(tmp_path / "part.msh"))
        found = [gmsh.model.mesh.getPeriodicNodes(2, tag) for _, tag in gmsh.model.getEntities(2)]
        (link,) = [each for each in found if len(each[1])]
        images, nodes = (np.array([gmsh.model.mesh.getNode(tag)[0] for tag in tags]) for tags in link[1:3])
    finally:
        gmsh.finalize()
    turn = np.reshape(link[3], (4, 4))[:3, :3]
    assert len(nodes) == len(mesh.periodic["a__b"])
    assert np.allclose(turn, rotation(np.pi / 5), atol=1e-12)
    assert np.abs(nodes @ turn.T - images).max() < 1e-12


def test_the_node_sets_of_exodus_list_pairs_in_one_order(tmp_path):
    from scipy.io import netcdf_file

    mesh = cs.sweep_mesh(box(), size=2.5, source="floor", periodic={"left": "right"})
    mesh.write(tmp_path / "part.e")
    with netcdf_file(tmp_path / "part.e", mmap=False) as file:
        names = [b"".join(row).strip(b"\0").decode() for row in file.variables["ns_names"].data]
        sets = {name: file.variables[f"node_ns{j}"].data - 1 for j, name in enumerate(names, 1)}
    assert np.column_stack([sets["left"], sets["right"]]).tolist() == mesh.periodic["left__right"].tolist()


def test_a_side_and_a_cap_of_a_sweep_answer_each_other():
    cube = cq.Workplane().box(2, 2, 2)
    mesh = cs.sweep_mesh(cube, source="<Z", target=">Z", size=0.5, periodic={"<X": ">Z"})
    (pairs,) = mesh.periodic.values()
    side, cap = mesh.points[pairs[:, 0]], mesh.points[pairs[:, 1]]
    assert len(pairs) == 25
    assert np.abs(side[:, 0] + 1.0).max() < 1e-12
    assert np.abs(cap[:, 2] - 1.0).max() < 1e-12
    apart = [np.linalg.norm(own[:, None] - own[None], axis=2) for own in (side, cap)]
    assert np.abs(apart[0] - apart[1]).max() < 1e-12, "the one is carried to the other by a motion"


def test_faces_that_cannot_be_matched_are_refused():
    with pytest.raises(InputError, match="no translation or rotation carries 'left' to 'high'"):
        cs.sweep_mesh(box(), source="floor", periodic={"left": "high"})
    with pytest.raises(InputError, match="No face matches 'lefft'"):
        cs.sweep_mesh(box(), periodic={"lefft": "right"})
    counts = {"edges:|Y and <X and <Z": 4, "edges:|Y and >X and <Z": 6}
    with pytest.raises(InputError, match="unlike counts"):
        cs.sweep_mesh(box(), source="floor", counts=counts, periodic={"left": "right"})


def test_a_sector_of_two_solids_is_cyclic_boundary_by_boundary(tmp_path):
    both = cq.Assembly(name="both")
    for name, low in (("disc", 0), ("hub", 3)):
        work = cq.Workplane(sector(pi / 5).val().translate((0, 0, low)))  # without its tags
        one = cq.Assembly(work, name=name)
        for side in work.faces("%PLANE").vals():
            normal = side.normalAt()
            if abs(normal.z) < 1e-6:
                one.addSubshape(side, name="left" if abs(normal.x) < 1e-6 else "right")
        both.add(one)
    mesh = cs.sweep_mesh(both, size=2, periodic={"left": "right"})
    (pairs,) = mesh.periodic.values()
    assert np.abs(mesh.points[pairs[:, 0]] @ rotation(pi / 5).T - mesh.points[pairs[:, 1]]).max() < 1e-12
    mesh.write(tmp_path / "polyMesh")
    text = (tmp_path / "polyMesh" / "boundary").read_text()
    for name, partner in (("left", "right"), ("right", "left")):
        for solid in ("disc", "hub"):
            assert re.search(rf"{solid}_{name}\s*{{\s*type\s+cyclic;[^}}]*neighbourPatch\s+{solid}_{partner};", text)
