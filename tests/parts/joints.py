"""Plates between parts whose outlines on them differ: bolted joints."""

import cadquery as cq

from tests.parts.chamfered import chamfered_bolt, chamfered_nut

THICK = 10.0


def plate(bore: float = 11.0) -> cq.Workplane:
    """A square plate with a hole, its upper face at z = 0."""
    return cq.Workplane().box(40, 40, THICK).faces(">Z").workplane().hole(bore).translate((0, 0, -THICK / 2))


def between(n_sides: int, radius: float, turn: float = 0.0) -> cq.Assembly:
    """The plate between a bored prism of `n_sides` on it and a washer of a radius below."""
    prism = cq.Workplane().transformed(rotate=(0, 0, turn)).polygon(n_sides, 20).circle(5.5).extrude(6)
    washer = cq.Workplane().circle(radius).circle(5.5).extrude(-2).translate((0, 0, -THICK))
    return cq.Assembly().add(plate(), name="plate").add(prism, name="prism").add(washer, name="washer")


def bolted(*, head: bool = True) -> cq.Assembly:
    """The plate with a nut below it and, with `head`, a bolt through both: chamfers touch the flats."""
    nut = chamfered_nut(6, across=17, height=8, bore=10).translate((0, 0, -THICK - 8))
    joint = cq.Assembly().add(plate(), name="plate").add(nut, name="nut")
    return joint.add(chamfered_bolt(), name="bolt") if head else joint
