"""A corrugated sheet with holes: caps of many tangent cylinders, swept through the thickness."""

import cadquery as cq

outer = cq.Workplane("XZ").moveTo(-4, 0).threePointArc((0, 4), (4, 0)).threePointArc((10, -6), (16, 0))
outer = outer.lineTo(14, 0).threePointArc((10, -4), (6, 0)).threePointArc((0, 6), (-6, 0)).close()
sheet = outer.extrude(-20)
holes = cq.Workplane("XY").pushPoints([(0, 7), (0, 15)]).circle(1.5).extrude(10)
result = sheet.cut(holes)

show_object(result, name="corrugated_sheet")  # noqa: F821
