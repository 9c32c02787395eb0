"""Blends of a solid: roundings that stand for an edge, and patches that stand for a corner.

Place in the flow: after ``cad``, on its values alone; ``cadsweep info`` lists what is found.

Not handled: blends whose borders are not tangent to what they lie between, and a rounding whose border is a sharp edge.
"""

from .finding import Blend, find_blends

__all__ = ["Blend", "find_blends"]
