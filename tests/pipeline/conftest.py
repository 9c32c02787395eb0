"""Parts of a few hundred hexahedra, made once."""

import pytest

cq = pytest.importorskip("cadquery")
pytest.importorskip("gmsh")


@pytest.fixture(scope="session")
def elbow():
    """A quarter of a torus of square section, its source on the plane y = 0."""
    return cq.Workplane("XZ").center(10, 0).rect(4, 4).revolve(90, (-10, 0), (-10, 1))


@pytest.fixture(scope="session")
def plate():
    return cq.Workplane().box(20, 20, 3).faces(">Z").workplane().hole(6)


@pytest.fixture(scope="session")
def ring():
    """A full ring of L-shaped section: no caps, until it is cut open."""
    section = [(8, 0), (12, 0), (12, 1), (9, 1), (9, 4), (8, 4)]
    return cq.Workplane("XZ").polyline(section).close().revolve(360, (0, 0), (0, 1))


@pytest.fixture(scope="session")
def padded():
    """A bar with a named patch on one of its sides, whose outline no sweep follows."""
    bar = cq.Workplane().polygon(6, 20).extrude(25).val()
    tool = cq.Workplane("XZ", origin=(0, -6, 12)).rect(4, 8).extrude(6).val()
    solid = bar.cut(tool).fuse(bar.intersect(tool)).Solids()[0]
    model = cq.Assembly(solid)
    model.addSubshape(min(solid.Faces(), key=lambda face: face.Area()), name="pad")
    return model
