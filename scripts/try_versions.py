"""Run the tests on the lowest and the newest versions of all dependencies.

    python scripts/try_versions.py lowest|newest [--folder FOLDER] [-- PYTEST ARGUMENTS]
    python scripts/try_versions.py lowest --folder /tmp/lowest -- tests/test_mesh.py tests/cli

``lowest`` takes the oldest release that ``pyproject.toml`` allows of every requirement, the extra ``view`` included,
and what goes with those (uv resolves it); ``newest`` the newest of all. Tools of the tests are the newest either way.
The environment is made in a folder of its own, and kept where ``--folder`` names one. What was installed is printed,
then what pytest says; the exit code is pytest's. Not part of the gate: it downloads half a gigabyte. Without arguments
all tests are run. ``scripts/part_figures.py``, run with both environments' Python, compares faces, cuts, names and
counts of parts. With OCP 7.8 and 7.9 and all else equal 30 of 31 parts are the same; in the other one, CadQuery's
booleans hand the faces over in another order, so the unnamed ones have other numbers (of its STEP file all is equal).
With the lowest versions of all (gmsh 4.13 and 4.15, too) two more have other quads, and so other counts.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
TOOLS = ["pytest", "pytest-timeout", "pytest-xdist", "hypothesis", "scikit-fem", "meshio", "netCDF4"]
SHOWN = (
    "cadquery",
    "cadquery-ocp",
    "gmsh",
    "numpy",
    "scipy",
    "numba",
    "h5py",
    "pyvista",
    "vtk",
    "click",
    "rich",
    "plotly",
)


def requirements() -> list[str]:
    """What is asked of pip for the package and its pictures."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    return [*project["dependencies"], *project["optional-dependencies"]["view"]]


def main() -> int:
    """Make the environment, install, test."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("which", choices=["lowest", "newest"])
    parser.add_argument("--folder", type=Path)
    split = sys.argv.index("--") if "--" in sys.argv else len(sys.argv)
    given = parser.parse_args(sys.argv[1:split])
    asked = sys.argv[split + 1 :] or ["tests"]
    with tempfile.TemporaryDirectory() as temporary:
        folder = given.folder or Path(temporary)
        python = folder / "bin" / "python"
        if not python.exists():
            subprocess.run([sys.executable, "-m", "venv", str(folder)], check=True)
        pip = [str(python), "-m", "pip", "--disable-pip-version-check"]
        subprocess.run([*pip, "install", "--quiet", "uv"], check=True)
        resolution = "lowest-direct" if given.which == "lowest" else "highest"
        install = [str(python), "-m", "uv", "pip", "install", "--quiet", "--python", str(python)]
        subprocess.run([*install, "--resolution", resolution, *requirements()], check=True)
        kept = folder / "kept.txt"
        listed = subprocess.run([*pip, "list", "--format=freeze"], check=True, capture_output=True, text=True).stdout
        kept.write_text(listed)
        subprocess.run([*install, *TOOLS, "--constraint", str(kept)], check=True)
        print(", ".join(line for line in listed.splitlines() if line.split("==")[0].lower() in SHOWN), flush=True)
        environment = {**os.environ, "PYTHONPATH": str(ROOT)}
        command = [str(python), "-m", "pytest", "-q", "-p", "no:cacheprovider", *asked]
        return subprocess.run(command, check=False, cwd=ROOT, env=environment).returncode


if __name__ == "__main__":
    sys.exit(main())
