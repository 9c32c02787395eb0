"""A mesh larger than memory: made, checked and written slab by slab from its factors.

Place in the flow: ``pipeline`` hands over a :class:`~cadsweep.blocks.block.FactoredMesh`; each slab of layers is
multiplied out, measured, and written, and the memory is used again. The boundary, which is small beside
the inside, is checked as a whole: closed, outward, on its CAD faces, with the CAD's areas and volume.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, BinaryIO

import numpy as np

from ..arrays import FloatArray, IntArray
from ..cells import sweep_hexes
from ..io.vtk_cells import color_fields
from ..quality import (
    CadReference,
    QualityAccumulator,
    QualityReport,
    boundary_limit,
    check_surface,
    make_report,
    structure_problems,
)
from ..quality.check import POOR, SurfaceFindings
from .block import FactoredMesh, unite_quads

if TYPE_CHECKING:
    from ..io.slabs import SlabWriter

SLAB_NODES = 200_000
"""Nodes of a slab: large enough for the arithmetic, small enough for the cache and for flat memory."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Slab:
    """Some layers of hexahedra.

    Attributes
    ----------
    start, stop : int
        Layers of hexahedra, stop exclusive.
    points : (stop - start + 1, n, 3) float64
        Nodes of the layers start to stop; on a closed ring the last may be the first layer again. Valid until the
        next slab is made.
    """

    start: int
    stop: int
    points: FloatArray


def make_slabs(factored: FactoredMesh, *, start: int = 0, stop: int | None = None) -> Iterator[Slab]:
    """Multiply the layers of hexahedra `start` to `stop` out, a slab at a time, into one buffer."""
    structure = factored.structure
    stop = structure.n_layers if stop is None else stop
    step = max(1, min(stop - start, SLAB_NODES // structure.n_nodes))
    buffer = np.empty((step + 1, structure.n_nodes, 3))
    for first in range(start, stop, step):
        last = min(first + step, stop)
        inner = min(last + 1, factored.n_node_layers)
        factored.points(first, inner, out=buffer[: inner - first])
        if inner == last:  # a closed ring: its last layer of hexahedra ends on the first layer of nodes
            factored.points(0, 1, out=buffer[last - first : last - first + 1])
        yield Slab(start=first, stop=last, points=buffer[: last - first + 1])


def measure_slab(seen: QualityAccumulator, factored: FactoredMesh, slab: Slab, hexes: IntArray) -> None:
    """Add a slab's hexahedra, given in its own node numbers, to running metrics."""
    q = len(factored.structure.quads)
    seen.add_hexes(slab.points.reshape(-1, 3), hexes, first_hex=slab.start * q, per_layer=q, layer=slab.start)


def measure(factored: FactoredMesh, *, start: int = 0, stop: int | None = None) -> QualityAccumulator:
    """Measure the layers of hexahedra `start` to `stop`, without keeping them."""
    seen, structure = QualityAccumulator(), factored.structure
    hexes = np.empty((0, 8), dtype=np.int64)
    for slab in make_slabs(factored, start=start, stop=stop):
        m = slab.stop - slab.start
        if len(hexes) != m * len(structure.quads):
            hexes = sweep_hexes(structure.quads, structure.n_nodes, m)
        measure_slab(seen, factored, slab, hexes)
    return seen


def check_boundary(factored: FactoredMesh, reference: CadReference | None, *, volume: float) -> SurfaceFindings:
    """Check the whole boundary, which is known from the rings and the caps alone.

    Parameters
    ----------
    volume : float
        Sum of the volumes of the hexahedra, to be held against that of the CAD model.
    """
    structure = factored.structure
    n, ring = structure.n_nodes, np.concatenate(structure.loops)
    b, n_rings = len(ring), factored.n_node_layers
    points = factored.to_model(factored.sweep.rings[:n_rings].copy()).reshape(-1, 3)
    inside = np.empty(0, dtype=np.int64)
    if not structure.periodic:
        inside = np.setdiff1d(np.arange(n), ring)
        caps = [factored.points(k, k + 1)[0, inside] for k in (0, structure.n_layers)]
        points = np.concatenate([points, *caps])
    # Boundary nodes get numbers of their own: the rings layer by layer, then what the caps have inside.
    on_ring, on_cap = np.full(n, -1, dtype=np.int64), np.zeros(n, dtype=np.int64)
    on_ring[ring] = np.arange(b)
    on_cap[inside] = n_rings * b + np.arange(len(inside))

    def renumbered(nodes: IntArray) -> IntArray:
        layer, node = np.divmod(nodes, n)
        return np.where(on_ring[node] >= 0, layer * b + on_ring[node], on_cap[node] + (layer > 0) * len(inside))

    owned = [(names, renumbered(quads)) for names, quads in factored.owned_quads()]
    quads = np.concatenate([quads for _, quads in owned])
    return check_surface(points, quads, unite_quads(owned), cad=reference, volume=volume)


def make_slab_report(factored: FactoredMesh, seen: QualityAccumulator, surface: SurfaceFindings) -> QualityReport:
    """Join what the slabs and the boundary showed."""
    structure = factored.structure
    problems = [*structure_problems(structure, factored.n_node_layers * structure.n_nodes), *surface.problems]
    if not np.isfinite(seen.volume):
        problems.insert(0, "there are nodes that are not finite")
    return make_report(
        seen,
        n_nodes=factored.n_node_layers * structure.n_nodes,
        problems=problems,
        areas=surface.areas,
        euler=surface.euler,
        crossings=surface.crossings,
        limit=boundary_limit(lambda k: factored.points(k, k + 1)[0], structure)
        if seen.min_scaled_jacobian < POOR
        else None,
    )


class BoundaryMarks:
    """Which boundary each hexahedron touches: the first by number, -1 inside."""

    def __init__(self, factored: FactoredMesh, order: tuple[str, ...]) -> None:
        structure = factored.structure
        rank = {name: i for i, name in enumerate(order)}
        number = np.array(
            [min(rank.get(name, len(order)) for name in names) for names in factored.owner_names], dtype=np.int32
        )
        self._none = np.int32(len(order))
        self._structure = structure
        self._source, self._target = number[factored.source_owners], number[factored.target_owners]
        self._sides = number[factored.side_owners]
        self._quad_of_segment = _quads_of_segments(structure.quads, structure.loops, structure.n_nodes)

    def of_layer(self, k: int) -> np.ndarray:
        """Marks (q,) of the hexahedra of layer `k`."""
        marks = np.full(len(self._structure.quads), self._none)
        np.minimum.at(marks, self._quad_of_segment, self._sides[k])
        if not self._structure.periodic:
            if k == 0:
                np.minimum(marks, self._source, out=marks)
            if k == self._structure.n_layers - 1:
                np.minimum(marks, self._target, out=marks)
        return np.where(marks == self._none, np.int32(-1), marks)


def _quads_of_segments(quads: IntArray, loops: tuple[IntArray, ...], n_nodes: int) -> IntArray:
    """The quad (b,) that has each segment of the loops as an edge."""
    starts, ends = np.concatenate(loops), np.concatenate([np.roll(loop, -1) for loop in loops])
    edges = quads * n_nodes + np.roll(quads, -1, axis=1)
    order = np.argsort(edges, axis=None)
    found = np.searchsorted(edges.reshape(-1), starts * n_nodes + ends, sorter=order)
    return order[found] // 4


def open_writer(stream: BinaryIO, factored: FactoredMesh) -> tuple[SlabWriter, BoundaryMarks]:
    """Make the file of a serial mesh, all sizes known."""
    from ..io.slabs import PieceSizes, SlabWriter  # and HDF5, which hardly any run writes

    boundaries = factored.boundaries()
    names = tuple(boundaries)
    structure = factored.structure
    fields = {
        "part_names": np.array([factored.part], dtype=str),
        "boundary_names": np.array(names, dtype=str),
        **{f"boundary:{name}": quads for name, quads in boundaries.items()},
        **color_fields(factored.info.get("colors", {}), names, [factored.part]),
    }
    sizes = PieceSizes(
        n_points=factored.n_node_layers * structure.n_nodes, n_hexes=structure.n_layers * len(structure.quads)
    )
    writer = SlabWriter(stream, [sizes], fields=fields, cell_arrays={"part": np.int32, "boundary": np.int32})
    return writer, BoundaryMarks(factored, names)


def write_slabs(stream: BinaryIO, factored: FactoredMesh, *, on_slab: Callable[[float], None]) -> QualityAccumulator:
    """Write a mesh slab by slab, and measure it on the way.

    Parameters
    ----------
    stream : BinaryIO
        Open for reading and writing.
    on_slab : callable
        Called with the fraction that is done.
    """
    structure = factored.structure
    n, q = structure.n_nodes, len(structure.quads)
    writer, marks = open_writer(stream, factored)
    seen = QualityAccumulator()
    hexes = np.empty((0, 8), dtype=np.int64)
    for slab in make_slabs(factored):
        m = slab.stop - slab.start
        if len(hexes) != m * q:
            hexes = sweep_hexes(structure.quads, n, m)
        measure_slab(seen, factored, slab, hexes)
        numbered = hexes + slab.start * n
        if structure.periodic and slab.stop == structure.n_layers:
            numbered.reshape(m, q, 8)[-1, :, 4:] = structure.quads
        own = slab.stop + (slab.stop == structure.n_layers and not structure.periodic) - slab.start
        writer.add_points(slab.start * n, slab.points[:own].reshape(-1, 3))
        writer.add_hexes(
            slab.start * q,
            numbered,
            part=np.zeros(m * q, dtype=np.int32),
            boundary=np.concatenate([marks.of_layer(k) for k in range(slab.start, slab.stop)]),
        )
        on_slab(slab.stop / structure.n_layers)
    writer.close()
    return seen
