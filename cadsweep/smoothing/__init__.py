"""Smoothing: only where a mesh is not good enough, and never making it worse."""

from .cutting import Blocks
from .ladder import Smoothed, improve

__all__ = ["Blocks", "Smoothed", "improve"]
