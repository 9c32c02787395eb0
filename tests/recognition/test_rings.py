"""Closed sweeps: cut open where their rails close, refused where they do not."""

import numpy as np
import pytest

import cadsweep as cs
from cadsweep.blocks.reference import is_ring
from cadsweep.errors import NotSweepableError
from cadsweep.pipeline.parts import open_and_find

pytestmark = pytest.mark.cad


def racetrack():
    cq = pytest.importorskip("cadquery")
    path = (
        cq.Workplane()
        .moveTo(0, -6)
        .lineTo(4, -6)
        .threePointArc((10, 0), (4, 6))
        .lineTo(-4, 6)
        .threePointArc((-10, 0), (-4, -6))
        .close()
    )
    return cq.Workplane("YZ", origin=(0, -6, 0)).circle(2).sweep(path).val()


def test_a_ring_around_any_path_is_opened_and_meshed_closed():
    solid = racetrack()
    part, sweeps = open_and_find(cs.load(solid), None, None)
    assert is_ring(sweeps[0])
    assert part.solids[0].volume == pytest.approx(solid.Volume(), rel=1e-9)
    mesh = cs.sweep_mesh(solid, size=1.5)
    report = mesh.info["quality"]
    assert report.valid
    assert report.euler == 0
    # the boundary is sides alone: nothing of the cut is left in it
    area = sum(report.areas.values())
    assert area == pytest.approx(solid.Area(), rel=0.05)
    # every segment of the boundary belongs to two quads
    quads = np.concatenate(list(mesh.boundaries.values()))
    pairs = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    assert (np.unique(pairs, axis=0, return_counts=True)[1] == 2).all()


def test_a_sweep_that_only_looks_possible_does_not_hide_the_ring():
    sweeps = cs.find_sweeps(racetrack())
    assert len(sweeps[0].source) == 1


def test_a_plate_with_a_hole_is_no_ring():
    cq = pytest.importorskip("cadquery")
    part = cs.load(cq.Workplane().box(20, 20, 5).faces(">Z").workplane().rect(8, 8).cutThruAll())
    assert not any(is_ring(sweep) for sweep in cs.find_sweeps(part))


def test_a_twist_that_does_not_close_is_named():
    from pathlib import Path

    pytest.importorskip("cadquery")
    path = Path(__file__).parents[1] / "parts" / "unsweepable" / "twisted_band.py"
    with pytest.raises(NotSweepableError, match="closes with a twist"):
        cs.find_sweeps(path)
