"""Bores that cross are parted by planes into cells with a block at every corner, wherever their axes pass."""

from dataclasses import replace

import pytest

pytest.importorskip("cadquery")

import cadquery as cq
import numpy as np

from cadsweep import load, recognition
from cadsweep.cad.edit.axes import find_axes
from cadsweep.cad.edit.axial import direction_of, find_clusters, main_normals
from cadsweep.cad.edit.crossings import _meeting, at_crossings, find_crossings
from cadsweep.cad.edit.cutting import cut_cell
from cadsweep.cad.heal.validate import faults
from cadsweep.cad.shapes import shapes_of

pytestmark = pytest.mark.cad

FLAT = 1e-4


def bored(radius, other, offset, *, length=40.0):
    """A block with a bore along z, and another along x that passes its axis at a distance."""
    block = cq.Workplane().box(length, 40, 40).cut(cq.Workplane(origin=(0, 0, -20)).circle(radius).extrude(40))
    place = (-length / 2, offset, 0)
    return block.cut(cq.Workplane("YZ", origin=place).circle(other).extrude(length))


@pytest.mark.parametrize(("radius", "other", "offset"), [(6, 6, 0), (8, 5, 0), (8, 5, 2), (6, 6, 5), (7, 4, 8)])
def test_every_cell_of_a_crossing_is_filled(radius, other, offset):
    part = load(bored(radius, other, offset))
    (cutter,) = at_crossings(part.solids[0])
    pieces = cut_cell(part, 0, cutter.tools)
    for cell in pieces.solids:
        swept = recognition.search_sweeps(cell, folds=False, most_readings=1).sweeps
        assert swept or recognition.find_corner_blocks(cell) is not None
    assert sum(cell.volume for cell in pieces.solids) == pytest.approx(part.solids[0].volume, rel=1e-6)


@pytest.mark.parametrize("offset", [11.5, 13.0])
def test_bores_that_graze_or_pass_do_not_cross(offset):
    assert find_crossings(find_axes(load(bored(6, 6, offset)).solids[0])) == []


def test_a_bore_is_what_it_is_beyond_its_crossings():
    """Two bores that cross: where they do, no direction suits; of each two ends are left, which go its own way."""
    (solid,) = load(bored(8, 5, 2, length=60)).solids
    ways = [direction_of(solid, face) for face in solid.faces]
    normals = main_normals(solid, ways)
    found = find_clusters(solid, ways, normals, FLAT)
    (middle,) = [cluster for cluster in found if cluster.is_crossing]
    assert not middle.ways
    ends = [cluster for cluster in found if not cluster.is_crossing]
    assert sorted(int(np.abs(normals[way]).argmax()) for cluster in ends for way in cluster.ways) == [0, 0, 2, 2]
    assert all(cluster.axes < middle.axes for cluster in ends)


def test_a_divided_bore_is_what_opencascade_takes_for_valid(tmp_path):
    """Halves of a closed face into which another bore opens are valid to OpenCASCADE, so they can be cut further."""
    block = cq.Workplane().box(85, 50, 62).cut(cq.Workplane("YZ", origin=(42.5, -11, 8)).circle(4).extrude(-85))
    block = block.cut(cq.Workplane("XY", origin=(-21, -17, 31)).circle(5).extrude(-62))
    cq.exporters.export(block, str(tmp_path / "block.step"))
    (solid,) = load(tmp_path / "block.step").solids
    assert faults(shapes_of(solid).shape) == []


def test_of_many_bores_every_pair_that_meets_is_found():
    """Pairs far apart are left out beforehand; those that meet are the same as of all pairs."""
    rng = np.random.default_rng(3)
    (axis,) = find_axes(load(cq.Workplane().box(9, 9, 9).faces(">Z").workplane().hole(2)).solids[0])
    axes = []
    for j in range(60):
        direction = rng.standard_normal(3)
        direction /= np.linalg.norm(direction)
        low, high = np.sort(rng.uniform(-4, 4, 2))
        place, radius = rng.uniform(-10, 10, 3), float(rng.uniform(0.2, 2.0))
        axes.append(replace(axis, place=place, direction=direction, low=low, high=high, radius=radius, line=j))
    meeting = {(i, j) for i in range(60) for j in range(i + 1, 60) if _meeting(axes[i], axes[j]) is not None}
    assert 0 < len(meeting) < 60 * 59 / 4
    assert {crossing.lines for crossing in find_crossings(axes)} == meeting
