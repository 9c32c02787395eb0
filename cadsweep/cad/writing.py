"""The cells of a part as a STEP file of touching solids, named and coloured.

Place in the flow: the end of ``cadsweep cut``. Lengths are the model's again.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
from OCP.gp import gp_Trsf, gp_Vec

from ..brep import Part
from ..errors import CadError, InputError
from .shapes import SolidShape

_GOLDEN = 0.618034


def write_cells(part: Part, path: Path) -> list[str]:
    """Write every cell as a solid of an assembly; returns their names.

    Raises
    ------
    InputError
        The file is no STEP file.
    CadError
        It could not be written.
    """
    import cadquery as cq

    if path.suffix.lower() not in (".step", ".stp"):
        raise InputError(f"{path}: the pieces are written as STEP (.step), not '{path.suffix}'")
    assembly = cq.Assembly(name=part.name)
    names = _names(part)
    for j, (solid, name) in enumerate(zip(part.solids, names, strict=True)):
        holder = solid.kernel
        assert isinstance(holder, SolidShape)
        assembly.add(cq.Shape.cast(_in_model_units(part, holder.shape)), name=name, color=_color(j))
    assembly.export(str(path), exportType="STEP")
    if not path.is_file() or not path.stat().st_size:
        raise CadError(f"{path} could not be written")
    return names


def _names(part: Part) -> list[str]:
    """The solid's name, and its piece's number where it has several."""
    seen: dict[int, int] = {}
    names = []
    for owner in part.owners:
        seen[owner] = seen.get(owner, 0) + 1
        several = part.owners.count(owner) > 1
        names.append(part.models[owner].name + (f"_{seen[owner]}" if several else ""))
    return names


def _in_model_units(part: Part, shape: object) -> object:
    if part.scale == 1.0 and not part.offset.any():
        return shape
    shift, stretch = gp_Trsf(), gp_Trsf()
    shift.SetTranslation(gp_Vec(*map(float, part.offset)))
    stretch.SetScaleFactor(part.scale)
    return BRepBuilderAPI_Transform(shape, shift.Multiplied(stretch), True).Shape()


def _color(number: int) -> object:
    """Colours far apart for cells that follow each other."""
    import cadquery as cq

    hue = (number * _GOLDEN) % 1.0
    rgb = np.clip(np.abs(((hue + np.array([0.0, 2 / 3, 1 / 3])) % 1.0) * 6.0 - 3.0) - 1.0, 0.0, 1.0)
    return cq.Color(*(float(c) for c in 0.35 + 0.55 * rgb))
