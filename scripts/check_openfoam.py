"""Mesh models, hand them to OpenFOAM, and ask OpenFOAM's ``checkMesh`` for its verdict.

    python scripts/check_openfoam.py [MODEL.py ...]

Without arguments every model of ``models/`` is taken. Each is written twice: as MSH 2.2, converted by ``gmshToFoam``,
and as a ``polyMesh`` folder. Both must end in "Mesh OK", with one patch a named boundary. Needs OpenFOAM
(``apt-get install openfoam``); exit 0: all are, 1: one is not, 3: OpenFOAM is missing.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from cadsweep import io
from cadsweep.mesh import HexMesh

_HEAD = "FoamFile {{ version 2.0; format ascii; class dictionary; object {name}; }}\n"
_CONTROL = (
    "application checkMesh; startFrom startTime; startTime 0; stopAt endTime; endTime 1; deltaT 1;\n"
    "writeControl timeStep; writeInterval 1; writeFormat ascii; writePrecision 17; timeFormat general;\n"
)
_SCHEMES = "ddtSchemes {} gradSchemes {} divSchemes {} laplacianSchemes {} interpolationSchemes {} snGradSchemes {}\n"


def find_openfoam() -> bool:
    """Whether OpenFOAM's programs are there."""
    return shutil.which("checkMesh") is not None and shutil.which("gmshToFoam") is not None


def make_case(folder: Path) -> Path:
    """Make an empty case, enough for the mesh tools."""
    (folder / "system").mkdir(parents=True)
    (folder / "constant").mkdir()
    for name, body in (("controlDict", _CONTROL), ("fvSchemes", _SCHEMES), ("fvSolution", "")):
        (folder / "system" / name).write_text(_HEAD.format(name=name) + body)
    return folder


def run(case: Path, *command: str) -> str:
    """Run a program of OpenFOAM on a case and return what it said."""
    environment = dict(os.environ)
    if Path("/usr/share/openfoam").is_dir():  # where Debian's package keeps its settings
        environment.setdefault("WM_PROJECT_DIR", "/usr/share/openfoam")
    done = subprocess.run(
        [*command, "-case", str(case)], capture_output=True, text=True, timeout=600, env=environment, check=False
    )
    return done.stdout + done.stderr


def check(mesh: HexMesh, folder: Path) -> list[str]:
    """What OpenFOAM has against a mesh, by either way; empty where it is content."""
    complaints = []
    for way in ("gmshToFoam", "polyMesh"):
        case = make_case(folder / way)
        if way == "gmshToFoam":
            io.write(mesh, case / "mesh.msh", version="2.2")
            said = run(case, "gmshToFoam", str(case / "mesh.msh"))
        else:
            io.write(mesh, case / "constant" / "polyMesh")
            said = ""
        said += run(case, "checkMesh", "-allTopology")
        if "Mesh OK." not in said:
            reasons = [line.strip() for line in said.splitlines() if "***" in line or "ERROR" in line]
            complaints.append(f"{way}: {'; '.join(reasons[:3]) or said[-300:]}")
            continue
        cells = re.search(r"^\s*cells:\s+(\d+)", said, re.MULTILINE)
        hexes = re.search(r"^\s*hexahedra:\s+(\d+)", said, re.MULTILINE)
        if not cells or not hexes or int(cells[1]) != mesh.n_hexes or int(hexes[1]) != mesh.n_hexes:
            complaints.append(f"{way}: not {mesh.n_hexes} hexahedra")
        patches = (case / "constant" / "polyMesh" / "boundary").read_text()
        for name, quads in mesh.boundaries.items():
            row = re.search(rf"^\s*{name}\s*\n\s*\{{[^}}]*nFaces\s+(\d+)", patches, re.MULTILINE)
            if row is None or int(row[1]) != len(quads):
                complaints.append(f"{way}: no patch {name} of {len(quads)} faces")
    return complaints


def main(arguments: list[str]) -> int:
    """Check the models that are named, or all of them."""
    if not find_openfoam():
        print("OpenFOAM is missing (checkMesh, gmshToFoam): apt-get install openfoam", file=sys.stderr)
        return 3
    import cadsweep

    models = Path(__file__).parents[1] / "models"
    paths = [Path(a) for a in arguments] or sorted(p for p in models.glob("*.py") if p.name != "paper.py")
    n_bad = 0
    for path in paths:
        mesh = cadsweep.sweep_mesh(path)
        with tempfile.TemporaryDirectory() as folder:
            complaints = check(mesh, Path(folder))
        n_bad += bool(complaints)
        print(f"{path.name}: {mesh.n_hexes} hexahedra: {'; '.join(complaints) or 'Mesh OK'}", flush=True)
    return int(n_bad > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
