"""One good solid out of what was read: chosen, sewn, turned outside out, repaired.

Place in the flow: after reading, before normalising. Every change leaves a note. Faces are never
merged, because names hang on them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from OCP.BRep import BRep_Builder
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeSolid, BRepBuilderAPI_Sewing
from OCP.BRepLib import BRepLib
from OCP.BRepTools import BRepTools
from OCP.ShapeFix import ShapeFix_Shape
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopoDS import TopoDS, TopoDS_Shell

from ...errors import CadError
from ..shapes import EDGE, FACE, SHELL, SOLID, bounds, subshapes
from ..trial import attempted
from .canonical import make_canonical
from .elementary import make_elementary
from .gaps import cover_gaps
from .poles import close_poles
from .touched_seams import turn_touched_seams
from .tracing import Traced
from .turns import gather_turns
from .validate import check_closed, faults, place, signed_volume

SEWING = 1e-5
"""Gap between faces that sewing closes, and between edges that a vertex covers, as a share of the part's size."""


def take_solid(traced: Traced) -> list[str]:
    """Reduce the shape to its one solid, sewing loose faces where there is none.

    Raises
    ------
    CadError
        There is no solid, and the faces make none.
    """
    notes = []
    solids = subshapes(traced.shape, SOLID)
    if not solids:
        notes.append(sew(traced))
        solids = subshapes(traced.shape, SOLID)
    elif len(subshapes(traced.shape, FACE)) > len(subshapes(solids[0], FACE)):
        n_loose = len(subshapes(traced.shape, FACE)) - len(subshapes(solids[0], FACE))
        notes.append(f"{n_loose} faces that belong to no solid left out")
    traced.replace(solids[0], lambda sub: sub)
    return notes


def sew(traced: Traced) -> str:
    """Sew the faces of the shape to one closed shell and promote it to a solid."""
    faces = subshapes(traced.shape, FACE)
    if not faces:
        raise CadError("there is no solid and no face in it, only wires, edges or points. Extrude it to a solid first.")
    box = bounds(traced.shape)
    sewing = BRepBuilderAPI_Sewing(max(SEWING * float(abs(box[1] - box[0]).max()), 1e-7))
    for face in faces:
        sewing.Add(face)
    sewing.Perform()
    sewn = sewing.SewedShape()
    free = [] if sewn is None or sewn.IsNull() else [sewing.FreeEdge(j) for j in range(1, sewing.NbFreeEdges() + 1)]
    if free:
        its = f"its {len(faces)} faces do" if len(faces) > 1 else "its one face does"
        raise CadError(
            f"there is no solid, and {its} not close to one: {len(free)} edges bound "
            f"one face only, the first at {place(free[0])}. "
            "A face is missing, or faces do not meet; close the gap in the CAD program."
        )
    shells = [] if sewn is None or sewn.IsNull() else subshapes(sewn, SHELL)
    if not shells and len(faces) == 1 and sewn is not None and not sewn.IsNull():
        shells = [_shell_of(sewn)]  # a whole sphere or torus is closed by itself, and there was nothing to sew
    if len(shells) != 1:
        raise CadError(
            f"there is no solid, and its {len(faces)} faces make {len(shells)} shells instead of one closed shell. "
            "Join them to a solid in the CAD program."
        )
    solid = BRepBuilderAPI_MakeSolid(shells[0]).Solid()
    BRepLib.OrientClosedSolid_s(solid)
    traced.replace(
        solid,
        lambda sub: sewing.Modified(sub) if sub.ShapeType() == FACE else sewing.ModifiedSubShape(sub),
    )
    return f"{len(faces)} loose faces sewn and promoted to a solid"


def _shell_of(face: Any) -> Any:
    builder, shell = BRep_Builder(), TopoDS_Shell()
    builder.MakeShell(shell)
    builder.Add(shell, face)
    shell.Closed(True)
    return shell


def mend(traced: Traced) -> list[str]:
    """Bring the solid in order: closed, manifold, valid, outside out.

    Raises
    ------
    CadError
        It is open, not manifold, without volume, or OpenCASCADE finds a fault that it cannot repair.
    """
    notes = []
    BRepTools.RemoveInternals_s(traced.shape)
    check_closed(traced.shape)
    gather_turns(traced)
    notes += close_poles(traced)
    notes += make_canonical(traced)
    notes += make_elementary(traced)
    notes += turn_touched_seams(traced)
    before = faults(traced.shape)
    if before:
        _repair(traced, before)
        notes.append(f"repaired: {before[0]}")
    if signed_volume(traced.shape) < 0:
        traced.shape = TopoDS.Solid_s(_inside_out(traced.shape))
        notes.append("the solid was inside out and has been reversed")
    return notes


def _repair(traced: Traced, found: Sequence[str]) -> None:
    """Let OpenCASCADE repair the solid, unless it has to make other faces for that."""
    repair = ShapeFix_Shape(traced.shape)
    done = attempted(repair.Perform, "repairing the solid")
    solids = subshapes(repair.Shape(), SOLID) if done else []
    # A face whose boundary crosses itself comes back as several, which close no volume any more.
    kept = len(solids) == 1 and len(subshapes(solids[0], FACE)) == len(subshapes(traced.shape, FACE))
    if kept:
        traced.replace(solids[0], repair.Context().Apply)
        check_closed(traced.shape)
    left = faults(traced.shape)
    if left and cover_gaps(traced, SEWING * float(np.ptp(bounds(traced.shape), axis=0).max())):
        left = faults(traced.shape)
    if left:
        worst = next((fault for fault in found if "intersecting" in fault), left[0])
        more = f" (and {len(left) - 1} more)" if len(left) > 1 else ""
        raise CadError(
            f"OpenCASCADE finds the solid invalid: {worst}{more}. Look for faces or wires that cross "
            "themselves, and repair the model in its CAD program."
        )


def _inside_out(solid: Any) -> Any:
    """The solid with every face turned round."""
    if solid.Orientation() == TopAbs_Orientation.TopAbs_REVERSED:
        return solid.Oriented(TopAbs_Orientation.TopAbs_FORWARD)
    turned = BRepBuilderAPI_MakeSolid()
    for shell in subshapes(solid, SHELL):
        turned.Add(TopoDS.Shell_s(shell.Reversed()))
    return turned.Solid()


__all__ = ["EDGE", "mend", "take_solid"]
