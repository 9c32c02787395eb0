"""Files of meshes: one module a format, chosen by the suffix, and written whole or not at all.

Place in the flow: the last stage, and the way back. :func:`write` labels the mesh (portable names, groups as disjoint
blocks), lets the format's module write to a file that has no name yet, reads that back, compares, and puts it in place
in one step. What each format keeps stands in ``docs/formats.md``.

Node orders, element types and sides are tables of the format modules, each with its source.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Collection
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import replace
from importlib import import_module
from os import PathLike
from pathlib import Path
from struct import error as struct_error
from types import ModuleType
from typing import TYPE_CHECKING, Any, BinaryIO

from ..contacts import solids_of
from ..errors import CadSweepError, InputError, no_such_file
from ..progress import Progress, silent
from .atomic import check_place, replaced_file, replaced_folder

if TYPE_CHECKING:  # the command asks for formats before anything is loaded that takes time
    from ..arrays import IntArray
    from ..mesh import HexMesh
    from .labels import LabelledMesh

logger = logging.getLogger(__name__)

__all__ = ["FORMATS", "check_destination", "read", "write"]

FORMATS: dict[str, str] = {
    ".vtu": "VTK XML unstructured grid: ParaView, PyVista",
    ".pvtu": "VTK XML unstructured grid in pieces, a rank each, from a distributed run: ParaView",
    ".vtkhdf": "VTK HDF5: ParaView, PyVista",
    ".msh": "Gmsh MSH 4.1 binary, 2.2 text with version='2.2', Fluent with version='fluent': gmsh, dolfinx; OpenFOAM",
    ".inp": "Abaqus and CalculiX input, to be included in a deck",
    ".bdf": "Nastran bulk data, to be included in a deck",
    ".k": "LS-DYNA keyword input, to be included in a deck",
    ".cdb": "Ansys Mechanical APDL archive",
    ".rad": "Radioss starter input, to be included in a deck",
    ".feb": "FEBio mesh section, to be named by a model",
    ".unv": "I-deas universal file: Code_Aster, Salome",
    ".med": "MED 4: Code_Aster, Salome",
    ".cgns": "CGNS (HDF5)",
    ".e": "Exodus II: ParaView, Cubit, MOOSE",
    ".exo": "Exodus II",
    ".mesh": "MFEM mesh 1.3",
    ".re2": "Nek5000 and NekRS",
    ".su2": "SU2",
    ".xyz": "PLOT3D grid of structured blocks, with a neutral map (.nmf) beside it",
    ".polymesh": "OpenFOAM: a folder named polyMesh (case/constant/polyMesh)",
}
"""Suffix to what it is. A path whose last name is ``polyMesh`` needs no suffix."""

_FOLDER = ".polymesh"

_MODULES = {
    ".vtu": "vtu",
    ".pvtu": "pvtu",
    ".vtkhdf": "vtkhdf",
    ".msh": "msh",
    ".inp": "inp",
    ".bdf": "nastran",
    ".k": "lsdyna",
    ".cdb": "ansys",
    ".rad": "radioss",
    ".feb": "febio",
    ".unv": "unv",
    ".med": "med",
    ".cgns": "cgns",
    ".e": "exodus",
    ".exo": "exodus",
    ".mesh": "mfem_mesh",
    ".re2": "nek",
    ".su2": "su2",
    ".xyz": "plot3d",
    ".polymesh": "foam",
}


def check_destination(path: str | PathLike[str]) -> Path:
    """Make sure that a mesh can be written to `path`, before any work is done for it.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        The suffix names no format (the message lists them), or the folder is missing or not writable.
    """
    path = Path(path)
    _suffix(path)
    place = check_place(path)
    if place.is_dir() and _suffix(path) != _FOLDER:
        raise InputError(f"{path} is a folder; give a file name")
    return path


_BYTES = {
    ".vtu": 107,
    ".vtkhdf": 107,
    ".msh": 107,
    ".inp": 101,
    ".bdf": 204,
    ".k": 143,
    ".cdb": 295,
    ".rad": 168,
    ".feb": 162,
    ".unv": 314,
    ".med": 116,
    ".cgns": 58,
    ".e": 61,
    ".exo": 61,
    ".mesh": 81,
    ".re2": 204,
    ".su2": 111,
    ".xyz": 25,
    ".polymesh": 163,
}
"""About how many bytes a hexahedron of order 1 has with its nodes, of which a large mesh has as many: for progress."""


def write(
    mesh: HexMesh,
    path: str | PathLike[str],
    *,
    verify: bool = True,
    scale: float = 1.0,
    on_progress: Progress | None = None,
    **options: Any,
) -> None:
    """Write a mesh; the suffix of `path` names the format.

    The file appears whole or not at all: until it has been written, flushed to the disk, read back and compared, what
    stood at `path` before still stands.

    Parameters
    ----------
    mesh : HexMesh
    path : path
    verify : bool
        Read the file back and compare nodes, hexes, names and groups before it is put in place.
    scale : float
        Coordinates are written times this: 0.001 makes metres of a model in millimetres.
    on_progress : callable, optional
        Called while the file is written, every few megabytes, with ``"write"`` and about how much of it is done, then
        with ``"read back"`` where it is, and with ``"write", 1.0`` once it is in place. What it raises ends the
        writing, and what stood at `path` before still stands.
    options
        ``.msh``: ``version="4.1" | "2.2" | "fluent"``, ``binary``. ``.inp``: ``element="C3D8I"`` or another
        type of as many nodes, ``first_node``, ``first_element``, ``prefix``: several files go into one deck.
        ``polyMesh``: ``patch_types={"name": "wall"}``. ``.re2``: ``letters={"name": "v"}``. Other formats have none,
        or those that ``docs/formats.md`` names.

    Raises
    ------
    InputError
        The suffix, the folder, an option, or the mesh's arrays are not what they should be.
    CadSweepError
        The disk is full, or what was read back differs.

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> box = cq.Workplane().box(4, 3, 2)
    >>> from cadsweep import io
    >>> mesh = cs.sweep_mesh(box, size=1.0)
    >>> io.write(mesh, "box.inp", element="C3D8I", prefix="left_")
    >>> io.write(mesh, "case/constant/polyMesh", scale=0.001, patch_types={"source": "wall"})
    Traceback (most recent call last):
    cadsweep.errors.InputError: ...
    >>> import os
    >>> os.makedirs("case/constant")
    >>> io.write(mesh, "case/constant/polyMesh", scale=0.001, patch_types={"source": "wall"})
    """
    from .labels import label_mesh

    path = check_destination(path)
    module = _module(path)
    options = {name: value for name, value in options.items() if value is not None}
    check_options(path, options)
    if not 0 < scale < float("inf"):
        raise InputError(f"the scale is a positive, finite number, not {scale}")
    if scale != 1.0:
        mesh = replace(mesh, points=mesh.points * scale)
    labelled = label_mesh(
        mesh,
        max_name=getattr(module, "MAX_NAME", 80),
        reserved=getattr(module, "RESERVED", ()),
        most_order=getattr(module, "MOST_ORDER", 2),
    )
    voice = _Voice(on_progress, _BYTES.get(_suffix(path), 100) * mesh.n_hexes * mesh.hexes.shape[1] / 8)
    try:
        if _suffix(path) == _FOLDER:
            labelled = module.with_whole_boundary(labelled)
            with replaced_folder(path, known_files=module.FILES, on_bytes=voice.written) as folder:
                module.write_folder(folder, labelled, **options)
                if verify:
                    voice.say("read back", None)
                    _check(module, labelled, module.read_folder(folder.path), options)
        else:
            with ExitStack() as stack:
                if hasattr(module, "BESIDE"):  # a second file of the same name, put in place with the first
                    options["beside"] = stack.enter_context(replaced_file(path.with_suffix(module.BESIDE)))
                stream = stack.enter_context(replaced_file(path, voice.written))
                module.write(stream, labelled, **options)
                stream.flush()
                # The disk takes the bytes while they are compared.
                with ThreadPoolExecutor(max_workers=1) as pool:
                    flushed = pool.submit(os.fsync, stream.fileno())
                    if verify:
                        voice.say("read back", None)
                        _verify(module, labelled, stream, options)
                    flushed.result()
    except InputError:
        raise
    except CadSweepError as error:
        said = str(error)
        raise CadSweepError(said if str(path) in said else f"{path} was not written: {said}") from error
    voice.say("write", 1.0)
    logger.info("wrote %s: %d nodes, %d hexes", path, mesh.n_nodes, mesh.n_hexes)


class _Voice:
    """Says how much of a file is written."""

    def __init__(self, on_progress: Progress | None, expected: float) -> None:
        self.say = on_progress or silent
        self._expected, self._n_written = max(1.0, expected), 0

    def written(self, n_bytes: int) -> None:
        """Count bytes that were written."""
        self._n_written += n_bytes
        self.say("write", min(0.99, self._n_written / self._expected))


def check_options(path: str | PathLike[str], options: Collection[str]) -> None:
    """Make sure that the format has the options, before any work is done.

    Raises
    ------
    InputError
        Names the options that there are.
    """
    module = _module(Path(path))
    writer = getattr(module, "write_folder", None) or getattr(module, "write", None)
    allowed = getattr(writer, "__kwdefaults__", None) or {}
    for name in options:
        if name not in allowed:
            known = ", ".join(["scale", *allowed])
            raise InputError(f"{_suffix(Path(path))} files have no option {name!r}; they have: {known}")


def read(path: str | PathLike[str]) -> HexMesh:
    """Read a mesh of hexahedra; the suffix of `path` names the format.

    Returns
    -------
    HexMesh
        With the boundaries and parts that the file names; hexes in the order of the file's numbers.

    Raises
    ------
    InputError
        The file is missing, is not of its format, is cut short, or has no hexahedra or other solid cells too.

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> box = cq.Workplane().box(4, 3, 2)
    >>> mesh = cs.sweep_mesh(box, size=1.0)
    >>> mesh.write("box.msh")
    >>> again = cs.read("box.msh")
    >>> bool((again.points == mesh.points).all()), sorted(again.boundaries) == sorted(mesh.boundaries)
    (True, True)
    """
    path = Path(path)
    module = _module(path)
    try:
        if _suffix(path) == _FOLDER:
            mesh: HexMesh = module.read_folder(path)
        else:
            with ExitStack() as stack:
                stream = stack.enter_context(open(path, "rb"))
                second = path.with_suffix(getattr(module, "BESIDE", path.suffix))
                if second != path and second.exists():
                    mesh = module.read(stream, beside=stack.enter_context(open(second, "rb")))
                else:
                    mesh = module.read(stream)
        _check_groups(mesh)
        return _with_interfaces(mesh)
    except InputError as error:
        raise InputError(f"cannot read {path}: {error}") from error
    except FileNotFoundError:
        raise InputError(no_such_file(path)) from None
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror or error}") from error
    except MemoryError:
        raise InputError(f"cannot read {path}: it asks for more memory than there is; it may be damaged") from None
    except (ValueError, KeyError, IndexError, TypeError, OverflowError, EOFError, RuntimeError, struct_error) as error:
        # What numpy and the parsers say of damaged bytes: no defect of ours, and of no use to the user as it stands.
        raise InputError(
            f"cannot read {path}: it is no {_suffix(path)} file, or is damaged ({error}); write or copy it again"
        ) from error


def _check_groups(mesh: HexMesh) -> None:
    for name, quads in mesh.boundaries.items():
        if quads.size and not 0 <= int(quads.min()) <= int(quads.max()) < len(mesh.points):
            raise InputError(f"boundary {name!r} names a node that is not there: was the mesh changed outside?")
    for name, ids in mesh.parts.items():
        if ids.size and not 0 <= int(ids.min()) <= int(ids.max()) < len(mesh.hexes):
            raise InputError(f"part {name!r} names a hex that is not there")


def _with_interfaces(mesh: HexMesh) -> HexMesh:
    """Tell interfaces from boundaries: named after two parts, ``first__second``, and all of it inside the mesh."""
    interfaces: dict[str, IntArray] = {}
    twins = []
    for name, quads in mesh.boundaries.items():
        solids = solids_of(name, mesh.parts)
        if solids is not None and len(quads):
            if "__".join(solids[::-1]) in interfaces:  # the same quads seen from the other part
                twins.append(name)
            else:
                interfaces[name] = quads
    if not interfaces:
        return mesh
    from .sides import count_users

    interfaces = {n: q for n, q in interfaces.items() if (count_users(mesh.hexes, q, len(mesh.points)) == 2).all()}
    boundaries = {name: quads for name, quads in mesh.boundaries.items() if name not in {*interfaces, *twins}}
    return replace(mesh, boundaries=boundaries, interfaces=interfaces)


def _verify(module: ModuleType, mesh: LabelledMesh, stream: BinaryIO, options: dict[str, Any]) -> None:
    stream.seek(0)
    if hasattr(module, "verify"):
        module.verify(stream, mesh, **options)
    else:
        _check(module, mesh, module.read(stream), options)


def _check(module: ModuleType, mesh: LabelledMesh, back: HexMesh, options: dict[str, Any]) -> None:
    from .compare import all_boundaries, all_parts, check_same

    if hasattr(module, "aligned"):
        back = module.aligned(mesh, back)
    groups = (
        module.kept_groups(mesh, **options)
        if hasattr(module, "kept_groups")
        else (all_boundaries(mesh), all_parts(mesh))
    )
    check_same(
        mesh,
        back,
        groups,
        tolerance=getattr(module, "POINT_TOLERANCE", 0.0),
        turned=getattr(module, "TURNED", False),
    )


def _suffix(path: Path) -> str:
    suffix = _FOLDER if path.name.lower() == "polymesh" else path.suffix.lower()
    if suffix not in FORMATS:
        what = f"the suffix {path.suffix!r} of {path} names no format" if path.suffix else f"{path} has no suffix"
        raise InputError(f"{what}; known: {' '.join(FORMATS)}")
    return suffix


def _module(path: Path) -> ModuleType:
    return import_module(f".{_MODULES[_suffix(path)]}", __name__)
