"""CAD in, :class:`cadsweep.topology.Part` out: the only package that touches OpenCASCADE and CadQuery."""

from .loading import load

__all__ = ["load"]
