"""Corners of faces too sharp for a quad; here, so that nobody imports OpenCASCADE's booleans to look for them."""

from __future__ import annotations

from math import pi

from ...brep import Solid

SHARP = pi / 10
"""Angle of a face, radians, below which its corner is a tip: its sine is 0.3, and no quad there can be better."""


def has_sharp_corners(solid: Solid) -> bool:
    """Whether a face ends in a tip."""
    return any(angle < SHARP for face in solid.faces for loop in face.loops for angle in loop.angles)


__all__ = ["SHARP", "has_sharp_corners"]
