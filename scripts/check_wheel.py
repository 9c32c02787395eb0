"""Build the wheel with some Pythons, install it in fresh environments, and time a user's first mesh.

    python scripts/check_wheel.py                                this Python
    python scripts/check_wheel.py python3.11 python3.12 python3.13
    python scripts/check_wheel.py --tests tests/test_mesh.py     these as well, on the installed package
    python scripts/check_wheel.py --tools                        pipx install, uv tool install, uvx --from .
    python scripts/check_wheel.py --lowest                       with the oldest dependencies (uv resolves them)
    python scripts/check_wheel.py --installed PYTHON             only the first meshes, with what is installed there

The wheel is made from the sdist. Its name must say Python, machine and C library, and its machine code must ask nothing
of the C library that is not listed here. The first mesh of ``models/bracket.step`` and of a helical gear may take 1.5
times the processor time of the second, where neither the home nor the package can be written to, and two first runs
at once must be as good. The exit code is 1 where something of this is not so. It downloads half a gigabyte an
environment, unless pip has it.
"""

from __future__ import annotations

import argparse
import os
import pickle
import resource
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LIMIT = 1.5
"""The first run over the second."""

ASKED = {
    *("acos", "asin", "atan", "atan2", "cbrt", "ceil", "cos", "cosh", "exp", "exp2", "fabs", "floor", "fmod", "hypot"),
    *("log", "log2", "memcpy", "memmove", "memset", "pow", "sin", "sincos", "sinh", "sqrt", "tan", "tanh"),
}
"""What machine code may ask of the C library: in glibc since 2.1, so a wheel's 2.17 is no promise too much."""

OF_PYTHON = ("Py", "_Py", "NRT_", "numba_")

GEAR = """
import math, sys
import cadquery as cq
r, n = 20.0, 9
tooth = [(r, 0.0), (r + 2.5, 0.35), (r + 2.5, 0.55), (r, 0.9)]
turns = [(d, (i + a) * 2 * math.pi / n) for i in range(n) for d, a in tooth]
points = [(d * math.cos(a), d * math.sin(a)) for d, a in turns]
cq.exporters.export(cq.Workplane().polyline(points).close().twistExtrude(8, 20), sys.argv[1])
"""


WATCH = """
import logging, sys
import cadsweep as cs
logging.basicConfig(format="%(message)s")
logging.getLogger("cadsweep.compiled").setLevel("INFO")
for part in sys.argv[1:]:
    cs.sweep_mesh(part)
"""


class FailedError(Exception):
    """What is not as it should be."""


def run(*command: object, **options: object) -> None:
    """Run a command, and say what it said where it fails."""
    words = [str(word) for word in command]
    done = subprocess.run(words, capture_output=True, text=True, check=False, **options)  # type: ignore[call-overload]
    if done.returncode:
        raise FailedError(f"{' '.join(words)}: exit {done.returncode}\n{(done.stdout + done.stderr)[-2000:]}")


def build(python: str, folder: Path) -> Path:
    """The wheel that this Python makes of the sdist."""
    run(python, "-m", "venv", folder / "building")
    builder = folder / "building" / "bin" / "python"
    run(builder, "-m", "pip", "install", "--quiet", "build")
    run(builder, "-m", "build", "--outdir", folder / "dist", ROOT)
    (wheel,) = (folder / "dist").glob("*.whl")
    return wheel


def check_name(wheel: Path, python: str) -> None:
    """The tags of a wheel with machine code."""
    version = subprocess.check_output(
        [python, "-c", "import sys; print('cp%d%d' % sys.version_info[:2])"], text=True
    ).strip()
    if f"-{version}-{version}-manylinux_2_17_{os.uname().machine}" not in wheel.name:
        raise FailedError(f"{wheel.name}: not for {version} and this machine alone")


def undefined(elf: bytes) -> set[str]:
    """The names that an object file (ELF, 64 bits) asks of others."""
    (headers,) = struct.unpack_from("<Q", elf, 0x28)
    size, n = struct.unpack_from("<HH", elf, 0x3A)
    sections = [struct.unpack_from("<IIQQQQIIQQ", elf, headers + i * size) for i in range(n)]
    found = set()
    for section in sections:
        if section[1] != 2:  # a table of symbols
            continue
        strings = sections[section[6]][4]
        for at in range(section[4], section[4] + section[5], 24):
            name, _, _, home = struct.unpack_from("<IBBH", elf, at)
            if name and not home:
                found.add(elf[strings + name : elf.index(b"\0", strings + name)].decode())
    return found


def check_symbols(wheel: Path, python: Path) -> None:
    """What machine code asks for: Python, numba's runtime, and an old C library."""
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        code = [archive.read(name) for name in names if name.endswith(".nbc")]
    if not code or any("__pycache__" in name for name in names):
        raise FailedError(f"{wheel.name}: {len(code)} files of machine code, or a cache among the modules")
    # numba's words for its values are unpacked where numba is.
    script = (
        "import pickle, sys; code = pickle.load(sys.stdin.buffer)\n"
        "pickle.dump([pickle.loads(one)[0][2][0] for one in code], sys.stdout.buffer)"
    )
    unpacked = subprocess.run([python, "-c", script], input=pickle.dumps(code), capture_output=True, check=True).stdout
    asked = set().union(*map(undefined, pickle.loads(unpacked)))
    strange = {name for name in asked if name not in ASKED and not name.startswith(OF_PYTHON)}
    if strange:
        raise FailedError(f"machine code asks for {', '.join(sorted(strange))}")
    print(f"  {len(code)} loops compiled, asking the C library for {', '.join(sorted(asked & ASKED))}")


class Runs:
    """Runs of the installed command by somebody who may write to nothing but one folder."""

    def __init__(self, python: Path, folder: Path) -> None:
        self.command = python.with_name("cadsweep")
        self.folder = folder
        folder.mkdir()
        package = subprocess.check_output(
            [python, "-c", "import cadsweep; print(cadsweep.__path__[0])"], text=True, cwd=folder
        )
        for path in Path(package.strip()).rglob("*"):
            if path.is_dir():
                path.chmod(0o555)
        # Root may write anywhere, unless this is taken from it.
        capability = "--bounding-set=-dac_override", "--inh-caps=-dac_override"
        self.as_nobody = [] if os.getuid() else ["setpriv", *capability]
        self.environment = {"PATH": os.environ["PATH"], "HOME": "/proc", "TMPDIR": str(folder), "LANG": "C.UTF-8"}

    def start(self, part: Path, output: str) -> subprocess.Popen[str]:
        """A mesh of a part, on its way."""
        return subprocess.Popen(
            [*self.as_nobody, self.command, "mesh", part, "-o", self.folder / output, "--quiet"],
            cwd=self.folder,
            env=self.environment,
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
        )

    def finish(self, process: subprocess.Popen[str]) -> None:
        """Wait; whoever is quiet must have said nothing."""
        said, _ = process.communicate()
        if process.returncode or said:
            raise FailedError(f"exit {process.returncode}, said {said[-2000:]!r}")

    def seconds(self, part: Path, output: str) -> tuple[float, float]:
        """Of a mesh: of the processor, and by the clock."""
        before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
        self.finish(self.start(part, output))
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        return spent, time.monotonic() - start


def check_runs(python: Path, folder: Path) -> None:
    """First and second runs, one by one and two at once."""
    gear = folder / "gear.step"
    run(python, "-c", GEAR, gear)
    bracket = folder / "bracket.step"
    shutil.copy(ROOT / "models" / "bracket.step", bracket)
    runs = Runs(python, folder / "meshes")
    watched = [*runs.as_nobody, python, "-c", WATCH, bracket, gear]
    said = subprocess.run(
        watched, cwd=runs.folder, env=runs.environment, capture_output=True, text=True, check=True
    ).stderr
    if said:
        raise FailedError(f"not quiet: {said[-2000:]}")
    for part in (bracket, gear):
        both = [runs.start(part, f"{name}.vtu") for name in ("a", "b")] if part is gear else []
        for process in both:
            runs.finish(process)
        first, second = runs.seconds(part, "first.vtu"), runs.seconds(part, "second.vtu")
        ratio = first[0] / second[0]
        print(
            f"  {part.stem}: first {first[0]:.2f} s, second {second[0]:.2f} s of the processor ({ratio:.2f} x); "
            f"by the clock {first[1]:.2f} and {second[1]:.2f} s"
        )
        if ratio > LIMIT:
            raise FailedError(f"{part.stem}: the first mesh takes {ratio:.2f} times the second")


def install(python: str, folder: Path, wheel: Path, *, lowest: bool, tests: list[str]) -> Path:
    """A fresh environment with the wheel."""
    run(python, "-m", "venv", folder / "fresh")
    fresh = folder / "fresh" / "bin" / "python"
    if lowest:
        run(fresh, "-m", "pip", "install", "--quiet", "uv")
        run(fresh, "-m", "uv", "pip", "install", "--python", fresh, "--resolution", "lowest-direct", wheel)
    else:
        run(fresh, "-m", "pip", "install", "--quiet", wheel)
    if tests:
        run(fresh, "-m", "pip", "install", "--quiet", "pytest", "pytest-timeout", "hypothesis", "meshio")
    return fresh


def check_python(python: str, folder: Path, *, lowest: bool, tests: list[str]) -> None:
    """All of it for one Python."""
    wheel = build(python, folder)
    print(f"{wheel.name}: {wheel.stat().st_size / 1e6:.1f} MB", flush=True)
    check_name(wheel, python)
    fresh = install(python, folder, wheel, lowest=lowest, tests=tests)
    check_symbols(wheel, fresh)
    check_runs(fresh, folder)
    if tests:
        shutil.copytree(ROOT / "tests", folder / "tests")
        run(
            fresh,
            "-m",
            "pytest",
            "-q",
            "-p",
            "no:cacheprovider",
            "-c",
            "/dev/null",
            "--rootdir",
            folder,
            *tests,
            cwd=folder,
        )
        print(f"  {' '.join(tests)}: passed")


def check_tools(folder: Path) -> None:
    """The ways of those who install commands, not packages."""
    run(sys.executable, "-m", "venv", folder / "tools")
    tools = folder / "tools" / "bin"
    run(tools / "python", "-m", "pip", "install", "--quiet", "uv", "pipx")
    homes = {
        name: str(folder / name.lower()) for name in ("PIPX_HOME", "PIPX_BIN_DIR", "UV_TOOL_DIR", "UV_TOOL_BIN_DIR")
    }
    environment = {**os.environ, **homes}
    for command in (
        ("pipx", "install", ROOT),
        ("uv", "tool", "install", "--python", sys.executable, ROOT),
        ("uvx", "--python", sys.executable, "--from", ROOT, "cadsweep", "--version"),
    ):
        run(tools / command[0], *command[1:], env=environment)
        print(f"  {' '.join(map(str, command))}: fine", flush=True)
    for place in ("PIPX_BIN_DIR", "UV_TOOL_BIN_DIR"):
        run(Path(homes[place]) / "cadsweep", "mesh", ROOT / "models" / "bracket.step", "-o", folder / "bracket.vtu")


def main() -> int:
    """Check with every Python that is named."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("pythons", nargs="*", default=[sys.executable])
    parser.add_argument("--tests", nargs="+", default=[])
    parser.add_argument("--tools", action="store_true")
    parser.add_argument("--lowest", action="store_true")
    parser.add_argument("--installed", metavar="PYTHON", type=Path)
    given = parser.parse_args()
    for python in given.pythons:
        with tempfile.TemporaryDirectory(dir="/var/tmp") as temporary:
            folder = Path(temporary)
            try:
                if given.installed:
                    check_runs(given.installed.absolute(), folder)
                    continue
                check_python(python, folder, lowest=given.lowest, tests=given.tests)
                if given.tools and python == given.pythons[0]:
                    check_tools(folder)
            except FailedError as error:
                print(error, file=sys.stderr)
                return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
