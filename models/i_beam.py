"""An I-beam with fillets between web and flanges.

::

       .-------------.
       '----.   .----'      a constant section, bounded by lines and four fillet arcs
            |   |
            |   |
       .----'   '----.
       '-------------'
"""

import cadquery as cq

height = 100.0  # mm
width = 60.0  # of the flanges, mm
web = 8.0  # thickness, mm
flange = 10.0  # thickness, mm
fillet = 6.0  # radius, mm
length = 300.0  # mm

MIN_SCALED_JACOBIAN = 0.5  # of the mesh that the defaults make

inner = height / 2 - flange
result = (
    cq.Workplane("XY")
    .rect(width, height)
    .extrude(length)
    .cut(cq.Workplane("XY").pushPoints([(-width / 2, 0), (width / 2, 0)]).rect(width - web, 2 * inner).extrude(length))
    .edges(cq.selectors.BoxSelector((-web, -inner - 1, 0), (web, inner + 1, length)))
    .edges("|Z")
    .fillet(fillet)
)

show_object(result, name="i_beam")  # noqa: F821
