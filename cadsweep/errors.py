"""Errors: one root, few children.

Every error that cadsweep raises on purpose is a :class:`CadSweepError`. A message says what is
wrong, where (face, edge, layer) and what to try. ``assert`` is kept for defects of our own.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from copy import copy
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Self

from .brief import in_lines

if TYPE_CHECKING:
    from .arrays import FloatArray


def did_you_mean(word: str, names: Iterable[str]) -> str:
    """The end of a sentence about a word that names nothing: the name that is most like it, or no words."""
    near = get_close_matches(word, list(names), n=1)
    return f" (did you mean '{near[0]}'?)" if near else ""


def no_such_file(path: object) -> str:
    """The sentence about a file that is not there, with the file beside it whose name is most like it."""
    place = Path(str(path))
    try:
        beside = [other.name for other in place.parent.iterdir() if other.is_file()]
    except OSError:
        return f"{path}: there is no such file, and no folder {place.parent} that can be read; check the path."
    near = get_close_matches(place.name, beside, n=1)
    return f"{path}: there is no such file" + (f"; did you mean '{near[0]}'?" if near else "; check the path.")


class CadSweepError(Exception):
    """Root of the errors that cadsweep raises on purpose.

    ``str(error)`` has at most three short lines: what cannot be had, where, and what to try.

    Parameters
    ----------
    what : str
        What cannot be had, and why. A message of one sentence may name its place and say what to try by itself.
    where : str
        The face or the place.
    try_ : str
        What to try: what was seen to help, where that is cheap to see.
    reasons : sequence of str
        The long form: what was looked at and why each of it fails, a line each.

    Attributes
    ----------
    what, where, try_, reasons
        As they were given, unshortened.
    message : str
        All but the reasons, unshortened, in one line.
    solids : tuple of str
        The solids of an assembly that are at fault, where that is known.

    Examples
    --------
    >>> import cadsweep as cs
    >>> try:
    ...     cs.sweep_mesh("missing.step")
    ... except cs.CadSweepError as error:  # whatever goes wrong on purpose
    ...     print(error)
    missing.step: there is no such file; check the path.
    """

    solids: tuple[str, ...] = ()

    def __init__(self, what: object = "", *, where: str = "", try_: str = "", reasons: Sequence[str] = ()) -> None:
        super().__init__(what)
        self.where = where
        self.try_ = try_
        self.reasons = tuple(reasons)

    @property
    def what(self) -> str:
        """What cannot be had."""
        return str(self.args[0])

    @property
    def message(self) -> str:
        """All that is said, in one line."""
        said = [self.what, *([f"at {self.where}"] if self.where else []), *([self.try_] if self.try_ else [])]
        return " ".join(
            "; ".join(line.rstrip(".;") if k < len(said) - 1 else line for k, line in enumerate(said)).split()
        )

    def __str__(self) -> str:
        return "\n".join(in_lines(self.what, self.where, self.try_))

    def about(self, what: str = "", *, where: str = "", try_: str = "", reasons: Sequence[str] = ()) -> Self:
        """The same refusal with other words for what is given, and with more reasons."""
        other = copy(self)
        other.args = (what or self.what, *self.args[1:])
        other.where, other.try_ = where or self.where, try_ or self.try_
        other.reasons = (*self.reasons, *reasons)
        return other


class InputError(CadSweepError, ValueError):
    """An argument, option, file or script is not what it should be.

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> box = cq.Workplane().box(4, 3, 2)
    >>> cs.sweep_mesh(box, siz=1.0)
    Traceback (most recent call last):
    cadsweep.errors.InputError: there is no option 'siz' (did you mean 'size'?)...
    """


class UnknownNameError(CadSweepError, KeyError):
    """A mesh has no boundary, interface or part of this name; the message lists what there is.

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> box = cq.Workplane().box(4, 3, 2)
    >>> cs.sweep_mesh(box, size=1.0).boundaries["inlet"]
    Traceback (most recent call last):
    cadsweep.errors.UnknownNameError: the mesh has no boundary 'inlet'; there are source, target, ...
    """

    __str__ = CadSweepError.__str__  # a KeyError quotes its message


class CoarseMeshError(InputError):
    """A mesh of the size asked for is so coarse that it is not the part; another sweep of the part may still be."""


class CadError(CadSweepError):
    """The CAD model cannot be read, or is not one usable solid.

    Examples
    --------
    >>> import cadsweep as cs
    >>> with open("page.step", "w") as file:
    ...     n = file.write("<html>not a STEP file</html>")
    >>> cs.load("page.step")
    Traceback (most recent call last):
    cadsweep.errors.CadError: ...
    """


class NotSweepableError(CadSweepError):
    """No pair of caps makes the solid a sweep.

    Attributes
    ----------
    reasons : tuple of str
        One line per rejected candidate, each naming the candidate's source face and the face or
        edge that rules it out; then one for each change of the part that did not help either, for each direction along
        which it is no stack of columns, and what of it no cuts were found for.
    faces : tuple of int
        Ids of the faces that are most in the way, the worst first.
    left : sequence of (m, 3) float64
        Where cuts were tried and none did: the edges of the cell that has no sweep, or of the faces on which cells do
        not agree, as chains of points, model units.

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> try:
    ...     cs.find_sweeps(cq.Workplane().sphere(3))
    ... except cs.NotSweepableError as error:
    ...     len(error.reasons) > 0
    True
    """

    def __init__(
        self,
        what: object = "",
        *,
        where: str = "",
        try_: str = "",
        reasons: Sequence[str] = (),
        faces: Sequence[int] = (),
    ) -> None:
        super().__init__(what, where=where, try_=try_, reasons=reasons)
        self.faces = tuple(int(face) for face in faces)
        self.left: tuple[FloatArray, ...] = ()


class PlanError(CadSweepError):
    """The cells of a part have sweeps, but no choice of one each agrees on the faces that they share.

    Attributes
    ----------
    faces : tuple of (int, int)
        The contradicting faces: cell of the part, and face id in that cell.
    """

    def __init__(
        self,
        what: object = "",
        *,
        where: str = "",
        try_: str = "",
        reasons: Sequence[str] = (),
        faces: Sequence[tuple[int, int]] = (),
    ) -> None:
        super().__init__(what, where=where, try_=try_, reasons=reasons)
        self.faces = tuple((int(cell), int(face)) for cell, face in faces)


class SurfaceMeshError(CadSweepError):
    """A face could not be meshed with quads alone, or an edge could not be divided as needed.

    Attributes
    ----------
    edges : tuple of int
        Edges whose segments are too long for the places that could not be meshed; empty where that is not why.

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> plate = cq.Workplane().box(8, 6, 2).faces(">Z").workplane().hole(2)
    >>> try:
    ...     cs.sweep_mesh(plate, counts={"edges:|Z": 3}, layers=4)
    ... except cs.CadSweepError as error:  # the counts that contradict each other are named
    ...     "4" in str(error)
    True
    """

    def __init__(
        self,
        what: object = "",
        *,
        where: str = "",
        try_: str = "",
        reasons: Sequence[str] = (),
        edges: Sequence[int] = (),
    ) -> None:
        super().__init__(what, where=where, try_=try_, reasons=reasons)
        self.edges = tuple(int(e) for e in edges)


class ProjectionError(CadSweepError):
    """A layer cannot be placed, because its ring does not determine an affine map.

    Attributes
    ----------
    layer : int or None
        Node layer, 0 on the source cap.
    loop : int or None
        Loop of the ring, 0 for the outer one.

    Examples
    --------
    >>> from cadsweep.projection import fit_affine
    >>> line = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]]
    >>> fit_affine(line, line)
    Traceback (most recent call last):
    cadsweep.errors.ProjectionError: ...
    """

    def __init__(self, what: object = "", *, layer: int | None = None, loop: int | None = None) -> None:
        super().__init__(what)
        self.layer = layer
        self.loop = loop


class InvertedHexError(CadSweepError):
    """The mesh has hexahedra with a Jacobian that is not positive, and they could not be mended.

    Attributes
    ----------
    hexes : tuple of int
        Ids of the worst hexahedra, worst first.
    min_scaled_jacobian : float
        The least scaled Jacobian of the mesh.
    crossing : tuple of (float, float, float)
        Corners of boundary quads that cross others where no hexahedron is inverted, model units.

    Examples
    --------
    >>> import cadsweep as cs
    >>> error = cs.InvertedHexError("no valid mesh", hexes=[7, 3], min_scaled_jacobian=-0.2)
    >>> error.hexes, error.min_scaled_jacobian
    ((7, 3), -0.2)
    """

    def __init__(
        self,
        what: object = "",
        *,
        where: str = "",
        try_: str = "",
        reasons: Sequence[str] = (),
        hexes: Sequence[int] = (),
        min_scaled_jacobian: float = float("nan"),
    ) -> None:
        super().__init__(what, where=where, try_=try_, reasons=reasons)
        self.hexes = tuple(int(h) for h in hexes)
        self.min_scaled_jacobian = float(min_scaled_jacobian)
        self.crossing: tuple[tuple[float, float, float], ...] = ()


class WorkerError(CadSweepError):
    """The isolated worker ended without an answer: crash, time-out or memory limit.

    Attributes
    ----------
    stage : str
        The stage that was under way (``"cad"``, ``"surface"``, ...).

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> box = cq.Workplane().box(4, 3, 2)
    >>> cs.sweep_mesh(box, isolated=True, timeout=0.01)
    Traceback (most recent call last):
    cadsweep.errors.WorkerError: time-out in stage 'start': ...
    """

    def __init__(self, what: object = "", *, stage: str = "") -> None:
        super().__init__(what)
        self.stage = stage
