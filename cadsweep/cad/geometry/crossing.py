"""Faces of a solid that cross each other: why no mesh of it can be valid.

Place in the flow: called by the pipeline where no sweep of a part gave a valid mesh. OpenCASCADE's own
check of a shape looks at each face by itself, so a solid that runs into itself passes it, and the check
between faces takes seconds on splines: too long for parts that are sound.
"""

from __future__ import annotations

import time
from collections.abc import Collection
from itertools import combinations

import numpy as np
from OCP.BOPAlgo import BOPAlgo_CheckerSI
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.StdFail import StdFail_NotDone
from OCP.TopTools import TopTools_ListOfShape

from ...arrays import FloatArray
from ...brep import Solid
from ..shapes import FACE, SolidShape, bounds, is_plain, near_boxes
from ..trial import attempted

TOUCHES = 1e-6
"""Distance of two faces, as a share of the solid's size, up to which they touch."""
SECONDS = 4.0
"""Seconds of the processor for which faces are looked at; to measure two free-form ones takes up to one of them."""


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
    if not attempted(checker.Perform, "looking for faces that cross", seconds=SECONDS):
        return None
    found = checker.DS()
    pairs = []
    for pair in found.Interferences():
        first, second = (found.Shape(j) for j in pair.Indices())
        if first.ShapeType() == FACE == second.ShapeType():
            ids = [next((f for f, face in enumerate(holder.faces) if face.IsSame(s)), -1) for s in (first, second)]
            if min(ids) >= 0 and not set(ids) <= set(coincident):
                pairs.append((min(ids), max(ids)))
    return min(pairs, default=None)


def find_touching(solid: Solid) -> tuple[int, int, FloatArray] | None:
    """Find two faces that touch though they share no edge there: between them the material runs out to nothing.

    They share no vertex at all, or one around which no edges join them.

    Returns
    -------
    (int, int, (3,) float64) or None
        Their ids, the least first, and a place where they touch; None where there are none, or none among those that
        there was time for: planes and cylinders first.
    """
    pinched = _find_pinched(solid)
    if pinched is not None:
        return pinched
    holder = solid.kernel
    if not isinstance(holder, SolidShape):
        return None
    reach = TOUCHES * solid.size
    vertices = [{v for e in face.edges for v in (solid.edges[e].start, solid.edges[e].end)} for face in solid.faces]
    boxes = np.array([bounds(face) for face in holder.faces])
    near = near_boxes(boxes, boxes, reach)
    apart = [
        (one, other)
        for one, other in combinations(range(len(vertices)), 2)
        if near[one, other] and not vertices[one] & vertices[other]
    ]
    plain = [is_plain(face) for face in holder.faces]
    began = time.process_time()
    for one, other in sorted(apart, key=lambda pair: not (plain[pair[0]] and plain[pair[1]])):
        if time.process_time() - began > SECONDS:
            break
        try:
            between = BRepExtrema_DistShapeShape(holder.faces[one], holder.faces[other])
        except StdFail_NotDone:  # two tori, say, whose distance OpenCASCADE cannot find: not known to touch
            continue
        if between.IsDone() and between.NbSolution() and between.Value() < reach:
            place = between.PointOnShape1(1)
            return one, other, np.array([place.X(), place.Y(), place.Z()])
    return None


def _find_pinched(solid: Solid) -> tuple[int, int, FloatArray] | None:
    """Two faces at a vertex whose edges do not join all faces around it, as where two bores touch in a point."""
    around: list[list[tuple[int, int]]] = [[] for _ in solid.vertices]
    for edge in solid.edges:
        for v in {edge.start, edge.end}:
            around[v].append(edge.faces)
    for v, pairs in enumerate(around):
        joined = {pairs[0][0]} if pairs else set()
        while any((a in joined) != (b in joined) for a, b in pairs):
            joined |= {f for pair in pairs if joined & set(pair) for f in pair}
        apart = {f for pair in pairs for f in pair} - joined
        if apart:
            first, second = sorted((min(joined), min(apart)))
            return first, second, solid.vertices[v]
    return None
