"""Cells with a block of hexahedra at every corner: what is read as one, its sheets, its counts and its volume."""

from itertools import combinations
from math import prod

import numpy as np
import pytest

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")

import cadquery as cq

import cadsweep as cs
from cadsweep.recognition import find_corner_blocks

pytestmark = pytest.mark.cad


def polyhedron(corners, rims):
    """A solid of plane faces, each the corners around it seen from outside."""
    points = [cq.Vector(*corner) for corner in corners]
    faces = [cq.Face.makeFromWires(cq.Wire.makePolygon([points[v] for v in rim], close=True)) for rim in rims]
    return cq.Workplane(obj=cq.Solid.makeSolid(cq.Shell.makeShell(faces)))


def tetrahedron():
    """Four corners, four faces: face j is opposite to corner j in neither's numbering."""
    return polyhedron([(0, 0, 0), (6, 0, 0), (0, 6, 0), (0, 0, 6)], list(combinations(range(4), 3)))


def blocks_of(shape):
    """The only solid of a shape, read."""
    return find_corner_blocks(cs.load(shape).solids[0])


def test_a_tetrahedron_has_a_block_at_each_corner():
    blocks = blocks_of(tetrahedron())
    assert len(blocks.corners) == 4
    assert len(blocks.chains) == 6
    assert not blocks.grids
    for chain, (start, end) in enumerate(blocks.across):
        beside = {face for face, outline in blocks.outlines.items() if chain in {c for c, _ in outline}}
        assert beside | {start, end} == set(range(4))  # the other two faces each meet the chain in a corner


@pytest.mark.parametrize("sheets", [(1, 1, 1, 1), (1, 2, 3, 4), (7, 1, 1, 5)])
def test_the_counts_give_the_sheets_back(sheets):
    blocks = blocks_of(tetrahedron())
    counts = [sheets[start] + sheets[end] for start, end in blocks.across]
    assert blocks.sheets(counts).tolist() == list(sheets)


def test_a_choice_between_sheets_is_halved():
    prism = polyhedron(
        [(0, 0, 0), (6, 0, 0), (0, 6, 0), (0, 0, 6), (6, 0, 6), (0, 6, 6)],
        [(0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)],
    )
    blocks = blocks_of(prism)
    ends = [f for f, outline in blocks.outlines.items() if len(outline) == 3]
    counts = [9 if {start, end} == set(ends) else 4 for start, end in blocks.across]
    found = blocks.sheets(counts)
    assert sorted(found[ends]) == [4, 5]  # 9 segments between the triangles, as even as can be
    assert np.all(np.delete(found, ends) == 2)


def test_what_needs_no_cut_comes_back_as_it_is():
    part = cs.load(tetrahedron())
    assert cs.decompose(part) is part


@pytest.mark.parametrize(
    "shape",
    [
        cq.Workplane().box(1, 1, 1),  # has sweeps
        cq.Workplane().box(3, 3, 3).faces(">Z").hole(1),  # a face with a hole
        cq.Workplane().polyline([(0, 0), (4, 0), (4, 1), (1, 1), (1, 4), (0, 4)]).close().extrude(1),  # re-entrant
        cq.Workplane().cylinder(2, 1),  # its caps have two corners
    ],
)
def test_what_is_none(shape):
    assert blocks_of(shape) is None


def test_hexahedra_are_the_products_of_the_sheets_at_the_corners():
    blocks = blocks_of(tetrahedron())
    mesh = cs.sweep_mesh(tetrahedron(), size=1.5)
    assert np.isclose(mesh.info["quality"].volume, 6**3 / 6, rtol=1e-12)
    on_axis = mesh.points[(np.abs(mesh.points[:, 1:]) < 1e-9).all(axis=1)]
    (own,) = mesh.info["sweeps"]
    assert (own["source"], own["target"], own["layers"], own["corners"], own["cell"]) == ([], [], 0, 4, 0)
    counts = []
    for chain in blocks.chains:
        edge = blocks.solid.edges[chain[0][0]]
        ends = blocks.solid.vertices[[edge.start, edge.end]]
        along = (mesh.points - ends[0]) @ (ends[1] - ends[0]) / edge.length**2
        off = np.linalg.norm(mesh.points - ends[0] - along[:, None] * (ends[1] - ends[0]), axis=1)
        counts.append(int((off < 1e-9).sum()) - 1)
    assert len(on_axis) - 1 in counts
    sheets = blocks.sheets(counts)
    at = [
        [f for f, outline in blocks.outlines.items() if any(c in blocks.ends[k] for k, _ in outline)] for c in range(4)
    ]
    assert mesh.n_hexes == sum(prod(int(sheets[f]) for f in faces) for faces in at)


def test_a_prism_beside_corner_blocks_takes_their_quads():
    """A cube whose corner is cut off, and a prism on the triangle: its cap has the quads of the cube's star."""
    beyond = cq.Workplane(cq.Plane(origin=(2, 2, 2), normal=(1, 1, 1))).rect(60, 60).extrude(40)
    triangle = [(3, 3, 0), (0, 3, 3), (3, 0, 3)]
    above = [tuple(c + 2 for c in corner) for corner in triangle]
    prism = polyhedron([*triangle, *above], [(0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)])
    both = cq.Assembly().add(cq.Workplane().box(6, 6, 6).cut(beyond), name="cube").add(prism, name="prism")
    mesh = cs.sweep_mesh(both, size=1.0)
    assert mesh.info["quality"].valid
    assert np.isclose(mesh.info["quality"].volume, mesh.info["cad_volume"], rtol=1e-12)
    nodes = mesh.interfaces["cube__prism"]
    quads = mesh.points[nodes]
    areas = np.linalg.norm(np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1]), axis=1) / 2
    assert np.isclose(areas.sum(), 18 * 3**0.5 / 4, rtol=1e-12)  # an equilateral triangle of side 18 ** 0.5


def ring(turn):
    """A ring of a triangular section, as under a counterbore: from nowhere inside is all of its inner wall seen."""
    section = cq.Workplane("XZ").polyline([(5, 0), (7, 0), (5, -2)]).close()
    return section.revolve(turn, (0, 0, 0), (0, 1, 0))


@pytest.mark.parametrize(("turn", "fits"), [(60, True), (90, True), (120, False)])
def test_a_bent_prism_of_three_sides_has_blocks_up_to_a_quarter_of_a_turn(turn, fits):
    assert (blocks_of(ring(turn)) is not None) == fits


def test_a_ring_in_quarters_is_meshed_though_its_sweeps_would_follow_each_other_in_a_circle():
    mesh = cs.sweep_mesh(ring(360), cuts=["plane x=0", "plane y=0"], size=1.0)
    report = mesh.quality()
    assert report.valid, report.problems
    assert report.min_scaled_jacobian > 0.4
