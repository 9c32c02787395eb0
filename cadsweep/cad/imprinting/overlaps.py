"""Solids that overlap, made to touch: the smaller of two keeps its shape, the larger is cut.

Place in the flow: between healing and :mod:`.joining`, where it is asked for. A pin that is drawn through its plate, a
press fit, a thread over its core: whoever draws them so means that the smaller is there, and the larger around it.

Not handled: solids that come twice, and what would fall into pieces; the first is refused where solids are joined.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from OCP.BRepAlgoAPI import BRepAlgoAPI_Common, BRepAlgoAPI_Cut
from OCP.TopTools import TopTools_ListOfShape

from ...errors import CadError
from ..heal.tracing import Traced, image_of
from ..heal.validate import faults
from ..shapes import SOLID, bounds, near_boxes, subshapes, typed, volume_and_center
from ..trial import attempted

LEAST = 1e-9
"""Common volume, as a share of the smaller solid, up to which two solids only touch."""


def cut_overlaps(shapes: Sequence[Any], names: Sequence[str]) -> tuple[dict[int, Traced], list[str]]:
    """Cut what overlaps out of the larger of two solids.

    Parameters
    ----------
    shapes : sequence of TopoDS_Solid
        Healed, in working units.
    names : sequence of str
        How messages call them.

    Returns
    -------
    dict of int to Traced
        What has become of those that were cut.
    list of str
        Notes of what was cut out of what.

    Raises
    ------
    CadError
        A solid would be left in pieces, or OpenCASCADE cannot cut it.
    """
    shapes, found, notes = list(shapes), dict[int, Traced](), list[str]()
    volumes = [volume_and_center(shape)[0] for shape in shapes]
    boxes = np.array([bounds(shape) for shape in shapes])
    near = near_boxes(boxes, boxes, 0.0)
    order = np.argsort(volumes, kind="stable").tolist()
    for place, large in enumerate(order):
        beside = [small for small in order[:place] if near[small, large]]
        common = {small: _common(shapes[small], shapes[large]) for small in beside}
        # What is wholly in both is one solid twice, and refused as that.
        tools = [small for small in beside if LEAST * volumes[small] < common[small] < (1.0 - LEAST) * volumes[large]]
        if tools:
            what = ", ".join(f"'{names[small]}'" for small in tools)
            found[large] = _without(
                shapes[large], [shapes[small] for small in tools], f"{what} out of '{names[large]}'"
            )
            shapes[large] = found[large].shape
            share = sum(common[small] for small in tools) / volumes[large]
            notes.append(f"{what} cut out of '{names[large]}': {share:.2g} of its volume, where they overlapped")
    return found, notes


def _common(first: Any, second: Any) -> float:
    """Volume of what two solids have in common; 0 where OpenCASCADE finds nothing."""
    common = BRepAlgoAPI_Common()
    common.SetArguments(_list([first]))
    common.SetTools(_list([second]))
    common.SetNonDestructive(True)
    if not attempted(common.Build, "finding what two solids have in common", on=[first, second]):
        raise CadError("OpenCASCADE fails where two solids overlap")
    return sum(volume_and_center(solid)[0] for solid in subshapes(common.Shape(), SOLID))


def _without(large: Any, tools: Sequence[Any], what: str) -> Traced:
    """A solid without others, followed."""
    cut = BRepAlgoAPI_Cut()
    cut.SetArguments(_list([large]))
    cut.SetTools(_list(tools))
    cut.SetNonDestructive(True)
    if not attempted(cut.Build, "cutting overlaps out", on=[large, *tools]) or not cut.IsDone():
        raise CadError(f"OpenCASCADE cannot cut {what}")
    solids = subshapes(cut.Shape(), SOLID)
    if len(solids) != 1:
        raise CadError(f"cutting {what} leaves {len(solids)} pieces of it: do that in the CAD program")
    damage = faults(solids[0])
    if damage:
        raise CadError(f"cutting {what} makes it invalid: {damage[0]}")
    traced = Traced(large)
    traced.replace(typed(solids[0], SOLID), image_of(cut))
    return traced


def _list(shapes: Sequence[Any]) -> TopTools_ListOfShape:
    out = TopTools_ListOfShape()
    for shape in shapes:
        out.Append(shape)
    return out


__all__ = ["cut_overlaps"]
