"""Read BREP, text and binary: a file's, or what a FreeCAD document holds."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from OCP.BinTools import BinTools
from OCP.BRep import BRep_Builder
from OCP.BRepTools import BRepTools
from OCP.TopoDS import TopoDS_Shape

from ...errors import CadError
from ..quiet import kernel_path
from .brep_text import check_brep_text

_NOT_FINITE = re.compile(rb"(?:^|\s)[-+]?(?:nan|inf)\b", re.IGNORECASE)


def read_brep(path: Path | str, data: bytes, file: Path) -> Any:
    """Read the BREP `data` that stand in `file`; messages say `path`."""
    shape = TopoDS_Shape()
    head = data[:200]
    try:
        if b"CASCADE Topology" in head and b"Open CASCADE" in head:
            with kernel_path(file) as name:
                BinTools.Read_s(shape, name)
        elif b"CASCADE Topology" in head or b"DBRep_DrawableShape" in head:
            if _NOT_FINITE.search(data):
                raise CadError(
                    f"{path}: the file holds a number that is not finite. Repair the model in its CAD program."
                )
            check_brep_text(path, data)
            with kernel_path(file) as name:
                BRepTools.Read_s(shape, name, BRep_Builder())
        else:
            raise CadError(f"{path}: this is not a BREP file of OpenCASCADE. Export STEP instead.")
    except CadError:
        raise
    except Exception as error:
        raise CadError(
            f"{path}: OpenCASCADE cannot read the BREP file ({first_line(error)}): it is damaged. "
            "Export or copy it again."
        ) from error
    if shape.IsNull():
        raise CadError(
            f"{path}: the BREP file is damaged or cut off: no shape could be read from it. Export or copy it again."
        )
    return shape


def first_line(error: Any) -> str:
    """The first line of what an error says, or its kind."""
    return str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
