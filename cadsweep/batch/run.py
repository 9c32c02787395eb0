"""Run the cases of a study that have no record yet, and keep the table."""

from __future__ import annotations

import csv
import fcntl
import io
import json
import logging
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import CadSweepError, InputError
from .study import Case, Study

log = logging.getLogger(__name__)

Progress = Callable[[str, float | None], None]

FIGURES = ("n_nodes", "n_hexes", "min_scaled_jacobian", "mean_scaled_jacobian", "n_inverted", "volume", "cad_volume")
TABLE_EVERY = 2.0
"""Seconds between two writings of the table while the study runs."""


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
    """

    records: tuple[dict[str, Any], ...]
    n_resumed: int
    table: Path
    json: Path

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
    on_progress: Progress | None = None,
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

    Raises
    ------
    InputError
        The folder cannot be made, or another run is at work in it.
    """
    folder = (folder or study.folder).resolve()
    places = {name: folder / name for name in ("cases", "meshes")}
    try:
        for place in places.values():
            place.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot make the folder {folder}: {error.strerror}; choose another with --output") from error
    with _alone(folder):
        records = {} if again else _read_records(study, places["cases"], keep_failed=not retry_failed)
        n_resumed = len(records)
        table = _Table(study, folder, records)
        table.write()
        if on_progress is not None:
            on_progress("cases", len(records) / len(study.cases))
        for case, record in _run_cases(study, records, places, jobs, on_progress):
            _write(places["cases"] / f"{case.key}.json", json.dumps(record, indent=1))
            table.add(case, record)
        table.write()
    return StudyResult(
        records=tuple(table.records[case.key] for case in study.cases),
        n_resumed=n_resumed,
        table=table.csv_path,
        json=table.json_path,
    )


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Let one run at a time work in a folder; the lock goes with its process, however that ends."""
    try:
        with open(folder / ".lock", "a", encoding="ascii") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            yield
    except BlockingIOError as error:
        raise InputError(f"another run is at work in {folder}; wait for it, or choose another with --output") from error
    except PermissionError as error:
        raise InputError(f"the folder {folder} is not writable; choose another with --output") from error


def _read_records(study: Study, place: Path, *, keep_failed: bool) -> dict[str, dict[str, Any]]:
    """The records of finished cases; one that is damaged counts as none."""
    records = {}
    for case in study.cases:
        path = place / f"{case.key}.json"
        try:
            record = json.loads(path.read_text(encoding="utf-8"))
            kept = record["status"] == "ok" or keep_failed
        except FileNotFoundError:
            continue
        except (ValueError, KeyError, TypeError) as error:
            log.warning("the record %s is damaged (%s), so its case is done again", path, error)
            continue
        mesh = record.get("mesh")
        if kept and (mesh is None or (place.parent / mesh).exists()):
            records[case.key] = {**record, "case": case.name}
    return records


def _run_cases(
    study: Study, done: dict[str, Any], places: dict[str, Path], jobs: int, on_progress: Progress | None
) -> Iterator[tuple[Case, dict[str, Any]]]:
    """Run what is left, a few at a time, and give each record as soon as it is there."""
    from ..estimate import free_memory

    todo = [case for case in study.cases if case.key not in done]
    memory = free_memory() / jobs if study.max_memory is None else study.max_memory
    stop = threading.Event()
    n_done = len(study.cases) - len(todo)

    def tell(stage: str, fraction: float | None) -> None:
        if stop.is_set():
            raise _Stopped

    with ThreadPoolExecutor(max_workers=jobs) as pool:
        try:
            pending: dict[Future[dict[str, Any]], Case] = {
                pool.submit(_run_case, study, case, places["meshes"], memory, tell): case for case in todo
            }
            while pending:
                finished, _ = wait(pending, timeout=0.5, return_when=FIRST_COMPLETED)
                for future in finished:
                    case = pending.pop(future)
                    yield case, future.result()
                    n_done += 1
                if on_progress is not None:
                    on_progress("cases", n_done / len(study.cases))
        finally:
            stop.set()
            pool.shutdown(wait=True, cancel_futures=True)


def _run_case(study: Study, case: Case, meshes: Path, memory: float, tell: Progress) -> dict[str, Any]:
    from ..isolation import leftovers, run_isolated

    mesh = None if study.suffix is None else meshes / f"{case.name}{study.suffix}"
    record: dict[str, Any] = {"case": case.name, "params": case.params, "options": case.options, "status": "ok"}
    start = time.perf_counter()
    try:
        figures = run_isolated(
            "cadsweep.cli.work:mesh_file",
            (str(study.script), None if mesh is None else str(mesh)),
            {"options": {**case.options, "params": case.params or None, "max_memory": memory}},
            timeout=study.timeout,
            max_memory=memory,
            on_progress=tell,
            remove=[] if mesh is None else leftovers(mesh),
        )
        record.update(figures)
        record["mesh"] = None if mesh is None else f"{meshes.name}/{mesh.name}"
    except CadSweepError as error:
        record.update(status="failed", error=" ".join(str(error).split()), error_type=type(error).__name__)
    record["total_seconds"] = round(time.perf_counter() - start, 3)
    return record


class _Table:
    """The results as CSV and JSON files, both whole at any moment."""

    def __init__(self, study: Study, folder: Path, records: dict[str, dict[str, Any]]) -> None:
        self.records = records
        self.csv_path, self.json_path = folder / "results.csv", folder / "results.json"
        self._cases = study.cases
        self._params = list(dict.fromkeys(key for case in study.cases for key in case.params))
        self._options = list(dict.fromkeys(key for case in study.cases for key in case.options))
        self._written = 0.0

    def add(self, case: Case, record: dict[str, Any]) -> None:
        self.records[case.key] = record
        if time.monotonic() - self._written > TABLE_EVERY:
            self.write()

    def write(self) -> None:
        rows = [self.records[case.key] for case in self._cases if case.key in self.records]
        _write(self.json_path, json.dumps(rows, indent=1))
        text = io.StringIO()
        table = csv.writer(text, lineterminator="\n")
        options = [f"options.{key}" for key in self._options]
        table.writerow(["case", *self._params, *options, "status", *FIGURES, "seconds", "mesh", "error_type", "error"])
        for row in rows:
            table.writerow(
                [
                    row["case"],
                    *(row["params"].get(key) for key in self._params),
                    *(row["options"].get(key) for key in self._options),
                    row["status"],
                    *(row.get(key) for key in FIGURES),
                    row["total_seconds"],
                    row.get("mesh"),
                    row.get("error_type"),
                    row.get("error"),
                ]
            )
        _write(self.csv_path, text.getvalue())
        self._written = time.monotonic()


def _write(path: Path, text: str) -> None:
    from ..io.atomic import replaced_file

    with replaced_file(path) as file:
        file.write(text.encode("utf-8"))
