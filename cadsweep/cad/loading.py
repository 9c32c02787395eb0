"""``load``: from whatever the user has to a ``brep.Part``.

Place in the flow: the first stage. Reading (``files``, ``scripts``, ``objects``), healing
(``heal``), normalising (``units``), dividing (``divide``), extraction (``extract``).
"""

from __future__ import annotations

import logging
import math
import sys
from collections.abc import Callable, Mapping, Sequence
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from ..brep import Part
from ..collector import collector_resting
from ..errors import CadError, CadSweepError, InputError, no_such_file
from ..libraries import explain_import_error
from .read.model import Model

logger = logging.getLogger(__name__)

SCRIPTS = (".py",)
FILES = (".step", ".stp", ".brep", ".brp", ".iges", ".igs", ".fcstd", ".fcstd1")


def load(
    source: Any,
    *,
    params: Mapping[str, Any] | None = None,
    part: str | int | None = None,
    only: Sequence[str] | None = None,
    skip: Sequence[str] | None = None,
    touch: float | None = None,
    cut_overlaps: bool = False,
    on_progress: Callable[[float], None] | None = None,
) -> Part:
    """Load a part and make it clean for meshing.

    Parameters
    ----------
    source : path, CadQuery object or shape
        A ``.step``, ``.stp``, ``.brep``, ``.iges`` or ``.igs`` file, a FreeCAD document (``.FCStd``); a CadQuery
        script (``.py``) that calls ``show_object``; a ``cq.Workplane``, ``cq.Shape`` or ``cq.Assembly``; anything
        whose ``.wrapped`` is an OpenCASCADE shape, or ``.part`` is such an object (build123d), or such a shape
        itself; a list of them, in which a face with a ``.label`` names that face of the solids. A script is a program
        and runs with the rights of the caller.
    params : mapping, optional
        Values for the parameters of a script.
    part : str or int, optional
        Which solid of a model that has several: its name, or its number from 0; None takes them all.
    only, skip : sequence of str, optional
        Names of the solids to be read, or to be left out; what is left out need not be sound.
    touch : float, optional
        Distance, model units, up to which solids are taken to touch; by default, the noise of their coordinates.
    cut_overlaps : bool, optional
        Whether the larger of two solids that overlap is cut where they do; else they are refused.
    on_progress : callable, optional
        Called with the share that is done while several solids are healed and read.

    Returns
    -------
    Part
        With one cell for each solid: where solids touch, their cells share faces, edges and vertices. STEP and IGES
        files are in millimetres, whatever unit they were written in; other sources keep their numbers.

    Raises
    ------
    InputError
        The source is of no known kind, the file is not there, the script or its parameters are wrong, or there is
        no such `part`.
    CadError
        The model cannot be read, holds no usable solid, or holds solids that overlap and may not be cut.
    """
    if touch is not None and not 0.0 <= touch < math.inf:
        raise InputError(f"touch is a distance, in model units: {touch!r} is none.")
    read = read_model(source, params=params)
    from .heal.assembly import make_assembly
    from .heal.clean import make_part, stage
    from .heal.loose import separate_solids
    from .read.parts import choose_part, choose_solids, n_solids

    with stage(read, "sewing loose faces"):
        model = choose_solids(choose_part(separate_solids(read), part), only=only, skip=skip)
    if n_solids(model) <= 1:
        return make_part(model)
    return make_assembly(model, touch=touch, cut_overlaps=cut_overlaps, on_progress=on_progress)


def read_model(source: Any, *, params: Mapping[str, Any] | None = None) -> Model:
    """Read the source as it is, without healing."""
    if isinstance(source, (str, PathLike)):
        path = Path(fspath(source)).expanduser()
        if path.is_dir():
            raise InputError(f"{path}: this is a folder; name a file in it.")
        suffix = path.suffix.lower()
        if suffix not in SCRIPTS + FILES:
            raise InputError(
                f"{path}: cadsweep reads {', '.join(FILES + SCRIPTS)} files, not '{path.suffix}'; export one of them."
            )
        if not path.is_file():
            raise InputError(no_such_file(path))
        if suffix in SCRIPTS:
            _import_opencascade()
            from .read.scripts import run_script

            return run_script(path, params or {})
        if params:
            given = ", ".join(map(str, params))
            raise InputError(f"{path}: only scripts (.py) take parameters, given: {given}; leave them out.")
        _import_opencascade()
        from .read.files import read_file

        return read_file(path)
    if params:
        raise InputError("Only scripts (.py) take parameters; leave params out.")
    _import_opencascade()
    from .read.objects import read_object

    model = read_object(source)
    if model is None:
        raise InputError(
            f"cadsweep cannot load a {type(source).__name__}: give the path of a {', '.join(FILES + SCRIPTS)} file, "
            "a CadQuery Workplane, Shape or Assembly, or an object whose .wrapped is an OpenCASCADE shape."
        )
    return model


def _import_opencascade() -> None:
    """Import OpenCASCADE, or say in one line what to install."""
    if sys.modules.get("OCP") is not None:
        return
    try:
        with collector_resting():
            import OCP  # noqa: F401
    except (ImportError, OSError) as error:
        raise CadSweepError(explain_import_error("OpenCASCADE", error, distribution="cadquery")) from error


__all__ = ["CadError", "load", "read_model"]
