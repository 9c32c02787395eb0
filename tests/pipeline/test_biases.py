"""Graded edges: the ratio or first length that is asked for stands on the mesh, and what answers the edge follows."""

import re

import numpy as np
import pytest

import cadsweep as cs
from cadsweep.errors import InputError

pytestmark = pytest.mark.cad
cq = pytest.importorskip("cadquery")


def steps(mesh, axis, /, **at):
    """Lengths between the nodes on a line along an axis, the other two coordinates given."""
    place = dict(zip("xyz", mesh.points.T, strict=True))
    on = np.all([np.abs(place[name] - value) < 1e-6 for name, value in at.items()], axis=0)
    return np.diff(np.sort(place[axis][on]))


def is_geometric(lengths):
    return np.allclose(lengths[1:] / lengths[:-1], lengths[1] / lengths[0], rtol=1e-6)


@pytest.fixture(scope="module")
def plate():
    return cq.Workplane().box(100, 20, 10).faces(">Z").workplane().hole(8)


def test_the_ratio_is_kept_towards_a_face_and_followed_on_the_other_cap_and_around_the_hole(plate):
    mesh = cs.sweep_mesh(
        plate,
        size=3,
        layers=7,
        source="<Z",
        biases={
            "edges:|X and <Z": {"towards": "<X", "ratio": 5},
            "edges:|Z and >X and >Y": {"towards": ">Z", "ratio": 3},
        },
    )
    for z in (-5, 5):  # named at the bottom, answered at the top
        for y in (-10, 10):
            along = steps(mesh, "x", y=y, z=z)
            assert along[-1] / along[0] == pytest.approx(5)
            assert is_geometric(along)
    rails = [steps(mesh, "z", x=x, y=y) for x in (-50, 50) for y in (-10, 10)]
    around = np.abs(np.hypot(*mesh.points.T[:2]) - 4) < 1e-6
    rails.append(np.diff(np.unique(mesh.points[around, 2].round(9))))
    for up in rails:
        assert up[0] / up[-1] == pytest.approx(3)
        assert len(up) == 7


def test_a_first_length_is_kept_from_one_end_and_from_both():
    box = cq.Workplane().box(100, 20, 10)
    for towards, ends in ((">X", [-1]), ("both", [0, -1])):
        mesh = cs.sweep_mesh(box, size=5, biases={"edges:|X": {"towards": towards, "first": 0.5}})
        along = steps(mesh, "x", y=10, z=5)
        assert along[ends] == pytest.approx(0.5)
        assert len(along) == 20


def test_the_middle_and_points_and_vertices_are_places_to_go_towards():
    box = cq.Workplane().box(100, 20, 10)
    middle = steps(cs.sweep_mesh(box, size=5, biases={"edges:|X": {"towards": "middle", "ratio": 4}}), "x", y=10, z=5)
    assert middle == pytest.approx(middle[::-1])
    assert np.argmin(middle) in (9, 10)
    assert middle[0] / middle.min() == pytest.approx(4)  # also where the middle is a node
    for count in (19, 20):
        counts = {"edges:|X": count}
        ends = cs.sweep_mesh(box, size=5, counts=counts, biases={"edges:|X": {"towards": "both", "ratio": 5}})
        both = steps(ends, "x", y=10, z=5)
        assert both == pytest.approx(both[::-1])
        assert (len(both), both.max() / both[0]) == (count, pytest.approx(5))
    for towards in ((49, 0, 0), "vertices:>X", "faces:>X"):
        along = steps(cs.sweep_mesh(box, size=5, biases={"edges:|X": {"towards": towards, "ratio": 4}}), "x", y=10, z=5)
        assert along[0] / along[-1] == pytest.approx(4)


def test_grading_along_a_bend_is_by_arc_length_on_every_rail():
    elbow = cq.Workplane().rect(6, 4).revolve(90, (-20, 0, 0), (-20, 1, 0))
    mesh = cs.sweep_mesh(elbow, size=2, layers=12, biases={"edges:%CIRCLE": {"towards": "<Z", "ratio": 6}})
    angle = np.arctan2(mesh.points[:, 2], mesh.points[:, 0] + 20)
    each = np.diff(np.unique(np.abs(angle).round(7)))
    assert each[1:] / each[:-1] == pytest.approx(np.full(11, each[1] / each[0]), rel=1e-4)
    assert max(each[0], each[-1]) / min(each[0], each[-1]) == pytest.approx(6, rel=1e-4)


@pytest.mark.parametrize("kind", ["columns", "touching", "cut"])
def test_parts_of_several_blocks_are_graded_too(kind):
    options = {}
    part = cq.Workplane().box(60, 40, 20)
    if kind == "columns":
        part = part.faces(">Z").workplane().rect(30, 20).cutBlind(-8).faces(">Z").workplane()
        part = part.center(-24, 0).rect(6, 20).extrude(5)
    elif kind == "touching":
        other = cq.Workplane().box(60, 40, 6).translate((0, 0, 13))
        part = cq.Assembly().add(part, name="low").add(other, name="up")
    else:
        options["cuts"] = ["plane z=2"]
    mesh = cs.sweep_mesh(part, size=4, biases={"edges:|X": {"towards": "<X", "ratio": 4}}, **options)
    along = steps(mesh, "x", y=20, z=-10)
    assert along[-1] / along[0] == pytest.approx(4)
    assert is_geometric(along)
    assert len(along) > 10
    assert mesh.info["quality"].valid


@pytest.mark.parametrize(("kind", "word"), [("cut", "edges:|X"), ("cut", "edge 8"), ("touching", "edges:|X and <Z")])
def test_an_edge_in_pieces_is_graded_as_the_one_that_it_is(kind, word):
    part, options = cq.Workplane().box(60, 40, 20), {}
    if kind == "touching":
        low = cq.Workplane().box(20, 40, 6).translate((-10, 0, -13))
        part = cq.Assembly().add(part, name="up").add(low, name="low")
    else:
        options["cuts"] = ["plane x=-7", "plane z=2"]
    mesh = cs.sweep_mesh(part, size=3, biases={word: {"towards": "<X", "ratio": 5}}, **options)
    along = steps(mesh, "x", y=-20, z=-10)
    assert along[-1] / along[0] == pytest.approx(5)
    assert along.max() / along.min() == pytest.approx(5)
    assert np.exp(np.abs(np.diff(np.log(along)))).max() < 1.4  # as even as the pieces allow
    assert abs(len(along) - 60 / 3) <= 1
    first = cs.sweep_mesh(part, size=3, biases={word: {"towards": "both", "first": 0.7}}, **options)
    assert steps(first, "x", y=-20, z=-10)[[0, -1]] == pytest.approx(0.7)


def test_sizes_and_counts_name_the_edges_of_the_model_where_it_is_cut():
    box = cq.Workplane().box(60, 40, 20)  # edge 8 and face 4 are at the bottom; a cell's own are elsewhere
    for hints, n in (({"sizes": {"edge 8": 2}}, 30), ({"counts": {"edge 8": 22}}, 22), ({"sizes": {"face 4": 2}}, 30)):
        mesh = cs.sweep_mesh(box, size=4, cuts=["plane x=6"], **hints)
        assert len(steps(mesh, "x", y=-20, z=-10)) == n


def test_what_cannot_be_graded_is_said(plate):
    with pytest.raises(InputError, match="No edge matches 'rim'"):
        cs.sweep_mesh(plate, biases={"rim": {"towards": "both", "ratio": 2}})
    with pytest.raises(InputError, match="both its ends are as near to '>X'"):
        cs.sweep_mesh(plate, biases={"edges:|Y": {"towards": ">X", "ratio": 2}})
    with pytest.raises(InputError, match="fractions place the layers"):
        cs.sweep_mesh(plate, source="<Z", fractions=[0, 0.3, 1], biases={"edges:|Z": {"towards": "both", "ratio": 2}})
    with pytest.raises(InputError, match="gets 3 segments, of which the first cannot be 15 long"):
        cs.sweep_mesh(plate, size=40, counts={"edges:|Z": 3}, biases={"edges:|Z": {"towards": ">Z", "first": 15}})
    with pytest.raises(InputError, match="ask for different things"):
        cs.sweep_mesh(
            plate,
            biases={"edges:|X": {"towards": ">X", "ratio": 2}, "edges:|X and >Y": {"towards": ">X", "ratio": 3}},
        )
    for wrong in ({"ratio": 2}, {"towards": ">X"}, {"towards": ">X", "ratio": 0.5}, {"towards": ">X", "raito": 5}, 5):
        with pytest.raises(InputError, match=r"the bias of 'edges:\|X'"):
            cs.sweep_mesh(plate, biases={"edges:|X": wrong})


def test_the_command_line_reads_the_same_table():
    from cadsweep.cli.types import Assignment, Grading

    read = Assignment(Grading()).convert
    assert read("edges:|X=5@clamp", None, None) == ("edges:|X", {"towards": "clamp", "ratio": 5.0})
    assert read("rim=first:0.1@0,0,10", None, None) == ("rim", {"towards": (0.0, 0.0, 10.0), "first": 0.1})


def test_a_first_length_that_makes_segments_jump_is_said_with_the_count_that_does_not():
    bar = cq.Workplane().box(20, 6, 6)
    bias = {"edges:|X": {"towards": "faces:<X", "first": 0.1}}
    (note,) = (n for n in cs.sweep_mesh(bar, size=3.0, biases=bias).info["notes"] if "one to the next" in n)
    enough = int(re.search(r"(\d+) of them", note).group(1))
    # 0.1 (1.3^n - 1) / 0.3 = 20 is had by n = 15.67 segments: fewer would have to grow faster.
    assert enough == 16
    fine = cs.sweep_mesh(bar, size=3.0, biases=bias, counts={"edges:|X": enough})
    assert not any("one to the next" in n for n in fine.info["notes"])
