"""Smoothing: only where a mesh is not good enough, and never making it worse."""

from .cutting import Blocks
from .ladder import GOAL, Smoothed, improve
from .sliding import Slides

__all__ = ["GOAL", "Blocks", "Slides", "Smoothed", "improve"]
