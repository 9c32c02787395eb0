"""The turns and mirrors of a cap's outline: the same whichever way nearest places are found."""

from fractions import Fraction

import numpy as np
import pytest

pytest.importorskip("cadquery")

import cadquery as cq

import cadsweep as cs
from cadsweep.intervals import symmetry
from cadsweep.intervals.sizes import turnings

pytestmark = pytest.mark.cad


def pinwheel():
    """Four slots that lean the same way: turns, no mirror, and halves of concentric circles."""
    plate = cq.Workplane().circle(30).circle(6).extrude(4)
    slot = cq.Workplane().center(18, 3).slot2D(10, 4, 30).extrude(4)
    for k in range(4):
        plate = plate.cut(slot.rotate((0, 0, 0), (0, 0, 1), 90 * k))
    return plate


def plate():
    """Two mirrors, and half a turn."""
    return cq.Workplane().rect(40, 20).extrude(5).faces(">Z").workplane().rarray(20, 10, 2, 2).hole(4)


@pytest.mark.parametrize(("make", "n_motions"), [(plate, 3), (pinwheel, 3)])
def test_few_places_and_a_tree_give_the_same_motions(monkeypatch, make, n_motions):
    solid = cs.load(make()).solids[0]
    (top,) = [face for face in solid.faces if face.kind == "plane" and face.normal[2] > 0.9]
    found = []
    for few in (symmetry._FEW, 0):
        monkeypatch.setattr(symmetry, "_FEW", few)
        found.append(symmetry._find_symmetry(solid, top))
    one, other = found
    assert len(one.motions) == len(other.motions) == n_motions
    for a, b in zip(one.motions, other.motions, strict=True):
        assert (a.angle, a.is_mirror) == (b.angle, b.is_mirror)
        assert np.array_equal(a.image, b.image)
    # An orbit is what all motions, which are a group, carry a piece to.
    n_pieces = len(one.edges) + len(one.circles)
    pieces = [{e} for e in one.edges] + [set(circle.edges) for circle in one.circles]
    for orbit in map(set, one.orbits()):
        own = [j for j in range(n_pieces) if pieces[j] <= orbit]
        assert {int(motion.image[j]) for motion in one.motions for j in own} | set(own) == set(own)
    assert sorted(e for orbit in one.orbits() for e in orbit) == sorted(e for piece in pieces for e in piece)


def test_angles_are_multiples_of_the_least_part_of_a_turn():
    parts = np.arange(1, symmetry._FINEST + 1)
    shares = np.array([share for n in parts for share in (1.0 / n, -(n - 1.0) / n, 3.0 + 1.0 / n)])
    found = symmetry._denominators(2.0 * np.pi * shares)
    assert found.tolist() == [Fraction(share).limit_denominator(symmetry._FINEST).denominator for share in shares]
    assert symmetry._denominators(np.array([1.0, 2.0 * np.pi / (symmetry._FINEST + 1)])).tolist() == [0, 0]


def test_edges_turn_by_their_angles_and_winding_ones_by_all_their_turns():
    quarter = cs.load(cq.Workplane().rect(20, 10).extrude(5).edges("|Z").fillet(2)).solids[0]
    for e, turn in turnings(quarter, [edge.id for edge in quarter.edges]).items():
        assert turn == pytest.approx(0.0 if quarter.edges[e].kind == "line" else np.pi / 2)
    wire = cq.Wire.makeHelix(2, 6, 3)
    spring = cs.load(cq.Workplane("XZ").center(3, 0).rect(0.6, 0.4).sweep(cq.Workplane(wire), isFrenet=True)).solids[0]
    assert max(turnings(spring, range(len(spring.edges))).values()) > 5.0 * np.pi
