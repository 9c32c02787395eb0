"""Two flanges and the gasket between them, held by bolts with heads.

::

             ___                 ___
      ______|___|_______________|___|______
      |      | |                 | |      |   upper flange
      -------| |-----------------| |-------   gasket
      |______|_|_________________|_|______|   lower flange
"""

import cadquery as cq

outer = 30.0  # radius of the flanges, mm
bore = 12.0  # radius of the bore, mm
thickness = 6.0  # of a flange, mm
gasket = 2.0  # thickness of the gasket, mm
bolt = 3.0  # radius of the bolts, mm
head = 5.0  # radius of the bolts' heads, mm
head_height = 3.0  # mm
circle = 22.0  # radius of the circle of bolts, mm
n_bolts = 4

MIN_SCALED_JACOBIAN = 0.3  # of the mesh that the defaults make


def plate(bottom, height):
    """A ring with the holes of the bolts."""
    ring = cq.Workplane(origin=(0, 0, bottom)).circle(outer).circle(bore).extrude(height)
    holes = cq.Workplane(origin=(0, 0, bottom)).polarArray(circle, 0, 360, n_bolts).circle(bolt).extrude(height)
    return ring.cut(holes)


top = 2 * thickness + gasket
shank = cq.Workplane().circle(bolt).extrude(top).faces(">Z").workplane().circle(head).extrude(head_height)
result = (
    cq.Assembly(name="bolted_flanges")
    .add(plate(0.0, thickness), name="lower", color=cq.Color("steelblue"))
    .add(plate(thickness, gasket), name="gasket", color=cq.Color("khaki"))
    .add(plate(thickness + gasket, thickness), name="upper", color=cq.Color("steelblue"))
)
for k in range(n_bolts):
    turned = shank.translate((circle, 0, 0)).rotate((0, 0, 0), (0, 0, 1), 360.0 * k / n_bolts)
    result.add(turned, name=f"bolt_{k + 1}", color=cq.Color("gray"))

show_object(result, name="bolted_flanges")  # noqa: F821
