"""Colours of CAD models as text, and whose they are: the part's or one face's.

Place in the flow: the readers collect colours of solids and faces; ``clean`` hands them to the faces of the healed
solid. A colour is ``#rrggbb`` in sRGB, or ``#rrggbbaa`` where it is not opaque.

Not handled: colours of edges, and what a material looks like.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from OCP.Quantity import Quantity_ColorRGBA, Quantity_TypeOfColor

from ..names.naming import by_place
from ..shapes import FACE, SOLID, compound, index_map, mapped, subshapes, typed
from .model import Colored


def color_text(color: Any) -> str:
    """Write a ``Quantity_ColorRGBA`` as text."""
    red, green, blue = color.GetRGB().Values(Quantity_TypeOfColor.Quantity_TOC_sRGB)
    channels = [red, green, blue] if color.Alpha() >= 1.0 else [red, green, blue, color.Alpha()]
    return "#" + "".join(f"{round(255 * min(max(float(c), 0.0), 1.0)):02x}" for c in channels)


def object_color(color: Any) -> str | None:
    """The colour that a CadQuery or build123d object, or a text, stands for; None where it is none."""
    if isinstance(color, str):
        return color
    wrapped = getattr(color, "wrapped", None)
    return color_text(wrapped) if isinstance(wrapped, Quantity_ColorRGBA) else None


def color_of(shape: Any, color: str) -> list[Colored]:
    """A colour of a face, or of all solids of a shape; of its faces, where it has no solid."""
    if shape.ShapeType() == FACE:
        return [Colored(shape, color)]
    return [Colored(sub, color) for sub in subshapes(shape, SOLID) or subshapes(shape, FACE)]


def split_colors(
    colored: Iterable[Colored], solids: Sequence[Any], original: Any
) -> list[tuple[str | None, dict[int, str]]]:
    """Tell the colours of solids from those of their faces.

    Many programs write the colour of a part on each of its faces: a colour that all faces have is the part's, and a
    face with the part's colour has none of its own.

    Parameters
    ----------
    colored : iterable of Colored
        The first entry of a shape counts. A face that is not in the model any more gives its colour, as its name, to
        those that lie on it.
    solids : sequence of TopoDS_Solid
        Those that were chosen.
    original : TopoDS_Shape
        The model as read, whose faces give the numbers.

    Returns
    -------
    list of (str or None, dict of int to str)
        For each solid its colour, and colours by index into ``Traced.faces``.
    """
    faces: dict[int, str] = {}
    wholes: dict[int, str] = {}
    found = index_map(original, FACE)
    found_solids = index_map(compound(solids), SOLID)
    all_faces = mapped(found, FACE)
    for shape, color in colored:
        if shape.ShapeType() == FACE:
            number = found.FindIndex(shape)
            for j in [number - 1] if number else by_place(typed(shape, FACE), all_faces, FACE):
                faces.setdefault(j, color)
        else:
            wholes.setdefault(found_solids.FindIndex(shape), color)
    out = []
    for solid in solids:
        whole = wholes.get(found_solids.FindIndex(solid))
        own = [found.FindIndex(face) - 1 for face in subshapes(solid, FACE)]
        shared = {faces.get(j) for j in own}
        if len(shared) == 1 and None not in shared:
            (whole,) = shared
        chosen = faces if len(solids) == 1 else {j: faces[j] for j in own if j in faces}
        out.append((whole, {j: color for j, color in chosen.items() if color != whole}))
    return out


def common_color(colors: Sequence[str | None]) -> str | None:
    """The colour that all of them are, or None."""
    return colors[0] if len(set(colors)) == 1 else None
