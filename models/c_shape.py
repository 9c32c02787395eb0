"""A C of circular section: the paper's first example (figure 8).

::

        dome                 source   disc of radius r, centre at distance R from the axis;
         __                           its boundary is a plane circle, its inside is domed
        /  \\       ____      target   the plane disc at the other end
       |    |     |    |     sides    half tori: two, because the circle is drawn as two arcs
        \\    \\___/    /
         \\           /        every ring between the caps is the source ring, turned about the
          `--.___.--'         axis; nothing is approximated

The two arcs are kept through the revolve, so that no seam has to be cut later and
the sides stay exact.
"""

import cadquery as cq
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeWire
from OCP.BRepTools import BRepTools_ReShape

r = 1.0  # radius of the section
R = 3.0  # radius of the sweep path
angle = 180.0  # how far the section is turned, degrees
dome = 0.4  # height of the source above the plane of its boundary, outward; 0 leaves it plane

MIN_SCALED_JACOBIAN = 0.5  # of the mesh that the defaults make


def domed(face, height):
    """A cap on the boundary of a plane face that rises to `height` above its middle."""
    if not height:
        return face
    top = face.Center() + face.normalAt() * height
    surface = cq.Face.makeNSidedSurface(face.Edges(), [top], nbPtsOnCur=40, nbIter=4, tol2d=1e-7, tol3d=1e-7)
    return cq.Face.constructOn(surface, face.outerWire())


# One arc after the other: a wire made of both at once keeps either of two ends that meet to rounding.
upper = cq.Edge.makeThreePointArc(cq.Vector(R - r, 0), cq.Vector(R, r), cq.Vector(R + r, 0))
lower = cq.Edge.makeThreePointArc(cq.Vector(R + r, 0), cq.Vector(R, -r), cq.Vector(R - r, 0))
section = cq.Wire(BRepBuilderAPI_MakeWire(upper.wrapped, lower.wrapped).Wire())
body = cq.Workplane(cq.Solid.revolve(section, [], angle, cq.Vector(0, 0), cq.Vector(0, 1)))

source = body.faces(cq.NearestToPointSelector((R, 0, 0))).val()
cap = domed(source, dome).wrapped
if cq.Face(cap).normalAt().dot(source.normalAt()) < 0:
    cap = cap.Reversed()
# Exchanged in place: sewing the faces together anew would keep any one of two equal edges.
exchange = BRepTools_ReShape()
exchange.Replace(source.wrapped, cap)
result = cq.Workplane(cq.Shape.cast(exchange.Apply(body.val().wrapped)))

show_object(result, name="c_shape")  # noqa: F821
