"""Facets of a loaded solid's faces: what pictures of a part are drawn from, and fitted grids laid by.

Place in the flow: called by ``report`` and for ``fitted``; where something is on a face, the face itself says.

Method: OpenCASCADE's incremental mesh of a copy of each face, so that the model's own shapes carry no triangles.
"""

from __future__ import annotations

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.IMeshTools import IMeshTools_MeshAlgoType, IMeshTools_Parameters
from OCP.Poly import Poly_Triangulation
from OCP.ShapeFix import ShapeFix_Face
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS_Face

from ...arrays import FloatArray, IntArray
from ...brep import Solid
from ...errors import CadError
from ..shapes import EDGE, FACE, SolidShape, subshapes, typed

DEFLECTION = 1e-3
"""Distance of facets from their face, over the part's size: what an eye takes for round in a picture."""

ANGLE = 0.3
"""Angle between neighbouring facets, radians."""

COARSER = 10.0
"""How many times the distance of a face's facets may be, where OpenCASCADE makes none as near as those of others."""

USUAL, OTHER = (
    IMeshTools_MeshAlgoType.IMeshTools_MeshAlgoType_DEFAULT,
    IMeshTools_MeshAlgoType.IMeshTools_MeshAlgoType_Delabella,
)
"""OpenCASCADE's ways to divide a face. The other takes no longer for each of many holes than for the first, 0.4 s for a
plate of 800, where the usual one takes 11; and leaves less of a face away whose outline is cut coarsely."""

MANY_EDGES = 100
"""Edges of a face from which on its facets are made the other way."""


def find_facets(solid: Solid) -> list[tuple[FloatArray, IntArray]]:
    """Facet every face of a solid.

    Returns
    -------
    list of (n, 3) float64, (t, 3) int64
        By face id: points, working units, and triangles, counter-clockwise from outside; empty where OpenCASCADE made
        none.

    Raises
    ------
    CadError
        The solid was not made by ``cad``.
    """
    if not isinstance(solid.kernel, SolidShape):
        raise CadError("the solid has no shape in the CAD kernel to be drawn from")
    return [_facets(face, DEFLECTION * solid.size) for face in solid.kernel.faces]


def _facets(face: object, deflection: float) -> tuple[FloatArray, IntArray]:
    copied = typed(BRepBuilderAPI_Copy(face).Shape(), FACE)
    # OpenCASCADE's division of closed faces leaves edges without a common range, and its mesher does not come back from
    # some of them.
    if not all(BRep_Tool.SameRange_s(edge) for edge in subshapes(copied, EDGE)):
        copied = _fixed(copied)
    place = TopLoc_Location()
    made = _triangulated(copied, deflection, place, OTHER if len(subshapes(copied, EDGE)) > MANY_EDGES else USUAL)
    # A wire that crosses itself by less than tolerances: mended, or cut so coarsely that it does so no more.
    for coarser, algorithm in ((1.0, USUAL), (COARSER, OTHER)):
        if made is None:
            copied = _fixed(typed(BRepBuilderAPI_Copy(face).Shape(), FACE))
            made = _triangulated(copied, coarser * deflection, place, algorithm)
    if made is None:
        return np.empty((0, 3)), np.empty((0, 3), dtype=np.int64)
    move = place.Transformation()
    nodes = [made.Node(i).Transformed(move) for i in range(1, made.NbNodes() + 1)]
    triangles = np.array([made.Triangle(i).Get() for i in range(1, made.NbTriangles() + 1)], dtype=np.int64) - 1
    if copied.Orientation() == TopAbs_Orientation.TopAbs_REVERSED:
        triangles = triangles[:, ::-1]
    return np.array([[p.X(), p.Y(), p.Z()] for p in nodes]), np.ascontiguousarray(triangles.reshape(-1, 3))


def _fixed(face: TopoDS_Face) -> TopoDS_Face:
    fixer = ShapeFix_Face(face)
    fixer.Perform()
    return fixer.Face()


def _triangulated(
    face: TopoDS_Face, deflection: float, place: TopLoc_Location, algorithm: IMeshTools_MeshAlgoType
) -> Poly_Triangulation | None:
    """Of a face, and by `place` where it lies; None where OpenCASCADE makes none."""
    wanted = IMeshTools_Parameters()
    wanted.Deflection, wanted.Angle, wanted.MeshAlgo = deflection, ANGLE, algorithm
    BRepMesh_IncrementalMesh(face, wanted)
    return BRep_Tool.Triangulation_s(face, place)
