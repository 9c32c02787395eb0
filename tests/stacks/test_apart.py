"""Caps of unlike heights that come near each other in plan: no layer stands up between them."""

import cadquery as cq
import pytest

import cadsweep as cs

DEPTHS = (7.0, 6.2)


def block(gap: float) -> cq.Workplane:
    """A block with two pockets whose floors are 0.8 apart in height, and whose nearest corners are by a gap in plan."""
    part = cq.Workplane().box(40, 40, 12, centered=(True, True, False))
    for side, depth in zip((1.0, -1.0), DEPTHS, strict=True):
        at = side * (5.0 + gap / 2.0)
        part = part.cut(cq.Workplane("XY", (at, at, 12.0 - depth)).rect(10, 10).extrude(12))
    return part


@pytest.mark.parametrize("gap", [0.01, 0.1, 1.0])
def test_floors_that_all_but_touch_in_plan_have_levels_of_their_own(gap):
    mesh = cs.sweep_mesh(block(gap), size=5.0, decompose=False)
    assert mesh.quality().min_scaled_jacobian > 0.6


def test_floors_far_from_each_other_share_a_level():
    far = cs.sweep_mesh(block(4.0), size=5.0, decompose=False)
    near = cs.sweep_mesh(block(0.1), size=5.0, decompose=False)
    assert far.info["sweeps"][0]["layers"] < near.info["sweeps"][0]["layers"]
