"""A cell cut by the image of a face of another: where faces are to answer each other, so are the cuts that end there.

Place in the flow: ``pipeline`` asks for it where one of two periodic faces is divided and the other is not.
"""

from __future__ import annotations

from typing import Any

from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
from OCP.gp import gp_Trsf

from ...arrays import FloatArray
from ...brep import Part
from ..shapes import shapes_of
from .central import plane_tool
from .cutting import cut_cell


def cut_by_image(part: Part, cell: int, of: tuple[int, int], matrix: FloatArray, shift: FloatArray) -> Part | None:
    """Cut a cell along a face of a cell, carried by ``points @ matrix.T + shift``; a plane goes on through the cell.

    Returns
    -------
    Part or None
        None where that does not divide the cell, or not well.
    """
    solid, face = part.solids[of[0]], part.solids[of[0]].faces[of[1]]
    if face.kind == "plane":
        return cut_cell(part, cell, [plane_tool(part.solids[cell], matrix @ face.normal, matrix @ face.center + shift)])
    motion = gp_Trsf()
    rows: list[Any] = [float(x) for row, end in zip(matrix, shift, strict=True) for x in (*row, end)]
    motion.SetValues(*rows)
    carried = BRepBuilderAPI_Transform(shapes_of(solid).faces[of[1]], motion, True).Shape()
    return cut_cell(part, cell, [carried])


__all__ = ["cut_by_image"]
