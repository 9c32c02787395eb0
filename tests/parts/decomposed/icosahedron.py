"""An icosahedron: five triangles at every corner, and any plane through one leaves as many edges at others."""

from itertools import combinations
from math import dist, sqrt

import cadquery as cq

LONG = 0.5 * (1.0 + sqrt(5.0))
corners = [
    cq.Vector(*place)
    for a in (-6.0, 6.0)
    for b in (-6.0 * LONG, 6.0 * LONG)
    for place in ((0, a, b), (a, b, 0), (b, 0, a))
]
faces = [
    cq.Face.makeFromWires(cq.Wire.makePolygon(three, close=True))
    for three in combinations(corners, 3)
    if all(dist(a.toTuple(), b.toTuple()) < 13.0 for a, b in combinations(three, 2))
]
result = cq.Workplane(obj=cq.Solid.makeSolid(cq.Shell.makeShell(faces)).fix())

show_object(result, name="icosahedron")  # noqa: F821
