"""Cells of a plane extruded to a prism, as a ``brep.Solid`` made of data.

Place in the flow: last step of an arrangement. What is over a cell follows from the cell, so OpenCASCADE need not
extrude thousands of them, nor be read again: the edges of the plane are read once, and the top is the bottom, moved.
:mod:`.prism_plane` reads them, :mod:`.prism_numbers` numbers what they become, :mod:`.prism_edges` and
:mod:`.prism_faces` make it.

::

         top[e]            faces, in this order: the sides of the rim, then of every cell its bottom and its top
       +-------->+         edges run the same way at the bottom and at the top, rails run up
    rail    side   rail    loops of a top run as those of its cell, those of a bottom the other way round
       +-------->+
        bottom[e]
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ...arrays import FloatArray
from ...brep import Solid
from ..geometry.curves import EdgeCurve
from ..geometry.surfaces import Geometry, Plane
from ..shapes import compound
from .extent import tight_bounds
from .prism_edges import edges_of
from .prism_faces import faces_of
from .prism_numbers import number_prism
from .prism_plane import Overhead, Wires, read_plane
from .solids import largest_tolerance


class Prism(NamedTuple):
    """A prism over cells, and where they are in it.

    Attributes
    ----------
    solid : Solid
        Its `kernel` are the :class:`PlaneShapes` of its bottom.
    bottoms, tops : tuple of int
        Faces under and over each cell.
    lower, upper : list of int
        Edges that every line became at the bottom and at the top.
    """

    solid: Solid
    bottoms: tuple[int, ...]
    tops: tuple[int, ...]
    lower: list[int]
    upper: list[int]


@dataclass(frozen=True, kw_only=True, eq=False)
class PlaneShapes:
    """OpenCASCADE's edges and vertices of the bottom of a prism, by their ids."""

    edges: dict[int, Any]
    vertices: dict[int, Any]


def extrude_cells(  # noqa: PLR0917
    cells: Sequence[Wires],
    lines: Sequence[Any],
    read: Sequence[tuple[EdgeCurve, str]],
    beside: Sequence[tuple[int, int]],
    plane: Geometry,
    along: FloatArray,
    overhead: Overhead | None = None,
) -> Prism:
    """Make the prism over the cells of a plane.

    Parameters
    ----------
    cells : sequence of Wires
        On the plane, facing along the direction.
    lines : sequence of TopoDS_Edge
        All that bound them.
    read : sequence of (EdgeCurve, str)
        Their curves and kinds.
    beside : sequence of (int, int)
        Cells on the left and on the right of each line, -1 outside.
    plane : Geometry
        Of the bottom; a plane.
    along : (3,) float64
        From the bottom to the top.
    overhead : Overhead, optional
        What of a part lies over the lines and the cells: messages name that.

    Raises
    ------
    CadError
        The outline of the cells touches itself, or a cell is turned over.
    """
    assert isinstance(plane, Plane)
    if overhead is None:
        overhead = Overhead.nothing(len(lines), len(cells))
    own = read_plane(cells, lines, read, beside, plane, along, overhead)
    ids = number_prism(own)
    faces = faces_of(own, ids)
    low = tight_bounds(compound(own.shapes[: own.n_rim]))
    corners = np.concatenate([low, low + along])
    vertices = np.empty((2 * len(ids.lower_vertex), 3))
    for v, place in enumerate(own.shared.positions):
        vertices[ids.lower_vertex[v]], vertices[ids.upper_vertex[v]] = place, place + along
    edges = edges_of(own, ids)
    solid = Solid(
        vertices=vertices,
        edges=edges,
        faces=faces,
        volume=own.height * sum(faces[f].area for f in ids.tops),
        size=float(np.linalg.norm(np.ptp(corners, axis=0))),
        tolerance=largest_tolerance(compound(own.shapes)),
        units=overhead.units,
        kernel=PlaneShapes(
            edges={ids.lower[j]: shape for j, shape in enumerate(own.shapes)},
            vertices={ids.lower_vertex[v]: shape for v, shape in enumerate(own.shared.vertex_shapes)},
        ),
        vertex_keys=np.arange(len(vertices)),
        edge_keys=np.arange(len(edges)),
        face_keys=np.arange(len(faces)),
    )
    places = [own.place[j] for j in range(len(own.place))]
    return Prism(solid, ids.bottoms, ids.tops, [ids.lower[k] for k in places], [ids.upper[k] for k in places])


def plane_shapes(prism: Solid) -> PlaneShapes:
    """OpenCASCADE's side of a prism that :func:`extrude_cells` made."""
    holder = prism.kernel
    assert isinstance(holder, PlaneShapes), "it is an arrangement's"
    return holder


__all__ = ["PlaneShapes", "Prism", "extrude_cells", "plane_shapes"]
