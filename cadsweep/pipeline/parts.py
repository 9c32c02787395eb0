"""From what the user gives to a part and its candidate sweeps."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

from .. import cad, recognition
from ..assembly import is_ring
from ..errors import CadError, InputError, NotSweepableError
from ..options import SweepOptions
from ..topology import Part, Solid, Sweep
from .run import Run

DOUBTFUL = 0.4
"""Score of the best sweep below which one of the part with merged faces is looked for."""


def load(source: Any, *, params: dict[str, Any] | None = None, part: str | int | None = None) -> Part:
    """Read a part and make it clean for meshing.

    Parameters
    ----------
    source : path, CadQuery object, or anything with ``.wrapped``
        A ``.step``, ``.stp``, ``.brep``, ``.iges``, ``.igs`` or ``.py`` file; a ``cq.Workplane``,
        ``cq.Shape`` or ``cq.Assembly``. A CadQuery script is executed.
    params : dict or None
        Parameters of a script.
    part : str, int or None
        Which solid of an assembly: its name, or its number from 0.

    Raises
    ------
    InputError
        No such file, an unknown format, a part that is not there, or parameters that the script does not have.
    CadError
        The model cannot be read, or holds no usable solid.
    """
    if isinstance(source, Part):
        if params:
            raise InputError("params go with a script; this part is loaded already")
        if part is not None:
            raise InputError("part chooses a solid of what is loaded; this part is loaded already")
        return source
    return cad.load(source, params=params, part=part)


def find_sweeps(part: Any, *, source: Any = None, target: Any = None) -> list[Sweep]:
    """List the ways in which a part can be swept, best first.

    Parameters
    ----------
    part : Part, or whatever :func:`load` takes
    source, target : name, id, CadQuery selector string, sequence of them, or None
        Keep only sweeps with this cap.

    Raises
    ------
    NotSweepableError
        There is none; ``.reasons`` says why, a line for each candidate.
    """
    return open_and_find(load(part), source, target)[1]


def open_and_find(part: Part, source: Any, target: Any) -> tuple[Part, list[Sweep]]:
    """Find the sweeps of a part.

    A full ring of revolution, which has none, is cut open first. Where nothing is found, or nothing
    good, or the best sweep's caps are divided in ways that do not correspond, faces that only divide
    one plane or cylinder are merged. A cap that the user named keeps its faces where the part has any sweep.
    """
    solid = _only_solid(part)
    refusal: NotSweepableError | None = None
    sweeps: list[Sweep] = []
    try:
        sweeps = recognition.find_sweeps(solid, source=_resolve(part, source), target=_resolve(part, target))
        corresponds = len(sweeps[0].target) == 1 or bool(sweeps[0].target_faces)
        if corresponds and sweeps[0].score >= DOUBTFUL:
            return part, sweeps
    except NotSweepableError as error:
        refusal = error
        ring = cad.cut_ring(part)
        if ring is not None:
            sweeps = recognition.find_sweeps(
                _only_solid(ring), source=_resolve(ring, source), target=_resolve(ring, target)
            )
            return ring, [sweep for sweep in sweeps if is_ring(sweep)] or sweeps
    hinted = source is not None or target is not None
    merged = None if hinted and _is_sweepable(solid) else cad.merge_faces(part)
    if merged is not None:
        with suppress(NotSweepableError):  # then the part as it was has the last word
            better = recognition.find_sweeps(
                _only_solid(merged), source=_resolve(merged, source), target=_resolve(merged, target)
            )
            if not sweeps or better[0].score > sweeps[0].score:
                return merged, better
    if refusal is not None:
        raise refusal
    return part, sweeps


def _is_sweepable(solid: Solid) -> bool:
    try:
        return bool(recognition.find_sweeps(solid))
    except NotSweepableError:
        return False


def _only_solid(part: Part) -> Solid:
    if len(part.solids) != 1:
        raise CadError(
            f"'{part.name}' has {len(part.solids)} solids, and a sweep belongs to one: "
            "choose one with part=..., or fuse them first"
        )
    return part.solids[0]


def _resolve(part: Part, choice: Any) -> tuple[int, ...] | None:
    """Resolve the user's word for a cap to face ids."""
    if choice is None:
        return None
    choices = choice if isinstance(choice, list | tuple) else [choice]
    return tuple(dict.fromkeys(face for one in choices for face in cad.select_faces(part, one)))


def find_candidates(source: Any, options: SweepOptions, run: Run) -> tuple[Part, list[Sweep]]:
    with run.stage("cad"):
        params = None if options.params is None else dict(options.params)
        part = load(source, params=params, part=options.part)
    with run.stage("recognition"):
        return open_and_find(part, options.source, options.target)
