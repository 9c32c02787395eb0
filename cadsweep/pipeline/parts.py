"""From what the user gives to a part, and the sweeps of its one solid."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from .. import cad, recognition
from ..brep import Part, Solid
from ..errors import CadError, InputError
from ..sweep import Sweep
from .complexes.subsets import chosen_solids


def load(
    source: Any,
    *,
    params: dict[str, Any] | None = None,
    part: str | int | None = None,
    only: Sequence[str] | None = None,
    skip: Sequence[str] | None = None,
    touch: float | None = None,
    cut_overlaps: bool = False,
    on_progress: Callable[[float], None] | None = None,
) -> Part:
    """Read a part and make it clean for meshing.

    Parameters
    ----------
    source : path, CadQuery object, or anything with ``.wrapped``
        A ``.step``, ``.stp``, ``.brep``, ``.iges``, ``.igs``, ``.FCStd`` or ``.py`` file; a ``cq.Workplane``,
        ``cq.Shape`` or ``cq.Assembly``. A CadQuery script is executed.
    params : dict or None
        Parameters of a script.
    part : str, int or None
        Which solid of an assembly: its name, or its number from 0; None takes them all, imprinted on each other.
    only, skip : sequence of str or None
        Names of the solids of an assembly to be read, or to be left out; what is left out need not be sound.
    touch : float or None
        Distance, model units, up to which solids are taken to touch; None derives it from the part's size.
    cut_overlaps : bool
        Whether the larger of two solids that overlap is cut where they do; else they are refused.
    on_progress : callable or None
        Called with the share that is done while several solids are healed and read.

    Raises
    ------
    InputError
        No such file, an unknown format, a part that is not there, or parameters that the script does not have.
    CadError
        The model cannot be read, or holds no usable solid.

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> box = cq.Workplane().box(4, 3, 2)
    >>> cs.load(box)
    Part part: 6 faces, volume 24
      1 solid: part
    >>> cs.load("models/elbow.py", params={"angle": 45}).name
    'elbow'
    >>> [model.name for model in cs.load("models/flanges.step").models]
    ['lower', 'gasket', 'upper']
    """
    if isinstance(source, Part):
        if params:
            raise InputError("params go with a script; this part is loaded already")
        if part is not None:
            raise InputError("part chooses a solid of what is loaded; this part is loaded already")
        return chosen_solids(source, only=only, skip=skip)
    return cad.load(
        source,
        params=params,
        part=part,
        only=only,
        skip=skip,
        touch=touch,
        cut_overlaps=cut_overlaps,
        on_progress=on_progress,
    )


def search(part: Part, source: Any, target: Any) -> list[Sweep]:
    """The sweeps of the solid as it is, with the caps that the user named.

    Raises
    ------
    NotSweepableError
        There is none.
    """
    return recognition.find_sweeps(only_solid(part), source=resolve_cap(part, source), target=resolve_cap(part, target))


def only_solid(part: Part) -> Solid:
    """The solid of a part that has one."""
    if len(part.solids) != 1:
        raise CadError(
            f"'{part.name}' has {len(part.solids)} solids, and a sweep belongs to one: "
            "choose one with part=..., or fuse them first"
        )
    return part.solids[0]


def resolve_cap(part: Part, choice: Any) -> tuple[int, ...] | None:
    """Resolve the user's word for a cap to face ids."""
    if choice is None:
        return None
    choices = choice if isinstance(choice, list | tuple) else [choice]
    return tuple(dict.fromkeys(face for one in choices for face in cad.select_faces(part, one)))
