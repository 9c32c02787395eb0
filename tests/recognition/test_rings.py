"""Closed sweeps: cut open where their rails close, refused where they do not."""

import numpy as np
import pytest

import cadsweep as cs
from cadsweep.errors import NotSweepableError
from cadsweep.pipeline.attempts import open_and_find

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
    assert sweeps[0].closed
    assert part.solids[0].volume == pytest.approx(solid.Volume(), rel=1e-9)
    mesh = cs.sweep_mesh(solid, size=1.5, allow_coarse=True)
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
    assert not any(sweep.closed for sweep in cs.find_sweeps(part))


def test_a_twist_that_does_not_close_is_named():
    from pathlib import Path

    pytest.importorskip("cadquery")
    path = Path(__file__).parents[1] / "parts" / "unsweepable" / "twisted_band.py"
    with pytest.raises(NotSweepableError, match="closes with a twist"):
        cs.find_sweeps(path)


def u_duct(inner):
    """A duct of revolution that runs up, over and down again; both its ends lie in the plane y = 0."""
    cq = pytest.importorskip("cadquery")
    profile = [(1, 0), (2, 0), (2, 6), (inner, 6), (inner, 0), (4, 0), (4, 8), (1, 8)]
    return cq.Workplane().polyline(profile).close().revolve(360, (0, 0, 0), (0, 1, 0))


def end_faces(part):
    """The annuli in the plane y = 0, the inner one first."""
    ends = [f for f in part.solids[0].faces if f.kind == "plane" and abs(f.center[1]) < 1e-9]
    return [f.id for f in sorted(ends, key=lambda f: max(part.solids[0].edges[e].length for e in f.edges))]


def test_caps_of_equal_area_about_one_centre_are_no_cut():
    # With an inner radius of sqrt(13) the two annuli have the area 3 pi each, and one centre, and lie in one plane.
    part = cs.load(u_duct(13**0.5))
    first, second = end_faces(part)
    areas = [part.solids[0].faces[f].area for f in (first, second)]
    assert areas == pytest.approx([3 * np.pi, 3 * np.pi])
    assert not any(sweep.closed for sweep in cs.find_sweeps(part, source=first, target=second))
    mesh = cs.sweep_mesh(part, source=first, target=second, size=0.5)
    assert mesh.info["quality"].valid
    assert mesh.structure is not None
    assert not mesh.structure.periodic


def test_a_cut_is_closed_from_either_side_and_after_a_way_through_a_file(tmp_path):
    cq = pytest.importorskip("cadquery")
    torus = cq.Workplane(cq.Solid.makeTorus(5, 1))
    cq.exporters.export(torus, str(tmp_path / "ring.step"))
    for model in (torus, tmp_path / "ring.step"):
        part, sweeps = open_and_find(cs.load(model), None, None)
        assert sweeps[0].closed
        one, other = part.solids[0].opened
        assert {frozenset(sweeps[0].source), frozenset(sweeps[0].target)} == {one, other}
        assert one.isdisjoint(other)


def test_a_slotted_ring_keeps_its_ends():
    # All but closed: the slot is a ten-thousandth of the way round, and its sides are the caps of an open sweep.
    cq = pytest.importorskip("cadquery")
    ring = cq.Workplane("XZ").center(5, 0).rect(2, 1).revolve(360 - 0.036, (-5, 0, 0), (-5, 1, 0))
    _, sweeps = open_and_find(cs.load(ring), None, None)
    assert not sweeps[0].closed
    mesh = cs.sweep_mesh(ring, size=0.8)
    assert mesh.info["quality"].valid
    assert not mesh.structure.periodic
