"""Meshes as small values: arrays and names, no behaviour that needs another library.

The order of a hexahedron's nodes is drawn in :mod:`cadsweep.cells`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from .arrays import FloatArray, IntArray
from .cells import SweptStructure
from .errors import UnknownNameError, did_you_mean
from .lattice import order_of
from .record import MeshRecord
from .verbs import do

if TYPE_CHECKING:
    from .quality import QualityReport


class NamedArrays(dict[str, IntArray]):
    """Arrays by name; a name that is not there is an error that lists those that are.

    Parameters
    ----------
    kind : str
        What the names are of: ``boundary``, ``interface``, ``part``.
    arrays : mapping of str to int64 array
    """

    def __init__(self, kind: str, arrays: Mapping[str, IntArray]) -> None:
        super().__init__(arrays)
        self._kind = kind

    def __missing__(self, name: str) -> IntArray:
        meant = did_you_mean(str(name), self)
        there = (
            "there is none"
            if not self
            else f"there are {', '.join(self)}"
            if len(self) > 1
            else f"there is {next(iter(self))}"
        )
        raise UnknownNameError(f"the mesh has no {self._kind} '{name}'{meant}; {there}")

    def __reduce__(self) -> tuple[Any, ...]:
        return NamedArrays, (self._kind, dict(self))


@dataclass(frozen=True, kw_only=True, eq=False)
class WallRows:
    """Rows of nodes along walls of a section, a column of them at each node of the walls.

    Attributes
    ----------
    ring : (c,) int64
        Where each column begins: a place in ``np.concatenate(loops)``.
    nodes : (c, n) int64
        Nodes of the cap, from the wall inwards.
    first, growth : (c,) float64
        Height of the first layer that is asked for, working units, and its growth.
    room : (c,) float64
        Length that a column may have on the source cap.
    faces : frozenset of int
        The walls.
    """

    ring: IntArray
    nodes: IntArray
    first: FloatArray
    growth: FloatArray
    room: FloatArray
    faces: frozenset[int]


@dataclass(frozen=True, kw_only=True, eq=False)
class QuadMesh:
    """The source cap's mesh.

    Attributes
    ----------
    points : (n, 3) float64
    quads : (q, 4) int64
        Counter-clockwise about the sweep direction (normals point into the solid).
    faces : (q,) int64
        Face id of the solid that each quad lies on.
    loops : tuple of int64 arrays
        Boundary nodes in cyclic order, outer loop first; loop j follows ``Sweep.source_loops[j]``.
    edge_nodes : dict of int to int64 array
        For every edge of the cap (boundary and, on a cap of several faces, inner ones): its node
        ids from the edge's start to its end.
    walls : tuple of WallRows
        Rows of nodes whose distance from a wall was asked for.
    places : (n_levels, n, 3) float64, optional
        Of the arrangement of a stack: where its nodes are on every level, where that was looked for level by level.
    """

    points: FloatArray
    quads: IntArray
    faces: IntArray
    loops: tuple[IntArray, ...]
    edge_nodes: dict[int, IntArray]
    walls: tuple[WallRows, ...] = ()
    places: FloatArray | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class SurfaceMesh:
    """What the surface stage hands to projection: the source cap and the rings on the linking sides.

    Attributes
    ----------
    source : QuadMesh
    rings : (n_layers + 1, b, 3) float64
        Boundary nodes of every layer, in the order of ``np.concatenate(source.loops)``.
    side_faces : (n_layers, b) int64
        Face id of the linking quad between ring nodes j and its successor in the same loop, and
        layers k and k + 1.
    node_edges : (n_layers + 1, b) int64
        Edge id on which the ring node lies, -1 inside a face.
    node_vertices : (n_layers + 1, b) int64
        Vertex id on which the ring node lies, -1 elsewhere.
    target_edge_points : dict of int to (m, 3) float64
        Node positions on inner edges of a target cap of several faces, start to end; empty else.
    notes : tuple of str
    """

    source: QuadMesh
    rings: FloatArray
    side_faces: IntArray
    node_edges: IntArray
    node_vertices: IntArray
    target_edge_points: dict[int, FloatArray] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class HexMesh:
    """A hexahedral mesh with named boundaries.

    Attributes
    ----------
    points : (n, 3) float64
        Nodes in model length units.
    hexes : (m, 8), (m, 20), (m, 27) or (m, (p + 1)^3) int64
        VTK node order; above order 2 that of its Lagrange hexahedra (:mod:`cadsweep.lattice`).
    boundaries : dict of str to (q, 4), (q, 8), (q, 9) or (q, (p + 1)^2) int64
        Quads of each named boundary, outward.
    parts : dict of str to (h,) int64
        Hex ids of each named volume.
    interfaces : dict of str to (q, 4), (q, 8), (q, 9) or (q, (p + 1)^2) int64
        Quads between two parts, outward from the one that the name begins with.
    periodic : dict of str to (p, 2) int64
        Pairs of nodes of two boundaries whose meshes answer each other, as ``"left__right"``: each node of the first
        and its image on the second.
    structure : SweptStructure or None
        Quads times layers, where the mesh is one sweep of order 1.
    info : MeshRecord
        What is known of its making, as a read-only mapping (:mod:`cadsweep.record` explains its keys); a mapping that
        is handed over becomes one.
    parents : (m,) int64 or None
        Of a refined mesh (:func:`cadsweep.refine`): the hex of the unrefined mesh that each hex is a piece of.
    origin : object or None
        What the pipeline made the mesh from, the CAD model included, by which it can be refined; it stays in the
        process (no file and no pickle has it).

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> box = cq.Workplane().box(4, 3, 2)
    >>> mesh = cs.sweep_mesh(box, size=1.0, layers=2)
    >>> mesh
    HexMesh: 24 hexes of order 1, 60 nodes
      boundaries: source (12 quads), target (12 quads), ...
    >>> mesh.points.shape, mesh.hexes.shape, mesh.boundaries["source"].shape
    ((60, 3), (24, 8), (12, 4))
    >>> mesh.record.cad_volume
    24.0
    """

    points: FloatArray
    hexes: IntArray
    boundaries: dict[str, IntArray]
    parts: dict[str, IntArray] = field(default_factory=dict)
    interfaces: dict[str, IntArray] = field(default_factory=dict)
    periodic: dict[str, IntArray] = field(default_factory=dict)
    structure: SweptStructure | None = None
    info: Mapping[str, Any] = field(default_factory=MeshRecord)
    parents: IntArray | None = None
    origin: Any = field(default=None, repr=False)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "origin": None}

    def __post_init__(self) -> None:
        for field_name, kind in (("boundaries", "boundary"), ("interfaces", "interface"), ("parts", "part")):
            object.__setattr__(self, field_name, NamedArrays(kind, getattr(self, field_name)))
        object.__setattr__(self, "info", MeshRecord.of(self.info))

    def __repr__(self) -> str:
        lines = [f"HexMesh: {self.n_hexes:,} hexes of order {self.order}, {self.n_nodes:,} nodes"]
        lines.append("  boundaries: " + _counted(self.boundaries, "quads"))
        if len(self.parts) > 1 or self.interfaces:
            lines.append(f"  parts: {_counted(self.parts, 'hexes')}; interfaces: {_counted(self.interfaces, 'quads')}")
        return "\n".join(lines)

    @property
    def record(self) -> MeshRecord:
        """What is known of its making, by typed fields."""
        assert isinstance(self.info, MeshRecord)
        return self.info

    @property
    def order(self) -> int:
        """Polynomial order, 1 to 8; 0 of an array that is none of hexahedra."""
        return order_of(self.hexes.shape[1])

    @property
    def n_nodes(self) -> int:
        """Number of nodes."""
        return len(self.points)

    @property
    def n_hexes(self) -> int:
        """Number of hexahedra."""
        return len(self.hexes)

    def named_quads(self) -> dict[str, IntArray]:
        """Quads of boundaries and interfaces, by name; of both where some faces of a name are in contact."""
        found = {**self.boundaries, **self.interfaces}
        for name in self.boundaries.keys() & self.interfaces.keys():
            found[name] = np.concatenate([self.boundaries[name], found[name]])
        return found

    def quality(self) -> QualityReport:
        """Every metric and check of :mod:`cadsweep.quality` on this mesh."""
        report: QualityReport = do("check_mesh", self)
        return report

    def write(self, path: str | PathLike[str], **options: Any) -> None:
        """Write the mesh; the suffix of `path` names the format (:func:`cadsweep.io.write`)."""
        do("write", self, path, **options)

    def to_pyvista(self) -> Any:
        """The mesh as a ``pyvista.UnstructuredGrid`` (needs the extra ``view``)."""
        return do("to_pyvista", self)

    def plot(self, **options: Any) -> Any:
        """Show the mesh in a window, or write a picture (:func:`cadsweep.view.plot`)."""
        return do("plot", self, **options)

    def _repr_html_(self) -> str:
        return str(do("mesh_summary_html", self))


def _counted(arrays: Mapping[str, IntArray], what: str, most: int = 6) -> str:
    """Names and how long their arrays are, in one line."""
    named = [f"{name} ({len(rows):,} {what})" for name, rows in list(arrays.items())[:most]]
    more = [f"and {len(arrays) - most} more"] if len(arrays) > most else []
    return ", ".join([*named, *more]) or "none"
