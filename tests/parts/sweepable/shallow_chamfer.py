"""Trait: a chamfer nearly in the plane of the cap, which is better a part of it."""

import cadquery as cq

show_object(cq.Workplane().box(20, 16, 8).edges(">Z").chamfer(0.5, 3))  # noqa: F821
