"""What a mesh was made from, kept beside it while the process lives: by it the mesh can be refined, or carried."""

from __future__ import annotations

from dataclasses import dataclass

from ..blocks.block import FactoredMesh
from ..brep import Part
from ..errors import InputError
from ..mesh import HexMesh, SurfaceMesh
from ..options import SweepOptions
from ..sweep import Sweep


@dataclass(frozen=True, kw_only=True, eq=False)
class Origin:
    """The CAD model, the way it was swept, the mesh of its boundary, and the factors.

    Attributes
    ----------
    part : Part
    sweep : Sweep
    surfaces : SurfaceMesh
        Its nodes are those of the mesh, working units.
    factored : FactoredMesh
    options : SweepOptions
    """

    part: Part
    sweep: Sweep
    surfaces: SurfaceMesh
    factored: FactoredMesh
    options: SweepOptions


def origin_of(mesh: HexMesh, purpose: str) -> Origin:
    """The origin of a mesh.

    Raises
    ------
    InputError
        It has none.
    """
    if isinstance(mesh.origin, Origin):
        return mesh.origin
    raise InputError(
        f"{purpose} needs the CAD model that the mesh was made from, and this mesh comes from a file, from another "
        "process or from several sweeps: make it with cadsweep.sweep_mesh(...), without isolated=True"
    )
