"""Sources that another process can take: CadQuery's own objects can be pickled, bare OpenCASCADE shapes cannot.

Place in the flow: before an isolated run, in the caller. CadQuery's colours are others when they have been pickled
(they go out as sRGB and come back as if they were linear), so an assembly goes as a tree with its colours as text.
"""

from __future__ import annotations

from dataclasses import replace
from os import PathLike
from typing import Any

from .tree import AssemblyNode


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

    if isinstance(source, cq.Assembly):
        return _as_node(source)
    shape = getattr(source, "wrapped", source)
    if shape is source and getattr(source, "part", None) is not None:
        return make_portable(source.part)
    if isinstance(source, cq.Workplane) or not isinstance(shape, TopoDS_Shape) or shape.IsNull():
        return source
    from .labelled import labelled_tree

    return cq.Shape.cast(shape) if shape is source else _portable(labelled_tree(source))


def _portable(node: AssemblyNode) -> AssemblyNode:
    """The node with shapes of CadQuery."""
    import cadquery as cq

    def cast(held: Any) -> Any:
        return None if held is None else cq.Shape.cast(held.wrapped)

    return replace(
        node,
        obj=cast(node.obj),
        _subshape_names={cast(held): name for held, name in node._subshape_names.items()},
        _subshape_colors={cast(held): color for held, color in node._subshape_colors.items()},
        children=[_portable(child) for child in node.children],
    )


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
