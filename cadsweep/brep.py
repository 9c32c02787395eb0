"""The boundary representation as ids and numbers: what every stage after ``cad`` sees.

Place in the flow: ``cad`` makes these objects; ``recognition``, ``intervals`` and ``surface`` read
them. No OpenCASCADE type appears here; geometry is met only through the small protocols
:class:`Curve` and :class:`Surface`.

Lengths are *working* lengths: ``cad`` scales and shifts a part so that its size suits OpenCASCADE
and gmsh. :meth:`Part.to_model` brings points back to model units, bit for bit where nothing was
scaled.

Not handled here: geometry that is not a solid, and non-manifold solids; ``cad`` refuses them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import floor, log10, pi
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from .arrays import FloatArray, IntArray


class Curve(Protocol):
    """Geometry of an edge. ``fractions`` are fractions of arc length, 0 at its start, 1 at its end."""

    def evaluate(self, fractions: FloatArray) -> FloatArray:
        """Return the points (m, 3) at the given arc-length fractions (m,)."""
        ...

    def project(self, points: FloatArray) -> FloatArray:
        """Return the arc-length fractions (m,) of the points of the edge nearest to `points` (m, 3)."""
        ...

    def distance(self, points: FloatArray) -> FloatArray:
        """Return the distances (m,) of `points` (m, 3) from the edge, its ends included."""
        ...


class Surface(Protocol):
    """Geometry of a face, in the surface's own parameters ``uv`` (m, 2)."""

    @property
    def periods(self) -> tuple[float | None, float | None]:
        """Periods in u and v, None where the surface is not periodic."""
        ...

    def evaluate(self, uv: FloatArray) -> FloatArray:
        """Return the points (m, 3) of the surface at `uv` (m, 2)."""
        ...

    def derivatives(self, uv: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the partial derivatives (m, 3), (m, 3) by u and by v."""
        ...

    def normals(self, uv: FloatArray) -> FloatArray:
        """Return unit normals (m, 3) that point out of the solid."""
        ...

    def project(self, points: FloatArray) -> FloatArray:
        """Return the parameters (m, 2) of the points of the *face's surface* nearest to `points`."""
        ...

    def distance(self, points: FloatArray, *, close: float = ...) -> FloatArray:
        """Return the distances (m,) of `points` (m, 3) from the *face's surface*.

        Distances up to `close` are found fast; larger ones are made sure of by slower ways.
        """
        ...

    def edge_uv(self, edge: int, fractions: FloatArray) -> FloatArray:
        """Return the parameters (m, 2) of an edge of this face at arc-length fractions (m,).

        On a periodic surface the values of all edges lie in one consistent branch.
        """
        ...


@dataclass(frozen=True, eq=False)
class Units:
    """How working coordinates become the model's.

    Attributes
    ----------
    scale : float
        Model units per working unit, a power of two.
    offset : (3,) float64
        Model coordinates of the working origin.
    """

    scale: float = 1.0
    offset: FloatArray = field(default_factory=lambda: np.zeros(3))

    def to_model(self, points: FloatArray) -> FloatArray:
        """Bring points (..., 3) from working to model units; exact where nothing was shifted."""
        if self.scale == 1.0 and not self.offset.any():
            return points
        return points * self.scale + self.offset

    def place(self, point: FloatArray) -> str:
        """Return how messages say where a working point is: its model coordinates, to four digits of the part."""
        working = np.where(np.abs(point) > 1e-9, point, 0.0)
        if not self.offset.any():
            return ", ".join(f"{c:.4g}" for c in working * self.scale + 0.0)
        # Far from the origin, four digits of the coordinates themselves would be the same all over the part.
        step = self.scale * max(float(np.abs(working).max()), 1e-9) * 1e-4
        decimals = max(0, -floor(log10(step)))
        return ", ".join(f"{round(float(c), decimals) + 0.0:.15g}" for c in self.to_model(working))


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
    units : Units
        What messages give places in.

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
    units: Units = field(default_factory=Units)

    @property
    def names(self) -> tuple[str, ...]:
        """All of the user's names for the edge."""
        return self.groups if self.name is None else (self.name, *self.groups)

    def label(self) -> str:
        """How messages name the edge: id, name, kind and place of its middle."""
        return _label("edge", self.id, self.name, self.kind, self.units.place(self.midpoint))


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
    contains : callable
        ``contains(points)`` says of points (m, 3) on the face's surface which lie in the patch, (m,) bool.
    """

    names: tuple[str, ...]
    key: str
    color: str | None
    area: float
    place: FloatArray
    contains: Callable[[FloatArray], npt.NDArray[np.bool_]]


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
    units : Units
        What messages give places in.

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
    units: Units = field(default_factory=Units)

    @property
    def names(self) -> tuple[str, ...]:
        """All of the user's names for the face."""
        return self.groups if self.name is None else (self.name, *self.groups)

    @property
    def edges(self) -> tuple[int, ...]:
        """Ids of all edges of the face."""
        return tuple(e for loop in self.loops for e in loop.edges)

    def label(self) -> str:
        """How messages name the face: id, name, kind and place."""
        return _label("face", self.id, self.name, self.kind, self.units.place(self.center))


def _label(what: str, number: int, name: str | None, kind: str, place: str) -> str:
    named = f" '{name}'" if name else ""
    return f"{what} {number}{named} ({kind} at {place})"


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Solid:
    """One solid: vertices, edges and faces by id, every edge shared by exactly two faces.

    Attributes
    ----------
    vertices : (n_vertices, 3) float64
    edges : tuple of Edge
    faces : tuple of Face
    volume : float
    size : float
        Diagonal of the bounding box.
    tolerance : float
        Largest gap that the model allows between a vertex or an edge and its faces.
    kernel : object
        What ``cad`` has to find again of the solid, its shape in the CAD kernel; None, or whatever else, to everybody
        else.
    vertex_keys, edge_keys, face_keys : int64 arrays
        Ids within the whole part: equal keys in two solids mean the same, shared entity.
    name : str or None
    material : str or None
    color : str or None
        The part's colour in the CAD model, as in ``Face.color``.
    units : Units
        What messages give places in.
    opened : pair of frozenset of int, or None
        Of a closed ring that was cut open, the faces on either side of the cut: two caps in one place.

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> box = cq.Workplane().box(4, 3, 2)
    >>> solid = cs.load(box).solids[0]
    >>> len(solid.faces), len(solid.edges), solid.vertices.shape
    (6, 12, (8, 3))
    >>> all(len(edge.faces) == 2 for edge in solid.edges)
    True
    """

    vertices: FloatArray
    edges: tuple[Edge, ...]
    faces: tuple[Face, ...]
    volume: float
    size: float
    tolerance: float = 0.0
    kernel: object = None
    vertex_keys: IntArray
    edge_keys: IntArray
    face_keys: IntArray
    name: str | None = None
    material: str | None = None
    color: str | None = None
    units: Units = field(default_factory=Units)
    opened: tuple[frozenset[int], frozenset[int]] | None = None

    def first_vertex(self, directed: tuple[int, bool]) -> int:
        """Vertex where a directed edge ``(edge id, forward)`` begins."""
        edge = self.edges[directed[0]]
        return edge.start if directed[1] else edge.end

    def last_vertex(self, directed: tuple[int, bool]) -> int:
        """Vertex where a directed edge ``(edge id, forward)`` ends."""
        edge = self.edges[directed[0]]
        return edge.end if directed[1] else edge.start

    def __repr__(self) -> str:
        names = [face.name for face in self.faces if face.name]
        known = f", named: {', '.join(names[:6])}" + (", ..." if len(names) > 6 else "") if names else ""
        return (
            f"Solid {self.name or ''}".rstrip()
            + f": {len(self.faces)} faces, {len(self.edges)} edges, {len(self.vertices)} vertices{known}"
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class ModelSolid:
    """A solid of the model, as its user knows it: one part of the mesh, of one cell or of several.

    Attributes
    ----------
    name : str
        Unique among the model's solids, also without regard to case, and made of ``[A-Za-z0-9_]``.
    path : str
        The names of the assemblies that it is in and its own as the user gave it, joined by ``/``.
    volume : float
        Of the solid before it was imprinted or cut, working units.
    material : str or None
    color : str or None
        As in ``Face.color``.
    kernel : object
        What ``cad`` must find again: the solid before it was imprinted.
    """

    name: str
    path: str = ""
    volume: float
    material: str | None = None
    color: str | None = None
    kernel: Any = field(default=None, repr=False, compare=False)


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Part:
    """What ``load`` returns: the solids of a model, made clean for meshing.

    Attributes
    ----------
    solids : tuple of Solid
        The cells: entities that two of them share have equal keys in both.
    name : str
    scale : float
        Model units per working unit, a power of two.
    offset : (3,) float64
        Model coordinates of the working origin.
    notes : tuple of str
        What was done to the model on the way (faces divided, slivers merged, shells sewn, names
        changed): one readable line each.
    names : dict
        Declared (unique, ``[A-Za-z0-9_]``) name to the name the user gave.
    owners : tuple of int
        For every cell the index into `models` of the solid that it is a piece of; by default, each its own.
    models : tuple of ModelSolid
        The solids of the model; by default, those that the cells are.
    cuts : tuple of str
        Along what the solids were cut, a line a cut.
    touch : float
        Distance, working units, by which faces of solids may have been moved to one another where they touch.
    contacts : frozenset of str
        Names of faces that stand for contacts, where the solids share nothing.

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> part = cs.load("models/flanges.step")
    >>> [solid.name for solid in part.solids]
    ['lower', 'gasket', 'upper']
    >>> shared = set(part.solids[0].face_keys) & set(part.solids[1].face_keys)
    >>> len(shared)  # the gasket lies on one face of the lower flange
    1
    """

    solids: tuple[Solid, ...]
    name: str = "part"
    scale: float = 1.0
    offset: FloatArray = field(default_factory=lambda: np.zeros(3))
    notes: tuple[str, ...] = ()
    names: dict[str, str] = field(default_factory=dict)
    owners: tuple[int, ...] = ()
    models: tuple[ModelSolid, ...] = ()
    cuts: tuple[str, ...] = ()
    touch: float = 0.0
    contacts: frozenset[str] = frozenset()

    def __post_init__(self) -> None:
        if not self.owners:
            object.__setattr__(self, "owners", tuple(range(len(self.solids))))
        if not self.models:
            models = tuple(
                ModelSolid(
                    name=solid.name or (f"solid_{j + 1}" if len(self.solids) > 1 else "solid"),
                    volume=solid.volume,
                    material=solid.material,
                    color=solid.color,
                )
                for j, solid in enumerate(self.solids)
            )
            object.__setattr__(self, "models", models)

    def __repr__(self) -> str:
        volume = sum(solid.volume for solid in self.solids) * self.scale**3
        n_faces = sum(len(solid.faces) for solid in self.solids)
        solids = ", ".join(model.name for model in self.models[:6]) + (", ..." if len(self.models) > 6 else "")
        cells = f" in {len(self.solids)} cells" if len(self.solids) > len(self.models) else ""
        count = f"{len(self.models)} solid{'s' * (len(self.models) > 1)}"
        return f"Part {self.name}: {n_faces} faces, volume {volume:.6g}\n  {count}{cells}: {solids}"

    def to_model(self, points: FloatArray) -> FloatArray:
        """Bring points (..., 3) from working to model units; exact where nothing was shifted."""
        return Units(self.scale, self.offset).to_model(points)
