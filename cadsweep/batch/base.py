"""Studies in which all cases have one mesh: its base, and one file of the nodes of all cases.

The base is the mesh of the study's first case, kept as a file of factors beside the results; every case, the first
included, is carried from there (``sweep_mesh(..., like=...)``). The file of all cases is a ``.vtkhdf`` that holds the
hexahedra once and a time step of points for every case: ParaView steps through them, and h5py reads
``VTKHDF/Points``, case after case.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..errors import CadSweepError
from ..isolation import Worker, leftovers
from .records import case_folder, locked
from .study import Study

NODES = "nodes.npy"
"""In a case's folder: its nodes, for the file of all cases."""

TOGETHER = "cases.vtkhdf"


def base_path(study: Study, folder: Path) -> Path:
    """Where the factors of the base are."""
    return folder / f"base_{study.cases[0].key[:8]}.sweep.npz"


def make_base(study: Study, folder: Path, *, max_memory: float, on_progress: Any = None) -> Path:
    """Mesh the first case for the others, unless an earlier run has.

    Raises
    ------
    CadSweepError
        It cannot be meshed, so that no case can.
    """
    path = base_path(study, folder)
    with locked(folder / ".base.lock", wait=(lambda: on_progress("base", None)) if on_progress else None):
        return path if path.exists() else _make(study, path, max_memory, on_progress)


def _make(study: Study, path: Path, max_memory: float, on_progress: Any) -> Path:
    first = study.cases[0]
    options = {key: value for key, value in first.options.items() if key not in ("order", "nodes", "refine")}
    try:
        with Worker() as worker:
            worker.run(
                "cadsweep.cli.work:mesh_file",
                (str(study.script), str(path)),
                {"options": {**options, "params": first.params or None, "max_memory": max_memory}},
                timeout=study.timeout,
                max_memory=max_memory,
                on_progress=on_progress,
                remove=leftovers(path),
            )
    except CadSweepError as error:
        raise CadSweepError(
            f"the first case '{first.name}', whose mesh all cases are to have, cannot be meshed: {error.message}"
        ) from error
    return path


def carried_options(options: Mapping[str, Any], base: Path) -> dict[str, Any]:
    """Options of a case that is carried from the base: what the base brings along is left out."""
    from ..pipeline.finished.like import OWN

    return {**{key: value for key, value in options.items() if key not in OWN}, "like": str(base)}


def write_together(study: Study, folder: Path, records: Sequence[Mapping[str, Any]]) -> Path | None:
    """Write the nodes of all cases that have a mesh into one file; None where none has."""
    import numpy as np

    from ..io.atomic import replaced_file
    from ..io.steps import write_steps
    from ..pipeline import expand

    done = [
        (number, case)
        for number, (case, record) in enumerate(zip(study.cases, records, strict=True))
        if record["status"] == "ok"
    ]
    if not done:
        return None
    base = expand(base_path(study, folder))
    first = np.load(case_folder(folder, done[0][1]) / NODES, mmap_mode="r")
    mesh = replace(base, points=np.asarray(first))
    params = list(dict.fromkeys(key for case in study.cases for key in case.params))
    numbers = {
        key: np.array([float(case.params.get(key, np.nan)) for _, case in done])
        for key in params
        if all(isinstance(case.params.get(key), int | float) for _, case in done)
    }
    path = folder / TOGETHER
    with replaced_file(path) as stream:
        write_steps(
            stream,
            mesh,
            (np.load(case_folder(folder, case) / NODES, mmap_mode="r") for _, case in done),
            times=[float(number) for number, _ in done],
            fields={"case_names": np.array([case.name for _, case in done]), **numbers},
        )
    return path
