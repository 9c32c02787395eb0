"""A square that becomes four arcs, along a straight, skewed path: the paper's fourth example (figure 11).

::

            .--'''''--.       target   plane, bounded by four arcs of sagitta `bulge`
            )         (       rings    plane; the nearer to the target, the more curved, and turning
           /'--.....-'/                from the one plane into the other
          /          /
         /          /         source   a square in a plane inclined to the target's by `tilt`;
        /        _.-|                  its inside is domed
       /      _.-   |
       |  _.-'   _.-'         sides    four, drawn through plane sections
       '-'____.-'

The arcs are flat: a full circle would ask for corners of 180 degrees. Source and target are not
affine to one another.
"""

import math

import cadquery as cq
from cadquery import func

side = 2.0  # side of the square
length = 5.0  # height of the target's centre above the source's
skew = 3.0  # sideways shift of the target's centre
bulge = 0.2  # sagitta of the target's arcs
tilt = 40.0  # inclination of the source, degrees
dome = 0.4  # height of the source above the plane of its boundary, outward; 0 leaves it plane
n_sections = 5  # sections that the sides are drawn through

MIN_SCALED_JACOBIAN = 0.5  # of the mesh that the defaults make

half = side / 2
inclined = cq.Vector(math.cos(math.radians(tilt)), 0, -math.sin(math.radians(tilt)))
normal = cq.Vector(-inclined.z, 0, inclined.x)  # of the source, along the sweep
corners = [(-half, -half), (half, -half), (half, half), (-half, half)]


def section(t):
    """Four lines or arcs at the fraction t of the path; corners go straight from cap to cap."""
    center = cq.Vector(skew, 0, length) * t
    x_axis = inclined * (1 - t) + cq.Vector(1, 0, 0) * t
    y_axis = cq.Vector(0, 1, 0)
    points = [center + x_axis * x + y_axis * y for x, y in corners]
    edges = []
    for start, end in zip(points, points[1:] + points[:1], strict=True):
        middle = (start + end) / 2
        outward = (middle - center).normalized()
        if t * bulge == 0:
            edges.append(cq.Edge.makeLine(start, end))
        else:
            edges.append(cq.Edge.makeThreePointArc(start, middle + outward * bulge * t, end))
    return cq.Wire.assembleEdges(edges)


def domed(wire, top):
    """A smooth face on a wire, through the point `top`; a plane one where no height is asked for."""
    if not dome:
        return cq.Face.makeFromWires(wire)
    surface = cq.Face.makeNSidedSurface(wire.Edges(), [top], degree=5, nbPtsOnCur=30, nbIter=3, tol3d=1e-7)
    return cq.Face.constructOn(surface, wire)


start, end = section(0), section(1)
sides = func.loft(*(section(i / (n_sections - 1)) for i in range(n_sections))).Faces()
caps = [domed(start, normal * -dome), cq.Face.makeFromWires(end)]
result = cq.Workplane(cq.Solid.makeSolid(cq.Shell.makeShell([*caps, *sides])))

show_object(result, name="square_to_arcs")  # noqa: F821
