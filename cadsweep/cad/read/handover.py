"""Sources that another process can take: CadQuery's own objects can be pickled, bare OpenCASCADE shapes cannot.

Place in the flow: before an isolated run, in the caller. CadQuery's colours are others when they have been pickled
(they go out as sRGB and come back as if they were linear), so an assembly goes as a tree with its colours as text.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import Any


@dataclass(frozen=True, kw_only=True, eq=False)
class AssemblyNode:
    """What :mod:`cadsweep.cad.objects` reads of a ``cq.Assembly``, under the same names."""

    name: str
    loc: Any
    obj: Any
    color: str | None
    material: Any
    _subshape_names: Mapping[Any, str]
    _subshape_colors: Mapping[Any, str | None]
    children: Sequence[AssemblyNode]


def make_portable(source: Any) -> Any:
    """Return what :func:`cadsweep.cad.load` reads alike, and what can be pickled where that is possible.

    Parameters
    ----------
    source
        As for :func:`cadsweep.cad.load`.

    Returns
    -------
    object
        An OpenCASCADE shape, or an object with one as its ``.wrapped``, as a ``cq.Shape``; an assembly as
        :class:`AssemblyNode`; all else as it is.
    """
    if isinstance(source, str | PathLike):
        return source
    if isinstance(source, list | tuple):
        return [make_portable(one) for one in source]
    import cadquery as cq
    from OCP.TopoDS import TopoDS_Shape

    if isinstance(source, cq.Shape):
        return source
    if isinstance(source, cq.Assembly):
        return _as_node(source)
    shape = getattr(source, "wrapped", source)
    return cq.Shape.cast(shape) if isinstance(shape, TopoDS_Shape) and not shape.IsNull() else source


def _as_node(assembly: Any) -> AssemblyNode:
    from .colors import object_color

    return AssemblyNode(
        name=assembly.name,
        loc=assembly.loc,
        obj=assembly.obj,
        color=object_color(assembly.color),
        material=getattr(assembly, "material", None),
        _subshape_names=dict(getattr(assembly, "_subshape_names", {})),
        _subshape_colors={
            shape: object_color(color) for shape, color in getattr(assembly, "_subshape_colors", {}).items()
        },
        children=[_as_node(child) for child in assembly.children],
    )
