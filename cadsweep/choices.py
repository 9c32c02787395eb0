"""Words that options of a sweep choose among; one home for the core, which knows no options, and for them."""

from __future__ import annotations

FUNCTIONALS = ("F", "G", "H")
"""Least-squares functionals for the affine maps of the layers (Roca, Sarrate and Huerta)."""

STRATEGIES = ("source", "advancing", "both")
"""From where each layer is projected: the source cap, the layer before it, or both caps."""
