"""A mesh larger than memory: made, checked and written slab by slab from its factors.

Place in the flow: ``pipeline`` hands over a :class:`~cadsweep.assembly.FactoredMesh`; each slab of layers is
multiplied out, measured, and written, and the memory is used again. The boundary, which is small beside
the inside, is checked as a whole: closed, outward, on its CAD faces, with the CAD's areas and volume.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np

from .assembly import FactoredMesh
from .io.slabs import PieceSizes, SlabWriter
from .mesh import sweep_hexes
from .quality import CadReference, QualityAccumulator, QualityReport, check_surface, make_report
from .topology import FloatArray, IntArray

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


class SlabChecks:
    """Running checks of a mesh that is made slab by slab."""

    def __init__(self, factored: FactoredMesh) -> None:
        self._factored = factored
        self._seen = QualityAccumulator()
        structure = factored.structure
        self._boundary_points = np.full((factored.n_node_layers, len(np.concatenate(structure.loops)), 3), np.nan)
        self._hexes = sweep_hexes(structure.quads, structure.n_nodes, 1)
        self._finite = True
        self._caps: dict[int, FloatArray] = {}

    def add(self, slab: Slab) -> None:
        """Measure a slab, and keep its boundary nodes."""
        structure = self._factored.structure
        m = slab.stop - slab.start
        if len(self._hexes) != m * len(structure.quads):
            self._hexes = sweep_hexes(structure.quads, structure.n_nodes, m)
        self._finite &= bool(np.isfinite(slab.points).all())
        self._seen.add_hexes(
            slab.points.reshape(-1, 3),
            self._hexes,
            first_hex=slab.start * len(structure.quads),
            per_layer=len(structure.quads),
            layer=slab.start,
        )
        ring = np.concatenate(structure.loops)
        stop = min(slab.stop + 1, self._factored.n_node_layers)
        self._boundary_points[slab.start : stop] = slab.points[: stop - slab.start, ring]
        for k in (0, structure.n_layers):
            if slab.start <= k <= slab.stop:
                self._caps[k] = slab.points[k - slab.start].copy()

    def report(self, reference: CadReference | None) -> QualityReport:
        """What all slabs together are."""
        factored, structure = self._factored, self._factored.structure
        n, ring = structure.n_nodes, np.concatenate(structure.loops)
        last = factored.n_node_layers - 1
        # Boundary nodes get numbers of their own: the rings layer by layer, then what the caps have inside.
        b = len(ring)
        inside = np.setdiff1d(np.arange(n), ring) if not structure.periodic else np.empty(0, dtype=np.int64)
        place_on_ring = np.full(n, -1, dtype=np.int64)
        place_on_ring[ring] = np.arange(b)
        place_inside = np.full(n, -1, dtype=np.int64)
        place_inside[inside] = np.arange(len(inside))
        first_inside = (last + 1) * b

        def compact(nodes: IntArray) -> IntArray:
            layer, node = np.divmod(nodes, n)
            on_cap = first_inside + np.where(layer == 0, 0, len(inside)) + place_inside[node]
            return np.where(place_on_ring[node] >= 0, layer * b + place_on_ring[node], on_cap)

        boundaries = {name: compact(quads) for name, quads in factored.boundaries().items()}
        points = self._boundary_points.reshape(-1, 3)
        if not structure.periodic:
            points = np.concatenate([points, self._caps[0][inside], self._caps[structure.n_layers][inside]])
        found = check_surface(
            points, np.concatenate(list(boundaries.values())), boundaries, cad=reference, volume=self._seen.volume
        )
        problems = list(found.problems) if self._finite else ["there are nodes that are not finite", *found.problems]
        return make_report(
            self._seen,
            n_nodes=factored.n_node_layers * n,
            problems=problems,
            areas=found.areas,
            euler=found.euler,
        )


def measure(factored: FactoredMesh, reference: CadReference | None) -> QualityReport:
    """Check a mesh without writing it."""
    checks = SlabChecks(factored)
    for slab in make_slabs(factored):
        checks.add(slab)
    return checks.report(reference)


class BoundaryMarks:
    """Which boundary each hexahedron touches: the first by number, -1 inside."""

    def __init__(self, factored: FactoredMesh, order: tuple[str, ...]) -> None:
        structure = factored.structure
        rank = {name: i for i, name in enumerate(order)}
        number = np.array([rank.get(name, len(order)) for name in factored.names], dtype=np.int32)
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
    boundaries = factored.boundaries()
    names = tuple(boundaries)
    structure = factored.structure
    fields = {
        "part_names": np.array([factored.part], dtype=str),
        "boundary_names": np.array(names, dtype=str),
        **{f"boundary:{name}": quads for name, quads in boundaries.items()},
    }
    sizes = PieceSizes(
        n_points=factored.n_node_layers * structure.n_nodes, n_hexes=structure.n_layers * len(structure.quads)
    )
    writer = SlabWriter(stream, [sizes], fields=fields, cell_arrays={"part": np.int32, "boundary": np.int32})
    return writer, BoundaryMarks(factored, names)


def write_slabs(
    stream: BinaryIO, factored: FactoredMesh, *, on_slab: Callable[[float], None], checks: SlabChecks | None = None
) -> None:
    """Write a mesh slab by slab; `checks`, where given, sees every slab that is written.

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
    hexes = np.empty((0, 8), dtype=np.int64)
    for slab in make_slabs(factored):
        m = slab.stop - slab.start
        if checks is not None:
            checks.add(slab)
        if len(hexes) != m * q:
            hexes = sweep_hexes(structure.quads, n, m)
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
