"""Nuts whose chamfers touch their flats: faces with tips of no angle."""

import math

import cadquery as cq


def chamfered_nut(n_sides: int, across: float = 13.0, height: float = 6.8, bore: float = 7.0) -> cq.Workplane:
    """A nut with a chamfer of 30 degrees at both ends, whose circle is as wide as the nut across its flats."""
    wide = across / math.cos(math.pi / n_sides)
    beyond = wide / 2 + 1.0 - across / 2
    turned = cq.Workplane().circle(across / 2 + beyond).extrude(height)
    turned = turned.faces("<Z or >Z").edges().chamfer(math.tan(math.pi / 6) * beyond, beyond)
    return cq.Workplane().polygon(n_sides, wide).extrude(height).intersect(turned).faces(">Z").workplane().hole(bore)
