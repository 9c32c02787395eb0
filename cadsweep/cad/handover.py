"""Sources that another process can take: CadQuery's own objects can be pickled, bare OpenCASCADE shapes cannot.

Place in the flow: before an isolated run, in the caller.
"""

from __future__ import annotations

from os import PathLike
from typing import Any


def make_portable(source: Any) -> Any:
    """Return what :func:`cadsweep.cad.load` reads alike, and what can be pickled where that is possible.

    Parameters
    ----------
    source
        As for :func:`cadsweep.cad.load`.

    Returns
    -------
    object
        An OpenCASCADE shape, or an object with one as its ``.wrapped``, as a ``cq.Shape``; all else as it is.
    """
    if isinstance(source, str | PathLike):
        return source
    import cadquery as cq
    from OCP.TopoDS import TopoDS_Shape

    if isinstance(source, cq.Shape):
        return source
    shape = getattr(source, "wrapped", source)
    return cq.Shape.cast(shape) if isinstance(shape, TopoDS_Shape) and not shape.IsNull() else source
