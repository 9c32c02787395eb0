"""Run the cases of a study that have no record yet, and keep the table."""

from __future__ import annotations

import fcntl
import os
import queue
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import InputError
from .base import make_base, write_together
from .records import CASES, Table, read_records
from .study import Case, Study
from .work import claimed_case


@dataclass(frozen=True, kw_only=True)
class Tally:
    """How far a study is.

    Attributes
    ----------
    n_ok, n_failed, n_left : int
        Cases with a mesh, cases without, cases to be done.
    """

    n_ok: int
    n_failed: int
    n_left: int


OnCase = Callable[[dict[str, Any] | None, Tally], None]
"""Called with the record of every case that has ended, and once with None before the first."""


@dataclass(frozen=True, kw_only=True)
class StudyResult:
    """What became of a study.

    Attributes
    ----------
    records : tuple of dict
        One for every case, in the study's order: ``case``, ``params``, ``options``, ``status`` (``"ok"`` or
        ``"failed"``), the figures of ``cadsweep mesh --json``, ``error``, ``error_type``, ``mesh``.
    n_resumed : int
        Cases that an earlier run had finished.
    table, json : Path
        The same as files.
    together : Path or None
        Of a study of one mesh: the file of the nodes of all cases.
    """

    records: tuple[dict[str, Any], ...]
    n_resumed: int
    table: Path
    json: Path
    together: Path | None = None

    @property
    def n_cases(self) -> int:
        """Number of cases."""
        return len(self.records)

    @property
    def n_failed(self) -> int:
        """Number of cases without a mesh."""
        return sum(record["status"] != "ok" for record in self.records)

    def summary(self) -> dict[str, Any]:
        """The result as plain data."""
        return {
            "n_cases": self.n_cases,
            "n_failed": self.n_failed,
            "n_resumed": self.n_resumed,
            "table": str(self.table),
            "json": str(self.json),
            "together": None if self.together is None else str(self.together),
            "cases": list(self.records),
        }

    def line(self) -> str:
        """The result in a line."""
        done = self.n_cases - self.n_failed
        resumed = f", {self.n_resumed} of them earlier" if self.n_resumed else ""
        return f"{done} of {self.n_cases} cases meshed{resumed}: {self.table}"


class _Stopped(BaseException):
    """Ends a worker from its progress callback, once the study is interrupted."""


def run_study(
    study: Study,
    folder: Path | None = None,
    *,
    jobs: int = 1,
    again: bool = False,
    retry_failed: bool = False,
    shard: tuple[int, int] | None = None,
    dask: str | None = None,
    on_case: OnCase | None = None,
) -> StudyResult:
    """Mesh the cases of a study that have not been meshed, and write the table of all.

    Parameters
    ----------
    study : Study
    folder : Path or None
        Where the results go; None: where the study says.
    jobs : int
        Cases at a time; each has its share of the machine's memory unless the study sets a limit.
    again : bool
        Do all cases, whatever is there.
    retry_failed : bool
        Do the failed ones again.
    shard : (int, int) or None
        (I, N): do every N-th case from the I-th on (counted from 1). Any number of shards may be at work in a folder at
        once; the result has the records of this one, the table those of all cases that are done.
    dask : str or None
        Address of a dask scheduler whose workers do the cases; they must see the folder under the same name.
    on_case : callable or None

    Raises
    ------
    InputError
        The folder cannot be made, or another run is at work in it; there is no such shard.
    CadSweepError
        The scheduler is not there.
    """
    cases = study.cases if shard is None else _cases_of(study, *shard)
    folder = (folder or study.folder).resolve()
    try:
        (folder / CASES).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot make the folder {folder}: {error.strerror}; choose another with --output") from error
    with _at_work(folder, alone=shard is None):
        records = {} if again else read_records(folder, study, keep_failed=not retry_failed)
        table = Table(study, folder, records, shared=shard is not None)
        done = {case.key for case in cases if case.key in records}
        table.write()
        tell = _Teller(cases, records, on_case)
        tell(None)
        todo = [case for case in cases if case.key not in done]
        anew = again or retry_failed
        if dask is not None:
            from .remote import run_remotely

            made = run_remotely(todo, study, folder, dask, anew=anew)
        else:
            made = _run_cases(todo, study, folder, jobs, anew=anew)
        for case, record in made:
            table.add(case, record)
            tell(record)
        table.write()
        together = None
        if study.same_mesh and all(case.key in table.records for case in study.cases):
            together = write_together(study, folder, [table.records[case.key] for case in study.cases])
    return StudyResult(
        records=tuple(table.records[case.key] for case in cases),
        n_resumed=len(done),
        table=table.csv_path,
        json=table.json_path,
        together=together,
    )


def _cases_of(study: Study, number: int, of: int) -> tuple[Case, ...]:
    """The cases of a shard."""
    if not 1 <= number <= of:
        raise InputError(f"there is no shard {number} of {of}: shards are 1/{of} to {of}/{of}")
    return study.cases[number - 1 :: of]


class _Teller:
    """Counts the ends of cases for whoever asked."""

    def __init__(self, cases: Sequence[Case], records: dict[str, dict[str, Any]], on_case: OnCase | None) -> None:
        known = [records[case.key] for case in cases if case.key in records]
        self._total = len(cases)
        self._failed = sum(record["status"] != "ok" for record in known)
        self._done = len(known)
        self._on_case = on_case

    def __call__(self, record: dict[str, Any] | None) -> None:
        if record is not None:
            self._done += 1
            self._failed += record["status"] != "ok"
        if self._on_case is not None:
            left = self._total - self._done
            self._on_case(record, Tally(n_ok=self._done - self._failed, n_failed=self._failed, n_left=left))


@contextmanager
def _at_work(folder: Path, *, alone: bool) -> Iterator[None]:
    """Let one run at a time work in a folder, or any number of shards; the lock goes with its process."""
    try:
        with open(folder / ".lock", "a", encoding="ascii") as lock:
            fcntl.flock(lock, (fcntl.LOCK_EX if alone else fcntl.LOCK_SH) | fcntl.LOCK_NB)
            yield
    except BlockingIOError as error:
        raise InputError(f"another run is at work in {folder}; wait for it, or choose another with --output") from error
    except PermissionError as error:
        raise InputError(f"the folder {folder} is not writable; choose another with --output") from error


def _run_cases(
    cases: list[Case], study: Study, folder: Path, jobs: int, *, anew: bool
) -> Iterator[tuple[Case, dict[str, Any]]]:
    """Run cases, a few at a time, and give each record as soon as it is there."""
    from ..isolation import Worker
    from ..machine import free_memory

    if not cases:
        return
    jobs = min(jobs, len(cases))
    memory = free_memory() / jobs if study.max_memory is None else study.max_memory
    threads = str(max(1, (os.cpu_count() or 1) // jobs))  # workers share the processors, they do not fight for them
    todo, done, stop = deque(cases), queue.SimpleQueue[tuple[Case, dict[str, Any]]](), threading.Event()

    def tell(stage: str, fraction: float | None) -> None:
        if stop.is_set():
            raise _Stopped

    base = make_base(study, folder, max_memory=memory, on_progress=tell) if study.same_mesh else None

    def work() -> None:
        with Worker({"OMP_NUM_THREADS": threads}) as worker:
            while todo and not stop.is_set():
                try:
                    case = todo.popleft()
                except IndexError:  # another thread was faster
                    return
                record = claimed_case(
                    worker, study, case, folder, max_memory=memory, base=base, anew=anew, on_progress=tell
                )
                done.put((case, record))

    with ThreadPoolExecutor(max_workers=jobs) as pool:
        try:
            threads_at_work: list[Future[None]] = [pool.submit(work) for _ in range(jobs)]
            for _ in cases:
                yield _next(done, threads_at_work)
        finally:
            stop.set()


def _next(done: queue.SimpleQueue[tuple[Case, dict[str, Any]]], at_work: list[Future[None]]) -> Any:
    """The next record; an error that nobody meant in a thread comes out here."""
    while True:
        try:
            return done.get(timeout=0.5)
        except queue.Empty:
            for future in at_work:
                if future.done():
                    future.result()
