"""Boundary nodes against real CAD faces, edges and vertices: none is missed, and none is blamed without cause."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import cadsweep
from cadsweep.quality import check_mesh

cq = pytest.importorskip("cadquery")
pytest.importorskip("gmsh")
pytestmark = pytest.mark.cad

SPLINE = [(2, 0), (2.5, 1), (1, 2)]


def spring():
    helix = cq.Wire.makeHelix(2, 3, 3)
    return cq.Solid.sweep(cq.Wire.makeCircle(0.5, cq.Vector(3, 0, 0), cq.Vector(0, 1, 0)), [], helix, True, True)


def skewed_loft():
    return cq.Workplane().rect(1, 1).workplane(offset=5).center(-2, -1).ellipse(0.8, 0.7).loft()


def offset_sheet():
    points = [[cq.Vector(x, y, 0.3 * np.sin(x) * np.cos(y)) for x in range(4)] for y in range(4)]
    return cq.Face.makeSplineApprox(points, tol=1e-3).thicken(0.3)


PARTS = {
    "planes": lambda: cq.Workplane().box(2, 3, 1),
    "cylinder": lambda: cq.Workplane().circle(1).extrude(2),
    "cone": lambda: cq.Solid.makeCone(2, 1, 2),
    "torus": lambda: cq.Workplane().circle(1).revolve(120, (4, 0, 0), (4, 1, 0)),
    "ellipse": lambda: cq.Workplane().ellipse(2, 1).extrude(1),
    "extruded spline": lambda: cq.Workplane().spline(SPLINE, includeCurrent=True).lineTo(0, 2).close().extrude(1),
    "revolved spline": lambda: (
        cq.Workplane("XZ")
        .moveTo(2, 0)
        .spline([(4, 0), (5, 1), (4, 2)], includeCurrent=True)
        .lineTo(2, 2)
        .close()
        .revolve(90, (0, 0, 0), (0, 1, 0))
    ),
    "loft": skewed_loft,
    "twist": lambda: cq.Workplane().rect(1, 2).twistExtrude(4, 100),
    "spring": spring,
    "offset": offset_sheet,
    "fillet": lambda: cq.Workplane().box(4, 4, 1).edges("|Z").fillet(0.7),
    "far away": lambda: cq.Workplane("XY", origin=(3e4, 0, 0)).circle(1).extrude(2),
}


@pytest.fixture(scope="module", params=PARTS)
def meshed(request):
    part = cadsweep.load(PARTS[request.param]())
    mesh = cadsweep.sweep_mesh(part, max_hexes=40_000, smoothing=False, layers=30 if request.param == "spring" else 6)
    (reference,) = mesh.origin.references.values()
    return mesh, reference


def problems_with(mesh, reference, node, to):
    points = mesh.points.copy()
    points[node] = to
    return [p for p in check_mesh(replace(mesh, points=points), cad=reference).problems if "off their CAD" in p]


def owners(mesh):
    """Names of the boundaries of every boundary node."""
    names = {}
    for name, quads in mesh.boundaries.items():
        for node in np.unique(quads):
            names.setdefault(int(node), set()).add(name)
    return names


def test_a_sound_mesh_has_nothing_off(meshed):
    mesh, reference = meshed
    assert check_mesh(mesh, cad=reference).problems == ()


def test_every_single_node_is_found(meshed):
    """Moved by ten times the tolerance along the normal of one of its quads, any boundary node is named."""
    mesh, reference = meshed
    size = np.linalg.norm(np.ptp(mesh.points, axis=0))
    step = 10 * reference.tolerance * size
    rng = np.random.default_rng(0)
    for name, quads in mesh.boundaries.items():
        for quad in quads[rng.integers(len(quads), size=3)]:
            normal = np.cross(*(mesh.points[quad[2:]] - mesh.points[quad[:2]]))
            normal /= np.linalg.norm(normal)
            node = int(rng.choice(quad))
            for sign in (1, -1):
                found = problems_with(mesh, reference, node, mesh.points[node] + sign * step * normal)
                assert any(f"node {node} " in p for p in found), (name, node)


def test_a_node_of_an_edge_may_not_slide_off_it(meshed):
    """A node of two faces that moves to a neighbour within one of them is still on a face, but on no edge."""
    mesh, reference = meshed
    named = owners(mesh)
    for pair in {frozenset(names) for names in named.values() if len(names) == 2}:
        node = next(n for n, names in named.items() if names == pair)
        quads = mesh.boundaries[min(pair)]
        around = np.unique(quads[(quads == node).any(axis=1)])
        inner = [int(n) for n in around if named[int(n)] == {min(pair)}]
        if inner:
            found = problems_with(mesh, reference, node, mesh.points[inner[0]])
            assert any("off their CAD edge" in p and f"node {node} " in p for p in found), pair


def test_a_node_of_a_vertex_may_not_slide_along_an_edge(meshed):
    mesh, reference = meshed
    named = owners(mesh)
    corners = [n for n, names in named.items() if len(names) > 2]
    for node in corners[:3]:
        quads = np.concatenate(list(mesh.boundaries.values()))
        around = np.unique(quads[(quads == node).any(axis=1)])
        edge = next(int(n) for n in around if len(named[int(n)]) == 2)
        found = problems_with(mesh, reference, node, mesh.points[edge])
        assert any("off their CAD vertex" in p and f"node {node} " in p for p in found)
