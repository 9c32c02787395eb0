"""One mesh over many processes: every rank makes, checks and writes its own layers.

    mpiexec -n 8 python -m mpi4py -m cadsweep mesh part.step -o big.pvtu

Place in the flow: beside ``pipeline``, for ``.pvtu`` (a ``.vtu`` a rank) and ``.vtkhdf`` (one file, a partition a
rank). Rank 0 goes the way to a mesh that a streamed run goes; the others wait until it sends them a mesh in blocks, a
few megabytes, and measure their shares of it. When there is a mesh that is good, every rank makes and writes its
piece. An error on one rank is raised on all of them.

Not handled: more ranks than layers (the surplus ranks have nothing to do and write empty pieces);
parallel HDF5: the ranks write their partitions of a ``.vtkhdf`` file in turn.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from ..blocks.block_mesh import BlockMesh
from ..blocks.pieces import Piece, share_out
from ..blocks.stream import field_arrays, measure
from ..errors import CadSweepError, InputError
from ..io import pvtu
from ..io.atomic import check_place, replaced_file
from ..io.slabs import PieceSizes, SlabWriter
from ..options import SweepOptions
from ..progress import Progress
from ..quality import QualityAccumulator
from .meshing import figures, make_options
from .routes import mesh_in_blocks
from .run import make_run, silent

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
    mesh = _lead(comm, source, path, chosen, on_progress or silent) if comm.rank == 0 else _follow(comm)
    write = _write_pieces if path.suffix == ".pvtu" else _write_partitions
    write(comm, path, mesh)
    return figures(mesh)


def _lead(comm: Any, source: Any, path: Path, options: SweepOptions, on_progress: Progress) -> BlockMesh:
    """Come to a mesh on rank 0, with the others' help, and tell them."""

    def measure_together(mesh: BlockMesh) -> QualityAccumulator:
        comm.bcast(("measure", mesh), root=0)
        return _measure_all(comm, mesh)

    try:
        check_place(path)
        mesh = mesh_in_blocks(source, options, make_run(on_progress, options.decompose_time, measure=measure_together))
    except CadSweepError as error:
        comm.bcast(("refuse", error), root=0)
        raise
    comm.bcast(("write", mesh), root=0)
    return mesh


def _follow(comm: Any) -> BlockMesh:
    """Measure what rank 0 sends until it sends the mesh, or the error, that all ranks end with."""
    while True:
        what, value = comm.bcast(None, root=0)
        if what == "refuse":
            raise value
        if what == "write":
            mesh: BlockMesh = value
            return mesh
        _measure_all(comm, value, lead=False)


def _measure_all(comm: Any, mesh: BlockMesh, *, lead: bool = True) -> QualityAccumulator:
    """Metrics of the whole mesh, on every rank; an error of any is raised on rank 0, which tells the others."""
    seen, error = QualityAccumulator(), None
    try:
        seen = measure(mesh, share_out(mesh, comm.rank, comm.size))
    except CadSweepError as caught:
        error = caught
    total = QualityAccumulator()
    for part, failed in comm.allgather((seen, error)):
        if failed is not None and lead:
            raise failed
        total.merge(part)
    return total


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


def _write_pieces(comm: Any, path: Path, mesh: BlockMesh) -> None:
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
            piece = Piece(mesh, comm.rank, comm.size)
            stream = stack.enter_context(replaced_file(path.parent / names[comm.rank]))
            pvtu.write_piece(
                stream,
                piece.points,
                piece.hexes,
                nodes=piece.node_arrays(),
                cells=piece.hex_arrays(),
                fields=piece.fields,
            )
            stream.flush()

        _agreed(comm, write)
    comm.barrier()

    def write_list() -> None:
        if comm.rank == 0:
            with replaced_file(path) as stream:
                pvtu.write_index(stream, names)

    _agreed(comm, write_list)


def _write_partitions(comm: Any, path: Path, mesh: BlockMesh) -> None:
    """One ``.vtkhdf`` with a partition a rank, which rank 0 writes as the pieces come in, one at a time."""
    piece = Piece(mesh, comm.rank, comm.size)
    sizes = comm.gather(PieceSizes(n_points=len(piece.points), n_hexes=len(piece.hexes)), root=0)

    def receive() -> None:
        with replaced_file(path) as stream:
            writer = SlabWriter(
                stream,
                sizes,
                fields=field_arrays(mesh, {name: faces.quads for name, faces in mesh.faces.items()}),
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
