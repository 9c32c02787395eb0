"""Nuts and bolts whose chamfers touch their flats: faces with tips of no angle."""

import math

import cadquery as cq


def chamfered_nut(n_sides: int, across: float = 13.0, height: float = 6.8, bore: float = 7.0) -> cq.Workplane:
    """A nut with a chamfer of 30 degrees at both ends, whose circle is as wide as the nut across its flats."""
    wide = across / math.cos(math.pi / n_sides)
    beyond = wide / 2 + 1.0 - across / 2
    turned = cq.Workplane().circle(across / 2 + beyond).extrude(height)
    turned = turned.faces("<Z or >Z").edges().chamfer(math.tan(math.pi / 6) * beyond, beyond)
    return cq.Workplane().polygon(n_sides, wide).extrude(height).intersect(turned).faces(">Z").workplane().hole(bore)


def chamfered_bolt(across: float = 17.0, height: float = 8.0, shank: float = 5.0, length: float = 25.0) -> cq.Workplane:
    """A bolt whose hexagon head has such a chamfer above; the shank goes down from the origin."""
    wide = across / math.cos(math.pi / 6)
    beyond = wide / 2 + 1.0 - across / 2
    turned = cq.Workplane().circle(across / 2 + beyond).extrude(height)
    turned = turned.faces(">Z").edges().chamfer(math.tan(math.pi / 6) * beyond, beyond)
    head = cq.Workplane().polygon(6, wide).extrude(height).intersect(turned)
    return head.union(cq.Workplane().circle(shank).extrude(-length))
