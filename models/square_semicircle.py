"""A square along a semicircle that ends in a bent face: the paper's second example (figure 9).

::

         ______               source   a square in a plane, its inside domed
        /  ^   \\    . ' .     target   bounded by four parabolas that leave its plane: two opposite
       |  dome  |  ~ bent ~            sides bow forward, the other two backward
        \\______/   ' . . '    sides    four; their cross-sections bend more and more towards the
           \\         /                 target, so that the rings grow less plane
            `--.__.-'

At the fraction t of the semicircle, the point (x, y) of the square is moved forward by
``bend * t**2 * (x**2 - y**2) / half**2``: a saddle, zero at the corners and on average.
"""

import math

import cadquery as cq
from cadquery import func

side = 2.0  # side of the square
R = 3.0  # radius of the semicircle
bend = 0.4  # how far the middles of the target's sides leave its plane
dome = 0.4  # height of the source above the plane of its boundary, outward; 0 leaves it plane
n_sections = 13  # sections that the sides are drawn through

MIN_SCALED_JACOBIAN = 0.4  # of the mesh that the defaults make

half = side / 2
corners = [(-half, -half), (half, -half), (half, half), (-half, half)]


def place(x, y, t):
    """The point (x, y) of the section at the fraction t of the semicircle."""
    forward = bend * t**2 * (x**2 - y**2) / half**2
    sine, cosine = math.sin(math.pi * t), math.cos(math.pi * t)
    return cq.Vector((R + x) * cosine - forward * sine, y, -(R + x) * sine - forward * cosine)


def section(t):
    """The bent square at the fraction t: four parabolas."""
    edges = []
    for (x0, y0), (x1, y1) in zip(corners, corners[1:] + corners[:1], strict=True):
        start, end = place(x0, y0, t), place(x1, y1, t)
        middle = place((x0 + x1) / 2, (y0 + y1) / 2, t)
        edges.append(cq.Edge.makeBezier([start, middle * 2 - (start + end) / 2, end]))
    return cq.Wire.assembleEdges(edges)


def cap(wire, *through):
    """A smooth face on a wire, through the points `through`."""
    surface = cq.Face.makeNSidedSurface(wire.Edges(), through, degree=5, nbPtsOnCur=30, nbIter=3, tol3d=1e-7)
    return cq.Face.constructOn(surface, wire)


sides = func.loft(*(section(i / (n_sections - 1)) for i in range(n_sections))).Faces()
source = cap(section(0), place(0, 0, 0) + cq.Vector(0, 0, dome))
target = cap(section(1))
result = cq.Workplane(cq.Solid.makeSolid(cq.Shell.makeShell([source, target, *sides])))

show_object(result, name="square_semicircle")  # noqa: F821
