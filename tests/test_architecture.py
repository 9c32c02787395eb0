"""The rules that keep the layout: who may import whom, and what the first import costs."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

import cadsweep

PACKAGE = Path(cadsweep.__file__).parent
FOUNDATION = {
    "arrays",
    "polygons",
    "asked",
    "contacts",
    "brep",
    "sweep",
    "disjoint",
    "stack",
    "stack_mesh",
    "processor",
    "cells",
    "corner_blocks",
    "mesh",
    "lattice",
    "record",
    "rows",
    "harmonic",
    "quality",
    "brief",
    "errors",
    "libraries",
    "machine",
    "choices",
    "collector",
    "compiled",
    "threads",
    "trial",
    "progress",
    "verbs",
    "_version",
}
# cadquery: the plugin for Workplanes
COMPOSITION = {"pipeline", "__init__", "__main__", "cli", "app", "batch", "cadquery"}
MODULES = sorted(p.relative_to(PACKAGE) for p in PACKAGE.rglob("*.py"))


def stage_of(path: Path) -> str:
    """The stage a module belongs to: the package folder, or the module itself."""
    return path.parts[0] if len(path.parts) > 1 else path.stem


def imported(path: Path) -> list[tuple[str, bool]]:
    """Absolute dotted names that a module imports, and whether it does so when it is imported itself."""
    tree = ast.parse((PACKAGE / path).read_text(encoding="utf-8"))
    deferred = {id(n) for f in ast.walk(tree) if isinstance(f, ast.FunctionDef) for n in ast.walk(f)}
    typing_only = {
        id(n)
        for f in ast.walk(tree)
        if isinstance(f, ast.If) and getattr(f.test, "id", "") == "TYPE_CHECKING"
        for n in ast.walk(f)
    }
    found = []
    for node in ast.walk(tree):
        if id(node) in typing_only:
            continue
        eager = id(node) not in deferred
        if isinstance(node, ast.Import):
            found += [(alias.name, eager) for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            found.append((node.module or "", eager))
        elif isinstance(node, ast.ImportFrom):
            base = ["cadsweep", *path.parent.parts]
            base = base[: len(base) - (node.level - 1)]
            if node.module:
                found.append((".".join([*base, node.module]), eager))
            else:
                found += [(".".join([*base, alias.name]), eager) for alias in node.names]
    return found


def siblings(path: Path) -> set[str]:
    """Parts of cadsweep outside its own stage that a module imports."""
    own = stage_of(path)
    return {
        name.split(".")[1] for name, _ in imported(path) if name.startswith("cadsweep.") and name.split(".")[1] != own
    }


# gmsh_session is the one door to gmsh.
ALLOWED = {
    "surface": {"gmsh_session"},
    "smoothing": {"gmsh_session", "projection"},  # the minimiser alone
    "io": {"gmsh_session"},
    "report": {"view", "cad"},
    "budget": {"estimate"},
    # What the pipeline assembles: values made of a stage's results, and their files.
    "blocks": {"io", "projection"},
    "orders": {"projection"},  # the minimiser alone
    # What is done to a finished mesh, of whatever blocks.
    "entity": {"blocks", "projection"},
}


@pytest.mark.parametrize("path", [p for p in MODULES if stage_of(p) not in COMPOSITION], ids=str)
def test_stages_import_the_foundation_and_nothing_sideways(path: Path):
    extra = siblings(path) - FOUNDATION - ALLOWED.get(stage_of(path), set())
    assert not extra, f"{path} imports {sorted(extra)}: only pipeline joins stages"


@pytest.mark.parametrize("path", MODULES, ids=str)
def test_opencascade_stays_in_cad_gmsh_in_its_session_and_numba_in_compiled(path: Path):
    roots = {name.split(".")[0] for name, _ in imported(path)}
    if stage_of(path) not in {"cad", "cadquery"}:
        assert not roots & {"OCP", "cadquery"}, f"{path} touches OpenCASCADE outside cad/"
    if path.name != "gmsh_session.py":
        assert "gmsh" not in roots, f"{path} opens gmsh outside gmsh_session.py"
    if stage_of(path) != "compiled":
        assert "numba" not in roots, f"{path} imports numba: loops are compiled by cadsweep.compiled"


def test_no_circle_of_imports():
    """Not even of imports that wait for a call: what a module knows does not know the module."""
    homes = {".".join(["cadsweep", *p.with_suffix("").parts]).removesuffix(".__init__"): p for p in MODULES}
    graph = {}
    for name, path in homes.items():
        found = {target for target, _ in imported(path)}
        for module in ast.walk(ast.parse((PACKAGE / path).read_text(encoding="utf-8"))):
            if isinstance(module, ast.ImportFrom) and module.level and module.module:
                base = ["cadsweep", *path.parent.parts]
                base = base[: len(base) - (module.level - 1)]
                found |= {".".join([*base, module.module, alias.name]) for alias in module.names}
        graph[name] = (found & homes.keys()) - {name, "cadsweep"}
    # Importing a module runs the packages around it, which list what they offer: no knowledge of the module's own.
    left = {name: {other for other in found if not name.startswith(other + ".")} for name, found in graph.items()}
    while free := [name for name, found in left.items() if not found & left.keys()]:
        for name in free:
            del left[name]
    assert not left, f"modules that know each other, or know some that do: {sorted(left)[:12]}"


CORE = {"projection", "arrays", "lattice", "brep", "sweep", "cells", "mesh", "record", "quality", "errors", "brief"}


@pytest.mark.parametrize("path", [p for p in MODULES if stage_of(p) in CORE], ids=str)
def test_the_core_needs_numpy_scipy_and_numba_alone(path: Path):
    foreign = {name.split(".")[0] for name, eager in imported(path) if eager} - set(sys.stdlib_module_names)
    assert foreign <= {"numpy", "scipy", "numba", "cadsweep"}, f"{path} needs {foreign}"


@pytest.mark.parametrize("path", MODULES, ids=str)
def test_the_library_never_prints(path: Path):
    if stage_of(path) == "cli":
        pytest.skip("the command line speaks to its user")
    tree = ast.parse((PACKAGE / path).read_text(encoding="utf-8"))
    calls = [n.lineno for n in ast.walk(tree) if isinstance(n, ast.Call) and getattr(n.func, "id", "") == "print"]
    assert not calls, f"{path} prints at lines {calls}"


def test_the_first_import_is_light():
    code = "import sys, cadsweep; print([m for m in ('OCP', 'cadquery', 'gmsh', 'numba', 'scipy') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_the_page_names_rooms_and_modules_that_are_there():
    page = (PACKAGE.parent / "docs" / "architecture.md").read_text(encoding="utf-8")
    rooms = set(re.findall(r"`([a-z0-9_]+)/`", page))
    packages = {p.parent.name for p in PACKAGE.glob("*/__init__.py")}
    below = {p.parent.name for p in PACKAGE.glob("*/*/__init__.py")}
    assert packages <= rooms <= packages | below
    modules = re.findall(r"`((?:[a-z0-9_]+/)+[a-z0-9_]+\.py)", page)
    assert len(modules) > 10
    assert [m for m in modules if not ((PACKAGE / m).exists() or (PACKAGE.parent / m).exists())] == []
