"""Mesh models, open the ``.msh`` files in dolfinx, and solve Poisson's equation there with conditions on named faces.

    python scripts/check_dolfinx.py [MODEL.py ...]

Without arguments every model of ``models/`` is taken, with hexahedra of 8 and of 27 nodes. The exact solution is
linear, so the discrete one must equal it: given on two boundaries, with the matching flux on all others. The volume of
the cells and the area of every named boundary must be those of the mesh. Needs a Python with dolfinx, this one or the
system's (``apt-get install python3-dolfinx``); exit 0: all are right, 1: one is not, 3: dolfinx is missing.
"""

from __future__ import annotations

import functools
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

_TOLERANCE = 1e-8
_PYTHONS = (sys.executable, "/usr/bin/python3")


@functools.cache
def find_dolfinx() -> str | None:
    """A Python that has dolfinx, and gmsh's module, its own or ours."""
    for python in _PYTHONS:
        if Path(python).is_file() and _run(python, "-c", "import dolfinx.io, gmsh").returncode == 0:
            return python
    return None


def _run(python: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run another Python that sees of our packages gmsh's module alone."""
    from importlib.util import find_spec

    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    spec = find_spec("gmsh")
    with tempfile.TemporaryDirectory() as folder:
        if spec is not None and spec.origin is not None:
            (Path(folder) / "gmsh.py").symlink_to(spec.origin)
            environment["PYTHONPATH"] = folder
        return subprocess.run(
            [python, *arguments], capture_output=True, text=True, timeout=600, env=environment, check=False
        )


def solve(path: str, degree: int, given: list[str]) -> dict[str, Any]:
    """What dolfinx makes of a file: volume, areas by name, and the error of its solution. Runs where dolfinx is."""
    import dolfinx.fem.petsc
    import gmsh
    import numpy as np
    import ufl
    from dolfinx import fem
    from mpi4py import MPI

    try:
        from dolfinx.io import gmshio
    except ImportError:  # dolfinx 0.10 and later
        from dolfinx.io import gmsh as gmshio

    gmsh.initialize([], False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.open(path)
    tags = {gmsh.model.getPhysicalName(*group): group for group in gmsh.model.getPhysicalGroups()}
    mesh, cells, facets = gmshio.model_to_mesh(gmsh.model, MPI.COMM_WORLD, 0, gdim=3)[:3]
    gmsh.finalize()
    names = {name: tag for name, (dimension, tag) in tags.items() if dimension == 2}
    dx, ds = (ufl.Measure(kind, mesh, subdomain_data=data) for kind, data in (("dx", cells), ("ds", facets)))

    def integral(form: Any) -> float:
        return float(np.real(fem.assemble_scalar(fem.form(form))))

    x = ufl.SpatialCoordinate(mesh)
    exact = 1 + 2 * x[0] - 3 * x[1] + x[2]
    # On curved cells only the functions of the cells' own degree hold every linear one.
    space = (getattr(fem, "functionspace", None) or fem.FunctionSpace)(mesh, ("Lagrange", degree))
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    flux = ufl.dot(ufl.grad(exact), ufl.FacetNormal(mesh))
    one = fem.Constant(mesh, 1.0)
    natural = sum(flux * v * ds(tag) for name, tag in names.items() if name not in given)
    value = fem.Function(space)
    value.interpolate(lambda p: 1 + 2 * p[0] - 3 * p[1] + p[2])
    fixed = np.concatenate([facets.find(names[name]) for name in given])
    conditions = [fem.dirichletbc(value, fem.locate_dofs_topological(space, 2, fixed))]
    system = ufl.inner(ufl.grad(u), ufl.grad(v)) * ufl.dx
    options = {"ksp_type": "cg", "pc_type": "jacobi", "ksp_rtol": 1e-12}
    problem = fem.petsc.LinearProblem(system, natural, bcs=conditions, petsc_options=options)
    solution = problem.solve()
    return {
        "version": dolfinx.__version__,
        "volumes": {name: integral(one * dx(tag)) for name, (dimension, tag) in tags.items() if dimension == 3},
        "areas": {name: integral(one * ds(tag)) for name, tag in names.items()},
        "error": float(np.abs(solution.x.array - value.x.array).max() / np.abs(value.x.array).max()),
    }


def area(quads: Any) -> float:
    """Area of quads (q, 4 | 9, 3), by four Gauss points each way."""
    import numpy as np

    at, weights = np.polynomial.legendre.leggauss(4)
    if quads.shape[1] == 4:
        values, slopes = np.array([1 - at, 1 + at]) / 2, np.array([-np.ones(4), np.ones(4)]) / 2
        grid = quads[:, [[0, 3], [1, 2]]]  # [i, j]: along 0-1, along 0-3
    else:
        values = np.array([at * (at - 1) / 2, 1 - at**2, at * (at + 1) / 2])
        slopes = np.array([at - 0.5, -2 * at, at + 0.5])
        grid = quads[:, [[0, 7, 3], [4, 8, 6], [1, 5, 2]]]
    along = [np.einsum("ia,jb,qijc->qabc", *pair, grid) for pair in ((slopes, values), (values, slopes))]
    return float(np.einsum("a,b,qab->", weights, weights, np.linalg.norm(np.cross(*along), axis=-1)))


def check(mesh: Any, folder: Path) -> list[str]:
    """What dolfinx has against a mesh whose boundaries do not overlap; empty where it is content."""
    python = find_dolfinx()
    assert python is not None
    path = folder / "mesh.msh"
    mesh.write(path)
    done = _run(python, __file__, "--solve", str(path), str(mesh.order), *list(mesh.boundaries)[:2])
    if done.returncode:
        return [f"dolfinx fails: {' '.join(done.stderr.split())[-300:]}"]
    found = json.loads(done.stdout.splitlines()[-1])
    complaints = []
    if found["error"] > _TOLERANCE:
        complaints.append(f"the solution is off by {found['error']:.2g}")
    expected = {name: area(mesh.points[quads]) for name, quads in mesh.boundaries.items()}
    expected |= dict.fromkeys(mesh.parts, mesh.quality().volume)
    sizes = {**found["areas"], **found["volumes"]}
    if set(sizes) != set(expected):
        complaints.append(f"the names are {sorted(sizes)}, not {sorted(expected)}")
    # The area of a bent quad is the integral of a root: two quadratures differ a little.
    for name in sorted(set(sizes) & set(expected)):
        if abs(sizes[name] - expected[name]) > 1e-4 * abs(expected[name]):
            complaints.append(f"'{name}' measures {sizes[name]:.8g}, not {expected[name]:.8g}")
    return complaints


def main(arguments: list[str]) -> int:
    """Check the models that are named, or all of them."""
    if arguments[:1] == ["--solve"]:
        print(json.dumps(solve(arguments[1], int(arguments[2]), arguments[3:])))
        return 0
    if find_dolfinx() is None:
        print("dolfinx is missing: apt-get install python3-dolfinx", file=sys.stderr)
        return 3
    import cadsweep

    models = Path(__file__).parents[1] / "models"
    paths = [Path(a) for a in arguments] or sorted(p for p in models.glob("*.py") if p.name != "paper.py")
    n_bad = 0
    for path in paths:
        for options in ({}, {"order": 2, "nodes": 27}):
            mesh = cadsweep.sweep_mesh(path, **options)
            with tempfile.TemporaryDirectory() as folder:
                complaints = check(mesh, Path(folder))
            n_bad += bool(complaints)
            said = "; ".join(complaints) or "solved exactly"
            print(f"{path.name}: {mesh.n_hexes} hexahedra of {mesh.hexes.shape[1]} nodes: {said}", flush=True)
    return int(n_bad > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
