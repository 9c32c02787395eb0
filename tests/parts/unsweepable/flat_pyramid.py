"""A pyramid whose faces meet its base at 6 degrees: no hexahedron at its foot is wider."""

from math import radians, tan

import cadquery as cq

corners = [(-10, -10, 0), (10, -10, 0), (10, 10, 0), (-10, 10, 0), (0, 0, 10 * tan(radians(6)))]


def face(*at):
    """The plane face with these corners."""
    return cq.Face.makeFromWires(cq.Wire.makePolygon([cq.Vector(*corners[j]) for j in at], close=True))


faces = [face(0, 1, 2, 3), face(0, 1, 4), face(1, 2, 4), face(2, 3, 4), face(3, 0, 4)]
result = cq.Workplane(obj=cq.Solid.makeSolid(cq.Shell.makeShell(faces)))

show_object(result, name="flat_pyramid")  # noqa: F821
