"""CadQuery objects, and anything with ``.wrapped``, read as a model.

Place in the flow: one of the readers. CadQuery itself is not imported: its objects are known by
what they offer. Tags of a Workplane and sub-shape names of an Assembly become names of faces and
edges; names, materials and colours of an Assembly's parts become those of solids. As in CadQuery, a part
without a colour has that of the assembly it is in.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS_Shape

from ...errors import CadError, InputError
from ..names.unique import MATERIAL_PREFIX, is_given, join_part
from ..shapes import EDGE, FACE, SOLID, WIRE, compound, subshapes
from .colors import color_of, object_color
from .model import Model, Named
from .tree import AssemblyNode


def read_object(source: Any) -> Model | None:
    """Read a Workplane, Shape, Assembly, an object with ``.wrapped``, a TopoDS shape, or a list; None if it is none.

    Raises
    ------
    CadError
        The object holds no shape.
    InputError
        It is a Workplane that holds something else, such as a sketch or a point.
    """
    return _read_several(source) if isinstance(source, list | tuple) else _read_one(source)


def _read_one(source: Any) -> Model | None:
    name = type(source).__name__
    if isinstance(source, TopoDS_Shape):
        return Model(shape=_not_null(source, name), source=name)
    is_assembly = hasattr(source, "toCompound") and hasattr(source, "traverse") and hasattr(source, "children")
    if is_assembly or isinstance(source, AssemblyNode):
        return _read_assembly(source)
    wrapped = getattr(source, "wrapped", None)
    if isinstance(wrapped, TopoDS_Shape):
        return _read_labelled(source, name)
    if wrapped is None and hasattr(source, "part"):  # a builder of build123d holds what it has built
        if source.part is None:
            raise CadError(f"The {name} is empty: its .part is None.")
        return read_object(source.part)
    if hasattr(source, "vals") and hasattr(source, "workplane"):
        return _read_workplane(source, name)
    if hasattr(source, "wrapped") and wrapped is None:
        raise CadError(f"The {name} is empty: its .wrapped is None.")
    return None


def _read_several(sources: Sequence[Any]) -> Model:
    """Read a list of any of these as one model."""
    models = []
    for number, source in enumerate(sources):
        model = read_object(source)
        if model is None:
            raise InputError(
                f"item {number} of the list is a {type(source).__name__}: a list holds CadQuery or OpenCASCADE shapes."
            )
        models.append(model)
    if not models:
        raise InputError("The list is empty: it holds no shape.")
    # A face with a label beside a solid says what that solid's face is called.
    shapes = [model.shape for model in models if not _says_something(model)]
    if not any(subshapes(shape, SOLID) for shape in shapes):
        shapes = [model.shape for model in models]
    whole = Model(shape=compound(shapes), source="list")
    for model in models:
        whole.names += model.names
        whole.paths += model.paths
        whole.materials += model.materials
        whole.colors += model.colors
        if model.name:
            solids = [s for s in subshapes(model.shape, SOLID) if not any(e.shape.IsSame(s) for e in model.names)]
            whole.names += [Named(solid, model.name) for solid in solids]
    return whole


def _says_something(model: Model) -> bool:
    """Whether a model is no solid, and has the name or the colour of a face or an edge."""
    return not subshapes(model.shape, SOLID) and bool(model.names or model.colors)


def _read_labelled(source: Any, name: str) -> Model:
    """A shape that may have a label, a colour and children, as those of build123d do."""
    from .labelled import labelled_tree

    _not_null(source.wrapped, name)
    model = _read_assembly(labelled_tree(source))
    model.source = name
    return model


def _not_null(shape: Any, name: str) -> Any:
    if shape is None or shape.IsNull():
        raise CadError(f"The {name} is empty: its shape is null.")
    return shape


def _read_workplane(source: Any, name: str) -> Model:
    values = source.vals()
    shapes = _shapes(source)
    if not shapes:
        held = ", ".join(sorted({type(v).__name__ for v in values})) or "nothing"
        raise InputError(f"The {name} holds {held} and no shape: select the solid at the end of its chain of calls.")
    if not any(subshapes(s, SOLID) for s in shapes):
        # The chain ended on a selection such as .faces(">Z"): the solid stands earlier in it.
        solid = _solid_behind(source)
        if solid is not None:
            shapes = [solid]
    model = Model(shape=shapes[0] if len(shapes) == 1 else compound(shapes), source=name)
    _collect_tags(model, source, part=None, location=TopLoc_Location())
    return model


def _shapes(source: Any) -> list[Any]:
    """The OpenCASCADE shapes that a Workplane or Shape holds."""
    if source is None:
        return []
    values = source.vals() if hasattr(source, "vals") else [source]
    wrapped = [getattr(v, "wrapped", None) for v in values]
    return [w for w in wrapped if isinstance(w, TopoDS_Shape) and not w.IsNull()]


def _solid_behind(source: Any) -> Any:
    parent = getattr(source, "parent", None)
    while parent is not None:
        solids = [s for shape in _shapes(parent) for s in subshapes(shape, SOLID)]
        if len(solids) == 1:
            return solids[0]
        parent = getattr(parent, "parent", None)
    return None


def _collect_tags(model: Model, source: Any, *, part: str | None, location: Any) -> None:
    """Add the faces and edges (and materials of solids) that the tags of a Workplane select."""
    context = getattr(source, "ctx", None)
    for tag, tagged in getattr(context, "tags", {}).items():
        for shape in _shapes(tagged):
            _add_name(model, shape.Moved(location), str(tag), part)


def _add_name(model: Model, shape: Any, name: str, part: str | None) -> None:
    if name.startswith(MATERIAL_PREFIX):
        solids = subshapes(shape, SOLID)
        model.materials.extend(Named(solid, name[len(MATERIAL_PREFIX) :]) for solid in solids)
    elif shape.ShapeType() in (FACE, EDGE):
        model.names.append(Named(shape, join_part(part, name)))
    elif shape.ShapeType() == WIRE:
        model.names.extend(Named(edge, join_part(part, name)) for edge in subshapes(shape, EDGE))


def _read_assembly(source: Any) -> Model:
    model = Model(shape=None, source=type(source).__name__)
    parts: list[Any] = []
    _walk(model, parts, source, TopLoc_Location(), color=None, path=())
    if not parts:
        raise CadError(f"The assembly '{source.name}' holds no shape.")
    model.shape = parts[0] if len(parts) == 1 else compound(parts)
    if is_given(source.name):
        model.name = source.name
    elif len(source.children) == 1 and is_given(source.children[0].name):
        model.name = source.children[0].name
    return model


def _walk(
    model: Model, parts: list[Any], node: Any, location: Any, *, color: str | None, path: tuple[str, ...]
) -> None:
    path = (*path, str(node.name)) if is_given(node.name) else path
    own = getattr(node.loc, "wrapped", None)
    if own is not None:
        location = location.Multiplied(own)
    color = object_color(getattr(node, "color", None)) or color
    for shape, given in getattr(node, "_subshape_colors", {}).items():
        own_color = object_color(given)
        if own_color is not None:
            model.colors += color_of(shape.wrapped.Moved(location), own_color)
    for shape in _shapes(node.obj):
        placed = shape.Moved(location)
        parts.append(placed)
        solids = subshapes(placed, SOLID)
        if color is not None:
            model.colors += color_of(placed, color)
        model.paths.extend(Named(solid, "/".join(path)) for solid in solids if path)
        name = str(node.name)
        if name.startswith(MATERIAL_PREFIX):
            model.materials.extend(Named(solid, name[len(MATERIAL_PREFIX) :]) for solid in solids)
        elif is_given(name):
            model.names.extend(Named(solid, name) for solid in solids)
        material = getattr(node, "material", None)
        if material is not None:
            label = str(getattr(material, "name", material))
            model.materials.extend(Named(solid, label.removeprefix(MATERIAL_PREFIX)) for solid in solids)
    part = None if str(node.name).startswith(MATERIAL_PREFIX) else str(node.name)
    for shape, name in getattr(node, "_subshape_names", {}).items():
        _add_name(model, shape.wrapped.Moved(location), str(name), part)
    _collect_tags(model, node.obj, part=part, location=location)
    for child in node.children:
        _walk(model, parts, child, location, color=color, path=path)
