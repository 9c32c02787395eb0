"""An octahedron: eight triangles, four at every corner."""

import cadquery as cq

ring = [cq.Vector(5, 5, 0), cq.Vector(-5, 5, 0), cq.Vector(-5, -5, 0), cq.Vector(5, -5, 0)]
poles = [cq.Vector(0, 0, 7), cq.Vector(0, 0, -7)]
faces = [
    cq.Face.makeFromWires(cq.Wire.makePolygon([ring[k], ring[(k + 1) % 4], pole], close=True))
    for pole in poles
    for k in range(4)
]
result = cq.Workplane(obj=cq.Solid.makeSolid(cq.Shell.makeShell(faces)))

show_object(result, name="octahedron")  # noqa: F821
