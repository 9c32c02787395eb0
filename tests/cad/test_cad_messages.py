"""Messages give places in the model's own units, however a part was scaled and shifted for the work."""

import re

import numpy as np
import pytest

cq = pytest.importorskip("cadquery")

import cadsweep as cs  # noqa: E402

ASLANT = cq.Workplane(cq.Plane((0, 0, 0), (1, 0, -1), (1, 2, 1))).circle(0.25).extrude(10, both=True)
DRILLED = cq.Workplane().box(4, 3, 2).faces(">Z").workplane().hole(1).cut(ASLANT)


def places(message):
    return [np.array([float(x) for x in found.split(",")]) for found in re.findall(r" at ([-\d., e+]+)\)", message)]


@pytest.mark.parametrize("scale", [1.0, 1e-3, 1e4])
@pytest.mark.parametrize("shift", [(0.0, 0.0, 0.0), (1e6, -2e6, 0.0)])
def test_places_in_a_refusal_lie_in_the_part(scale, shift):
    part = cs.load(DRILLED.val().scale(scale).translate(cq.Vector(*(scale * s for s in shift))))
    half = scale * np.array([2.0, 1.5, 1.0])
    with pytest.raises(cs.NotSweepableError) as caught:
        cs.find_sweeps(part)
    found = [place for reason in caught.value.reasons for place in places(reason)]
    assert len(found) >= len(caught.value.reasons)
    off = np.abs(np.array(found) - scale * np.array(shift))
    assert (off <= 1.002 * half).all()
    assert off.max() > 0.9 * half.max()


def test_a_size_that_is_too_large_is_compared_in_the_users_units():
    part = cs.load(cq.Workplane().box(4e-3, 3e-3, 2e-3))
    mesh = cs.sweep_mesh(part, size=0.5)
    said = "size 0.5 is larger than the whole part, whose diagonal is 0.005385"
    assert any(note.startswith(said) for note in mesh.info["notes"])
    assert mesh.quality().valid


def test_a_bore_that_another_touches_from_inside_is_named_with_the_place():
    """Bores of radii 6 and 4 whose axes are 2 apart: both end at z = 6, where their curve crosses itself."""
    block = cq.Workplane().box(60, 60, 40).cut(cq.Workplane("YZ").center(-6, 0).circle(6).extrude(30, both=True))
    block = block.cut(cq.Workplane("XZ").center(10, 2).circle(4).extrude(30, both=True))
    with pytest.raises(cs.CadError, match=r"face \d+ touches itself at \(10, -6, 6\)"):
        cs.load(block)
