"""Smoothing: only where a mesh is not good enough, and never making it worse."""

from .ladder import Smoothed, improve

__all__ = ["Smoothed", "improve"]
