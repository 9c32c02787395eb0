"""One sweep a cell: shared faces get roles that agree, and quads are carried on in an order without a circle."""

import itertools
import math

import pytest

pytest.importorskip("cadquery")

import cadquery as cq

from cadsweep import load
from cadsweep.errors import PlanError
from cadsweep.plan import list_ways, make_plan
from cadsweep.recognition import search_sweeps
from cadsweep.sweep import turned

pytestmark = pytest.mark.cad


def part_of(*shapes):
    """Touching solids as one part."""
    whole = cq.Assembly()
    for j, shape in enumerate(shapes):
        whole.add(shape, name=f"part_{j}")
    return load(whole)


def candidates(part):
    return [search_sweeps(solid).sweeps for solid in part.solids]


def prism(z, height, radius=None):
    """A disc, or a plate that is larger, at a height."""
    flat = cq.Workplane().workplane(offset=z)
    return (flat.circle(radius) if radius else flat.rect(10, 10)).extrude(height)


def test_a_sweep_turned_twice_is_what_it_was():
    for sweep in search_sweeps(load(prism(0, 3)).solids[0]).sweeps:
        again = turned(turned(sweep))
        assert (again.source, again.target, again.source_loops) == (sweep.source, sweep.target, sweep.source_loops)
        assert again.linking_sides == sweep.linking_sides or all(
            (a.bottom, a.right, a.top, a.left) == (b.bottom, b.right, b.top, b.left)
            for a, b in zip(again.linking_sides, sweep.linking_sides, strict=True)
        )


def test_nobody_meshes_a_face_twice():
    part = part_of(prism(0, 1), prism(1, 2, 3.0), prism(3, 1))
    plan = make_plan(part, candidates(part))
    roles = {}
    for cell, (solid, way) in enumerate(zip(part.solids, plan.ways, strict=True)):
        for face, key in enumerate(solid.face_keys.tolist()):
            roles.setdefault(key, []).append((way.roles[face], cell))
    place = {cell: j for j, cell in enumerate(plan.order)}
    for users in roles.values():
        assert sum(role == "last" for role, _ in users) <= 1
        for role, cell in users:
            if role == "last":
                assert all(place[other] >= place[cell] for _, other in users)
                assert not any(role == "grid" for role, _ in users)


def test_a_disc_between_larger_plates_is_carried_to_both():
    part = part_of(prism(0, 1), prism(1, 2, 3.0), prism(3, 1))
    plan = make_plan(part, candidates(part))
    assert sorted(plan.order) == [0, 1, 2]


def test_caps_with_unlike_imprints_have_no_way():
    below = cq.Workplane().workplane(offset=-2).pushPoints([(-2.5, 0), (2.5, 0)]).circle(1).extrude(2)
    part = part_of(prism(0, 1), prism(1, 1, 3.0), *below.solids().vals())
    assert not list_ways(candidates(part)[0])
    with pytest.raises(PlanError) as caught:
        make_plan(part, candidates(part))
    assert {cell for cell, _ in caught.value.faces} == {0}


def test_caps_with_imprints_that_answer_each_other_have_ways():
    part = part_of(prism(0, 1), prism(1, 1, 2.0), prism(-2, 2, 3.0))
    straight = [s for s in candidates(part)[0] if len(s.source) > 1 and len(s.target) > 1]
    assert list_ways(straight)


def test_a_contradiction_names_the_faces():
    # A disc on the side of a plate: to the plate a hole in a linking side, which no sweep of it allows.
    part = part_of(prism(0, 4), cq.Workplane("YZ").workplane(offset=5).circle(1).extrude(2).translate((0, 0, 2)))
    across = [
        [s for s in own if abs(part.solids[j].faces[s.source[0]].normal[2]) > 0.9]
        for j, own in enumerate(candidates(part))
    ]
    with pytest.raises(PlanError) as caught:
        make_plan(part, across)
    assert caught.value.faces


def ring_of_lofts(turned_by):
    """A ring of eight straight lofts between pentagons, which come back turned by an angle."""
    wires = []
    for j in range(9):
        turn = math.radians(45.0 * j)
        outward = cq.Vector(math.cos(turn), math.sin(turn), 0)
        plane = cq.Plane(outward * 10, outward, cq.Vector(-outward.y, outward.x, 0))
        angles = [math.radians(72 * k + turned_by * j / 8) for k in range(5)]
        corners = [plane.toWorldCoords((2 * math.cos(a), 2 * math.sin(a))) for a in angles]
        wires.append(cq.Wire.makePolygon(corners, close=True))
    return [cq.Solid.makeLoft([a, b], True) for a, b in itertools.pairwise(wires)]


@pytest.mark.parametrize(("turned_by", "closes"), [(0.0, True), (72.0, False)])
def test_cells_around_a_ring_follow_each_other_where_its_section_comes_back_to_itself(turned_by, closes):
    part = part_of(*ring_of_lofts(turned_by))
    # Along the ring alone, all the same way around.
    around = [[s for s in own if len(s.source_loops[0]) == 5] for own in candidates(part)]
    if not closes:
        with pytest.raises(PlanError, match="in a circle"):
            make_plan(part, around)
        return
    plan = make_plan(part, around)
    assert sorted(plan.order) == list(range(8))
    assert sum(role == "last" for way in plan.ways for role in way.roles) == 8, "each is carried on to the next"
