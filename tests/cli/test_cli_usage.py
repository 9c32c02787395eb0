"""The command line without any CAD: how fast it answers, and what it says to a wrong command."""

import json
import subprocess
import sys

import pytest

HEAVY = ("OCP", "cadquery", "gmsh", "numpy", "scipy", "numba", "vtkmodules", "pyvista", "rich")
COMMANDS = ("mesh", "info", "check", "view", "report", "batch", "expand")


def cadsweep(*args, **options):
    return subprocess.run(
        [sys.executable, "-m", "cadsweep", *args], capture_output=True, text=True, timeout=60, check=False, **options
    )


@pytest.mark.parametrize("args", [["--help"], ["--version"], *([c, "--help"] for c in COMMANDS)], ids=" ".join)
def test_help_needs_no_heavy_import(args):
    code = (
        "import sys, json\nfrom cadsweep.cli import main\n"
        f"try: main({args!r})\n"
        f"finally: print(json.dumps([m for m in {HEAVY!r} if m in sys.modules]), file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0
    assert done.stdout.strip()
    assert json.loads(done.stderr.splitlines()[-1]) == []


@pytest.mark.parametrize(
    "args",
    [
        ["mesh", "a.step"],
        ["mesh", "-o", "a.vtu"],
        ["mesh", "a.step", "-o", "a.vtu", "--no-such-option"],
        ["mesh", "a.step", "-o", "a.vtu", "--size", "0"],
        ["mesh", "a.step", "-o", "a.vtu", "--size", "-1"],
        ["mesh", "a.step", "-o", "a.vtu", "--size", "nan"],
        ["mesh", "a.step", "-o", "a.vtu", "--size", "inf"],
        ["mesh", "a.step", "-o", "a.vtu", "--size", "two"],
        ["mesh", "a.step", "-o", "a.vtu", "--layers", "0"],
        ["mesh", "a.step", "-o", "a.vtu", "--layers", "-1"],
        ["mesh", "a.step", "-o", "a.vtu", "--layers", "1.5"],
        ["mesh", "a.step", "-o", "a.vtu", "--layers", "1000000000"],
        ["mesh", "a.step", "-o", "a.vtu", "--bias", "0"],
        ["mesh", "a.step", "-o", "a.vtu", "--bias", "1e6"],
        ["mesh", "a.step", "-o", "a.vtu", "--bias", "1,2,3"],
        ["mesh", "a.step", "-o", "a.vtu", "--fractions", "0,2,1"],
        ["mesh", "a.step", "-o", "a.vtu", "--functional", "K"],
        ["mesh", "a.step", "-o", "a.vtu", "--strategy", "best"],
        ["mesh", "a.step", "-o", "a.vtu", "--order", "9"],
        ["mesh", "a.step", "-o", "a.vtu", "--timeout", "0"],
        ["mesh", "a.step", "-o", "a.vtu", "--max-memory", "-1"],
        ["mesh", "a.step", "-o", "a.vtu", "--max-hexes", "0"],
        ["mesh", "a.step", "-o", "a.vtu", "--param", "width=3"],
        ["mesh", "a.py", "-o", "a.vtu", "--param", "width"],
        ["mesh", "a.step", "-o", "a.vtu", "--face-size", "inlet=0"],
        ["mesh", "a.step", "-o", "a.vtu", "--edge-size", "rim=-1"],
        ["mesh", "a.step", "-o", "a.vtu", "--edge-count", "rim=1.5"],
        ["mesh", "a.step", "-o", "a.vtu", "--rail-layers", "span 1=0"],
        ["mesh", "a.step", "-o", "a.vtu", "--rail-layers", "8"],
        ["mesh", "a.step", "-o", "a.no_such_format"],
        ["mesh", "a.step", "-o", "no_suffix"],
        ["info", "a.step", "--param", "width=3"],
        ["info"],
        ["batch"],
        ["batch", "a.toml", "--jobs", "0"],
        ["no-such-command"],
    ],
    ids=lambda args: " ".join(args[3:]) or " ".join(args),
)
def test_wrong_usage_is_exit_2_before_any_work(args, tmp_path):
    done = cadsweep(*args, cwd=tmp_path)
    assert done.returncode == 2
    assert done.stdout == ""
    assert "Error:" in done.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("text", "value"),
    [("3", 3), ("2.5", 2.5), ("true", True), ("False", False), ("'3'", "3"), ("steel", "steel"), ("1,2", (1, 2)),
     ("__import__('os')", "__import__('os')"), ("", "")],
)  # fmt: skip
def test_parameters_read_as_python_would_but_never_run(text, value):
    from cadsweep.cli.types import parse_parameter

    assert parse_parameter(text) == value
    assert type(parse_parameter(text)) is type(value)


@pytest.mark.parametrize(
    ("text", "value"), [(None, None), ("3", 3), ("3, 4", [3, 4]), ("inlet", "inlet"), (">Z", ">Z"), ("a,b", "a,b")]
)
def test_caps_are_ids_or_names(text, value):
    from cadsweep.cli.types import parse_cap

    assert parse_cap(text) == value
