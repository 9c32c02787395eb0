"""What is a blend, of which radius, and what only looks like one."""

import cadquery as cq
import pytest
from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet

import cadsweep as cs
from cadsweep.blends import find_blends

INSIDE = cq.selectors.BoxSelector


def told(shape):
    """(kind, convex, smallest, largest radius) of every blend, model units."""
    part = cs.load(shape)
    (solid,) = part.solids
    return sorted(
        (b.kind, b.convex, round(b.radii[0] * part.scale, 3), round(b.radii[1] * part.scale, 3))
        for b in find_blends(solid)
    )


def test_a_box_rounded_all_over_has_twelve_edges_and_eight_corners():
    part = cs.load(cq.Workplane().box(10, 8, 6).edges().fillet(1.5))
    blends = find_blends(part.solids[0])
    assert [b.kind for b in blends] == ["edge"] * 12 + ["corner"] * 8
    assert all(b.convex and b.radii[0] * part.scale == pytest.approx(1.5, rel=0.01) for b in blends)
    assert len({f for b in blends for f in b.faces}) == 20
    planes = {face.id for face in part.solids[0].faces if face.kind == "plane"}
    assert all(planes.issuperset(side) for b in blends if b.kind == "edge" for side in b.supports)


def test_a_corner_where_radii_differ_is_a_patch():
    plate = cq.Workplane().box(10, 8, 2).edges("|Z").fillet(2).edges(">Z").fillet(0.5)
    assert told(plate) == (
        [("corner", True, 0.5, 0.5)] * 4 + [("edge", True, 0.5, 0.5)] * 4 + [("edge", True, 2.0, 2.0)] * 4
    )


def test_the_floor_of_a_pocket_and_the_foot_of_a_boss_are_concave():
    pocket = (
        cq.Workplane()
        .box(20, 16, 8)
        .cut(cq.Workplane().box(12, 8, 4).edges("|Z").fillet(2).faces("<Z").edges().fillet(1).translate((0, 0, 2)))
    )
    found = told(pocket)
    assert found.count(("edge", False, 2.0, 2.0)) == found.count(("edge", False, 1.0, 1.0)) == 4
    assert [row[0] for row in found].count("corner") == 4
    assert len(found) == 12
    boss = cq.Workplane().box(20, 20, 4).faces(">Z").workplane().circle(4).extrude(6)
    assert told(boss.edges(INSIDE((-5, -5, 1.5), (5, 5, 2.5))).fillet(1)) == [("edge", False, 1.0, 1.0)]


def test_ends_of_slots_and_full_rounds_are_none():
    assert told(cq.Workplane().box(20, 10, 4).faces(">Z").workplane().slot2D(10, 4).cutThruAll()) == []
    rimmed = cq.Workplane().slot2D(20, 8).extrude(4).faces(">Z").edges().fillet(1)
    assert told(rimmed) == [("edge", True, 1.0, 1.0)] * 4


def test_a_bent_wall_is_none_and_a_rounded_bracket_is_one():
    corner = cq.Workplane("XZ").polyline([(0, 0), (20, 0), (20, 4), (4, 4), (4, 20), (0, 20)]).close().extrude(10)
    inner = corner.edges("|Y").edges(INSIDE((3, -20, 3), (5, 20, 5))).fillet(3)
    assert told(inner) == [("edge", False, 3.0, 3.0)]
    outer = INSIDE((-1, -20, -1), (1, 20, 1))
    assert told(inner.edges("|Y").edges(outer).fillet(7)) == []
    assert len(told(inner.edges("|Y").edges(outer).fillet(5))) == 2


def test_a_radius_that_varies_is_told_from_end_to_end():
    box = cq.Workplane().box(10, 8, 6)
    tool = BRepFilletAPI_MakeFillet(box.val().wrapped)
    tool.Add(1.0, 2.0, box.edges(">Z and >X").val().wrapped)
    ((kind, convex, low, high),) = told(cq.Workplane(cq.Shape.cast(tool.Shape())))
    assert (kind, convex) == ("edge", True)
    assert low == pytest.approx(1.0, abs=0.06)
    assert high == pytest.approx(2.0, abs=0.06)


def test_bent_pipes_have_none():
    assert told(cq.Workplane().circle(3).sweep(cq.Workplane("XZ").lineTo(0, 10).radiusArc((10, 20), 10))) == []


def test_info_lists_them_with_their_radius(tmp_path, capsys):
    from cadsweep.cli.show import print_info
    from cadsweep.cli.work import describe_part

    path = tmp_path / "part.step"
    cq.exporters.export(cq.Workplane().box(10, 8, 2).edges("|Z").fillet(1.25), str(path))
    data = describe_part(str(path), params=None, on_progress=lambda *_: None)
    assert [(row["kind"], row["solid"], len(row["supports"])) for row in data["blends"]] == [("edge", 0, 2)] * 4
    assert all(row["radii"] == pytest.approx([1.25, 1.25]) for row in data["blends"])
    print_info(data)
    shown = capsys.readouterr().out
    assert shown.count("convex") == 4
    assert "1.25" in shown
