"""Shapes that carry a label, a colour and children, as those of build123d do, as a tree of an assembly.

Place in the flow: one of the readers; it imports neither build123d nor CadQuery, whose shapes have labels, too. A
child of build123d knows its place in its parent alone, and a parent's compound holds its children where they are: so
the tree is walked along the compound, and every child is found in it by the shape that both share.

A child that is a face or an edge names (and colours) the face or edge that lies there, and is not meshed itself.
"""

from __future__ import annotations

import logging
from typing import Any

from OCP.TopoDS import TopoDS_Iterator

from ..names.unique import is_meaningful
from ..shapes import EDGE, FACE, SOLID, compound, subshapes
from .colors import object_color
from .tree import AssemblyNode, Held

logger = logging.getLogger(__name__)


def labelled_tree(source: Any) -> AssemblyNode:
    """Read labels, colours and children of a shape.

    Parameters
    ----------
    source
        With an OpenCASCADE shape as ``.wrapped``, and maybe ``.label``, ``.color``, ``.material`` and ``.children``.

    Returns
    -------
    AssemblyNode
        What :mod:`cadsweep.cad.read.objects` reads of an assembly; its shapes are :class:`Held`.
    """
    return _node(source, source.wrapped, above=None)


def _node(source: Any, placed: Any, *, above: str | None) -> AssemblyNode:
    """The node of an object whose shape lies at `placed`.

    `above` is what solids without a label are called after: the label of the group that they are in; None for the
    whole, whose label is the part's name.
    """
    own = _label(source)
    color = object_color(getattr(source, "color", None))
    if above is None and not subshapes(placed, SOLID):
        names, colors = _marks(placed, own, color)
        return AssemblyNode(name="", obj=Held(placed), _subshape_names=names, _subshape_colors=colors)
    group = own or above or ""
    rest = _parts_of(placed)
    given = list(getattr(source, "children", None) or ())
    children: list[AssemblyNode] = []
    all_names: dict[Held, str] = {}
    all_colors: dict[Held, str | None] = {}
    for child in given:
        wrapped = getattr(child, "wrapped", None)
        at = next((j for j, shape in enumerate(rest) if wrapped is not None and shape.IsPartner(wrapped)), None)
        if at is None:
            logger.warning("'%s' is listed in '%s', and its shape is not in it: left out", _label(child), group)
            continue
        shape = rest.pop(at)
        if subshapes(shape, SOLID):
            children.append(_node(child, shape, above="" if above is None else group))
        else:
            names, colors = _marks(shape, _label(child), object_color(getattr(child, "color", None)))
            all_names |= names
            all_colors |= colors
    obj = (Held(compound(rest)) if rest else None) if given else Held(placed)
    return AssemblyNode(
        name=group,
        obj=obj,
        color=color,
        material=_material(source),
        _subshape_names=all_names,
        _subshape_colors=all_colors,
        children=children,
    )


def _label(source: Any) -> str:
    label = getattr(source, "label", None)
    return label.strip() if isinstance(label, str) and is_meaningful(label) else ""


def _material(source: Any) -> str | None:
    material = getattr(source, "material", None)
    name = getattr(material, "name", material)
    return name if isinstance(name, str) and is_meaningful(name) else None


def _marks(placed: Any, label: str, color: str | None) -> tuple[dict[Held, str], dict[Held, str | None]]:
    """What a face, an edge or several of them say of the solid that they lie on; ``~`` keeps the label as it is."""
    found = [Held(shape) for shape in subshapes(placed, FACE) or subshapes(placed, EDGE)]
    return (dict.fromkeys(found, f"~{label}") if label else {}), (dict.fromkeys(found, color) if color else {})


def _parts_of(shape: Any) -> list[Any]:
    """What a compound holds, where it lies."""
    parts = []
    iterator = TopoDS_Iterator(shape)
    while iterator.More():
        parts.append(iterator.Value())
        iterator.Next()
    return parts
