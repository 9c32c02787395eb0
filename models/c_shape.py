"""A C of circular section: the paper's first example (figure 8).

::

        dome                 source   disc of radius r, centre at distance R from the axis;
         __                           its boundary is a plane circle, its inside is domed
        /  \\       ____      target   the plane disc at the other end
       |    |     |    |     sides    half tori: two, because the circle is drawn as two arcs
        \\    \\___/    /
         \\           /        every ring between the caps is the source ring, turned about the
          `--.___.--'         axis; nothing is approximated

The two arcs are kept through the revolve (``clean=False``), so that no seam has to be cut later and
the sides stay exact.
"""

import cadquery as cq

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


section = cq.Workplane("XY").moveTo(R - r, 0).threePointArc((R, r), (R + r, 0)).threePointArc((R, -r), (R - r, 0))
body = section.close().revolve(angle, (0, 0), (0, 1), clean=False)

source = body.faces(cq.NearestToPointSelector((R, 0, 0))).val()
others = [face for face in body.faces().vals() if not face.isSame(source)]
result = cq.Workplane(cq.Solid.makeSolid(cq.Shell.makeShell([*others, domed(source, dome)])))

show_object(result, name="c_shape")  # noqa: F821
