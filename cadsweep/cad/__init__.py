"""CAD in, :class:`cadsweep.topology.Part` out: the only package that touches OpenCASCADE and CadQuery."""

from .loading import load
from .selection import select_faces

__all__ = ["load", "select_faces"]
