"""CadQuery objects, and anything with ``.wrapped``, read as a model.

Place in the flow: one of the readers. CadQuery itself is not imported: its objects are known by
what they offer.
"""

from __future__ import annotations

from typing import Any

from OCP.TopoDS import TopoDS_Shape

from ..errors import CadError
from .model import Model
from .shapes import compound


def read_object(source: Any) -> Model | None:
    """Read a Workplane, Shape, Assembly, an object with ``.wrapped``, or a TopoDS shape; None if it is none.

    Raises
    ------
    CadError
        The object holds no shape.
    """
    name = type(source).__name__
    if isinstance(source, TopoDS_Shape):
        return Model(shape=_not_null(source, name), source=name)
    if hasattr(source, "toCompound") and hasattr(source, "objects") and hasattr(source, "children"):
        return Model(shape=_not_null(source.toCompound().wrapped, name), source=name)
    wrapped = getattr(source, "wrapped", None)
    if isinstance(wrapped, TopoDS_Shape):
        return Model(shape=_not_null(wrapped, name), source=name)
    if hasattr(source, "vals") and hasattr(source, "workplane"):
        shapes = [v.wrapped for v in source.vals() if isinstance(getattr(v, "wrapped", None), TopoDS_Shape)]
        if not shapes:
            raise CadError(f"The {name} holds no shape: select the solid at the end of its chain of calls.")
        return Model(shape=shapes[0] if len(shapes) == 1 else compound(shapes), source=name)
    return None


def _not_null(shape: Any, name: str) -> Any:
    if shape is None or shape.IsNull():
        raise CadError(f"The {name} is empty: its shape is null.")
    return shape
