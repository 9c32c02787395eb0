"""Edges and faces of a solid, by id."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import pi

import numpy as np
import numpy.typing as npt

from ..arrays import BoolArray, FloatArray
from .geometry import Curve, Surface, Units


@dataclass(frozen=True, kw_only=True, eq=False)
class Edge:
    """A bounded curve between two vertices (which may be the same vertex only on refused parts).

    Attributes
    ----------
    id : int
        Index into ``Solid.edges``.
    start, end : int
        Vertex ids.
    length : float
        Arc length, working units.
    kind : str
        ``"line"``, ``"circle"``, ``"ellipse"``, ``"bspline"``, ``"other"``.
    faces : (int, int)
        Ids of the two faces that share the edge.
    dihedral : float
        Interior angle of the solid across the edge at its middle, radians: pi where the faces are
        tangent, below pi where the edge is convex.
    midpoint : (3,) float64
    tangents : (2, 3) float64
        Unit tangents at the start and at the end, both in the direction start to end.
    curve : Curve
    name : str or None
        The user's name for the edge, if there is one; of several, the one that names the fewest edges.
    groups : tuple of str
        Its other names, which it shares with more edges.
    key : str
        The id the edge had in the input, such as ``"edge 7"``; pieces of a divided edge share it. Empty
        where no edge was there.
    gap : float
        How far the borders of its faces, and its vertices, are off the curve, as measured; the model's own tolerance
        may say more.
    number : int or None
        What a user knows the edge by, where that is not its `id`; -1 where faces were divided since.
    units : Units
        What messages give places in.
    stands_for : tuple of Edge
        Of an edge that is drawn in a plane, and is none of the part: the part's edges that lie over it, lowest
        first.

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> box = cq.Workplane().box(4, 3, 2)
    >>> import numpy as np
    >>> edge = cs.load(box).solids[0].edges[0]
    >>> edge.kind, edge.length
    ('line', 2.0)
    >>> bool(np.allclose(edge.curve.evaluate(np.array([0.5]))[0], edge.midpoint))
    True
    """

    id: int
    start: int
    end: int
    length: float
    kind: str
    faces: tuple[int, int]
    dihedral: float
    midpoint: FloatArray
    tangents: FloatArray
    curve: Curve
    name: str | None = None
    groups: tuple[str, ...] = ()
    key: str = ""
    gap: float = 0.0
    number: int | None = None
    units: Units = field(default_factory=Units)
    stands_for: tuple[Edge, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """All of the user's names for the edge."""
        return self.groups if self.name is None else (self.name, *self.groups)

    @property
    def known(self) -> int:
        """The number that a user knows the edge by."""
        return self.id if self.number is None else self.number

    def __repr__(self) -> str:
        return f"E{self.label()[1:]}: length {self.length * self.units.scale:.6g}"

    def label(self) -> str:
        """How messages name the edge: id, name, kind and place of its middle."""
        if self.stands_for:
            return _one_under_another(self.stands_for)
        if self.known < 0:
            return f"an edge of the mesh's own ({self.kind} at {self.units.place(self.midpoint)})"
        return _label("edge", self.known, self.name, self.kind, self.units.place(self.midpoint))


RIGHT_TURN = pi / 4
"""How far an angle may be from a quarter or three quarters of a turn to count as one; from a half, half as far."""


def quarter_turns(angles: Sequence[float]) -> list[int] | None:
    """Turns of a loop at its vertices, in quarters to the left; None where an angle is near no multiple of one.

    Parameters
    ----------
    angles : sequence of float
        Interior angles.
    """
    turns = [round((pi - angle) / (pi / 2)) for angle in angles]
    off = [abs(pi - angle - turn * pi / 2) for angle, turn in zip(angles, turns, strict=True)]
    clear = all(o <= (RIGHT_TURN if turn else RIGHT_TURN / 2) for o, turn in zip(off, turns, strict=True))
    return turns if clear and all(abs(turn) <= 1 for turn in turns) else None


@dataclass(frozen=True, kw_only=True, eq=False)
class Loop:
    """A closed cycle of edges that bounds a face, its material on the left seen from outside.

    Attributes
    ----------
    edges : tuple of int
        Edge ids in cyclic order.
    forward : tuple of bool
        Whether edge j is run through from its start to its end.
    angles : tuple of float
        Interior angle of the face, in (0, 2 pi), at the vertex where edge j begins.
    """

    edges: tuple[int, ...]
    forward: tuple[bool, ...]
    angles: tuple[float, ...]

    @property
    def directed(self) -> tuple[tuple[int, bool], ...]:
        """The directed edges ``(edge id, forward)`` of the loop."""
        return tuple(zip(self.edges, self.forward, strict=True))


@dataclass(frozen=True, kw_only=True, eq=False)
class FormerFace:
    """A part of a face that was a face of its own in the model; its outline is no edge any more.

    Attributes
    ----------
    names : tuple of str
    key : str
    color : str or None
        As for :class:`Face`.
    area : float
    place : (3,) float64
        A point inside it.
    piece_at : callable
        ``piece_at(points)`` gives the numbers (m,) of what points (m, 3) on the face's surface lie in.
    pieces : tuple of int
        Numbers of what the patch is of.
    number : int or None
        As for :class:`Face`, of a face that is asked for by its number.
    """

    names: tuple[str, ...]
    key: str
    color: str | None
    area: float
    place: FloatArray
    piece_at: Callable[[FloatArray], npt.NDArray[np.generic]]
    pieces: tuple[int, ...]
    number: int | None = None


def lie_in(former: Sequence[FormerFace], points: FloatArray) -> BoolArray:
    """Which of points (m, 3) of a face lie in each of its patches, (n, m); what several share is asked once."""
    at = {ask: ask(points) for ask in dict.fromkeys(patch.piece_at for patch in former)}
    inside = [np.isin(at[patch.piece_at], patch.pieces) for patch in former]
    return np.array(inside, dtype=bool).reshape(len(former), len(points))


@dataclass(frozen=True, eq=False)
class GainedTip:
    """The tip of a neighbour that a face got (:mod:`cadsweep.cad.edit.bridging`).

    Attributes
    ----------
    surface : Surface
        That it lies on.
    corner : (3,) float64
    radius : float
        It is within this distance of its corner.
    """

    surface: Surface
    corner: FloatArray
    radius: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Face:
    """A bounded piece of a surface.

    Attributes
    ----------
    id : int
        Index into ``Solid.faces``.
    kind : str
        ``"plane"``, ``"cylinder"``, ``"cone"``, ``"sphere"``, ``"torus"``, ``"bspline"``,
        ``"revolution"``, ``"extrusion"``, ``"other"``.
    area : float
    center : (3,) float64
        Centroid of the face.
    normal : (3,) float64
        Unit normal out of the solid at the point of the face nearest to `center`.
    loops : tuple of Loop
        Outer loop first.
    surface : Surface
    name : str or None
        The user's name for the face, if there is one; of several, the one that names the fewest faces.
    groups : tuple of str
        Its other names, which it shares with more faces.
    color : str or None
        The face's own colour in the CAD model, sRGB as ``#rrggbb`` or ``#rrggbbaa``; None where it has the part's.
    key : str
        A name that a user can find: the id the face had in the input, such as ``"face 7"``; pieces
        of a divided face share it.
    former : tuple of FormerFace
        Parts of a merged face that go by another name.
    number : int or None
        Of a cell that was cut from a solid: the face of that solid that it is a piece of, -1 on a cut; of a solid
        without its marks the number that the face had with them. None where `id` is what a user knows the face by.
    units : Units
        What messages give places in.
    handles : int
        By how much its Euler number is less than its loops say: of a face that was united from several, twice its
        handles; negative where loops touch in vertices, as a hole that reaches the rim from inside.
    tips : tuple of GainedTip
        Tips of neighbours that it got: its outline leaves its surface there.
    stands_for : tuple of Face
        Of a face of a prism of columns, which is none of the part: the caps over its cell, lowest first, or the walls
        over its line.

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> box = cq.Workplane().box(4, 3, 2)
    >>> face = cs.load(box).solids[0].faces[0]
    >>> face.label()
    'face 0 (plane at -2, 0, 0)'
    >>> face.area, face.center.tolist()
    (6.0, [-2.0, 0.0, 0.0])
    """

    id: int
    kind: str
    area: float
    center: FloatArray
    normal: FloatArray
    loops: tuple[Loop, ...]
    surface: Surface
    name: str | None = None
    groups: tuple[str, ...] = ()
    color: str | None = None
    key: str = ""
    former: tuple[FormerFace, ...] = ()
    number: int | None = None
    units: Units = field(default_factory=Units)
    handles: int = 0
    tips: tuple[GainedTip, ...] = ()
    stands_for: tuple[Face, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """All of the user's names for the face."""
        return self.groups if self.name is None else (self.name, *self.groups)

    @property
    def known(self) -> int:
        """The number that a user knows the face by; -1 for a face on a cut."""
        return self.id if self.number is None else self.number

    @property
    def shown(self) -> str | int:
        """What a table calls the face: its name, else the number that a user knows it by."""
        return self.name or ("a cut" if self.known < 0 else self.known)

    @property
    def euler(self) -> int:
        """Euler number of the face without its border."""
        return 2 - len(self.loops) - self.handles

    @property
    def edges(self) -> tuple[int, ...]:
        """Ids of all edges of the face."""
        return tuple(e for loop in self.loops for e in loop.edges)

    def __repr__(self) -> str:
        return f"F{self.label()[1:]}: area {self.area * self.units.scale**2:.6g}"

    def label(self) -> str:
        """How messages name the face: the number that a user knows it by, name, kind and place."""
        if self.stands_for:
            return _one_under_another(self.stands_for)
        if self.number is not None and self.number < 0:
            return f"a cut ({self.kind} at {self.units.place(self.center)})"
        return _label("face", self.known, self.name, self.kind, self.units.place(self.center))


def _label(what: str, number: int, name: str | None, kind: str, place: str) -> str:
    named = f" '{name}'" if name else ""
    return f"{what} {number}{named} ({kind} at {place})"


def _one_under_another(over: Sequence[Edge | Face]) -> str:
    """How messages name what is no edge or face of a part: by those of the part that lie over it, lowest first."""
    more = f" and {len(over) - 2} more" if len(over) > 2 else ""
    return " under ".join(one.label() for one in over[:2]) + more
