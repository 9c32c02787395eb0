"""Run CalculiX on a mesh: the deck includes the mesh file, as a user's would."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from cadsweep.mesh import HexMesh

YOUNG, POISSON = 210_000.0, 0.3


def require_calculix() -> None:
    """Skip where CalculiX is missing; fail instead where the environment promises it (CI)."""
    if shutil.which("ccx") is None:
        if os.environ.get("CADSWEEP_REQUIRE_CALCULIX"):
            pytest.fail("CalculiX (ccx) is missing: apt-get install calculix-ccx")
        pytest.skip("CalculiX (ccx) is missing: apt-get install calculix-ccx")


def solve(folder: Path, mesh: HexMesh, conditions: str, *, element: str | None = None) -> np.ndarray:
    """Displacements (n, 3) of a linear elastic part.

    Parameters
    ----------
    conditions : str
        Keyword lines inside the step: ``*BOUNDARY``, ``*DSLOAD``, ...
    element : str, optional
        Element type in place of the file's, as ``C3D8I``.
    """
    mesh.write(folder / "part.inp")
    if element:
        text = (folder / "part.inp").read_text()
        (folder / "part.inp").write_text(re.sub(r"TYPE=C3D\w+", f"TYPE={element}", text))
    part = next(iter(mesh.parts))
    found = run_deck(
        folder,
        f"*INCLUDE, INPUT=part.inp\n*NSET, NSET=EVERY, GENERATE\n1, {mesh.n_nodes}\n"
        f"*MATERIAL, NAME=STEEL\n*ELASTIC\n{YOUNG}, {POISSON}\n*SOLID SECTION, ELSET={part}, MATERIAL=STEEL\n"
        f"*STEP\n*STATIC\n{conditions}*NODE PRINT, NSET=EVERY\nU\n*END STEP\n",
    )
    table = found["displacements"]
    assert len(table) == mesh.n_nodes
    return table[np.argsort(table[:, 0]), 1:]


def run_deck(folder: Path, deck: str) -> dict[str, np.ndarray]:
    """Tables of numbers (rows, columns) that a job prints, by the first word of their titles."""
    (folder / "job.inp").write_text(deck)
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    done = subprocess.run(
        ["ccx", "job"], cwd=folder, capture_output=True, text=True, timeout=250, env=environment, check=False
    )
    assert done.returncode == 0, done.stdout[-2000:]
    assert "*ERROR" not in done.stdout
    tables: dict[str, list[list[float]]] = {}
    for line in (folder / "job.dat").read_text().splitlines():
        if re.match(r"\s*[a-z]", line):
            rows = tables.setdefault(line.split()[0], [])
        elif line.strip():
            rows.append([float(word) for word in line.split()])
    return {title: np.array(rows) for title, rows in tables.items()}
