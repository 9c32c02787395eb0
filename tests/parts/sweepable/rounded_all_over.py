"""Trait: every edge rounded, so that no cap meets a side at an angle and the corners are spheres."""

import cadquery as cq

show_object(cq.Workplane().box(20, 16, 12).edges().fillet(2.5))  # noqa: F821
