"""A tetrahedron: four triangles."""

import cadquery as cq

points = [cq.Vector(0, 0, 0), cq.Vector(10, 0, 0), cq.Vector(0, 10, 0), cq.Vector(0, 0, 10)]
faces = [
    cq.Face.makeFromWires(cq.Wire.makePolygon([points[i] for i in corner], close=True))
    for corner in ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))
]
result = cq.Workplane(obj=cq.Solid.makeSolid(cq.Shell.makeShell(faces)))

show_object(result, name="tetrahedron")  # noqa: F821
