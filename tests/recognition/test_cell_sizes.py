"""How long the segments of cells are where nobody names a size."""

from __future__ import annotations

import math

import pytest

import cadsweep as cs
from cadsweep.intervals import CellSweep, Wishes, cell_sizes
from cadsweep.intervals.sizes import WANTED_HEXES

pytestmark = pytest.mark.cad


def size_of(profile):
    """Size of a prism of a profile, over that of its volume's share of the wanted hexahedra."""
    part = cs.load(profile.extrude(2.0))
    sweep = next(s for s in cs.find_sweeps(part) if {part.solids[0].faces[f].kind for f in s.source} == {"plane"})
    (size,) = cell_sizes([CellSweep(fill=sweep, grids=tuple(sweep.linking_sides))], Wishes())
    return size / (part.solids[0].volume / WANTED_HEXES) ** (1 / 3)


def between_circles(start):
    """What lies between two circles of radii 5 and 6 that touch at the origin, above one height and below another."""
    import cadquery as cq

    def at(radius, height):
        return radius - math.sqrt(radius**2 - height**2), height

    ends = [at(5.0, start), at(5.0, 2.0), at(6.0, 2.0), at(6.0, start)]
    middle = 0.5 * (start + 2.0)
    inner = cq.Workplane().moveTo(*ends[0]).threePointArc(at(5.0, middle), ends[1]).lineTo(*ends[2])
    outer = inner.threePointArc(at(6.0, middle), ends[3])
    return (outer if start == 0.0 else outer.lineTo(*ends[0])).close()


def test_a_tip_whose_sides_part_tangent_has_no_thickness_to_be_shown():
    assert size_of(between_circles(0.0)) == pytest.approx(1.0, rel=1e-6)


def test_what_is_thin_without_a_tip_gets_shorter_segments():
    assert size_of(between_circles(1.0)) < 0.9
