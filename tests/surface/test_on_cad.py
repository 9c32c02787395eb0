"""The surface stage on CAD solids: nodes on their own faces, conforming caps, the same bytes again."""

import numpy as np
import pytest

import cadsweep as cs
from cadsweep.cad import load
from cadsweep.recognition import find_sweeps
from cadsweep.surface import disc_lattice, mesh_boundary
from cadsweep.surface.relax import corner_sines

from ..lone import assign_intervals

pytestmark = pytest.mark.cad

cq = pytest.importorskip("cadquery")
pytest.importorskip("gmsh")


def half_torus():
    return cq.Workplane("XZ").center(3, 0).circle(1).revolve(180, (-3, 0, 0), (-3, 1, 0))


def plate_with_holes():
    return cq.Workplane().box(8, 5, 1).faces(">Z").workplane().pushPoints([(-2, 0), (2, 1)]).hole(1.2)


def bent_sheet():
    profile = cq.Workplane("XZ").hLine(6).radiusArc((8, 2), -2).vLine(4).hLine(-0.5).vLine(-4)
    sheet = profile.radiusArc((6, 0.5), 1.5).hLine(-6).close().extrude(5)
    return sheet.cut(cq.Workplane("XY", origin=(3, -2.5, 0)).circle(1).extrude(2))


def stepped_pipe():
    path = cq.Workplane("XZ").lineTo(0, 4).radiusArc((2, 6), 2).lineTo(6, 6)
    return cq.Workplane().circle(1).circle(0.7).sweep(path)


def lens():
    ball = cq.Workplane().sphere(20).translate((0, 0, -16))
    return cq.Workplane().rect(14, 9).extrude(20).intersect(ball)


PARTS = [half_torus, plate_with_holes, bent_sheet, stepped_pipe, lens]


def mesh_of(make, **options):
    solid = load(make()).solids[0]
    sweep = find_sweeps(solid)[0]
    return sweep, mesh_boundary(sweep, assign_intervals(sweep, **options))


def distance_to(surface, points):
    return np.abs(surface.evaluate(surface.project(points)) - points).max()


@pytest.fixture(scope="module", params=PARTS, ids=lambda make: make.__name__)
def meshed(request):
    return mesh_of(request.param)


def test_every_node_lies_on_its_own_face(meshed):
    sweep, mesh = meshed
    faces, size = sweep.solid.faces, sweep.solid.size
    following = np.concatenate([np.roll(loop, -1) for loop in mesh.source.loops])
    for face in np.unique(mesh.side_faces):
        k, j = np.nonzero(mesh.side_faces == face)
        corners = np.concatenate([mesh.rings[k, j], mesh.rings[k + 1, following[j]]])
        assert distance_to(faces[face].surface, corners) < 1e-7 * size
    for face in np.unique(mesh.source.faces):
        nodes = np.unique(mesh.source.quads[mesh.source.faces == face])
        assert distance_to(faces[face].surface, mesh.source.points[nodes]) < 1e-7 * size


def test_the_cap_conforms_and_its_normals_point_into_the_solid(meshed):
    sweep, mesh = meshed
    cap = mesh.source
    edges = np.sort(np.stack([cap.quads, np.roll(cap.quads, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    unique, uses = np.unique(edges, axis=0, return_counts=True)
    border = {tuple(edge) for edge in unique[uses == 1].tolist()}
    loops = [np.sort(np.stack([loop, np.roll(loop, -1)], axis=1), axis=1) for loop in cap.loops]
    assert uses.max() == 2
    assert border == {tuple(edge) for edge in np.concatenate(loops).tolist()}
    for face in np.unique(cap.faces):
        quads = cap.quads[cap.faces == face]
        used = np.unique(quads)
        normals = np.zeros_like(cap.points)
        surface = sweep.solid.faces[face].surface
        normals[used] = -surface.normals(surface.project(cap.points[used]))
        assert corner_sines(cap.points, quads, normals).min() > 0.3


def test_linking_quads_look_outwards(meshed):
    sweep, mesh = meshed
    following = np.concatenate([np.roll(loop, -1) for loop in mesh.source.loops])
    a, b = mesh.rings[:-1], mesh.rings[:-1, following]
    d, c = mesh.rings[1:], mesh.rings[1:, following]
    normals = np.cross(c - a, d - b)
    for face in np.unique(mesh.side_faces):
        mine = mesh.side_faces == face
        surface = sweep.solid.faces[face].surface
        centers = (a + b + c + d)[mine] / 4
        outward = surface.normals(surface.project(centers))
        assert (np.einsum("qd,qd->q", normals[mine], outward) > 0).all()


def test_inner_edges_of_a_cap_are_divided_once_and_run_from_start_to_end(meshed):
    sweep, mesh = meshed
    solid = sweep.solid
    for edge, nodes in mesh.source.edge_nodes.items():
        ends = solid.vertices[[solid.edges[edge].start, solid.edges[edge].end]]
        assert np.array_equal(mesh.source.points[nodes[[0, -1]]], ends)
    assert set(mesh.source.edge_nodes) == {e for f in sweep.source for e in solid.faces[f].edges}


def test_the_same_sweep_gives_the_same_bytes():
    (_, first), (_, second) = (mesh_of(plate_with_holes, size=0.4, layers=3) for _ in range(2))
    assert first.rings.tobytes() == second.rings.tobytes()
    assert first.source.points.tobytes() == second.source.points.tobytes()
    assert first.source.quads.tobytes() == second.source.quads.tobytes()


def test_a_gmsh_of_the_users_own_is_left_alone_and_changes_nothing():
    import gmsh

    _, alone = mesh_of(plate_with_holes, size=0.6, layers=2)
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.MeshSizeFactor", 0.3)
        gmsh.model.add("theirs")
        _, beside = mesh_of(plate_with_holes, size=0.6, layers=2)
        assert gmsh.model.getCurrent() == "theirs"
        assert gmsh.option.getNumber("Mesh.MeshSizeFactor") == 0.3
    finally:
        gmsh.finalize()
    assert alone.source.points.tobytes() == beside.source.points.tobytes()


def test_split_caps_on_both_ends_give_the_targets_inner_edges():
    plate = cq.Workplane().box(6, 4, 1)
    # A groove-free split: two boxes glued along a plane that both caps show as an edge.
    halves = cq.Workplane().box(2.5, 4, 1).translate((-1.75, 0, 0))
    solid = load(plate.cut(halves).union(halves, clean=False)).solids[0]
    sweep = next((s for s in find_sweeps(solid) if len(s.source) == 2 and s.target_edges), None)
    assert sweep is not None
    mesh = mesh_boundary(sweep, assign_intervals(sweep, size=0.5, layers=2))
    on_loops = {edge for loop in sweep.source_loops for edge, _ in loop}
    inner = [e for e in mesh.source.edge_nodes if e not in on_loops]
    assert len(inner) == 1
    target, same = sweep.target_edges[inner[0]]
    points = mesh.target_edge_points[target]
    above = mesh.source.points[mesh.source.edge_nodes[inner[0]]][:: 1 if same else -1]
    shift = points - above
    assert np.abs(shift - shift[0]).max() < 1e-12


def test_a_ring_of_thin_wall_gets_no_core_in_its_bore(monkeypatch):
    # A core of 100 x 100 quads within a wall of one: laid a dozen times, and taken out again.
    monkeypatch.setattr(disc_lattice, "_lattices", lambda *_: pytest.fail("a core was laid"))
    mesh = cs.sweep_mesh(cq.Workplane().circle(10).circle(9.6).extrude(1))
    assert mesh.quality().min_scaled_jacobian > 0.9
