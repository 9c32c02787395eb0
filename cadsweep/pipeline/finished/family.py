"""A family of nested meshes, and how its figures converge.

Place in the flow: on top of :func:`.refinement.refine`; the command line and the report show what it says.
"""

from __future__ import annotations

from dataclasses import dataclass

from ...errors import InputError
from ...mesh import HexMesh
from ...quality.convergence import ConvergenceIndex, convergence_index, convergence_lines
from .refinement import refine

FEWEST, MOST = 3, 7
"""Meshes of a family: three show an order, and each has eight times the hexahedra of the one before."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Family:
    """Nested meshes of one part.

    Attributes
    ----------
    meshes : tuple of HexMesh
        The coarsest first.
    convergence : dict of str to ConvergenceIndex
        Of ``volume``, and of the area of every boundary.
    """

    meshes: tuple[HexMesh, ...]
    convergence: dict[str, ConvergenceIndex]

    def index(self, values: list[float]) -> ConvergenceIndex:
        """Order, limit and uncertainty of a figure of the user's own, from its value on every mesh."""
        if len(values) != len(self.meshes):
            raise InputError(f"a figure has one value a mesh: {len(self.meshes)}, not {len(values)}")
        return convergence_index(values)

    def __str__(self) -> str:
        return "\n".join(convergence_lines(self.convergence))


def make_family(mesh: HexMesh, n_meshes: int = 3) -> Family:
    """Refine a mesh into a family of nested ones.

    Parameters
    ----------
    mesh : HexMesh
        The coarsest, from :func:`cadsweep.sweep_mesh` in this process.
    n_meshes : int
        With `mesh`.

    Returns
    -------
    Family
        Its ``convergence`` holds observed order, Richardson's extrapolated value and Roache's grid convergence index of
        the volume and of every boundary's area; ``str()`` is a table of them.

    Raises
    ------
    InputError
        `n_meshes` is not from 3 to 7, or the mesh does not know its CAD model.
    InvertedHexError
        A refined mesh is not valid.

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> family = cs.make_family(cs.sweep_mesh(cq.Workplane().box(4, 3, 2), size=1.0, layers=2))
    >>> [mesh.n_hexes for mesh in family.meshes]
    [24, 192, 1536]
    """
    if isinstance(n_meshes, bool) or not isinstance(n_meshes, int) or not FEWEST <= n_meshes <= MOST:
        raise InputError(f"a family has {FEWEST} to {MOST} meshes, not {n_meshes!r}")
    meshes = [mesh]
    while len(meshes) < n_meshes:
        meshes.append(refine(meshes[-1]))
    reports = [one.info["quality"] for one in meshes]
    figures = {"volume": [report.volume for report in reports]}
    for name in reports[0].areas:
        figures[f"area of {name}"] = [report.areas[name] for report in reports]
    found = {name: convergence_index(values) for name, values in figures.items()}
    return Family(meshes=tuple(meshes), convergence=found)
