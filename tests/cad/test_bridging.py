"""Faces end before their tips: where their edges are a length apart, and nowhere else is the solid another."""

import math

import cadquery as cq
import numpy as np
import pytest

import cadsweep as cs
from cadsweep import cad
from cadsweep.cad.edit.corners import SHARP
from cadsweep.cad.edit.tips import find_tips
from cadsweep.decomposition import is_planar
from tests.parts.chamfered import chamfered_nut
from tests.parts.joints import bolted

LENGTH = 0.02


def pad_over_a_rim():
    """A plate with a round pad whose wall crosses that of the plate at ten degrees."""
    pad = cq.Workplane().center(0, -4.1).circle(6).extrude(3)
    return cq.Workplane().box(30, 20, 2, centered=(True, True, False)).union(pad)


@pytest.mark.parametrize("n_sides", [4, 6])
def test_every_chamfer_of_a_nut_has_two_tips_at_both_ends(n_sides):
    (solid,) = cs.load(chamfered_nut(n_sides)).solids
    tips = find_tips(solid, LENGTH)
    assert len(tips) == 4 * n_sides
    assert {solid.faces[tip.face].kind for tip in tips} == {"cone"}
    assert {solid.faces[tip.neighbour].kind for tip in tips} == {"plane"}


@pytest.mark.parametrize("n_sides", [4, 6])
@pytest.mark.parametrize("turn", [0.0, 31.0])
def test_a_tip_ends_in_an_edge_of_that_length_and_faces_keep_their_ids(n_sides, turn):
    part = cs.load(chamfered_nut(n_sides).rotate((0, 0, 0), (1, 2, 3), turn))
    bridged = cad.bridge_tips(part, LENGTH)
    (old,), (new,) = part.solids, bridged.solids
    assert len(new.edges) == len(old.edges) + 2 * 4 * n_sides
    assert [face.key for face in new.faces] == [face.key for face in old.faces]
    assert not find_tips(new, LENGTH)
    short = [edge for edge in new.edges if edge.length < 2 * LENGTH]
    assert len(short) == 4 * n_sides
    assert [edge.length for edge in short] == pytest.approx([LENGTH] * len(short), rel=1e-3)
    assert min(angle for face in new.faces for loop in face.loops for angle in loop.angles) > math.pi / 10
    assert new.volume == old.volume
    assert sum(face.area for face in new.faces) == pytest.approx(sum(face.area for face in old.faces), rel=1e-4)


def test_a_face_that_got_a_tip_knows_that_places_near_it_may_lie_on_either_surface():
    part = cs.load(chamfered_nut(6))
    (old,) = part.solids
    (new,) = cad.bridge_tips(part, LENGTH).solids
    tip = find_tips(old, LENGTH)[0]
    edge, fraction = next(end for end in tip.ends if tip.neighbour not in old.edges[end[0]].faces)
    rim = old.edges[edge].curve.evaluate(np.array([fraction]))
    assert old.faces[tip.neighbour].surface.distance(rim)[0] > 1e-3
    assert new.faces[tip.neighbour].surface.distance(rim)[0] < 1e-9
    middle = old.edges[edge].curve.evaluate(np.array([0.5]))
    far = old.faces[tip.neighbour].surface.distance(middle)
    assert new.faces[tip.neighbour].surface.distance(middle) == pytest.approx(far, rel=1e-12)


@pytest.mark.parametrize("length", [1e-3, 5e-2])
def test_a_tip_may_be_as_short_as_asked(length):
    (new,) = cad.bridge_tips(cs.load(chamfered_nut(4)), length).solids
    assert min(edge.length for edge in new.edges) == pytest.approx(length, rel=1e-3)


def test_a_part_without_tips_stays_the_part():
    part = cs.load(cq.Workplane().box(4, 3, 2).edges("|Z").fillet(0.5))
    assert cad.bridge_tips(part, 0.1) is part


def test_walls_of_a_tip_that_stand_across_it_leave_it_as_it_is():
    (solid,) = cs.load(pad_over_a_rim()).solids
    sharp = [face for face in solid.faces if any(a < SHARP for loop in face.loops for a in loop.angles)]
    assert sharp
    assert not [tip for tip in find_tips(solid, 0.1) if solid.faces[tip.face].kind == "plane"]


def test_a_contact_gets_the_tips_of_what_lies_on_it_and_stays_shared():
    part = cs.load(bolted(head=False))
    bridged = cad.bridge_tips(part, LENGTH)
    nut, plate = (next(j for j, solid in enumerate(part.solids) if solid.name == name) for name in ("nut", "plate"))
    (key,) = set(part.solids[nut].face_keys) & set(part.solids[plate].face_keys)
    (new,) = set(bridged.solids[nut].face_keys) & set(bridged.solids[plate].face_keys)
    contact = {j: bridged.solids[j].face_keys.tolist().index(new) for j in (nut, plate)}
    for j, face in contact.items():
        was = part.solids[j].faces[part.solids[j].face_keys.tolist().index(key)]
        now = bridged.solids[j].faces[face]
        assert now.key == was.key
        assert now.tips
        assert len(now.edges) == len(was.edges) + 12 + 12  # two short edges and two of the flats for each of six arcs
        assert now.area > was.area
    assert not any(cad.has_sharp_corners(solid) for solid in bridged.solids)
    for one, other in zip(bridged.solids, part.solids, strict=True):
        assert sum(face.area for face in one.faces) == pytest.approx(sum(face.area for face in other.faces), rel=1e-3)


def test_a_face_that_is_kept_keeps_its_own_tips_and_no_others():
    (solid,) = cs.load(chamfered_nut(6)).solids
    tips = find_tips(solid, LENGTH)
    kept = tips[0].face
    left = find_tips(solid, LENGTH, {kept})
    assert [tip.corner for tip in left] == [tip.corner for tip in tips if tip.face != kept]
    assert 0 < len(left) < len(tips)


def chamfered_and_cut_off():
    """A block with a chamfer below, and a wedge cut off that ends on the face above the chamfer, at eleven degrees."""
    block = cq.Workplane().box(10, 10, 6, centered=False).edges(">X and <Z").chamfer(1.2)
    wedge = cq.Workplane("YZ").polyline([(-1, 2.3), (9.5, 0.2), (9.5, 9), (-1, 9)]).close().extrude(4)
    return block.cut(wedge.translate((7, 0, 0)))


def test_a_plane_whose_outline_leaves_it_for_a_tip_is_not_cut_as_a_polygon_and_its_pieces_know_the_tip():
    part = cs.load(chamfered_and_cut_off())
    bridged = cad.bridge_tips(part, LENGTH)
    assert is_planar(part.solids[0])
    assert not is_planar(bridged.solids[0])
    (face,) = [face for face in bridged.solids[0].faces if face.tips]
    cut = np.array([[-1.0, -1.0, 4.0], [11.0, -1.0, 4.0], [11.0, 11.0, 4.0], [-1.0, 11.0, 4.0]])
    cells = cad.cut_along(bridged, [(np.array([0.0, 0.0, 1.0]), [cut])])
    assert len(cells.solids) > 1
    (piece,) = [own for cell in cells.solids for own in cell.faces if own.key == face.key]
    assert piece.tips == face.tips
    assert piece.surface.distance(face.tips[0].corner[None])[0] < 1e-9
