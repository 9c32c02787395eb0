"""build123d: builders, labels, colours and children; where it is not installed, objects that offer the same."""

from __future__ import annotations

import pickle
from types import SimpleNamespace

import cadquery as cq
import numpy as np
import pytest

import cadsweep as cs
from cadsweep.cad.read.handover import make_portable

pytestmark = pytest.mark.cad

try:
    import build123d as bd
except ImportError as error:
    bd, reason = None, f"build123d cannot be imported: {error}"
else:
    reason = ""
real = pytest.mark.skipif(bd is None, reason=reason)


def shape(wrapped, label="", color=None, children=()):
    """As an object of build123d."""
    return SimpleNamespace(wrapped=wrapped, label=label, color=color, children=children)


def stack_alike():
    """Two boxes in a group that is moved, and a face of the upper one, as build123d holds them."""
    lower, upper = cq.Solid.makeBox(4, 4, 1), cq.Solid.makeBox(4, 4, 1).moved(cq.Location((0, 0, 1)))
    roof = upper.faces(">Z")
    group = cq.Compound.makeCompound([lower, upper, roof])
    children = [shape(lower.wrapped, "lower", "#008000"), shape(upper.wrapped, "upper")]
    children.append(shape(roof.wrapped, "roof", "#ffff00"))
    return shape(group.moved(cq.Location((10, 0, 0))).wrapped, "stack", None, children)


def stack():
    lower, upper = bd.Box(4, 4, 1), bd.Pos(0, 0, 1) * bd.Box(4, 4, 1)
    lower.label, lower.color = "lower", bd.Color("#008000")
    roof = upper.faces().sort_by(bd.Axis.Z)[-1]
    upper.label, roof.label, roof.color = "upper", "roof", bd.Color("#ffff00")
    group = bd.Compound(label="stack", children=[lower, upper, roof])
    group.location = bd.Location((12, 2, 0.5))
    return group


MAKERS = [stack_alike, pytest.param(stack, marks=real)]


@pytest.mark.parametrize("make", MAKERS)
@pytest.mark.parametrize("journey", [False, True], ids=["here", "to a worker"])
def test_labels_colours_and_places_of_children_are_kept(make, journey):
    source = make()
    part = cs.load(pickle.loads(pickle.dumps(make_portable(source))) if journey else source)
    assert part.name == "stack"
    assert [(model.name, model.path) for model in part.models] == [("lower", "stack/lower"), ("upper", "stack/upper")]
    assert part.models[1].color is None
    green = part.models[0].color
    assert green == "#008000" or (bd is not None and green is not None)  # 0.10 and before take colours as linear
    [(solid, roof)] = [(s, f) for s in part.solids for f in s.faces if f.name == "roof"]
    assert roof.color == "#ffff00"
    assert part.models[part.owners[part.solids.index(solid)]].name == "upper"
    corners = np.concatenate([s.vertices for s in part.solids]) * part.scale + part.offset
    np.testing.assert_allclose([corners.min(axis=0), corners.max(axis=0)], [[10, 0, 0], [14, 4, 2]], atol=1e-6)


def test_a_labelled_face_beside_a_part_names_its_face():
    box = cq.Workplane().box(1, 2, 3)
    top = shape(box.faces(">Z").val().wrapped, "top", "#0000ff")
    built = SimpleNamespace(part=shape(box.val().wrapped, "block"))
    part = cs.load([built, top])
    assert [model.name for model in part.models] == ["block"]
    assert [(face.name, face.color) for face in part.solids[0].faces if face.name] == [("top", "#0000ff")]
    assert "top" in cs.sweep_mesh([built, top], layers=2).boundaries


def test_an_empty_builder_says_so():
    with pytest.raises(cs.CadError, match=r"\.part is None"):
        cs.load(SimpleNamespace(part=None))


@real
def test_a_builder_is_meshed_by_its_faces_names():
    with bd.BuildPart() as plate:
        bd.Box(10, 8, 4)
        bd.Cylinder(2, 4, mode=bd.Mode.SUBTRACT)
    plate.part.label = "plate"
    top = plate.faces().sort_by(bd.Axis.Z)[-1]
    top.label = "top"
    mesh = cs.sweep_mesh([plate, top], size=2.0)
    assert list(mesh.parts) == ["plate"]
    assert "top" in mesh.boundaries
    volume = cs.load(plate).models[0].volume
    assert volume == pytest.approx(plate.part.volume)
    assert cs.sweep_mesh(plate, size=2.0).n_hexes == mesh.n_hexes
