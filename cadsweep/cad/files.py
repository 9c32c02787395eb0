"""STEP, BREP and IGES files, through OpenCASCADE alone.

Place in the flow: one of the readers.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from OCP.BRep import BRep_Builder
from OCP.BRepTools import BRepTools
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.IGESControl import IGESControl_Reader
from OCP.STEPControl import STEPControl_Reader
from OCP.TopoDS import TopoDS_Shape

from ..errors import CadError
from .model import Model


def read_file(path: Path) -> Model:
    """Read a CAD file."""
    suffix = path.suffix.lower()
    if suffix in (".brep", ".brp"):
        return Model(shape=_read_brep(path), source=str(path), name=path.stem)
    reader = STEPControl_Reader() if suffix in (".step", ".stp") else IGESControl_Reader()
    if reader.ReadFile(str(path)) != IFSelect_ReturnStatus.IFSelect_RetDone:
        raise CadError(f"{path}: OpenCASCADE cannot read the file.")
    reader.TransferRoots()
    if reader.NbShapes() == 0:
        raise CadError(f"{path}: the file holds no shape.")
    return Model(shape=reader.OneShape(), source=str(path), name=path.stem)


def _read_brep(path: Path) -> Any:
    shape = TopoDS_Shape()
    if not BRepTools.Read_s(shape, str(path), BRep_Builder()) or shape.IsNull():
        raise CadError(f"{path}: this is no OpenCASCADE BREP file, or it is damaged.")
    return shape
