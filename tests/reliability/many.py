"""Mesh many sources in few workers: one goes on until a source ends it."""

import json
import tempfile
from pathlib import Path

from cadsweep.errors import WorkerError
from cadsweep.isolation import run_isolated


def mesh_all(sources, *, timeout=600.0, max_memory=3.0, **options):
    """How each source ends: ``[kind, message, n_hexes, volume]``, kind ``"mesh"`` or the name of an error."""
    ends = []
    while len(ends) < len(sources):
        with tempfile.TemporaryDirectory() as folder:
            record = Path(folder) / "record"
            try:
                run_isolated(
                    "tests.reliability.worker_tasks:mesh_many",
                    ([str(s) for s in sources[len(ends) :]], options, str(record)),
                    timeout=timeout,
                    max_memory=max_memory,
                )
                died = None
            except WorkerError as error:
                died = ["WorkerError", str(error), 0, 0.0]
            if record.exists():
                ends += [json.loads(line) for line in record.read_text(encoding="utf-8").splitlines()]
            if died is not None:
                ends.append(died)
    return ends
