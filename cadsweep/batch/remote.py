"""Cases done by the workers of a dask cluster.

Place in the flow: beside :mod:`.run`, for ``--dask``. dask finds a worker, and another one where it is lost; the
case itself runs in a process that the worker keeps, as on one machine, so that a case that crashes costs no worker.
The folder of the study must be there for all of them under the same name (a shared file system).

Not handled: workers on Windows.
"""

from __future__ import annotations

import atexit
import threading
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from ..errors import CadSweepError
from .base import make_base
from .study import Case, Study
from .work import claimed_case

PATIENCE = 20.0
"""Seconds in which the scheduler must answer."""

_kept = threading.local()


def run_remotely(
    cases: Sequence[Case], study: Study, folder: Path, address: str, *, anew: bool
) -> Iterator[tuple[Case, dict[str, Any]]]:
    """Give cases to a cluster, and each record as soon as it is there.

    Raises
    ------
    CadSweepError
        dask is not installed, or the scheduler does not answer.
    """
    try:
        from distributed import Client, KilledWorker, as_completed
    except ImportError as error:
        raise CadSweepError(f'--dask needs the extra "dask": pip install "cadsweep[dask]" ({error})') from error
    if not cases:
        return
    try:
        client = Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise CadSweepError(f"no dask scheduler answers at {address}: {error}") from error
    with client:
        base = None
        if study.same_mesh:
            base = client.submit(remote_base, study, folder, key=f"base-{cases[0].key}", pure=False).result()
        by_future = {
            client.submit(
                remote_case, study, case, folder, base, anew, key=f"case-{case.key}", retries=0, pure=False
            ): case
            for case in cases
        }
        for future in as_completed(list(by_future), loop=client.loop):
            case = by_future[future]
            try:
                yield case, future.result()
            except KilledWorker as error:
                yield case, _lost(case, folder, str(error))


def _lost(case: Case, folder: Path, said: str) -> dict[str, Any]:
    """The record of a case that has cost too many workers."""
    from .records import write_record

    record = {
        "case": case.name,
        "params": case.params,
        "options": case.options,
        "status": "failed",
        "error": f"the workers that it was given to were lost: {' '.join(said.split())}",
        "error_type": "WorkerError",
        "total_seconds": None,
    }
    write_record(folder, case, record)
    return record


def remote_base(study: Study, folder: Path) -> Path:
    """On a worker: the mesh that all cases are to have."""
    return make_base(study, folder, max_memory=_memory(study), on_progress=_silent)


def remote_case(study: Study, case: Case, folder: Path, base: Path | None, anew: bool) -> dict[str, Any]:
    """On a worker: one case, in the process that this thread keeps for them."""
    from ..isolation import Worker

    if not hasattr(_kept, "worker"):
        _kept.worker = Worker({"OMP_NUM_THREADS": "1"})
        atexit.register(_kept.worker.end)  # before Python waits for its children
    return claimed_case(
        _kept.worker, study, case, folder, max_memory=_memory(study), base=base, anew=anew, on_progress=_silent
    )


def _memory(study: Study) -> float:
    """GB of a case on this machine: a share of what is free, by the threads that dask works with."""
    from distributed import get_worker

    from ..machine import free_memory

    return free_memory() / get_worker().state.nthreads if study.max_memory is None else study.max_memory


def _silent(stage: str, fraction: float | None) -> None:
    """Nobody watches."""
