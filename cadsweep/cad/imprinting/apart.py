"""One solid of an assembly as it was before the others were imprinted on it, and where they touch it.

Place in the flow: called by the pipeline for solids that are meshed each by itself, where a contact's outline is in the
way of a sweep.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from OCP.BRepTopAdaptor import BRepTopAdaptor_FClass2d
from OCP.gp import gp_Pnt2d
from OCP.TopAbs import TopAbs_State

from ...arrays import BoolArray, FloatArray
from ...brep import Part
from ..extract.labels import EdgeLabel, FaceLabel, Labels
from ..extract.solids import extract_solid
from ..heal.divide import divide_closed
from ..heal.shared_surfaces import part_surfaces
from ..heal.tracing import Traced
from ..heal.validate import check_closed
from ..shapes import EDGE, FACE, SOLID, index_map, shapes_of, subshapes, typed


@dataclass(frozen=True, kw_only=True, eq=False)
class Original:
    """A solid of the model before it was imprinted: healed, in working units, and its labels."""

    shape: Any
    labels: Labels


def part_apart(part: Part) -> Part | None:
    """The part of one solid, as it was before the others were imprinted on it; None where nothing was.

    Parameters
    ----------
    part : Part
        One cell of an imprinted part.
    """
    (model,), (cell,) = part.models, part.solids
    original = model.kernel
    if not isinstance(original, Original):
        return None
    traced = Traced(original.shape)
    part_surfaces(traced)
    divide_closed(traced)
    shape = typed(subshapes(traced.shape, SOLID)[0], SOLID)
    check_closed(shape)
    faces = traced.face_origins(index_map(shape, FACE))
    edges = traced.edge_origins(index_map(shape, EDGE))
    labels = Labels(
        [FaceLabel() if j is None else original.labels.faces[j] for j in faces],
        [EdgeLabel() if j is None else original.labels.edges[j] for j in edges],
    )
    solid = extract_solid(
        shape, labels=labels, name=cell.name, material=cell.material, color=cell.color, units=cell.units
    )
    return replace(part, solids=(solid,))


def contains(part: Part, faces: Sequence[int]) -> Callable[[FloatArray], BoolArray]:
    """Tell which points (m, 3) near some faces of the one cell of a part project into one of them."""
    (cell,) = part.solids
    holder = shapes_of(cell)
    known = [(cell.faces[f].surface, BRepTopAdaptor_FClass2d(holder.faces[f], 1e-9)) for f in faces]

    def inside(points: FloatArray) -> BoolArray:
        found = np.zeros(len(points), dtype=bool)
        for surface, classifier in known:
            left = np.flatnonzero(~found)
            for at, (u, v) in zip(left.tolist(), surface.project(points[left]), strict=True):
                found[at] = classifier.Perform(gp_Pnt2d(float(u), float(v))) != TopAbs_State.TopAbs_OUT
        return found

    return inside
