"""Meshes as small values: arrays and names, no behaviour that needs another library.

Node order of a hexahedron (VTK)::

          7-------6            bottom 0 1 2 3 lies nearer to the source; seen along the sweep
         /|      /|            it turns counter-clockwise, so its normal (right-hand rule) points
        4-------5 |            along the sweep and the volume is positive.
        | 3-----|-2
        |/      |/             hex20 adds the middles of the edges
        0-------1                8: 0-1    9: 1-2   10: 2-3   11: 3-0
                                12: 4-5   13: 5-6   14: 6-7   15: 7-4
                                16: 0-4   17: 1-5   18: 2-6   19: 3-7
                               hex27 adds the middles of the faces, then of the volume
                                20: 0-4-7-3   21: 1-2-6-5   22: 0-1-5-4
                                23: 3-7-6-2   24: 0-3-2-1   25: 4-5-6-7   26: volume

Quads of order 2 are quad8 ``(corners, middles of 0-1, 1-2, 2-3, 3-0)`` or quad9 (plus the centre).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from .topology import FloatArray, IntArray

if TYPE_CHECKING:
    from .quality import QualityReport

HEX_FACES = np.array(
    [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]],
    dtype=np.int64,
)
"""The six outward faces of a hexahedron: bottom, top, then the four sides in the order of the quad's edges."""


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
    """

    points: FloatArray
    quads: IntArray
    faces: IntArray
    loops: tuple[IntArray, ...]
    edge_nodes: dict[int, IntArray]


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


@dataclass(frozen=True, kw_only=True, eq=False)
class SweptStructure:
    """How a hexahedral mesh is made of layers of one quad mesh.

    Node i of layer k is ``k * n_nodes + i``; hex q between layers k and k + 1 is ``k * n_quads + q``
    and has the nodes ``quads[q] + k * n_nodes`` and ``quads[q] + (k + 1) * n_nodes``. On a closed
    ring (``periodic``) the last layer is the first.
    """

    quads: IntArray
    loops: tuple[IntArray, ...]
    n_nodes: int
    n_layers: int
    periodic: bool = False


@dataclass(frozen=True, kw_only=True, eq=False)
class HexMesh:
    """A hexahedral mesh with named boundaries.

    Attributes
    ----------
    points : (n, 3) float64
        Nodes in model length units.
    hexes : (m, 8), (m, 20) or (m, 27) int64
        VTK node order.
    boundaries : dict of str to (q, 4), (q, 8) or (q, 9) int64
        Quads of each named boundary, outward.
    parts : dict of str to (h,) int64
        Hex ids of each named volume.
    structure : SweptStructure or None
        Quads times layers, where the mesh is one sweep of order 1.
    info : dict
        What is known of its making: ``cad_volume``, ``seconds`` by stage, ``sweeps``, ``names``, ``notes``;
        ``part`` and ``material``: what the CAD model calls them; ``colors``: those of the CAD model,
        ``{"boundaries": {name: "#rrggbb"}, "parts": {...}}``.
    """

    points: FloatArray
    hexes: IntArray
    boundaries: dict[str, IntArray]
    parts: dict[str, IntArray] = field(default_factory=dict)
    structure: SweptStructure | None = None
    info: dict[str, Any] = field(default_factory=dict)

    @property
    def order(self) -> int:
        """Polynomial order, 1 or 2."""
        return 1 if self.hexes.shape[1] == 8 else 2

    @property
    def n_nodes(self) -> int:
        """Number of nodes."""
        return len(self.points)

    @property
    def n_hexes(self) -> int:
        """Number of hexahedra."""
        return len(self.hexes)

    def quality(self) -> QualityReport:
        """Every metric and check of :mod:`cadsweep.quality` on this mesh."""
        from .quality import check_mesh

        return check_mesh(self)

    def write(self, path: str | PathLike[str], **options: Any) -> None:
        """Write the mesh; the suffix of `path` names the format (:func:`cadsweep.io.write`)."""
        from .io import write

        write(self, path, **options)

    def to_pyvista(self) -> Any:
        """The mesh as a ``pyvista.UnstructuredGrid`` (needs the extra ``view``)."""
        from .view import to_pyvista

        return to_pyvista(self)

    def plot(self, **options: Any) -> Any:
        """Show the mesh in a window, or write a picture (:func:`cadsweep.view.plot`)."""
        from .view import plot

        return plot(self, **options)

    def _repr_html_(self) -> str:
        from .report import mesh_summary_html

        return mesh_summary_html(self)


def sweep_hexes(quads: IntArray, n_nodes: int, n_layers: int, *, periodic: bool = False) -> IntArray:
    """Connect layers of a quad mesh to hexahedra, as :class:`SweptStructure` numbers them.

    Parameters
    ----------
    quads : (q, 4) int64
    n_nodes : int
        Nodes of one layer.
    n_layers : int
        Layers of hexahedra.
    periodic : bool
        The last layer of hexahedra closes on the first layer of nodes.

    Returns
    -------
    (n_layers * q, 8) int64
    """
    hexes = np.empty((n_layers, len(quads), 8), dtype=np.int64)
    layers = np.arange(n_layers, dtype=np.int64)[:, None, None] * n_nodes
    np.add(quads, layers, out=hexes[:, :, :4])
    np.add(hexes[:, :, :4], n_nodes, out=hexes[:, :, 4:])
    if periodic:
        hexes[-1, :, 4:] = quads
    return hexes.reshape(-1, 8)


def side_quads(loops: Sequence[IntArray], n_nodes: int, n_layers: int, *, periodic: bool = False) -> IntArray:
    """Outward quads of the linking sides.

    Returns
    -------
    (n_layers, b, 4) int64
        Quad (k, j) stands on ring segment j (from ring node j to its successor in its loop)
        between layers k and k + 1.
    """
    starts = np.concatenate([np.asarray(loop) for loop in loops])
    ends = np.concatenate([np.roll(loop, -1) for loop in loops])
    layers = np.arange(n_layers, dtype=np.int64)[:, None] * n_nodes
    upper = layers + n_nodes
    if periodic:
        upper[-1] = 0
    return np.stack([starts + layers, ends + layers, ends + upper, starts + upper], axis=-1)
