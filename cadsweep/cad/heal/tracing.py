"""What became of each face and edge of the input, through every step of healing.

Place in the flow: the names of faces hang on the faces of the input; ``Traced`` finds the
faces of the result that they became.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..shapes import EDGE, FACE, compound, index_map, listed, subshapes, typed


class Traced:
    """A shape, and for each face and edge of the input the faces and edges that it became.

    Attributes
    ----------
    shape : TopoDS_Shape
        The present shape.
    faces, edges : list of list
        Entry j: what face (edge) j of the input is now.
    """

    def __init__(self, shape: Any) -> None:
        self.shape = shape
        self.faces: list[list[Any]] = [[face] for face in subshapes(shape, FACE)]
        self.edges: list[list[Any]] = [[edge] for edge in subshapes(shape, EDGE)]

    def replace(self, shape: Any, image: Callable[[Any], Any]) -> None:
        """Go on with `shape`; ``image(sub)`` is the shape that a face or edge became (None: it is gone)."""
        self.shape = shape
        self.faces = [_images(old, image, FACE) for old in self.faces]
        self.edges = [_images(old, image, EDGE) for old in self.edges]

    def become(self, other: Traced) -> None:
        """Go on from another state of the same input."""
        self.shape, self.faces, self.edges = other.shape, other.faces, other.edges

    def face_origins(self, found: Any) -> list[int | None]:
        """For every face of a map of the present faces, the input face it comes from."""
        return _origins(self.faces, found)

    def edge_origins(self, found: Any) -> list[int | None]:
        """For every edge of a map of the present edges, the input edge it comes from."""
        return _origins(self.edges, found)


def image_of(tool: Any) -> Callable[[Any], Any]:
    """What a face or an edge became, by the history of one of OpenCASCADE's booleans; None: it is gone."""

    def image(sub: Any) -> Any:
        if tool.IsDeleted(sub):
            return None
        became = listed(tool.Modified(sub))
        return compound(became) if became else sub

    return image


def _images(old: list[Any], image: Callable[[Any], Any], kind: Any) -> list[Any]:
    new = []
    for shape in old:
        became = image(shape)
        if became is None or became.IsNull():
            continue
        if became.IsSame(shape):  # of most nothing becomes another: a walk through each takes longer than all else
            new.append(typed(became, kind))
        else:
            new.extend(subshapes(became, kind))
    return new


def _origins(became: list[list[Any]], found: Any) -> list[int | None]:
    out: list[int | None] = [None] * found.Extent()
    for j, shapes in enumerate(became):
        for shape in shapes:
            number = found.FindIndex(shape)
            if number and out[number - 1] is None:
                out[number - 1] = j
    return out


def present(traced: Traced, kind: Any) -> Any:
    """Map of the present faces or edges."""
    return index_map(traced.shape, kind)
