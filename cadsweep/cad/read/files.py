"""STEP, BREP, IGES and FreeCAD files, through OpenCASCADE alone.

Place in the flow: one of the readers. Importing CadQuery would cost two seconds, so names are
read through OpenCASCADE's XCAF here (``step``).

Before OpenCASCADE sees a file, its frame is checked in Python: OpenCASCADE reads half of a truncated
file without a word, and some damaged ones crash it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.IGESControl import IGESControl_Reader

from ...errors import CadError, InputError
from ..quiet import kernel_path, quiet_opencascade
from .brep_files import first_line, read_brep
from .model import Model

FREECAD = (".fcstd", ".fcstd1")
BOM = b"\xef\xbb\xbf"


def read_file(path: Path) -> Model:
    """Read a STEP, BREP, IGES or FreeCAD file.

    Raises
    ------
    InputError
        The file cannot be opened, or is empty.
    CadError
        It is not what its suffix says, is truncated, or holds no shape.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: the file cannot be read: {error.strerror or error}.") from error
    if not data.strip(b" \t\r\n\0" + BOM):
        raise InputError(f"{path}: the file is empty. Export it again from its CAD program.")
    if data.startswith(b"version https://git-lfs"):
        raise CadError(f"{path}: this is a pointer of Git LFS and not the model. Fetch that with 'git lfs pull'.")
    suffix = path.suffix.lower()
    if suffix in FREECAD:
        from .freecad import read_freecad

        return read_freecad(path)
    with quiet_opencascade():
        if suffix in (".step", ".stp"):
            from .step import read_step
            from .step_text import check_step_text

            check_step_text(path, data)
            return read_step(path, data)
        shape = read_brep(path, data, path) if suffix in (".brep", ".brp") else _read_iges(path, data)
    return Model(shape=shape, source=str(path), name=path.stem)


def _read_iges(path: Path, data: bytes) -> Any:
    first = data.removeprefix(BOM).splitlines()[0]
    if len(first) < 73 or first[72:73] not in b"SCB":
        raise CadError(
            f"{path}: this is not an IGES file: column 73 of its first line does not say S. "
            "Export it again, or as STEP."
        )
    last = data.rstrip(b"\r\n \0").splitlines()[-1]
    if last[72:73] != b"T":
        raise CadError(f"{path}: the IGES file is cut off: its last line is no T line. Export or copy it again.")
    reader = IGESControl_Reader()
    try:
        with kernel_path(path) as name:
            status = reader.ReadFile(name)
        if status != IFSelect_ReturnStatus.IFSelect_RetDone:
            raise CadError(
                f"{path}: OpenCASCADE cannot read the IGES file: it is damaged. Export it again, or as STEP."
            )
        reader.TransferRoots()
        shape = reader.OneShape() if reader.NbShapes() else None
    except CadError:
        raise
    except Exception as error:
        raise CadError(
            f"{path}: OpenCASCADE cannot read the IGES file: {first_line(error)}. Export it again, or as STEP."
        ) from error
    if shape is None or shape.IsNull():
        raise CadError(f"{path}: the IGES file holds no shape. Export a solid, or its faces.")
    return shape
