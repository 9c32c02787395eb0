"""What a mesh was made from, kept beside it while the process lives: by it the mesh can be refined, or carried."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

from ..blocks.block import FactoredMesh
from ..blocks.block_mesh import BlockMesh
from ..blocks.cells import CellBlocks
from ..blocks.joined import JoinedMesh
from ..blocks.naming import NamedFaces, name_sweep
from ..blocks.reference import make_reference, make_references, twins_of
from ..brep import Part
from ..entity.entities import Entities
from ..errors import InputError
from ..mesh import HexMesh, SurfaceMesh
from ..options import SweepOptions
from ..quality import CadReference
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

    @cached_property
    def entities(self) -> Entities:
        """Where the nodes are."""
        from ..entity.swept import sweep_entities  # most meshes are never asked

        return sweep_entities(self.part, self.sweep, self.surfaces, self.factored)

    @property
    def joined(self) -> JoinedMesh:
        """The mesh as arrays, working units."""
        return self.entities.joined

    @property
    def names(self) -> NamedFaces:
        """Names of the faces that are no cuts."""
        return name_sweep(self.sweep)

    @property
    def model(self) -> Part:
        """The part as it was swept: what was done to it another one is put through, too."""
        return self.part

    @property
    def factors(self) -> FactoredMesh:
        """What the mesh is multiplied out of."""
        return self.factored

    @property
    def references(self) -> CadReference:
        """What the CAD model says that the mesh must be."""
        return make_reference(self.part, self.sweep)

    @property
    def twins(self) -> dict[int, int] | None:
        """Of a ring that was cut open, edges at the same places."""
        return twins_of(self.sweep)

    @property
    def is_swept(self) -> bool:
        """Whether the model is as it was made ready for one sweep."""
        return True

    def of_joined(self, joined: JoinedMesh) -> CellsOrigin:
        """Of a mesh that was made of this one, and is no product of factors."""
        return CellsOrigin(
            model=self.part,
            part=self.part,
            joined=joined,
            names=self.names,
            options=self.options,
            twins=self.twins,
            is_swept=True,
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class CellsOrigin:
    """Of a mesh of several cells or of columns: the cells, and the mesh before its order was raised.

    Attributes
    ----------
    model : Part
        The solids as they were before they were cut; with nothing cut, the cells themselves.
    part : Part
        The cells.
    joined : JoinedMesh
        Its nodes are those of the mesh, working units.
    names : NamedFaces
    options : SweepOptions
    cells : CellBlocks, FactoredMesh or None
        The factors of which `joined` was multiplied out before its nodes were smoothed, where it was.
    twins : dict of int to int or None
        Of a ring that was cut open, edges at the same places.
    is_swept : bool
        Whether the model is as it was made ready for one sweep, of a mesh that was refined or carried from such a one.
    """

    model: Part
    part: Part
    joined: JoinedMesh
    names: NamedFaces
    options: SweepOptions
    cells: CellBlocks | FactoredMesh | None = None
    twins: dict[int, int] | None = None
    is_swept: bool = False

    @cached_property
    def entities(self) -> Entities:
        """Where the nodes are."""
        return Entities(part=self.part, joined=self.joined, names=self.names)

    @property
    def factors(self) -> CellBlocks | FactoredMesh | None:
        """What the mesh is multiplied out of, but for nodes that were smoothed; None where it is not."""
        return self.cells

    @property
    def references(self) -> CadReference | Mapping[str, CadReference]:
        """What the CAD model says that the mesh must be."""
        found = make_references(self.part, self.names, self.twins)
        return next(iter(found.values())) if self.is_swept else found

    def of_joined(self, joined: JoinedMesh) -> CellsOrigin:
        """Of a mesh that was made of this one, and is no product of factors."""
        return replace(self, joined=joined, cells=None)


@dataclass(frozen=True, kw_only=True, eq=False)
class Group:
    """Solids that touch, or one that touches no other, and their mesh.

    Attributes
    ----------
    solids : tuple of str
    given : frozenset of str
        Boundary names that the user gave; the others of a solid by itself are called after it.
    mesh : HexMesh
        As if it were the whole part.
    part : Part
        The solids, with a face a contact, whether the mesh follows its outline or not.
    """

    solids: tuple[str, ...]
    given: frozenset[str]
    mesh: HexMesh
    part: Part


@dataclass(frozen=True, kw_only=True, eq=False)
class GroupsOrigin:
    """Of a mesh of solids that do not all touch: the meshes of those that do, each with an origin of its own.

    Attributes
    ----------
    part : Part
    groups : tuple of Group
    options : SweepOptions
    """

    part: Part
    groups: tuple[Group, ...]
    options: SweepOptions


AnyOrigin = Origin | CellsOrigin | GroupsOrigin

AnyMesh = HexMesh | BlockMesh
"""What the ways to a mesh make: one in memory, or one that stays in blocks."""


def origin_of(mesh: HexMesh, purpose: str) -> AnyOrigin:
    """The origin of a mesh.

    Raises
    ------
    InputError
        It has none.
    """
    if isinstance(mesh.origin, AnyOrigin):
        return mesh.origin
    raise InputError(
        f"{purpose} needs the CAD model that the mesh was made from, and this mesh comes from a file or from another "
        "process: make it with cadsweep.sweep_mesh(...), without isolated=True"
    )


def made_of(mesh: HexMesh, model: Part) -> HexMesh:
    """The mesh, knowing the part that its cells were cut from."""
    if not isinstance(mesh.origin, CellsOrigin):
        return mesh
    return replace(mesh, origin=replace(mesh.origin, model=model))


def first_order(mesh: HexMesh, n_nodes: int) -> HexMesh:
    """A mesh with so many corners as one of order 1: of a hex and a quad of any order they come first."""
    boundaries = {name: quads[:, :4] for name, quads in mesh.boundaries.items()}
    interfaces = {name: quads[:, :4] for name, quads in mesh.interfaces.items()}
    return replace(
        mesh, points=mesh.points[:n_nodes], hexes=mesh.hexes[:, :8], boundaries=boundaries, interfaces=interfaces
    )
