"""Trait: a fillet all around the edge of a cap, tangent to cap and sides."""

import cadquery as cq

show_object(cq.Workplane().box(24, 16, 8).edges(">Z").fillet(2))  # noqa: F821
