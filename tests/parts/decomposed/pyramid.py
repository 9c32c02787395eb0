"""A pyramid: triangular sides over a square."""

import cadquery as cq

ring = [cq.Vector(5, 5, 0), cq.Vector(-5, 5, 0), cq.Vector(-5, -5, 0), cq.Vector(5, -5, 0)]
top = cq.Vector(0, 0, 8)
rims = [[*ring], *([ring[k], ring[(k + 1) % 4], top] for k in range(4))]
faces = [cq.Face.makeFromWires(cq.Wire.makePolygon(rim, close=True)) for rim in rims]
result = cq.Workplane(obj=cq.Solid.makeSolid(cq.Shell.makeShell(faces)))

show_object(result, name="pyramid")  # noqa: F821
