"""Run what uses numba beyond its documented surface on the newest releases of its last versions, and on the oldest.

    python scripts/try_numba.py [--versions 5] [--folder FOLDER]

:mod:`cadsweep.compiled` loads machine code by numba's own classes for its cache, which may change from one version
to the next. Each version gets an environment of its own with numpy, scipy and pytest alone, in which code is made,
kept, loaded without the compiler, refused where it is of another source or numba, and called
(``tests/test_compiled.py`` and the tests of kernels). A line a version; the exit code is 1 where one fails. It
downloads 150 MB a version.
On 25 November 2026: 0.60.0, 0.64.0, 0.65.1, 0.66.0, 0.67.0 and 0.68.1 pass.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
TESTS = ["tests/test_compiled.py", "tests/projection/test_projection_kernels.py"]


def last_versions(n: int) -> list[str]:
    """The newest releases of the last n minor versions, and the oldest version that is asked for."""
    command = [sys.executable, "-m", "pip", "index", "versions", "numba", "--disable-pip-version-check"]
    said = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    every = re.findall(r"\d+\.\d+\.\d+", said.partition("Available versions:")[2])
    newest: dict[str, str] = {}
    for version in every:  # newest first
        newest.setdefault(version.rpartition(".")[0], version)
    wanted = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
    least = next(asked.partition(">=")[2] for asked in wanted if asked.startswith("numba"))
    return [*list(newest.values())[:n], f"{least}.0"]


def try_version(version: str, folder: Path) -> bool:
    """Make an environment, test in it, and say how it went."""
    python = folder / version / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", str(folder / version)], check=True)
        install = [str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        subprocess.run([*install, f"numba=={version}", "numpy", "scipy", "pytest", "pytest-timeout"], check=True)
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": str(folder / version / "cache")}
    command = [str(python), "-m", "pytest", "--noconftest", "-o", "addopts=", "-p", "no:cacheprovider", *TESTS]
    done = subprocess.run(command, check=False, cwd=ROOT, env=environment, capture_output=True, text=True)
    print(f"numba {version}: {done.stdout.strip().splitlines()[-1]}", flush=True)
    if done.returncode:
        print(done.stdout[-4000:], done.stderr[-2000:])
    return done.returncode == 0


def main() -> int:
    """Try all."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--versions", type=int, default=5)
    parser.add_argument("--folder", type=Path)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        went = [try_version(version, given.folder or Path(temporary)) for version in last_versions(given.versions)]
    return 0 if all(went) else 1


if __name__ == "__main__":
    sys.exit(main())
