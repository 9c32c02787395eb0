"""One case: asked of a worker that is kept for the next."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

from ..errors import CadSweepError, WorkerError
from ..isolation import Worker, leftovers
from ..progress import Progress
from .base import NODES, carried_options
from .records import CASES, RECORD, case_folder, locked, read_record, write_record
from .study import Case, Study


def claimed_case(
    worker: Worker,
    study: Study,
    case: Case,
    folder: Path,
    *,
    max_memory: float,
    base: Path | None = None,
    anew: bool = False,
    on_progress: Progress,
) -> dict[str, Any]:
    """Do a case that others may want to do, too: the first one does it, and the others get the record.

    Parameters
    ----------
    anew : bool
        Do it even where there is a record from before.
    """
    own = case_folder(folder, case)
    own.mkdir(parents=True, exist_ok=True)
    before = _age(own)
    with locked(own / ".lock", wait=lambda: on_progress("waiting", None)):
        record = read_record(folder, case)
        if record is None or (anew and _age(own) == before):
            record = run_case(worker, study, case, folder, max_memory=max_memory, base=base, on_progress=on_progress)
            write_record(folder, case, record)
        return record


def _age(own: Path) -> int:
    """When the record of a case was written; 0 where there is none."""
    try:
        return (own / RECORD).stat().st_mtime_ns
    except FileNotFoundError:
        return 0


def run_case(
    worker: Worker,
    study: Study,
    case: Case,
    folder: Path,
    *,
    max_memory: float,
    base: Path | None = None,
    on_progress: Progress,
) -> dict[str, Any]:
    """Mesh a case, like the `base` if there is one; whatever its end is, it is a record.

    A case that ends a worker which had served other cases is done once more in a fresh one, so that no record says
    anything of the cases before it. A time-out is not: it would cost as much again, and no library remembers time.
    """
    own = case_folder(folder, case)
    own.mkdir(parents=True, exist_ok=True)
    mesh = None if study.suffix is None else own / f"mesh{study.suffix}"
    options, more = case.options, {}
    if base is not None:
        options, more = carried_options(options, base), {"nodes": str(own / NODES)}
    record: dict[str, Any] = {"case": case.name, "params": case.params, "options": case.options, "status": "ok"}
    start = time.perf_counter()
    for again in (False, True):
        fresh, begun = worker.n_done == 0, time.perf_counter()
        try:
            figures = worker.run(
                "cadsweep.cli.work:mesh_file",
                (str(study.script), None if mesh is None else str(mesh)),
                {"options": {**options, "params": case.params or None, "max_memory": max_memory}, **more},
                timeout=study.timeout,
                max_memory=max_memory,
                on_progress=on_progress,
                remove=[] if mesh is None else leftovers(mesh),
            )
            record.update(figures)
            record["mesh"] = None if mesh is None else f"{CASES}/{case.folder}/{mesh.name}"
            if base is not None:
                record["nodes"] = f"{CASES}/{case.folder}/{NODES}"
        except WorkerError as error:
            if not fresh and not again and time.perf_counter() - begun < study.timeout:
                worker.end()
                continue
            record.update(_failed(error))
        except CadSweepError as error:
            record.update(_failed(error))
        break
    record["total_seconds"] = round(time.perf_counter() - start, 3)
    return record


def _failed(error: CadSweepError) -> dict[str, Any]:
    return {"status": "failed", "error": error.message, "error_type": type(error).__name__}
