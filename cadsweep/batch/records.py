"""What is kept of a study: a folder a case with its record, and a table of all.

A record is put in place in one step, and counts only together with the mesh that it names. So whoever reads the
folder, at any moment and after any kill, finds cases that are done, and others that are not there.
"""

from __future__ import annotations

import csv
import fcntl
import io
import json
import logging
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from .study import Case, Study

log = logging.getLogger(__name__)

CASES = "cases"
RECORD = "record.json"
FIGURES = ("n_nodes", "n_hexes", "min_scaled_jacobian", "mean_scaled_jacobian", "n_inverted", "volume", "cad_volume")

TABLE_EVERY = 2.0
"""Seconds between two writings of the table while the study runs."""


def case_folder(folder: Path, case: Case) -> Path:
    """Where everything of a case lies."""
    return folder / CASES / case.folder


def write_record(folder: Path, case: Case, record: dict[str, Any]) -> None:
    """Put the record of a finished case in place."""
    _write(case_folder(folder, case) / RECORD, json.dumps(record, indent=1))


def read_record(folder: Path, case: Case, *, keep_failed: bool = True) -> dict[str, Any] | None:
    """The record of a case; None where it is not done, or its record is damaged or without its mesh."""
    path = case_folder(folder, case) / RECORD
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
        kept = record["status"] == "ok" or keep_failed
    except FileNotFoundError:
        return None
    except (ValueError, KeyError, TypeError) as error:
        log.warning("the record %s is damaged (%s), so its case is done again", path, error)
        return None
    files = [record[name] for name in ("mesh", "nodes") if record.get(name) is not None]
    if not kept or not all((folder / name).exists() for name in files):
        return None
    return {**record, "case": case.name}


def read_records(folder: Path, study: Study, *, keep_failed: bool = True) -> dict[str, dict[str, Any]]:
    """The records of all finished cases, by the keys of the cases."""
    found = ((case.key, read_record(folder, case, keep_failed=keep_failed)) for case in study.cases)
    return {key: record for key, record in found if record is not None}


class Table:
    """The results as CSV and JSON files, both whole at any moment.

    Parameters
    ----------
    records : dict
        By the keys of the cases; grows.
    shared : bool
        Others work on the study as well: what they have finished is read whenever the files are written.
    """

    def __init__(self, study: Study, folder: Path, records: dict[str, dict[str, Any]], *, shared: bool = False) -> None:
        self.records = records
        self._study, self._folder, self._shared = study, folder, shared
        self.csv_path, self.json_path = folder / "results.csv", folder / "results.json"
        self._cases = study.cases
        self._params = list(dict.fromkeys(key for case in study.cases for key in case.params))
        self._options = list(dict.fromkeys(key for case in study.cases for key in case.options))
        self._written = 0.0

    def add(self, case: Case, record: dict[str, Any]) -> None:
        """Take a finished case in, and write the files if that is some time ago."""
        self.records[case.key] = record
        if time.monotonic() - self._written > TABLE_EVERY:
            self.write()

    def write(self) -> None:
        """Write both files."""
        if not self._shared:
            self._write_rows()
            return
        # One after the other, each with what is there by then: the last one's table has all.
        with locked(self._folder / ".table.lock"):
            self.records.update(read_records(self._folder, self._study))
            self._write_rows()

    def _write_rows(self) -> None:
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


@contextmanager
def locked(path: Path, *, wait: Callable[[], None] | None = None) -> Iterator[None]:
    """Hold a lock file; the lock goes with its process, however that ends.

    Parameters
    ----------
    path : Path
    wait : callable or None
        Called every half second while another process holds it.
    """
    with open(path, "a", encoding="ascii") as lock:
        while True:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                break
            except BlockingIOError:
                if wait is not None:
                    wait()
                time.sleep(0.5 if wait is not None else 0.05)
        yield
