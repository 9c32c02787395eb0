"""A mesh larger than memory: made, checked and written slab by slab from its blocks.

Place in the flow: ``pipeline`` hands over a :class:`~cadsweep.blocks.block_mesh.BlockMesh`; each slab of layers is
multiplied out, measured, and written, and the memory is used again. The surfaces, which are small beside
the inside, are checked as a whole: closed, outward, on their CAD faces, with the CAD's areas and volumes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from itertools import pairwise
from typing import TYPE_CHECKING, BinaryIO

import numpy as np

from ..arrays import IntArray
from ..io.vtk_cells import color_fields
from ..quality import (
    BoundaryLimit,
    CadReference,
    PartSurface,
    QualityAccumulator,
    QualityReport,
    Skin,
    boundary_limit,
    check_skin,
    fit_surfaces,
    make_report,
    name_quads,
    of_whole,
    shared_problems,
    volume_and_area,
)
from ..quality.boundary import boundary_problems
from ..quality.check import POOR
from .block_mesh import BlockMesh, Faces
from .slabs import Block, Slab, SweptBlock

if TYPE_CHECKING:
    from ..io.slabs import SlabWriter

Run = tuple[Block, int, int]
"""A block, and which of its layers: stop exclusive."""


def measure(mesh: BlockMesh, runs: list[Run]) -> QualityAccumulator:
    """Measure some layers of hexahedra, without keeping them."""
    seen = QualityAccumulator()
    for block, start, stop in runs:
        for slab in block.slabs(start, stop):
            measure_slab(seen, mesh, slab)
    return seen


def measure_slab(seen: QualityAccumulator, mesh: BlockMesh, slab: Slab) -> None:
    """Add a slab's hexahedra to running metrics; a mesh of one sweep alone has layers to speak of."""
    layers = {} if mesh.sweep is None else {"per_layer": slab.per_layer, "layer": slab.layer}
    seen.add_hexes(slab.points, slab.hexes, first_hex=slab.first_hex, **layers)


def check_blocks(
    mesh: BlockMesh, cad: CadReference | Mapping[str, CadReference] | None, seen: QualityAccumulator
) -> QualityReport:
    """Check the structure and the surfaces of a mesh whose hexahedra have been measured.

    Parameters
    ----------
    cad : CadReference, mapping of part name to CadReference, or None
        Of a mesh of several parts, of each.
    """
    problems = [*mesh.problems, *(problem for block in mesh.blocks for problem in block.problems())]
    quads = [mesh.rows(own) for own in mesh.part_quads]
    every = np.concatenate(quads)
    rows, unfit = fit_surfaces(every)
    outside = every[rows]
    problems += unfit
    flat = mesh.skin()
    named = name_quads(quads, flat.named_quads())
    surfaces = [
        PartSurface(name=name, quads=own, named=own_named, volume=volume_and_area(flat.points, own)[0])
        for name, own, own_named in zip(mesh.parts, quads, named, strict=True)
    ]
    skin = Skin(
        points=flat.points,
        quads=outside,
        boundaries=flat.boundaries,
        interfaces=flat.interfaces,
        parts=mesh.parts,
        surfaces=lambda: surfaces,
        between=lambda: shared_problems(flat.points, surfaces, flat.interfaces),
        numbers=mesh.surface_nodes,
    )
    surface = check_skin(skin, of_whole(cad, mesh.parts, every=True), volume=lambda: seen.volume)
    if not np.isfinite(seen.volume):
        problems.insert(0, "there are nodes that are not finite")
    return make_report(
        seen,
        n_nodes=mesh.n_nodes,
        problems=[*problems, *boundary_problems(flat, outside), *surface.problems],
        areas=surface.areas,
        euler=surface.euler,
        limit=_limit(mesh.sweep) if mesh.sweep is not None and seen.min_scaled_jacobian < POOR else None,
        crossings=surface.crossings,
    )


def _limit(sweep: SweptBlock) -> BoundaryLimit:
    """What the boundary of a mesh of one sweep allows."""
    assert sweep.whole is not None, "it is all of the mesh"
    return boundary_limit(lambda k: sweep.units.to_model(sweep.placed(k, k)[0]), sweep.whole)


class BoundaryMarks:
    """Which of some named sets of quads each hexahedron touches: the first by number, -1 inside."""

    def __init__(self, faces: Mapping[str, Faces]) -> None:
        hexes = np.concatenate([np.empty(0, dtype=np.int64), *(own.hexes for own in faces.values())])
        number = np.repeat(np.arange(len(faces), dtype=np.int32), [len(own.hexes) for own in faces.values()])
        self._hexes, first = np.unique(hexes, return_index=True)  # of several the first, which has the least number
        self._numbers = number[first]

    def of(self, hexes: IntArray) -> np.ndarray:
        """Marks (m,) of ascending hexahedra."""
        marks = np.full(len(hexes), -1, dtype=np.int32)
        if len(hexes):
            a, b = np.searchsorted(self._hexes, [hexes[0], hexes[-1] + 1])
            at = np.searchsorted(hexes, self._hexes[a:b])
            there = at < len(hexes)
            there[there] = hexes[at[there]] == self._hexes[a:b][there]
            marks[at[there]] = self._numbers[a:b][there]
        return marks


def field_arrays(mesh: BlockMesh, quads: Mapping[str, IntArray]) -> dict[str, np.ndarray]:
    """Names and colours of a mesh, and named quads."""
    names = tuple(mesh.faces)
    return {
        "part_names": np.array(mesh.parts, dtype=str),
        "boundary_names": np.array(names, dtype=str),
        **{f"boundary:{name}": own for name, own in quads.items()},
        **color_fields(mesh.info.get("colors", {}), names, mesh.parts),
    }


def open_writer(stream: BinaryIO, mesh: BlockMesh) -> SlabWriter:
    """Make the file of a serial mesh, all sizes known."""
    from ..io.slabs import PieceSizes, SlabWriter  # and HDF5, which hardly any run writes

    sizes = mesh.part_sizes() if len(mesh.parts) > 1 else {}
    return SlabWriter(
        stream,
        [PieceSizes(n_points=mesh.n_nodes, n_hexes=mesh.n_hexes)],
        fields=field_arrays(mesh, {name: own.quads for name, own in mesh.faces.items()}),
        lists={f"part:{name}": n for name, n in sizes.items()},
        cell_arrays={"part": np.int32, "boundary": np.int32},
    )


def write_slabs(stream: BinaryIO, mesh: BlockMesh, *, on_slab: Callable[[float], None]) -> QualityAccumulator:
    """Write a mesh slab by slab, and measure it on the way.

    Parameters
    ----------
    stream : BinaryIO
        Open for reading and writing.
    on_slab : callable
        Called with the fraction that is done.
    """
    writer, marks = open_writer(stream, mesh), BoundaryMarks(mesh.faces)
    seen = QualityAccumulator()
    n_hexes, written = mesh.n_hexes, dict.fromkeys(mesh.parts, 0)
    for start, stop in _consecutive(mesh.kept_nodes):
        writer.add_points(int(mesh.kept_nodes[start]), mesh.kept_points[start:stop])
    for block, part in zip(mesh.blocks, mesh.block_parts, strict=True):
        for slab in block.slabs():
            measure_slab(seen, mesh, slab)
            m = len(slab.hexes)
            ids = np.arange(slab.first_hex, slab.first_hex + m)
            if len(slab.own):
                writer.add_points(slab.first_node, slab.points[slab.own])
            marked = marks.of(ids)
            writer.add_hexes(
                slab.first_hex, slab.nodes[slab.hexes], part=np.full(m, part, dtype=np.int32), boundary=marked
            )
            if len(mesh.parts) > 1:
                name = mesh.parts[part]
                writer.add_list(f"part:{name}", written[name], ids)
                written[name] += m
            on_slab((slab.first_hex + m) / n_hexes)
    writer.close()
    return seen


def _consecutive(numbers: IntArray) -> Iterator[tuple[int, int]]:
    """Places (start, stop) of runs of ascending numbers that follow each other without a gap."""
    if len(numbers):
        breaks = np.flatnonzero(np.diff(numbers) != 1) + 1
        ends = [0, *breaks.tolist(), len(numbers)]
        yield from pairwise(ends)
