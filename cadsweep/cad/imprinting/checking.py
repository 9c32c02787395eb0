"""What an imprint must not do, and what the solids must not: overlap, come twice, lose a face, change a volume.

Place in the flow: called by :mod:`.joining` on what :mod:`.fusing` gives, before it is divided and read.
"""

from __future__ import annotations

from collections.abc import Sequence, Set
from typing import Any

import numpy as np
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps

from ...brep import Units
from ...contacts import say_leave_out
from ...errors import CadError
from ..extract.shared import PartGeometry
from ..extract.solids import extract_solid
from ..heal.divide import divide_closed
from ..heal.shared_surfaces import part_surfaces
from ..heal.tracing import Traced
from ..heal.validate import check_closed, faults
from ..shapes import FACE, SOLID, children, compound, index_map, mapped, subshapes, volume_and_center
from .fusing import Fused

SAME_VOLUME = 1e-6
"""Share of a solid's volume, and of a face's area, that imprinting may change: OpenCASCADE integrates no better."""


def integrated_volume(solid: Any) -> float:
    """Volume of a solid, by the integrals over its faces that a read solid has: slower, and more exact on splines."""
    traced = Traced(solid)
    part_surfaces(traced)
    divide_closed(traced)
    (shape,) = subshapes(traced.shape, SOLID)
    return extract_solid(shape, shared=PartGeometry(shape, closed=np.inf)).volume


def surface_area(shape: Any) -> float:
    """Area of a face or of all faces of a shape, by OpenCASCADE."""
    properties = GProp_GProps()
    BRepGProp.SurfaceProperties_s(shape, properties)
    return abs(float(properties.Mass()))


def check_distinct(fused: Fused, labels: Sequence[str], units: Units) -> None:
    """Refuse solids that overlap, one within another, or the same one twice.

    Parameters
    ----------
    fused : Fused
    labels : sequence of str
        How messages call each solid.
    units : Units

    Raises
    ------
    CadError
        Names the two, the common volume and its place.
    """
    found = index_map(_all(fused), SOLID)
    owners: list[list[int]] = [[] for _ in range(found.Extent())]
    cells: list[set[int]] = []
    for i, pieces in enumerate(fused.pieces):
        cells.append({found.FindIndex(piece) - 1 for piece in pieces})
        for cell in cells[-1]:
            owners[cell].append(i)
    shapes = mapped(found, SOLID)
    pairs: dict[tuple[int, int], list[int]] = {}
    for cell, own in enumerate(owners):
        if len(own) > 1:
            pairs.setdefault((own[0], own[1]), []).append(cell)
    if not pairs:
        return
    measured = {pair: [volume_and_center(shapes[cell]) for cell in common] for pair, common in pairs.items()}
    models = list(dict.fromkeys(label.strip("'") for label in labels))
    (i, j), common = max(measured.items(), key=lambda item: sum(volume for volume, _ in item[1]))
    volume = sum(volume for volume, _ in common)
    place = units.place(max(common, key=lambda piece: piece[0])[1])
    more = f" {len(pairs) - 1} more pairs overlap." if len(pairs) > 1 else ""

    def without(solid: int) -> str:
        said = say_leave_out([labels[solid].strip("'")], models)
        return f"; {said}" if said else ""

    if cells[i] == cells[j]:
        raise CadError(
            f"{labels[i]} and {labels[j]} are the same solid twice, at ({place}): remove one of them{without(j)}.{more}"
        )
    if cells[i] < cells[j] or cells[j] < cells[i]:
        inner, outer = (i, j) if cells[i] < cells[j] else (j, i)
        raise CadError(
            f"{labels[inner]} lies wholly inside {labels[outer]}, at ({place}): "
            f"cut_overlaps=True (--cut-overlaps) cuts it out of {labels[outer]}{without(inner)}.{more}"
        )
    raise CadError(
        f"{labels[i]} and {labels[j]} overlap by a volume of {volume * units.scale**3:.4g} at ({place}): "
        f"cut_overlaps=True (--cut-overlaps) cuts the smaller out of the larger{without(j)}.{more}"
    )


def check_counts(fused: Fused, labels: Sequence[str]) -> None:
    """Refuse a solid that the fuse has divided or lost; the others are in `check_distinct`.

    Raises
    ------
    CadError
    """
    for pieces, label in zip(fused.pieces, labels, strict=True):
        if len(pieces) != 1:
            raise CadError(f"imprinting made {len(pieces)} pieces of {label}")


def check_imprinted(
    shapes: Sequence[Any],
    traced: Traced,
    labels: Sequence[str],
    units: Units,
    *,
    moved: float,
    whole: Set[int] = frozenset(),
) -> None:
    """Refuse what the general fuse made of the solids where it is not they, with more faces.

    Parameters
    ----------
    shapes : sequence of TopoDS_Solid
        As they were.
    traced : Traced
        Their compound, followed through the fuse.
    labels : sequence of str
        How messages call each solid.
    units : Units
    moved : float
        Distance by which faces may have been moved to one another.
    whole : set of int
        Solids that have the faces that they had: of these only the count is looked at.

    Raises
    ------
    CadError
        A solid is invalid, of another volume, or has lost a face.
    """
    for number, (shape, piece, label) in enumerate(zip(shapes, children(traced.shape), labels, strict=True)):
        if piece.IsSame(shape) or number in whole:
            continue
        try:
            check_closed(piece)
        except CadError as error:
            raise CadError(f"imprinting damaged {label}: {error}") from error
        damage = faults(piece)
        if damage:
            raise CadError(f"imprinting made {label} invalid: {damage[0]}")
        before, after = volume_and_center(shape)[0], volume_and_center(piece)[0]
        if abs(after - before) <= SAME_VOLUME * before:
            continue
        allowed = moved * surface_area(shape)
        if abs(after - before) > SAME_VOLUME * before + allowed:
            # OpenCASCADE's integrals over a face with splines and over its pieces can differ by per cents.
            before, after = integrated_volume(shape), integrated_volume(piece)
        if abs(after - before) > SAME_VOLUME * before + allowed:
            raise CadError(
                f"imprinting changed the volume of {label} from {before * units.scale**3:.9g} to "
                f"{after * units.scale**3:.9g}"
            )
    present = index_map(traced.shape, FACE)
    both = subshapes(compound(shapes), FACE)
    for face, became in zip(both, traced.faces, strict=True):
        if not became or not all(present.Contains(piece) for piece in became):
            raise CadError(f"imprinting lost a face at ({_place_of(face, units)})")


def _all(fused: Fused) -> Any:
    return compound([piece for pieces in fused.pieces for piece in pieces])


def _place_of(face: Any, units: Units) -> str:
    properties = GProp_GProps()
    BRepGProp.SurfaceProperties_s(face, properties)
    center = properties.CentreOfMass()
    return units.place(np.array([center.X(), center.Y(), center.Z()]))
