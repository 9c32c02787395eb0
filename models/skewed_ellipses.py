"""Ellipses along a straight, skewed path: the paper's third example (figure 10).

::

              .-----------.     target   a plane ellipse, long in the direction of the skew
             /           /      rings    plane ellipses between the two: circular only half way,
            /           /                and turning from the one plane into the other
           /           /
          /           /         source   an ellipse, long across the skew, in a plane inclined to
         /        _.-'                   the target's by `tilt`; its inside is domed
        /     _.-'
        '._.-'                  sides    four ruled faces, which join points of equal parameter

Both ellipses are drawn as four arcs between their vertices, so that every ring is an exact affine
image of the source ring.
"""

import math

import cadquery as cq
from cadquery import func

length = 5.0  # height of the target's centre above the source's
skew = 3.0  # sideways shift of the target's centre
short, long = 1.0, 1.5  # semi-axes of the source, along and across the skew; `long` is the target's along it
tilt = 40.0  # inclination of the source, degrees
dome = 0.4  # height of the source above the plane of its boundary, outward; 0 leaves it plane

MIN_SCALED_JACOBIAN = 0.6  # of the mesh that the defaults make

inclined = cq.Vector(math.cos(math.radians(tilt)), 0, -math.sin(math.radians(tilt)))
normal = cq.Vector(-inclined.z, 0, inclined.x)  # of the source, along the sweep
# Half way, the semi-axes are the means of those at the ends: equal there, the ring is a circle.
last = (inclined * short + cq.Vector(long, 0, 0)).Length - long


def ellipse(center, normal, x_axis, x_radius, y_radius):
    """Four arcs from vertex to vertex."""
    arcs = [cq.Edge.makeEllipse(x_radius, y_radius, center, normal, x_axis, 90 * i, 90 * (i + 1)) for i in range(4)]
    return cq.Wire.assembleEdges(arcs)


def domed(wire, top):
    """A smooth face on a wire, through the point `top`; a plane one where no height is asked for."""
    if not dome:
        return cq.Face.makeFromWires(wire)
    surface = cq.Face.makeNSidedSurface(wire.Edges(), [top], nbPtsOnCur=40, nbIter=4, tol2d=1e-7, tol3d=1e-7)
    return cq.Face.constructOn(surface, wire)


start = ellipse(cq.Vector(0, 0, 0), normal, inclined, short, long)
end = ellipse(cq.Vector(skew, 0, length), cq.Vector(0, 0, 1), cq.Vector(1, 0, 0), long, last)
sides = func.loft(start, end, ruled=True).Faces()
caps = [domed(start, normal * -dome), cq.Face.makeFromWires(end)]
result = cq.Workplane(cq.Solid.makeSolid(cq.Shell.makeShell([*caps, *sides])))

show_object(result, name="skewed_ellipses")  # noqa: F821
