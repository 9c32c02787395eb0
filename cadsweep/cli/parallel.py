"""``cadsweep mesh`` under ``mpiexec``: every rank runs this, and rank 0 speaks.

Place in the flow: :func:`cadsweep.cli.making.mesh` comes here where the process is one rank of several. There is no
worker process then: a rank that dies ends the job, and ``mpiexec`` says so.
"""

from __future__ import annotations

import os
import sys
from typing import Any

import click

from ..errors import CadSweepError

_SIZES = ("PMI_SIZE", "OMPI_COMM_WORLD_SIZE", "MPI_LOCALNRANKS")
"""What the common launchers tell their processes."""


def is_rank() -> bool:
    """Whether this process belongs to an MPI job."""
    return "mpi4py" in sys.modules or any(int(os.environ.get(name, "0")) > 1 for name in _SIZES)


def mesh_over_ranks(source: str, output: str, options: dict[str, Any]) -> dict[str, Any] | None:
    """Mesh on all ranks; the figures come back on rank 0, None elsewhere."""
    try:
        from mpi4py import MPI
    except ImportError as error:
        raise CadSweepError(
            f"a run of several ranks needs mpi4py and an MPI ({error}): pip install 'cadsweep[mpi]'"
        ) from error
    from ..pipeline.ranks import mesh_distributed

    comm = MPI.COMM_WORLD
    try:
        summary = mesh_distributed(source, output, comm=comm, **options)
    except CadSweepError:
        if comm.rank == 0:
            raise
        click.get_current_context().exit(1)
    except BaseException as error:
        click.echo(f"cadsweep: rank {comm.rank} failed: {type(error).__name__}: {error}", err=True)
        comm.Abort(1)
        raise
    return summary if comm.rank == 0 else None
