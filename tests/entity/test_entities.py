"""Where the nodes of every kind of mesh are: on their own vertex, edge, face or cell, each once, chains in order."""

import numpy as np
import pytest

import cadsweep as cs
from cadsweep.entity.entities import CELL, EDGE, FACE, VERTEX
from cadsweep.pipeline.origin import CellsOrigin

cq = pytest.importorskip("cadquery")
pytest.importorskip("gmsh")
pytestmark = [pytest.mark.cad, pytest.mark.timeout(300)]


def plate():
    return cq.Workplane().box(4, 3, 1).faces(">Z").workplane().hole(1)


def elbow():
    return cq.Workplane().circle(1).circle(0.6).revolve(90, (3, 0, 0), (3, 1, 0))


def ring():
    return cq.Workplane("XZ").center(3, 0).rect(1, 1).revolve(360, (-3, 0), (-3, 1))


def split_caps():
    """Caps of two faces each, so that edges run inside them."""
    left = cq.Workplane().box(1, 1, 0.5).translate((-0.3, 0, 0))
    return left.union(cq.Workplane().box(1, 1, 0.5).translate((0.7, 0, 0)), clean=False)


def stepped():
    return cq.Workplane().box(4, 2, 1).faces(">Z").workplane().circle(0.6).extrude(1)


def crossing():
    block = cq.Workplane().box(6, 2, 1.5).union(cq.Workplane().box(1.5, 2, 2).translate((0, 0, 1.75)))
    return block.union(cq.Workplane().box(1.5, 3, 1).translate((0, 2.5, 0)))


def pair():
    model = cq.Assembly(name="pair")
    model.add(cq.Workplane().box(4, 4, 1).faces(">Z").workplane().hole(1), name="low")
    return model.add(cq.Workplane().box(2, 2, 0.5), name="high", loc=cq.Location((0.5, 0, 0.75)))


KINDS = [plate, elbow, ring, split_caps, stepped, crossing, pair]


@pytest.fixture(scope="module", params=KINDS, ids=lambda made: made.__name__)
def mesh(request):
    return cs.sweep_mesh(request.param(), size=0.5, allow_coarse=True)


def test_nodes_and_hexahedra_are_those_of_the_mesh(mesh):
    entities = mesh.origin.entities
    assert isinstance(mesh.origin, CellsOrigin)
    assert np.array_equal(entities.part.to_model(entities.points), mesh.points)
    assert np.array_equal(entities.joined.hexes, mesh.hexes)


def test_every_vertex_has_one_node_and_every_edge_its_nodes_in_order(mesh):
    entities = mesh.origin.entities
    closed = sum(solid.opened is not None for solid in entities.part.solids)
    assert len(set(entities.vertices.values())) == len(entities.vertices) or closed
    keys = {int(key) for solid in entities.part.solids for key in solid.vertex_keys}
    assert set(entities.vertices) == keys
    assert set(entities.chains) == {int(key) for solid in entities.part.solids for key in solid.edge_keys}
    for solid in entities.part.solids:
        for key, node in zip(solid.vertex_keys.tolist(), range(len(solid.vertices)), strict=True):
            assert np.allclose(entities.points[entities.vertices[key]], solid.vertices[node], atol=1e-6 * solid.size)
        for key, edge in zip(solid.edge_keys.tolist(), solid.edges, strict=True):
            chain = entities.chains[key]
            at = edge.curve.project(entities.points[chain[1:-1]])
            assert (np.diff(at) > 0).all()
            assert edge.curve.distance(entities.points[chain]).max() < 1e-6 * solid.size
            ends = [entities.vertices[int(solid.vertex_keys[v])] for v in (edge.start, edge.end)]
            assert chain[[0, -1]].tolist() == ends


def test_the_quads_of_a_face_lie_on_it_and_in_its_closure(mesh):
    entities = mesh.origin.entities
    dimensions, keys = entities.where
    for (cell, face), quads in entities.faces.items():
        solid = entities.part.solids[cell]
        own = solid.faces[face]
        assert own.surface.distance(entities.points[np.unique(quads)]).max() < 1e-6 * solid.size
        around = {int(solid.edge_keys[e]) for e in own.edges}
        corners = {int(solid.vertex_keys[v]) for e in own.edges for v in (solid.edges[e].start, solid.edges[e].end)}
        nodes = np.unique(quads)
        allowed = {FACE: {int(solid.face_keys[face])}, EDGE: around, VERTEX: corners, CELL: set()}
        if solid.opened is None:  # where a ring was cut open two entities have one place
            for dimension, those in allowed.items():
                assert set(keys[nodes[dimensions[nodes] == dimension]].tolist()) <= those
        # What is on the border of the quads is on the border of the face, and the other way round.
        on_border = {tuple(sorted(pair)) for e in around for pair in _steps(entities.chains[e])}
        seen, counts = np.unique(np.sort(_sides(quads), axis=1), axis=0, return_counts=True)
        if solid.opened is None:
            assert {tuple(pair) for pair in seen[counts == 1].tolist()} == on_border
        assert on_border <= {tuple(pair) for pair in seen.tolist()}


def test_every_quad_of_the_outside_is_on_a_face_of_the_model(mesh):
    entities = mesh.origin.entities
    named = [quads for place, quads in entities.faces.items() if entities.names.outside.get(place)]
    mine = {frozenset(quad) for quads in named for quad in quads.tolist()}
    assert mine == {frozenset(quad) for quads in mesh.boundaries.values() for quad in quads.tolist()}


def test_a_node_inside_a_cell_is_on_no_face(mesh):
    entities = mesh.origin.entities
    dimensions, keys = entities.where
    assert not np.isin(np.flatnonzero(dimensions == CELL), entities.joined.quads).any()
    assert set(keys[dimensions == CELL].tolist()) <= set(range(len(entities.part.solids)))


def test_middles_of_segments_and_quads_go_onto_their_curves_and_surfaces(mesh):
    entities = mesh.origin.entities
    for pairs, project in entities.on_curves():
        if project is not None:
            middles = mesh.points[pairs].mean(axis=1)
            there = project(middles)
            assert np.allclose(project(there), there, atol=1e-6)
            assert np.linalg.norm(there - middles, axis=1).max() < 0.5
    on_surfaces = entities.on_surfaces()
    for quads, project in on_surfaces:
        if project is not None:
            there = project(mesh.points[quads].mean(axis=1))
            assert np.allclose(project(there), there, atol=1e-6)
    told = np.unique(np.sort(np.concatenate([quads for quads, _ in on_surfaces]), axis=1), axis=0)
    held = [quads for place, quads in entities.faces.items() if entities.is_outside(place)]
    assert np.array_equal(told, np.unique(np.sort(np.concatenate(held), axis=1), axis=0))
    assert len(told) == sum(len(quads) for quads, _ in on_surfaces)


def test_where_a_cut_ends_on_a_face_there_is_no_edge():
    """Nodes there may have moved on the face, away from where the cut was."""
    tube = cq.Workplane().circle(1).circle(0.6).extrude(1)
    entities = cs.sweep_mesh(tube, size=0.4, cuts=["plane x=0.1"]).origin.entities
    x = entities.part.to_model(entities.points)[:, 0]
    on_cut = {key for key, chain in entities.chains.items() if np.abs(x[chain] - 0.1).max() < 1e-6}
    assert len(on_cut) == 8
    assert all(entities.edges[key].kind == "line" for key in on_cut)
    told = {tuple(pair) for pairs, _ in entities.on_curves() for pair in np.sort(pairs).tolist()}
    for key, chain in entities.chains.items():
        along = {tuple(pair) for pair in np.sort(np.column_stack([chain[:-1], chain[1:]])).tolist()}
        # Nor is there one where the closed face was divided.
        assert along <= told if entities.edges[key].kind == "circle" else not along & told


def _steps(chain):
    return zip(chain[:-1].tolist(), chain[1:].tolist(), strict=True)


def _sides(quads):
    return np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2)
