"""Faces of a solid that cross each other: why no mesh of it can be valid.

Place in the flow: called by the pipeline where no sweep of a part gave a valid mesh. OpenCASCADE's own
check of a shape looks at each face by itself, so a solid that runs into itself passes it, and the check
between faces takes seconds on splines: too long for parts that are sound.
"""

from __future__ import annotations

from collections.abc import Collection

from OCP.BOPAlgo import BOPAlgo_CheckerSI
from OCP.TopTools import TopTools_ListOfShape

from ...brep import Solid
from ..shapes import FACE, SolidShape


def find_crossing(solid: Solid, *, coincident: Collection[int] = ()) -> tuple[int, int] | None:
    """Find two faces that meet elsewhere than on the edges and vertices which they share.

    Parameters
    ----------
    solid : Solid
    coincident : collection of int
        Face ids that may lie on one another: the caps of a ring that was cut open.

    Returns
    -------
    (int, int) or None
        Their ids, the least first; None where there are none, or where OpenCASCADE cannot tell.
    """
    holder = solid.kernel
    if not isinstance(holder, SolidShape):
        return None
    shapes = TopTools_ListOfShape()
    shapes.Append(holder.shape)
    checker = BOPAlgo_CheckerSI()
    checker.SetArguments(shapes)
    checker.SetNonDestructive(True)
    checker.Perform()
    found = checker.DS()
    pairs = []
    for pair in found.Interferences():
        first, second = (found.Shape(j) for j in pair.Indices())
        if first.ShapeType() == FACE == second.ShapeType():
            ids = [next((f for f, face in enumerate(holder.faces) if face.IsSame(s)), -1) for s in (first, second)]
            if min(ids) >= 0 and not set(ids) <= set(coincident):
                pairs.append((min(ids), max(ids)))
    return min(pairs, default=None)
