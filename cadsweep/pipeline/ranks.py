"""One mesh over many processes: every rank makes, checks and writes its own layers.

    mpiexec -n 8 python -m mpi4py -m cadsweep mesh part.step -o big.pvtu

Place in the flow: beside ``pipeline``, for ``.pvtu`` (a ``.vtu`` a rank) and ``.vtkhdf`` (one file, a partition a
rank). Rank 0 does the CAD work and broadcasts the factors, a few megabytes; from then on a rank talks to the
others only to agree that all is well. An error on one rank is raised on all of them.

Not handled: more ranks than layers (the surplus ranks have nothing to do and write empty pieces);
parallel HDF5: the ranks write their partitions of a ``.vtkhdf`` file in turn.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import IntArray
from ..blocks.block import FactoredMesh
from ..blocks.reference import make_reference
from ..blocks.stream import BoundaryMarks, check_boundary, make_slab_report, measure
from ..cells import sweep_hexes
from ..errors import CadSweepError, InputError
from ..io import pvtu
from ..io.atomic import check_place, replaced_file
from ..io.slabs import PieceSizes, SlabWriter
from ..io.vtk_cells import color_fields
from ..options import SweepOptions
from ..progress import Progress
from ..quality import QualityAccumulator, QualityReport
from . import make_options
from .attempts import find_candidates
from .candidates import Made, checked, explained, figures, first_good, refuse, smoothed
from .factoring import factor_sweep
from .run import Run, silent

SUFFIXES = (".pvtu", ".vtkhdf")


def mesh_distributed(
    source: Any, path: str | Path, /, *, comm: Any = None, on_progress: Progress | None = None, **options: Any
) -> dict[str, Any]:
    """Mesh a part over all ranks of a communicator; every rank calls it with the same arguments.

    Parameters
    ----------
    source, **options
        As for :func:`cadsweep.sweep_mesh`, of order 1. Only rank 0 looks at the part.
    path : path
        A ``.pvtu`` or a ``.vtkhdf`` file in a folder that all ranks share.
    comm : mpi4py communicator
        None: ``MPI.COMM_WORLD``.

    Returns
    -------
    dict
        The figures that ``cadsweep mesh --json`` prints, on every rank.

    Raises
    ------
    CadSweepError
        On every rank, whichever rank it happened on.
    """
    if comm is None:
        from mpi4py import MPI

        comm = MPI.COMM_WORLD
    path = Path(path)
    chosen = make_options(options)
    if chosen.order != 1 or chosen.refine:
        raise InputError("a distributed mesh has order 1 and is not refined")
    if path.suffix not in SUFFIXES:
        raise InputError(f"{path}: a distributed mesh is written to {' or '.join(SUFFIXES)}")

    made = _first_good(comm, source, path, chosen, Run(on_progress=on_progress or silent))
    own = layers_of(comm.rank, comm.size, made.factored.structure.n_layers)
    write = _write_pieces if path.suffix == ".pvtu" else _write_partitions
    write(comm, path, made.factored, own)
    return figures(made.factored, made.report)


def _first_good(comm: Any, source: Any, path: Path, options: SweepOptions, run: Run) -> Made:
    """The loop over candidates, gone through by all ranks alike; only rank 0 has the part and its sweeps."""

    def shared(work: Callable[[], Any]) -> Any:
        """What rank 0 does, on all ranks."""
        return comm.bcast(_agreed(comm, lambda: work() if comm.rank == 0 else None), root=0)

    part: Any = None
    sweeps: list[Any] = []

    def find() -> int:
        nonlocal part, sweeps
        check_place(path)
        part, sweeps = find_candidates(source, options, run)
        return len(sweeps)

    n_sweeps = shared(find)
    sweeps = sweeps if comm.rank == 0 else [None] * n_sweeps

    def make(part: Any, sweep: Any, options: SweepOptions, run: Run, reached: float) -> Made:
        reference = None

        def factor() -> FactoredMesh:
            nonlocal reference
            factored, _ = factor_sweep(part, sweep, options, run, streamed=True)
            reference = make_reference(part, sweep)
            return factored

        def check(present: FactoredMesh) -> QualityReport:
            seen = _measure_all(comm, present, layers_of(comm.rank, comm.size, present.structure.n_layers))
            return make_slab_report(
                present, seen, shared(lambda: check_boundary(present, reference, volume=seen.volume))
            )

        def smooth(present: FactoredMesh) -> FactoredMesh:
            better: FactoredMesh = shared(lambda: smoothed(present))
            return better

        factored, report = checked(shared(factor), check, options, run, reached, smooth=smooth)
        shared(lambda: refuse(report, options, part, sweep))
        return Made(factored=factored, report=report)

    def explain(sweep: Any, failure: CadSweepError) -> CadSweepError:
        error: CadSweepError = shared(lambda: explained(sweep, failure))
        return error

    return first_good(part, sweeps, options, run, make, explain=explain)


def layers_of(rank: int, size: int, n_layers: int) -> tuple[int, int]:
    """Layers of hexahedra (start, stop) of a rank, shared as evenly as can be."""
    return rank * n_layers // size, (rank + 1) * n_layers // size


def _agreed(comm: Any, work: Callable[[], Any]) -> Any:
    """Do something on every rank; where it fails on one, raise its error on all."""
    result, error = None, None
    try:
        result = work()
    except CadSweepError as caught:
        error = caught
    errors = [e for e in comm.allgather(error) if e is not None]
    if errors:
        raise errors[0]
    return result


def _measure_all(comm: Any, factored: FactoredMesh, own: tuple[int, int]) -> QualityAccumulator:
    """Metrics of the whole mesh, on every rank."""
    mine = measure(factored, start=own[0], stop=own[1])
    total = QualityAccumulator()
    for part in comm.allgather(mine):
        total.merge(part)
    return total


class Piece:
    """What one rank writes: its layers, and a ghost layer of hexahedra on either side."""

    def __init__(self, factored: FactoredMesh, own: tuple[int, int]) -> None:
        structure = factored.structure
        n, q = structure.n_nodes, len(structure.quads)
        start, stop = own
        first, last = (max(start - 1, 0), min(stop + 1, structure.n_layers)) if stop > start else (start, start)
        m = last - first
        layers = np.arange(first, last + 1) if m else np.empty(0, dtype=np.int64)
        wraps = structure.periodic and last == structure.n_layers and m > 0
        distinct = layers % structure.n_layers if structure.periodic else layers
        points = np.empty((len(layers), n, 3))
        if m:
            factored.points(first, last + (not wraps), out=points[: m + (not wraps)])
            if wraps:
                factored.points(0, 1, out=points[m:])
        self.points = points.reshape(-1, 3)
        self.hexes = sweep_hexes(structure.quads, n, m)
        self.node_ids = (distinct[:, None] * n + np.arange(n)).reshape(-1).astype(np.int64)
        self.hex_ids = np.arange(first * q, last * q, dtype=np.int64)
        # The layer of nodes between two ranks belongs to the lower rank.
        lower = start + 1 if start > 0 else 0
        owned = (layers >= lower) & (layers <= stop)
        if structure.periodic and len(layers):
            owned &= layers < structure.n_layers
        self.node_ghosts = np.repeat(~owned, n).astype(np.uint8)
        self.hex_ghosts = ((self.hex_ids < start * q) | (self.hex_ids >= stop * q)).astype(np.uint8)
        boundaries = factored.boundaries()
        self.names = tuple(boundaries)
        marks = BoundaryMarks(factored, self.names)
        self.marks = (
            np.concatenate([marks.of_layer(k) for k in range(first, last)]) if m else np.empty(0, dtype=np.int32)
        )
        self.boundaries = {
            name: _own_quads(quads, n, own, first, structure.n_layers) for name, quads in boundaries.items()
        }
        self.part = factored.part
        self.colors = color_fields(factored.info.get("colors", {}), self.names, [self.part])

    def node_arrays(self) -> dict[str, np.ndarray]:
        """Data of the points."""
        return {pvtu.NODE_IDS: self.node_ids, pvtu.GHOSTS: self.node_ghosts}

    def hex_arrays(self) -> dict[str, np.ndarray]:
        """Data of the cells."""
        return {
            pvtu.HEX_IDS: self.hex_ids,
            pvtu.GHOSTS: self.hex_ghosts,
            "part": np.zeros(len(self.hex_ids), dtype=np.int32),
            "boundary": self.marks.astype(np.int32),
        }

    def field_arrays(self) -> dict[str, np.ndarray]:
        """Names, and the piece's own boundary quads in its own numbers."""
        return {
            "part_names": np.array([self.part], dtype=str),
            "boundary_names": np.array(self.names, dtype=str),
            **{f"boundary:{name}": quads for name, quads in self.boundaries.items()},
            **self.colors,
        }


def _own_quads(quads: IntArray, n: int, own: tuple[int, int], first: int, n_layers: int) -> IntArray:
    """Boundary quads of the layers that a rank owns, in its own node numbers."""
    layers = quads // n
    lowest, highest = layers.min(axis=1), layers.max(axis=1)
    wraps = highest - lowest > 1  # the last layer of a closed ring joins the last nodes to the first
    layer = np.where(wraps, highest, lowest)
    flat = (lowest == highest) & (lowest == n_layers)  # the target cap belongs to the last layer of hexahedra
    layer = np.where(flat, n_layers - 1, layer)
    mine = (layer >= own[0]) & (layer < own[1])
    chosen = quads[mine] + np.where(wraps[mine, None] & (layers[mine] == 0), n_layers * n, 0)
    return chosen - first * n


def _write_pieces(comm: Any, path: Path, factored: FactoredMesh, own: tuple[int, int]) -> None:
    """A ``.vtu`` a rank in a folder beside the list; nothing is put in place before all ranks have written."""
    folder = path.with_suffix("")

    def make_folder() -> None:
        if comm.rank == 0:
            try:
                folder.mkdir(exist_ok=True)
            except OSError as error:
                raise InputError(f"cannot make the folder {folder} for the pieces: {error.strerror}") from error

    _agreed(comm, make_folder)
    names = [f"{folder.name}/{folder.name}_{rank}.vtu" for rank in range(comm.size)]
    with ExitStack() as stack:

        def write() -> None:
            piece = Piece(factored, own)
            stream = stack.enter_context(replaced_file(path.parent / names[comm.rank]))
            pvtu.write_piece(
                stream,
                piece.points,
                piece.hexes,
                nodes=piece.node_arrays(),
                cells=piece.hex_arrays(),
                fields=piece.field_arrays(),
            )
            stream.flush()

        _agreed(comm, write)
    comm.barrier()

    def write_list() -> None:
        if comm.rank == 0:
            with replaced_file(path) as stream:
                pvtu.write_index(stream, names)

    _agreed(comm, write_list)


def _write_partitions(comm: Any, path: Path, factored: FactoredMesh, own: tuple[int, int]) -> None:
    """One ``.vtkhdf`` with a partition a rank, which rank 0 writes as the pieces come in, one at a time."""
    piece = Piece(factored, own)
    sizes = comm.gather(PieceSizes(n_points=len(piece.points), n_hexes=len(piece.hexes)), root=0)

    def receive() -> None:
        whole = factored.boundaries()
        fields = {
            "part_names": np.array([factored.part], dtype=str),
            "boundary_names": np.array(tuple(whole), dtype=str),
            **{f"boundary:{name}": quads for name, quads in whole.items()},
            **piece.colors,
        }
        with replaced_file(path) as stream:
            writer = SlabWriter(
                stream,
                sizes,
                fields=fields,
                cell_arrays={name: array.dtype for name, array in piece.hex_arrays().items()},
                point_arrays={name: array.dtype for name, array in piece.node_arrays().items()},
            )
            for rank in range(comm.size):
                part = piece if rank == 0 else comm.recv(source=rank, tag=1)
                writer.add_points(0, part.points, piece=rank, **part.node_arrays())
                writer.add_hexes(0, part.hexes, piece=rank, **part.hex_arrays())
            writer.close()

    if comm.rank > 0:
        comm.send(piece, dest=0, tag=1)
    _agreed(comm, receive if comm.rank == 0 else lambda: None)
